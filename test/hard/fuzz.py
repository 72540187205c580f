"""Mutated decks, scenes, CSV files and command lines: the program keeps its word on all of them.

Every run must end within a second of processor time with status 0, 1 or 2. With 1 or 2 it says
why in printable lines and leaves no file behind; with 0 its files are whole and hold finite
numbers. The same seed gives the same cases on every machine.

Longer run: python test/hard/fuzz.py --exe PATH --minutes 30 --keep FOLDER (or make fuzz).
"""

import argparse
import csv
import json
import math
import multiprocessing
import os
import random
import re
import resource
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import unicodedata
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from fuzz_effects import EFFECTS, broken_laws, keep_cells_coarse, random_scene

ROOT = Path(__file__).resolve().parents[2]

# A longer sweep or curve is honest work, which this test does not measure.
MOST_POSITIONS = 1_000_000
HONEST_COUNT = 300

# A build without optimisation, or with checks, may take so many times longer.
SLOWNESS = float(os.environ.get("ASPERITY_SLOWNESS", "1"))


@dataclass
class Case:
    """Files of a folder, and the command line given there."""

    files: dict
    arguments: list
    what: str = ""
    notes: list = field(default_factory=list)


# ---------------------------------------------------------------- what is mutated

def thesis_lines():
    return (ROOT / "data/thesis.deck").read_bytes().split(b"\n")


def short_deck(upper, lower):
    """The thesis' deck with fewer asperities: its runs are short."""
    lines = thesis_lines()
    head = lines[:4]
    head[1] = b"%5d" % upper + head[1][5:]
    head[2] = b"%5d" % lower + head[2][5:]
    return b"\n".join(head + lines[4:4 + upper] + lines[41:41 + lower]) + b"\n"


def row_deck():
    """Three asperities that travel along a row of twenty: contact at all positions."""
    upper = [(1.0, 1.0, 0.06), (1.5, 1.02, 0.055), (2.1, 0.97, 0.0625)]
    lower = [(0.9 + 0.3 * i, 2.455 + 0.01 * (i % 3), 0.05 + 0.002 * (i % 7)) for i in range(20)]
    lines = thesis_lines()[:4]
    lines[1] = b"%5d" % len(upper) + lines[1][5:]
    lines[2] = b"%5d" % len(lower) + lines[2][5:]
    lines += [b"%6.3f%6.3f%7.4f" % place for place in upper + lower]
    return b"\n".join(lines) + b"\n"


DECKS = [row_deck(), row_deck(), short_deck(8, 12),
         (ROOT / "data/examples/shifted.deck").read_bytes()]
BIG_DECK = (ROOT / "data/thesis.deck").read_bytes()
SURFACES = [(ROOT / "data/examples" / name).read_bytes()
            for name in ("upper.csv", "lower.csv", "ball.csv", "bump.csv")]

SCENES = [text.encode() for text in (
    """&surfaces upper = 'u.csv', lower = 'l.csv', radius = 2.0, 1.5 /
&material elastic_modulus = 210e3, 70e3, poisson_ratio = 0.3, 0.33 /
&motion x_step = 0.25, positions = 9 /
&loading control = 'load', value = 40. /
&limit criterion = 'hardy', yield_stress = 250. /
""",
    """! A curve at a given approach.
&surfaces upper = 'own.csv', lower = 'own.csv' /
&material elastic_modulus = 2*200e3, poisson_ratio = 2*0.3 /
&loading control = 'approach', value = 0.39, points = 12 /
&tilt upper_slope = 0.001, -0.002, rotation = 0.5, 3.14159 /
""",
    """&surfaces deck = 'small.deck' /
&motion x_first = 0.1, x_step = 0.1, y_first = 0.02, y_step = -0.01, positions = 20 /
&tilt upper_slope = 0.004, -0.00058
      lower_slope = -0.00067, -0.00045
      rotation = 0., 0. /
&loading control = 'limit', points = 5 /
&limit criterion = 'load', value = 288.89 /
&effects interaction = 'off', friction = 'off', plasticity = 'off', adhesion = 'off',
         creep = 'off', tolerance = 0.01 /
""",
    """&surfaces deck = 'small.deck' /
&limit criterion = 'greenwood_williamson', hardness = 20000. /
""",
    """&surfaces upper = 'u.csv', lower = 'own.csv', radius = 2*1.27 /
&material elastic_modulus = 3d5 275760, poisson_ratio = 0.42, -0.2 /
&limit criterion = "pressure" value = 900 /
&motion y_step = .25 positions = 4 /
""")]

NUMBERS = (
    b"0 -0 1 -1 2 1e308 -1e308 1.7976931348623157e308 1.8e308 1e309 1E-320 5e-324 2e-324 1e-308 "
    b"2.2250738585072014e-308 0.5 0.5000001 0.49999999999999994 0.50000000000000011 -0.999999 -1.0 "
    b"NaN nan Infinity -Inf +inf 1e 1e+ 1d400 1q5 0x10 1,5 1.2.3 .e1 . + - 1e-400 1e999999999 "
    b"1e-999999999 1e99999999999999999999 2147483647 2147483648 -2147483648 9223372036854775807 "
    b"9223372036854775808 99999999999999999999 123456789012345678901234567890 "
    b"0.1234567890123456789012345 00000000000000000000000000001 1e75 7.2e75 7.3e75 5.4e-79 1e-79 "
    b"3.4e38 3.5e38 1e-38 1e-45 1e-46 4e-46 1e150 1e-150 1e100 1e-100 1e15 1e-15 1e16 16777217 "
    b"999999 1000001 2000000000 3*1 0*1 999999999*1 2147483647*1 -1*2 4*0.42 "
    b"6.283185307179586 1e5 1e-5 0.3 2.54").split()
FIELDS = (b"1E70 9E99 1E-9 1E-70 -.001 0.000 99999 -9999 1+30 1-30 1D5 NAN INF 1E999 9E9 1E9 1. "
          b".4999 .5001 .5 -1. -.99 1E-79 7E75 E5 +-1 0 -0 -0. 1E+").split()
ODD_BYTES = [b"\0", b"\x1b[31m", b"\x7f", b"\xff\xfe", b"\xc3\xa9", b"\xc2\x9b", b"\xe2\x80\xae",
             b"\xef\xbb\xbf", b"\t", b"\r", b"\r\n", b"\n\n\n", b"'", b'"', b"!", b"&", b"/", b"=",
             b",", b",,", b"*", b"(", b")", b"%", b"\\", b" ", b"\x0b", b"\x0c", b"\x1a", b"\x80",
             b"\xed\xa0\x80", b"\xf5"]
TOKEN = re.compile(rb"[^\s,=/&']+")
NUMBER = re.compile(rb"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?(?![\w.])")


def pick_span(rng, pattern, text):
    spans = [match.span() for match in pattern.finditer(text)]
    return rng.choice(spans) if spans else (0, 0)


def replace(text, span, piece):
    return text[:span[0]] + piece + text[span[1]:]


def change_number(rng, text):
    return replace(text, pick_span(rng, NUMBER, text), rng.choice(NUMBERS))


def change_field(rng, text):
    """A number in its columns of a card."""
    first, last = pick_span(rng, NUMBER, text)
    width = last - first
    return replace(text, (first, last), rng.choice(FIELDS)[:width].rjust(width))


def nudge_number(rng, text):
    first, last = pick_span(rng, NUMBER, text)
    try:
        value = float(text[first:last].lower().replace(b"d", b"e") or b"0")
    except ValueError:
        return text
    value *= rng.choice([2.0, 0.5, -1.0, 1 + 1e-15, 1e3, 1e-3, 10 ** rng.uniform(-30, 30), 0.999])
    return replace(text, (first, last), (b"%.17g" if rng.random() < 0.5 else b"%.3g") % value)


def swap_tokens(rng, text):
    one, two = sorted([pick_span(rng, TOKEN, text), pick_span(rng, TOKEN, text)])
    if one[1] > two[0]:
        return text
    return (text[:one[0]] + text[two[0]:two[1]] + text[one[1]:two[0]] + text[one[0]:one[1]]
            + text[two[1]:])


def copy_token(rng, text):
    first, last = pick_span(rng, TOKEN, text)
    at = rng.randint(0, len(text))
    return text[:at] + text[first:last] + rng.choice([b" ", b"", b", "]) + text[at:]


def drop_token(rng, text):
    return replace(text, pick_span(rng, TOKEN, text), b"")


def flip_bit(rng, text):
    if not text:
        return text
    at = rng.randrange(len(text))
    return text[:at] + bytes([text[at] ^ (1 << rng.randrange(8))]) + text[at + 1:]


def odd_bytes(rng, text):
    at = rng.randint(0, len(text))
    return text[:at] + rng.choice(ODD_BYTES) * rng.choice([1, 1, 1, 3]) + text[at:]


def drop_bytes(rng, text):
    at = rng.randint(0, len(text))
    return text[:at] + text[at + rng.choice([1, 1, 2, 7, 80]):]


def truncate(rng, text):
    return text[:rng.randint(0, len(text))]


def lines_about(rng, text):
    lines = text.split(b"\n")
    one, two = rng.randrange(len(lines)), rng.randrange(len(lines))
    what = rng.randrange(6)
    if what == 0:
        del lines[one]
    elif what == 1:
        lines.insert(one, lines[two])
    elif what == 2:
        lines[one], lines[two] = lines[two], lines[one]
    elif what == 3:
        lines[one] = lines[one][:rng.randint(0, len(lines[one]))]
    elif what == 4:
        lines[one] += rng.choice([b" ", b"x", b"1,"]) * rng.choice([10, 1000, 100000])
    else:
        lines.insert(one, b"")
    return b"\n".join(lines)


def line_ends(rng, text):
    return text.replace(b"\n", rng.choice([b"\r\n", b"\r", b"\n\n", b" ", b"\n\r", b""]))


def much(rng, text):
    """A great many of something."""
    n = rng.choice([100, 1000])
    piece = rng.choice([
        b"&motion x_first = 1 /\n", b"&x /\n", b"& ", b"&a b = (", b"'", b'"', b"!\n", b"=", b",",
        b"&surfaces deck = ", b"\n", b"\xff", b"1*", b"a=1 ", b"/", b"positions = 3, ", b" " * 100])
    at = rng.choice([0, len(text), rng.randint(0, len(text))])
    return text[:at] + piece * n + text[at:]


def noise(rng, _text):
    return rng.randbytes(rng.choice([1, 10, 1000, 20000]))


def empty(rng, _text):
    return rng.choice([b"", b"\n", b" ", b"\n\n\n\n", b"\0", b"\xef\xbb\xbf", b"&", b"!", b"/"])


GENTLE = [change_number, change_field, nudge_number, nudge_number]
ROUGH = [swap_tokens, copy_token, drop_token, flip_bit, odd_bytes, drop_bytes, truncate,
         lines_about, line_ends, much, noise, empty]


def mutate(rng, text):
    # Half of the texts keep their form and get other numbers: they reach the solvers.
    gentle = rng.choice([0.3, 1.0])
    for _ in range(rng.choice([1, 1, 1, 2, 2, 3, 5])):
        text = rng.choice(GENTLE if rng.random() < gentle else ROUGH)(rng, text)
    return text


def keep_work_small(scene):
    """A number of positions or points that is allowed but long becomes a short one."""
    def shorter(match):
        value = int(match.group(2)[:15])
        return match.group(1) + (b"7" if HONEST_COUNT < value <= MOST_POSITIONS
                                 else match.group(2))
    scene = re.sub(rb"(?i)((?:positions|points)\s*=?\s*(?:1\*)?\+?)(\d+)", shorter, scene)
    return keep_cells_coarse(scene)


# ---------------------------------------------------------------- cases

PLACES = ["out.csv", "p.csv", "./out.csv", "sub/c.csv", "sub", "none/c.csv", "/dev/null",
          "/dev/full", "", " ", "deck", "./deck", "s.scene", "u.csv", "-", "x" * 300, "a\nb.csv",
          "a\x1b[2Jb.csv", "\u00e9.csv", "out.csv/", "deck/x.csv", "sub/../out.csv", "/", ".", ".."]
VALUES = ["ibm370", "real32", "real64", "real128", "IBM370", "none", "all", "13,55", "1,2,,3",
          "0", "101", "99999999999", "-1", "1e-3", "1e-30", "1e-400", "nan", "0.5", "1e", "2", "",
          "'", "\u20ac", "%s%n", "x" * 5000, "\x7f", "\x9b1m", "1 2", "1,100", "--help", "-h",
          "1.0e+999", "1-3", "+.5", "9" * 400]
OPTIONS = ["--arithmetic", "--tables", "--contacts", "--positions", "--carriage-control", "--curve",
           "--accuracy", "--threads", "--budget", "--quiet", "--csv", "--version", "--help", "-h",
           "--", "-", "--nothing", "-x", "--contacts=", "--=", "=", "--budget=1"]
VALUED = ("--arithmetic", "--tables", "--contacts", "--positions", "--curve", "--accuracy",
          "--threads", "--csv")
COMMANDS = ["solve", "solve", "accuracy", "generate", "study", "Solve", ""]
INPUTS = ["deck", "s.scene", "u.csv", "sub", "none.deck", "/dev/null", "/dev/zero", "", "deck/x",
          "./deck", "-", "\udcff.deck", "a\nb", "\x1b]0;x\x07", "x" * 5000, "/dev/full", "*"]


def places(rng, options):
    """Outputs, a few of them in odd places."""
    words = []
    for option, value, share in options:
        if rng.random() < share:
            words += [option, rng.choice(PLACES) or "p.csv" if rng.random() < 0.05 else value]
    return words


def wild_arguments(rng):
    words = []
    if rng.random() < 0.6:
        words.append(rng.choice(COMMANDS))
    for _ in range(rng.randrange(5)):
        option = rng.choice(OPTIONS)
        value = rng.choice(PLACES if rng.random() < 0.5 else VALUES)
        words += [option + "=" + value] if rng.random() < 0.3 else [option, value]
    words.insert(rng.randint(0, len(words)), rng.choice(INPUTS))
    if rng.random() < 0.1:
        words += ["deck"] * rng.choice([1, 2, 200])
    if "accuracy" in words[:1]:
        # The study itself is slow on purpose.
        words = [word for word in words if word not in ("deck", "./deck", "s.scene")] + ["none"]
    return words


def solve_arguments(rng):
    words = ["solve", "s.scene"]
    words += places(rng, [("--contacts", "c.csv", 0.6), ("--positions", "p.csv", 0.6),
                          ("--curve", "k.csv", 0.4)])
    draw = rng.random()
    if draw < 0.4:
        words += ["--arithmetic", rng.choice(["ibm370", "real32", "real64", "real128"])]
    elif draw < 0.5:
        words += ["--accuracy", rng.choice(["1e-3", "0.5", "1e-9", "1e-14", "1e-40"])]
    if rng.random() < 0.15:
        words.append("--budget")
    return words


def deck_arguments(rng):
    words = ["deck"]
    if rng.random() < 0.4:
        words = ["solve"] + words + ["--curve", "k.csv"] * (rng.random() < 0.5)
    else:
        words += ["--tables", rng.choice(["none", "all", "1,2", "100"])]
    if rng.random() < 0.7:
        words += ["--arithmetic", rng.choice(["ibm370", "real32", "real64", "real128"])]
    return words + places(rng, [("--contacts", "c.csv", 0.6), ("--positions", "p.csv", 0.6)])


def effects_case(rng, files, seed):
    """A random scene with effects, seldom mutated."""
    files["s.scene"], files["u.csv"], files["l.csv"] = random_scene(rng)
    if rng.random() < 0.15:
        files["s.scene"] = keep_work_small(mutate(rng, files["s.scene"]))
    arguments = ["solve", "s.scene", "--positions", "p.csv"]
    arguments += places(rng, [("--contacts", "c.csv", 0.6), ("--curve", "k.csv", 0.2)])
    if rng.random() < 0.05:
        arguments += ["--arithmetic", rng.choice(["real32", "real64"])]
    return Case(files, arguments, f"effects, seed {seed}")


def make_case(seed):
    """The case of a seed."""
    rng = random.Random(seed)
    files = {"u.csv": SURFACES[0], "l.csv": SURFACES[1], "own.csv": rng.choice(SURFACES[2:]),
             "small.deck": DECKS[0], "deck": rng.choice(DECKS), "s.scene": rng.choice(SCENES)}
    if seed % 5 == 4:
        return effects_case(rng, files, seed)
    kind = rng.choices(["deck", "scene", "surface", "command", "big"], [30, 34, 16, 19, 1])[0]
    if kind == "deck":
        files["deck"] = mutate(rng, files["deck"])
        arguments = deck_arguments(rng)
    elif kind == "big":
        files["deck"] = mutate(rng, BIG_DECK)
        arguments = ["deck", "--arithmetic", "real64", "--contacts", "c.csv"]
    elif kind == "scene":
        files["s.scene"] = keep_work_small(mutate(rng, files["s.scene"]))
        arguments = solve_arguments(rng)
    elif kind == "surface":
        name = rng.choice(["u.csv", "l.csv", "own.csv", "small.deck"])
        files[name] = mutate(rng, files[name])
        arguments = solve_arguments(rng)
    else:
        arguments = wild_arguments(rng)
    return Case(files, arguments, f"{kind}, seed {seed}")


# ---------------------------------------------------------------- one run and its check

class Late(Exception):
    """A run that did not end."""


def late(_signal, _frame):
    raise Late


def run(exe, case, folder, patience=20.0):
    """Run a case in a folder of its own: status, stdout, stderr, processor seconds, kilobytes."""
    (folder / "sub").mkdir()
    for name, data in case.files.items():
        (folder / name).write_bytes(data)
    paths = [os.path.join(tempfile.gettempdir(), f"{folder.name}.{name}") for name in "oe"]
    with open(paths[0], "wb") as out, open(paths[1], "wb") as err:
        words = [os.fsencode(word) for word in case.arguments]
        child = subprocess.Popen([os.fsencode(exe)] + words, cwd=folder, stdin=subprocess.DEVNULL,
                                 stdout=out, stderr=err)
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
                   rb"At line \d+ of file|Floating-point exception|IEEE_|signal [A-Z]|AddressSan")
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
            if not all(word and cell.isprintable() or math.isfinite(float(cell))
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
    """Cells take their time and their room; the budget compares with them, `auto` may use them."""
    return any("--budget" in str(word) for word in case.arguments) or \
        any(b"interaction" in text.lower() for text in case.files.values())


def check(case, folder, outcome, most_seconds=1.0, most_kilobytes=300_000):
    """All that is wrong with a run."""
    status, out, err, seconds, kilobytes = outcome
    wrong = []
    if on_cells(case):
        most_seconds = max(most_seconds, 30.0)
        most_kilobytes = max(most_kilobytes, 1_000_000)
    if status not in (0, 1, 2):
        wrong.append(f"status {status}")
    if CRASH.search(err) or CRASH.search(out):
        wrong.append("crash: " + err[-300:].decode("utf-8", "replace"))
    if seconds > SLOWNESS * most_seconds:
        wrong.append(f"took {seconds:.1f} s")
    if kilobytes > most_kilobytes:
        wrong.append(f"took {kilobytes // 1000} MB")
    if status in (1, 2):
        if not err.strip():
            wrong.append("no message")
        if out:
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
    for name, data in case.files.items():
        path = left.pop(name, None)
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
                wrong += broken_laws(path.read_bytes())
    return wrong


def run_and_check(exe, case, **limits):
    """Run a case in a new folder; status and all that is wrong."""
    with tempfile.TemporaryDirectory(prefix="fuzz") as name:
        folder = Path(name)
        outcome = run(exe, case, folder, patience=SLOWNESS * (60.0 if on_cells(case) else 20.0))
        return outcome[0], outcome[2], check(case, folder, outcome, **limits)


# ---------------------------------------------------------------- many runs

def prepare(place):
    """A place for all folders, and limits that the runs inherit: a fault stays small."""
    tempfile.tempdir = place
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (10 ** 6, 10 ** 6))
    memory = resource.getrlimit(resource.RLIMIT_AS)[1]
    most = 4_000_000_000
    resource.setrlimit(resource.RLIMIT_AS,
                       (most if memory == resource.RLIM_INFINITY else min(most, memory), memory))


def one_seed(task):
    exe, seed, limits = task
    status, _, wrong = run_and_check(exe, make_case(seed), **limits)
    return seed, status, wrong


def campaign(exe, seeds, processes=2, until=None, **limits):
    """Run the cases of all seeds; how many ended with which status, and the faults by seed."""
    ended, faults = Counter(), {}
    # One place, so that a campaign that is cut short leaves nothing behind.
    with tempfile.TemporaryDirectory(prefix="fuzz") as place, \
            multiprocessing.Pool(processes, prepare, (place,)) as pool:
        tasks = ((str(exe), seed, limits) for seed in seeds)
        for seed, status, wrong in pool.imap_unordered(one_seed, tasks, chunksize=16):
            ended[status] += 1
            if wrong:
                faults[seed] = wrong
            if until is not None and time.monotonic() > until:
                pool.terminate()
                break
    return ended, faults


def keep(case, folder):
    """Write a case as a folder like those of data/hard/found."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in case.files.items():
        (folder / name).write_bytes(data)
    (folder / "case.json").write_text(json.dumps(
        {"why": case.what, "arguments": case.arguments}, indent=2) + "\n", encoding="ascii")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--exe", required=True, help="the program")
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--runs", type=int, help="so many runs instead of a time")
    parser.add_argument("--seed", type=int, default=None, help="first seed (default: the clock)")
    parser.add_argument("--seconds", type=float, default=1.0, help="processor time for a run")
    parser.add_argument("--processes", type=int, default=os.cpu_count())
    parser.add_argument("--keep", type=Path, help="folder for the cases with faults")
    parser.add_argument("--show", action="store_true", help="print each fault's command and errors")
    given = parser.parse_args()
    first = int(time.time()) * 1000 if given.seed is None else given.seed
    seeds = range(first, first + (given.runs or 10 ** 9))
    until = None if given.runs else time.monotonic() + 60 * given.minutes
    exe = Path(given.exe).resolve()
    begun = time.monotonic()
    ended, faults = campaign(exe, seeds, given.processes, until, most_seconds=given.seconds)
    for seed in sorted(faults):
        case = make_case(seed)
        print(f"seed {seed} ({case.what}): {'; '.join(faults[seed])}")
        if given.show:
            print("   ", shlex.join(case.arguments)[:300])
        if given.keep:
            keep(case, given.keep / str(seed))
    print(summary(ended, faults), f"in {time.monotonic() - begun:.0f} s, seeds from {first}")
    return 1 if faults else 0


def summary(ended, faults):
    """`N runs: ... ended with status 0, ...; M with faults`."""
    parts = ", ".join(f"{ended[status]} with status {status}" for status in sorted(ended))
    return f"{sum(ended.values())} runs: {parts}; {len(faults)} faults"


if __name__ == "__main__":
    sys.exit(main())
