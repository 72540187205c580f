"""The fuzzer's cases: decks, scenes, CSV files and command lines of a seed.

The same seed gives the same case on every machine.
"""

import random
import re
from dataclasses import dataclass, field
from pathlib import Path

from fuzz_effects import keep_cells_coarse, random_scene
from fuzz_mutations import mutate

ROOT = Path(__file__).resolve().parents[2]

# A longer sweep or curve is honest work, which this test does not measure.
MOST_POSITIONS = 1_000_000
HONEST_COUNT = 300


@dataclass
class Case:
    """Files of a folder, and the command line given there."""

    files: dict
    arguments: list
    what: str = ""
    notes: list = field(default_factory=list)


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


def keep_work_small(scene):
    """A number of positions or points that is allowed but long becomes a short one."""
    def shorter(match):
        value = int(match.group(2)[:15])
        return match.group(1) + (b"7" if HONEST_COUNT < value <= MOST_POSITIONS
                                 else match.group(2))
    scene = re.sub(rb"(?i)((?:positions|points)\s*=?\s*(?:1\*)?\+?)(\d+)", shorter, scene)
    return keep_cells_coarse(scene)


# Words of command lines.

PLACES = ["out.csv", "p.csv", "./out.csv", "sub/c.csv", "sub", "none/c.csv", "/dev/null",
          "/dev/full", "", " ", "deck", "./deck", "s.scene", "u.csv", "-", "x" * 300, "a\nb.csv",
          "a\x1b[2Jb.csv", "\u00e9.csv", "out.csv/", "deck/x.csv", "sub/../out.csv", "/", ".", ".."]
VALUES = ["ibm370", "real32", "real64", "real128", "IBM370", "none", "all", "13,55", "1,2,,3",
          "0", "101", "99999999999", "-1", "1e-3", "1e-30", "1e-400", "nan", "0.5", "1e", "2", "",
          "'", "\u20ac", "%s%n", "x" * 5000, "\x7f", "\x9b1m", "1 2", "1,100", "--help", "-h",
          "1.0e+999", "1-3", "+.5", "9" * 400]
OPTIONS = ["--arithmetic", "--tables", "--contacts", "--positions", "--carriage-control", "--curve",
           "--accuracy", "--threads", "--units", "--quiet", "--csv", "--version", "--help", "-h",
           "--", "-", "--nothing", "-x", "--contacts=", "--=", "=", "--units=1"]
VALUED = ("--arithmetic", "--tables", "--contacts", "--positions", "--curve", "--accuracy",
          "--threads", "--csv", "--keep")
COMMANDS = ["solve", "solve", "accuracy", "generate", "summits", "Solve", ""]
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
    if draw < 0.1:
        words += ["--arithmetic", rng.choice(["ibm370", "real32", "real64", "real128"])]
    elif draw < 0.4:
        words += ["--accuracy", rng.choice(["1e-3", "0.5", "1e-9", "1e-14", "1e-40"])]
    if rng.random() < 0.15:
        words.append("--quiet")
    return words


def deck_arguments(rng):
    words = ["deck"]
    if rng.random() < 0.4:
        words = ["solve"] + words + ["--curve", "k.csv"] * (rng.random() < 0.5)
    else:
        words += ["--tables", rng.choice(["none", "all", "1,2", "100"])]
    if words[0] == "deck" and rng.random() < 0.7:
        words += ["--arithmetic", rng.choice(["ibm370", "real32", "real64", "real128"])]
    return words + places(rng, [("--contacts", "c.csv", 0.6), ("--positions", "p.csv", 0.6)])


def effects_case(rng, files, seed):
    """A random scene with effects, seldom mutated."""
    files["s.scene"], files["u.csv"], files["l.csv"] = random_scene(rng)
    if rng.random() < 0.15:
        files["s.scene"] = keep_work_small(mutate(rng, files["s.scene"]))
    arguments = ["solve", "s.scene", "--positions", "p.csv"]
    arguments += places(rng, [("--contacts", "c.csv", 0.6), ("--curve", "k.csv", 0.2)])
    return Case(files, arguments, f"effects, seed {seed}")


# What a run may find where it is to keep positions.
KEPT = [b"", b"asperity", b"asperity 0.4.0 solve, real64, contacts kept, input\n", b"x,y\n1,2\n",
        b"asperity 0.4.0 solve, real64, contacts summed, input 00000000 00000000\n"
        b"position 1, words 9\n"]


def make_case(seed):
    """The case of a seed."""
    case = first_of_case(seed)
    # Draws of its own: a seed stays what it was.
    rng = random.Random(f"keep {seed}")
    if case.arguments[:2] == ["solve", "s.scene"] and rng.random() < 0.2:
        case.arguments += ["--keep", "kept"]
        if rng.random() < 0.3:
            case.files["kept"] = rng.choice(KEPT)
    return case


def first_of_case(seed):
    """The case of a seed, nothing kept."""
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
