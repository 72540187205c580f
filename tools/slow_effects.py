"""Run the large cases with effects, which the tests leave out, and say how each ended.

    python tools/slow_effects.py EXECUTABLE [NAME ...]
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from effect_cases import effect_cases
from effect_laws import keeps_laws, run
from make_cases import surface_writer, write_effect_case


def ending(executable, case, folder):
    """How a case ended, in words."""
    try:
        solved = run(executable, write_effect_case(folder, case, surface_writer(folder)), folder)
        if solved.status:
            told = solved.stderr.strip().partition(".scene: ")[2]
            return f"refused: {told}" if case.refused in told else f"WRONG: {told}"
        kept = keeps_laws(solved, case.groups) + sum(law(solved) for law in case.laws)
    except subprocess.TimeoutExpired:
        return "WRONG: no end in two minutes"
    except AssertionError as broken:
        return f"WRONG: {broken}"
    return f"right, {kept} laws kept"


def main(executable, *names):
    for case in effect_cases():
        if case.large and (not names or case.name in names):
            with tempfile.TemporaryDirectory() as folder:
                begun = time.monotonic()
                told = ending(Path(executable).resolve(), case, Path(folder))
            known = f" (known: {case.open})" if case.open else ""
            print(f"{case.name}: {told}{known}, {time.monotonic() - begun:.0f} s", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
