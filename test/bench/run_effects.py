"""What effects cost: milliseconds a position, with and without, and against the cells.

    python test/bench/run_effects.py [--rounds R] [--small] [--save]

A position's time is the difference of two runs, of one position and of many at the same place, so
that starting, reading and writing do not count. One core; the least time of the rounds counts.
"""

import argparse
import os
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from run_bench import machine, release_build, save
from whole_runs import Work, take_turns

ROOT = Path(__file__).resolve().parents[2]

from effect_runs import random_caps, write_caps

THESIS = "&surfaces deck = '{deck}' /\n&motion x_first = {first}, x_step = {step}, " \
    "positions = {number} /\n&effects {effects} /\n"
# Caps of 1.27 cm on a plane of 7.6 by 10 cm, heights half-normal 0.01 cm, pressed to 20 kN.
CAPS, WIDTH, DEPTH, LOAD = 2000, 7.6, 10.0, 2.0e4
SEEDS = range(7, 13)


def thesis(folder, name, effects, number, first=5.6, step=0.0):
    """Position 56 again and again, or the whole sweep."""
    path = folder / f"{name}.{number}.scene"
    path.write_text(THESIS.format(deck=ROOT / "data/thesis.deck", first=first, step=step,
                                  number=number, effects=effects), encoding="ascii")
    return path


def caps(folder, seed, number, less):
    place = folder / f"{seed}.{number}"
    place.mkdir()
    return write_caps(place, *random_caps(CAPS // less, WIDTH, DEPTH, seed),
                      motion={"positions": number, "x_step": 0.0},
                      loading={"control": "load", "value": LOAD / less},
                      effects={"interaction": "coupled"}).scene


def a_position(exe, scenes, rounds):
    """Milliseconds a position, by name: scenes of one position and of `more` besides."""
    works = {name: (Work(exe, "solve", one, "--quiet"), Work(exe, "solve", many, "--quiet"), more)
             for name, (one, many, more) in scenes.items()}
    take_turns([work for one, many, _ in works.values() for work in (one, many)], rounds)
    return {name: 1e3 * (many.least - one.least) / more
            for name, (one, many, more) in works.items()}


def position_lines(exe, folder, rounds, less):
    yield "position 56 of the thesis, to the limit, ms"
    scenes = {}
    for name, effects, more in (
            ("no effect", "interaction = 'off'", 5000),
            ("interaction coupled", "interaction = 'coupled'", 1000),
            ("interaction boundary, 0.001", "interaction = 'boundary'", 10),
            ("friction", "friction = 'on', friction_coefficient = 0.2", 1000),
            ("plasticity", "plasticity = 'on', plastic_yield_stress = 8000.", 1000)):
        more //= less
        word = name.replace(" ", "_").replace(",", "")
        scenes[name] = (thesis(folder, word, effects, 1), thesis(folder, word, effects, 1 + more),
                        more)
    for name, value in a_position(exe, scenes, rounds).items():
        yield f"  {name:<40}{value:>10.4f}"


def sweep_lines(exe, folder, rounds, less):
    yield (f"{100 // less} positions of the thesis sweep, whole process: s, "
           "share of boundary throughout")
    works = {}
    for name, effects in (("no effect", "interaction = 'off'"),
                          ("auto, tolerance 0.01", "interaction = 'auto', tolerance = 0.01"),
                          ("coupled", "interaction = 'coupled'"),
                          ("boundary, 0.001", "interaction = 'boundary'")):
        word = name.replace(" ", "_").replace(",", "")
        works[name] = Work(exe, "solve", thesis(folder, "sweep_" + word, effects, 100 // less, 0.1,
                                                  0.1), "--quiet")
    take_turns(works.values(), rounds)
    whole = works["boundary, 0.001"].least
    for name, work in works.items():
        yield f"  {name:<40}{work.least:>10.3f}{work.least / whole:>10.3f}"


def caps_lines(exe, folder, rounds, less):
    yield (f"{CAPS // less} caps on {WIDTH} by {DEPTH} cm pressed to {LOAD / less / 1e3:g} kN, "
           "coupled, ms")
    more = 5
    scenes = {f"seed {seed}": (caps(folder, seed, 1, less),
                                 caps(folder, seed, 1 + more, less), more) for seed in SEEDS}
    for name, value in a_position(exe, scenes, rounds).items():
        yield f"  {name:<40}{value:>10.1f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5, help="turns of all (default 5)")
    parser.add_argument("--small", action="store_true",
                        help="a tenth of everything, one turn: to see that it runs")
    parser.add_argument("--save", action="store_true", help="also to reference_output/bench")
    options = parser.parse_args()

    rounds, less = (1, 10) if options.small else (options.rounds, 1)
    exe, flags = release_build()
    with tempfile.TemporaryDirectory() as name:
        parts = ["\n".join(machine(flags))]
        for part in (position_lines, sweep_lines, caps_lines):
            parts.append("\n".join(part(exe, Path(name), rounds, less)))
    text = "\n\n".join(parts) + "\n"
    print(text, end="")
    if options.save:
        save("effects.txt", text)


if __name__ == "__main__":
    main()
