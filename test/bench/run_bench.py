"""Time and memory of the thesis run in each arithmetic, and what effects cost a position.

    python test/bench/run_bench.py [--rounds N] [--small] [--save]

The least time of rounds counts, in which all runs take turns, so that a slow moment of the machine
hits all of them. Ratios carry over to another machine, milliseconds do not. A position's time is
the difference of two runs, of one position and of many at the same place, on one core. With --save
the lines go to reference_output/bench/.
"""

import argparse
import tempfile
from pathlib import Path

from whole_runs import ROOT, Work, machine, release_build, save, take_turns

DECK = "data/thesis.deck"
ARITHMETICS = ("real64", "real32", "ibm370", "real128")
# Position 56 of the thesis again and again; its effects, and how many positions show their time.
POSITION = ("&surfaces deck = '{deck}' /\n&motion x_first = 5.6, x_step = 0., "
            "positions = {number} /\n&effects {effects} /\n")
EFFECTS = {
    "no effect": ("interaction = 'off'", 5000),
    "interaction coupled": ("interaction = 'coupled'", 1000),
    "interaction boundary, 0.001": ("interaction = 'boundary'", 10),
    "friction": ("friction = 'on', friction_coefficient = 0.2", 1000),
    "plasticity": ("plasticity = 'on', plastic_yield_stress = 8000.", 1000)}


def arithmetic_lines(exe, rounds):
    """Ratios to the first arithmetic, least milliseconds and MiB of the whole process."""
    works = {name: Work(exe, DECK, "--arithmetic", name) for name in ARITHMETICS}
    take_turns(works.values(), rounds)
    base = works[ARITHMETICS[0]].least
    yield f"{f'asperity {DECK} --arithmetic':<40}{'ratio':>10}{'ms':>10}{'MiB':>10}"
    for name, work in works.items():
        yield (f"  {name:<38}{work.least / base:>10.2f}{1e3 * work.least:>10.2f}"
               f"{work.peak() / 2**20:>10.1f}")


def effect_lines(exe, folder, rounds, less):
    """Milliseconds a position."""
    def work(number, effects):
        path = folder / f"{len(list(folder.iterdir()))}.scene"
        path.write_text(POSITION.format(deck=ROOT / DECK, number=number, effects=effects))
        return Work(exe, "solve", path, "--quiet")

    pairs = {name: (work(1, effects), work(1 + more // less, effects), more // less)
             for name, (effects, more) in EFFECTS.items()}
    take_turns([work for one, many, _ in pairs.values() for work in (one, many)], rounds)
    yield "position 56 of the thesis, to the limit, ms"
    for name, (one, many, more) in pairs.items():
        yield f"  {name:<38}{1e3 * (many.least - one.least) / more:>10.4f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=20, help="turns of all (default 20)")
    parser.add_argument("--small", action="store_true", help="two turns: to see that it runs")
    parser.add_argument("--save", action="store_true", help="also to reference_output/bench")
    options = parser.parse_args()
    rounds, less = (2, 10) if options.small else (options.rounds, 1)
    exe, flags = release_build()
    with tempfile.TemporaryDirectory() as name:
        text = "\n".join([*machine(flags), "", *arithmetic_lines(exe, rounds), "",
                          *effect_lines(exe, Path(name), max(2, rounds // 4), less), ""])
    print(text, end="")
    if options.save:
        save("bench.txt", text)


if __name__ == "__main__":
    main()
