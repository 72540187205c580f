"""One run of the fuzzer, and all that can be wrong with it."""

import csv
import math
import os
import re
import resource
import signal
import subprocess
import tempfile
import unicodedata
from pathlib import Path

from fuzz_cases import VALUED
from fuzz_effects import EFFECTS, broken_laws

# Seconds after which a run counts as one that does not end: far more than any takes in any build.
PATIENCE = 300.0


class Late(Exception):
    """A run that did not end."""


def late(_signal, _frame):
    raise Late


def within(limits):
    """What a child does first: limits of `resource`, by their names."""
    for name, most in (limits or {}).items():
        resource.setrlimit(getattr(resource, name), (most, most))


def run(exe, case, folder, patience=PATIENCE, limits=None):
    """Run a case in a folder of its own: status, stdout, stderr, processor seconds, kilobytes."""
    (folder / "sub").mkdir()
    for name, data in case.files.items():
        (folder / name).write_bytes(data)
    paths = [os.path.join(tempfile.gettempdir(), f"{folder.name}.{name}") for name in "oe"]
    with open(paths[0], "wb") as out, open(paths[1], "wb") as err:
        words = [os.fsencode(word) for word in case.arguments]
        child = subprocess.Popen([os.fsencode(exe)] + words, cwd=folder, stdin=subprocess.DEVNULL,
                                 stdout=out, stderr=err, preexec_fn=lambda: within(limits))
        old = signal.signal(signal.SIGALRM, late)
        signal.setitimer(signal.ITIMER_REAL, patience)
        try:
            _, status, usage = os.wait4(child.pid, 0)
        except Late:
            child.kill()
            _, status, usage = os.wait4(child.pid, 0)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, old)
        child.returncode = os.waitstatus_to_exitcode(status)
    texts = [Path(path).read_bytes() for path in paths]
    for path in paths:
        os.unlink(path)
    return (child.returncode, *texts, usage.ru_utime + usage.ru_stime, usage.ru_maxrss)


CRASH = re.compile(rb"Error termination|Fortran runtime|Backtrace|Segmentation|Aborted|"
                   rb"At line \d+ of file|Floating-point exception|IEEE_|signal [A-Z]|AddressSan|"
                   rb"libgomp:|fftw:|runtime error:|LeakSan|Operating system error|"
                   rb"Error allocating")
NOT_FINITE = re.compile(rb"(?i)(?<![a-z])(?:[-+]?nan|[-+]?inf(?:inity)?)(?![a-z])")


DIRECTIONS = ("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e"
              "\u2066\u2067\u2068\u2069\ufeff")


def odd_text(data):
    """What is wrong with a text that people see; nothing when it is printable UTF-8."""
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        return f"no UTF-8 at byte {error.start}"
    bad = [letter for letter in text if letter not in "\n\t" and (
        unicodedata.category(letter) in ("Cc", "Cs", "Zl", "Zp") or letter in DIRECTIONS)]
    return f"control characters {sorted(set(bad))!r}" if bad else ""


def check_csv(path, data):
    """What is wrong with a CSV file that was written."""
    rows = list(csv.reader(data.decode("ascii").splitlines()))
    if not data.endswith(b"\n") or not rows:
        return [f"{path} is not whole"]
    wrong = [row for row in rows[1:] if len(row) != len(rows[0])]
    words = [name in EFFECTS for name in rows[0]]
    for row in rows[1:]:
        try:
            # What was not computed is empty.
            if not all(word and cell.isprintable() or math.isfinite(float(cell or 0))
                       for cell, word in zip(row, words)):
                wrong.append(row)
        except ValueError:
            wrong.append(row)
    return [f"{path}: {wrong[0]!r}"] if wrong else []


def operand(arguments):
    """The file that a command line reads."""
    words = iter(arguments[arguments[:1] == ["solve"]:])
    for word in words:
        if word in VALUED:
            next(words, None)
        elif not word.startswith("-"):
            return os.path.normpath(word)
    return ""


def may_be_written(case, name):
    """Whether a file is named as an output and is no input of the run."""
    words = [word.rpartition("=")[2] for word in case.arguments]
    read = operand(case.arguments)
    used = case.files.get(read, b"") if read.endswith(".scene") else b""
    return name != read and any(word.endswith(name) for word in words) and \
        name.encode() not in re.findall(rb"['\"]([^'\"]*)['\"]", used)


def on_cells(case):
    """Boundary elements take time and memory; `auto`, the default, may use them in any solve."""
    return case.arguments[:1] == ["solve"] or \
        any(b"interaction" in text.lower() for text in case.files.values())


def check_kept(case, left):
    """Kept positions stay, whatever becomes of the run; a file of other work stays as it was."""
    if "kept" not in left or not case.arguments[-2:] == ["--keep", "kept"]:
        return []
    data, before = left["kept"].read_bytes(), case.files.get("kept")
    if data != before and not data.startswith(before[:20] if before else b"asperity 0."):
        return [f"kept: {data[:80]!r}"]
    if data != before:
        del left["kept"]
    return []


def check(case, folder, outcome, most_seconds=math.inf, most_kilobytes=300_000):
    """All that is wrong with a run. Its time is no matter of a test, only of `make fuzz`."""
    status, out, err, seconds, kilobytes = outcome
    wrong = []
    if on_cells(case):
        most_seconds = max(most_seconds, 30.0)
        most_kilobytes = max(most_kilobytes, 1_000_000)
    if status not in (0, 1, 2):
        wrong.append(f"status {status}")
    if CRASH.search(err) or CRASH.search(out):
        wrong.append("crash: " + err[-300:].decode("utf-8", "replace"))
    if seconds > most_seconds:
        wrong.append(f"took {seconds:.1f} s")
    if kilobytes > most_kilobytes:
        wrong.append(f"took {kilobytes // 1000} MB")
    if status in (1, 2):
        if not err.strip():
            wrong.append("no message")
        # The original program prints what stood on paper where it stopped.
        if out and not (status == 1 and b"TABLE V\n" in out and case.arguments[:1] != ["solve"]):
            wrong.append("text on standard output in spite of a failure")
    if err and not err.endswith(b"\n"):
        wrong.append("the last message does not end its line")
    if len(err) > 1_000_000:
        wrong.append(f"{len(err)} bytes of messages")
    if odd_text(err):
        wrong.append("message: " + odd_text(err))
    # The first card's words are printed as they stand.
    words = case.files.get("deck", b"")[:8].lower()
    if NOT_FINITE.search(out) and b"nan" not in words and b"inf" not in words:
        wrong.append("not a number in the output: " + repr(NOT_FINITE.search(out)))
    left = {}
    for path in folder.rglob("*"):
        if path.is_file():
            left[str(path.relative_to(folder))] = path
    wrong += check_kept(case, left)
    for name, data in case.files.items():
        path = left.pop(name, None)
        if name == "kept" and path is None:
            continue  # checked
        if path is None or path.read_bytes() != data:
            if status == 0 and path is not None and may_be_written(case, name):
                wrong += check_csv(name, path.read_bytes())
            else:
                wrong.append(f"the file {name} was changed")
    for name, path in left.items():
        if status != 0:
            wrong.append(f"left {name} behind")
        elif name.endswith(".part"):
            wrong.append(f"left {name}")
        else:
            wrong += check_csv(name, path.read_bytes())
            if name == "p.csv":
                wrong += broken_laws(path.read_bytes(), case.files.get("s.scene", b""))
    return wrong


def run_and_check(exe, case, tight=None, **limits):
    """Run a case in a new folder; status and all that is wrong."""
    with tempfile.TemporaryDirectory(prefix="fuzz") as name:
        folder = Path(name)
        outcome = run(exe, case, folder, limits=tight)
        return outcome[0], outcome[2], check(case, folder, outcome, **limits)
