"""Random small scenes with an &effects group, for the fuzzer, and the laws their results keep.

Most groups are valid and reach the solvers; the rest have a wrong word or number somewhere.
"""

import csv
import math
import re

# Words of each effect, wrong ones among them.
WAYS = {"interaction": ["off", "coupled", "boundary", "auto"], "friction": ["off", "on", "auto"]}
OTHERS = {"plasticity": ["off", "on", "auto"], "adhesion": ["off", "on", "auto"],
          "creep": ["off", "on", "auto"]}
EFFECTS = (*WAYS, *OTHERS)
WRONG_WORDS = ["", "On", "yes", "full", "couple", "coupled ", "auto, auto", "-", "1", "x" * 300]
SHARES = ["1e-12", "1e-6", "1e-3", "0.01", "0.1", "0.5", "0.9", "0.999"]
# Finer cells than this are honest work, which the fuzzer does not measure.
LEAST_CELLS = 1e-3
BOUNDARY_SHARES = ["1e-3", "2e-3", "0.01", "0.1", "0.9"]
COEFFICIENTS = ["0", "1e-300", "1e-9", "0.1", "0.3", "1", "100", "1e12", "1e300"]
NUMBERS = ["-1", "0", "1", "1.0", "1e400", "nan", "-0.0", "1e-400", "0x1", "", "1,2", "2*0.1"]
OWN_NUMBERS = {"plastic_yield_stress": ["250", "1e-3", "1e9"],
               "work_of_adhesion": ["0", "1e-3", "10"], "equilibrium_distance": ["1e-6", "1"],
               "relaxation_time": ["1", "1e-9"], "relaxed_modulus_ratio": ["0.5", "1"],
               "hold_time": ["0", "10"]}


def number(rng, good, wild):
    """A number of a list; seldom any other one."""
    if rng.random() < wild:
        return rng.choice(NUMBERS)
    if rng.random() < 0.1:
        return repr(float(f"{10 ** rng.uniform(-3, -0.1):.4g}"))
    return rng.choice(good)


def surface(rows):
    return ("x,y,height,radius\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows)
            ).encode()


def geometry(rng, wide):
    """Rows of an upper and a lower surface; at most 25 pairs are near. `wide`: powers of ten that
    the radii may lie from 1; cells of very different sizes are honest work."""
    kind = rng.randrange(7)
    scale = rng.choice([1.0, 1.0, 1.0, 1e-6, 1e6, 2.0 ** 40, 1e-3, 3e-200, 1e100])
    n = rng.choice([1, 1, 2, 3, 4, 5, 8])
    if kind == 0:  # in one place, or as good as
        near = rng.choice([0.0, 0.0, 1e-12, 1e-6, 1e-2])
        upper = [(near * i, 0.0, 0.5, 1.0) for i in range(min(n, 5))]
        lower = [(0.1, near * i, 0.5, 0.75) for i in range(rng.choice([1, 1, 2]))]
    elif kind == 1:  # caps on a plane
        pitch = rng.choice([0.1, 0.3, 1.0, 30.0])
        height = rng.choice([0.0, 1e-12, 1e-3, 0.05])
        upper = [(pitch * (i % 3), pitch * (i // 3), height * rng.random(), 1.0)
                 for i in range(n)]
        lower = [(pitch, pitch, 0.0, 1e5)]
    elif kind == 2:  # radii wide apart
        radii = [10 ** rng.uniform(-wide, wide) for _ in range(n)]
        upper = [(rng.uniform(-1, 1), rng.uniform(-1, 1), 0.01 * r * rng.random(), r)
                 for r in radii]
        lower = [(rng.uniform(-1, 1), rng.uniform(-1, 1), 0.0, 10 ** rng.uniform(-wide, wide))
                 for _ in range(2)]
    elif kind == 3:  # steep
        # On cells a steep contact is a long strip of many cells.
        upper = [(2.0 - 10 ** rng.uniform(-6 if wide > 1 else -1, -0.3), 0.0, 1.0, 1.0)]
        lower = [(0.0, 0.0, 1.0, 1.0), (0.0, 3.0, 1.0, 1.0)]
    elif kind == 4:  # one inside another's circle
        upper = [(0.0, 0.0, 1.0, 10.0), (rng.uniform(0, 0.5), 0.0, 1.0 + 0.1 * rng.random(), 0.1)]
        lower = [(0.0, 0.0, 0.0, 1e4)]
    else:
        upper, lower = ([(rng.uniform(-2, 2), rng.uniform(-2, 2), 0.1 * rng.random(),
                          rng.uniform(0.3, 2)) for _ in range(rng.choice([1, 2, 5]))]
                        for _ in range(2))
    return [[tuple(c * scale for c in row) for row in rows] for rows in (upper, lower)], scale


def loading(rng, scale):
    """The groups that state how far to close."""
    points = f", points = {rng.choice([1, 2, 5])}" if rng.random() < 0.15 else ""
    draw = rng.random()
    if draw < 0.4:
        value = rng.choice([1e-300, 1e-12, 1e-3, 1.0, 40.0, 1e3, 1e4, 1e6, 1e12, 1e300])
        return f"&loading control = 'load', value = {value!r}{points} /\n"
    if draw < 0.5:
        value = rng.choice([0.9, 0.5, 0.4, 0.1, 0.0, -0.1]) * scale
        return f"&loading control = 'approach', value = {value!r}{points} /\n"
    criterion = rng.choice(["criterion = 'load', value = 30.",
                            "criterion = 'pressure', value = 2e4",
                            "criterion = 'hardy', yield_stress = 2e3",
                            "criterion = 'load', value = 1e-9"])
    return (f"&loading control = 'limit'{points} /\n" if points else "") + f"&limit {criterion} /\n"


def effects(rng):
    """The group, most often valid."""
    wild = rng.choice([0.0, 0.0, 0.0, 0.15])
    given = {}
    for name, words in WAYS.items():
        if rng.random() < 0.75:
            given[name] = rng.choice(words)
    if rng.random() < 0.15:
        name = rng.choice(list(OTHERS))
        given[name] = rng.choice(OTHERS[name])
    for name in list(given):
        if rng.random() < wild:
            given[name] = rng.choice(WRONG_WORDS)
    given = {name: "'" + word + "'" for name, word in given.items()}
    if rng.random() < 0.4:
        given["tolerance"] = number(rng, SHARES, wild)
    given["boundary_tolerance"] = number(rng, BOUNDARY_SHARES, wild)
    if rng.random() < 0.9:
        given["friction_coefficient"] = number(rng, COEFFICIENTS, wild)
    for name, values in OWN_NUMBERS.items():
        if given.keys() & OTHERS.keys() and rng.random() < 0.7:
            given[name] = number(rng, values, wild)
    names = list(given)
    rng.shuffle(names)
    return "&effects " + ", ".join(f"{name} = {given[name]}" for name in names) + " /\n"


def random_scene(rng):
    """A scene and the two surfaces that it names."""
    group = effects(rng)
    on_cells = "'boundary'" in group or "interaction = 'auto'" in group
    (upper, lower), scale = geometry(rng, 1 if on_cells else 3)
    text = "&surfaces upper = 'u.csv', lower = 'l.csv' /\n"
    ratios = rng.choice(["0.3, 0.25", "0.3, 0.25", "2*0.5", "-0.99, 0.5", "2*0."])
    text += f"&material elastic_modulus = 2e5, 1e5, poisson_ratio = {ratios} /\n"
    if rng.random() < 0.2:
        text += f"&motion x_first = 0., x_step = {0.1 * scale!r}, positions = 4 /\n"
    if rng.random() < 0.1:
        text += "&tilt upper_slope = 0.01, -0.02 /\n"
    text += loading(rng, scale) + group
    return text.encode(), surface(upper), surface(lower)


def keep_cells_coarse(scene):
    """Finer cells than the fuzzer has time for become coarse ones."""
    def coarser(match):
        try:
            value = float(match.group(2))
        except ValueError:
            return match.group(0)
        return match.group(1) + (b"1e-3" if 0 < value < LEAST_CELLS else match.group(2))
    return re.sub(rb"(?i)(boundary_tolerance\s*=\s*)([-+.\deE]+)", coarser, scene)


def largest_tolerance(scene):
    """The largest in the scene, or 0.01, that of `auto`."""
    given = re.findall(rb"(?i)tolerance\s*=\s*([-+.\deE]+)", scene)
    return max([0.01, *(float(value) for value in given)])


def broken_laws(data, scene):
    """What a file of positions states that no surfaces can do."""
    wrong, tolerance = [], largest_tolerance(scene)
    for row in csv.DictReader(data.decode("ascii").splitlines()):
        try:
            value = {name: float(cell) for name, cell in row.items()
                     if name not in EFFECTS and cell}
        except (TypeError, ValueError):
            return wrong  # reported elsewhere
        alone = "alone_load" not in value or row.get("interaction") == "off"
        # Elements press bodies without a ratio to Hertz' law: within their tolerance.
        slack = tolerance if value.get("cells", 0.0) > 0.0 else 1e-9
        if not alone and not 0.0 < value["factor"] <= 1.0 + slack:
            wrong.append(f"position {row['position']}: factor {row['factor']}")
        if row.get("friction") == "on" and \
                value["vertical_load"] < value["frictionless_load"] * (1 - 1e-12):
            wrong.append(f"position {row['position']}: friction lowers the load")
        for name, cell in value.items():
            if name.endswith("_residual") and not 0.0 <= cell <= 0.01 * tolerance:
                wrong.append(f"position {row['position']}: {name} {cell}")
            if name.endswith("load") and "adhesion" not in row and cell < 0.0:
                wrong.append(f"position {row['position']}: {name} {cell}")
        if not all(map(math.isfinite, value.values())):
            wrong.append(f"position {row['position']}: not finite")
    return wrong
