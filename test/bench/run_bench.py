"""Time and memory of the thesis run, whole process, and what accuracy costs in time.

    python test/bench/run_bench.py [--runs N] [--save]

Times are wall time from start to end of `asperity data/thesis.deck > report`. The runs of the
arithmetics take turns, so that a slow moment of the machine hits all of them. Prints ratios
first: these carry over to another machine, milliseconds do not. The accuracy study follows: every
way of computing the same sweep, its time a position and its errors. With --save both go to
reference_output/bench/.
"""

import argparse
import csv
import datetime
import os
import platform
import re
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DECK = "data/thesis.deck"
ARITHMETICS = ("real64", "real32", "ibm370", "real128")
HEAD = ("arithmetic", "ratio", "median ms", "min ms", "max ms", "quartiles ms", "peak MiB")


def output_of(*command):
    done = subprocess.run(
        command, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True
    )
    return done.stdout.strip() if done.returncode == 0 else ""


def release_build():
    """Path of the executable and the flags it was compiled with, as fpm tells them."""
    path = output_of("bash", ".ci/build", "release")
    if not path:
        raise SystemExit("bench: the release build failed, see: bash .ci/build release")
    fpm = ROOT / ".venv" / "bin" / "fpm"
    model = output_of(str(fpm), "build", "--profile", "release", "--show-model")
    flags = re.search(r'fortran_compile_flags="([^"]*)"', model)
    return path, flags.group(1) if flags else "not known"


def machine(flags):
    """The lines without which the numbers below mean nothing."""
    cpuinfo = Path("/proc/cpuinfo")
    text = cpuinfo.read_text() if cpuinfo.exists() else ""
    model = re.search(r"^model name\s*:\s*(.*)$", text, re.MULTILINE)
    compiler = output_of(os.environ.get("FPM_FC", "gfortran"), "--version").splitlines()
    return [
        f"date      {datetime.date.today().isoformat()}",
        f"machine   {model.group(1) if model else platform.machine()}, {os.cpu_count()} cores, "
        f"{platform.system()} {platform.release()}",
        f"compiler  {compiler[0] if compiler else 'not known'}",
        f"flags     {flags}",
    ]


def start(path, arithmetic, report):
    command = [path, DECK, "--arithmetic", arithmetic]
    return subprocess.Popen(command, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=report)


def wall_time(path, arithmetic):
    """Seconds of one run, from before its start until it has ended."""
    with tempfile.TemporaryFile() as report:
        begin = time.perf_counter()
        status = start(path, arithmetic, report).wait()
        seconds = time.perf_counter() - begin
    if status != 0:
        raise SystemExit(f"bench: {arithmetic} ended with status {status}")
    return seconds


def peak_of(process, pause=0.0):
    """Bytes resident at most of a process just started, read until it has gone; 0 where the system
    does not tell.

    Not ru_maxrss: what the kernel reports there includes the parent's pages before exec.
    """
    peak = 0
    status = Path(f"/proc/{process.pid}/status")
    while process.poll() is None:
        try:
            found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text())
        except OSError:
            found = None
        if found:
            peak = max(peak, 1024 * int(found.group(1)))
        if pause:
            time.sleep(pause)
    return peak


def peak_memory(path, arithmetic, runs=5):
    """MiB resident at most."""
    peak = 0
    for _ in range(runs):
        with tempfile.TemporaryFile() as report:
            peak = max(peak, peak_of(start(path, arithmetic, report)))
    return peak / 2**20


def measure(path, runs):
    """Seconds of every run, by arithmetic; one run of each first, not counted."""
    seconds = {arithmetic: [] for arithmetic in ARITHMETICS}
    for turn in range(runs + 1):
        for arithmetic in ARITHMETICS:
            elapsed = wall_time(path, arithmetic)
            if turn > 0:
                seconds[arithmetic].append(elapsed)
    return seconds


def table(seconds, memory):
    """Ratios to the first arithmetic, then what they are made of."""
    base = statistics.median(seconds[ARITHMETICS[0]])
    yield " ".join(f"{title:>13}" for title in HEAD)
    for arithmetic, times in seconds.items():
        ms = sorted(1000 * value for value in times)
        low, median, high = statistics.quantiles(ms, n=4)
        cells = (
            arithmetic,
            f"{median / (1000 * base):.2f}",
            f"{median:.2f}",
            f"{ms[0]:.2f}",
            f"{ms[-1]:.2f}",
            f"{low:.2f}-{high:.2f}",
            f"{memory[arithmetic]:.1f}" if memory[arithmetic] else "-",
        )
        yield " ".join(f"{cell:>13}" for cell in cells)


def accuracy_study(path):
    """The study's table and CSV, and the ratios that one looks for first."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "accuracy.csv"
        table_text = output_of(path, "accuracy", DECK, "--csv", str(file))
        text = file.read_text(encoding="ascii")
    rows = {r["method"]: r for r in csv.DictReader(text.splitlines()) if r["seconds"]}
    events = rows["real64; exact events"]

    def slower(method):
        return float(rows[method]["seconds"]) / float(events["seconds"])

    ratios = [
        "time, exact events in real64 = 1",
        f"  marching at 0.001 cm in real64, stable overlap   "
        f"{slower('real64; steps 1.0E-03'):8.2f}",
        f"  original program in real64                       "
        f"{slower('real64; original program; 1976'):8.2f}",
    ]
    front = [method for method, row in rows.items() if row["own_front"] == "1"]
    ratios.append("the cheapest for their accuracy: " + ", ".join(front))
    return ratios + ["", table_text], text


def save(name, text):
    folder = ROOT / "reference_output" / "bench"
    folder.mkdir(parents=True, exist_ok=True)
    stem, _, ending = name.rpartition(".")
    path = folder / f"{stem}.{datetime.date.today().isoformat()}.{ending}"
    path.write_text(text, encoding="utf-8")
    print(f"saved     {path.relative_to(ROOT)}")


def number_of_runs(text):
    if not text.isdigit() or int(text) < 2:
        raise argparse.ArgumentTypeError("expected a whole number, 2 or more")
    return int(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=number_of_runs, default=20, help="runs of each (default 20)")
    parser.add_argument("--save", action="store_true", help="also to reference_output/bench")
    options = parser.parse_args()

    path, flags = release_build()
    lines = machine(flags)
    lines.append(f"run       asperity {DECK} --arithmetic A > report, {options.runs} runs each")
    lines.append("")
    seconds = measure(path, options.runs)
    memory = {arithmetic: peak_memory(path, arithmetic) for arithmetic in ARITHMETICS}
    lines.extend(table(seconds, memory))
    study, study_csv = accuracy_study(path)
    lines += ["", *study]
    text = "\n".join(lines) + "\n"
    print(text, end="")
    if options.save:
        save("bench.txt", text)
        save("accuracy.csv", study_csv)


if __name__ == "__main__":
    main()
