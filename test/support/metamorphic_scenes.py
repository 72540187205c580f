"""Scenes whose numbers are known with their units, so that they can be moved, turned and scaled.

Coordinates are multiples of a power of two: to mirror, turn, shift or scale them changes no digit.
"""

import copy
import math
import random
from dataclasses import dataclass

from judge import ask
from surfaces_csv import write_scene, write_surface

# Powers of a length and of a modulus in the unit of a name of a scene.
UNITS = {"elastic_modulus": (0, 1), "contact_modulus": (0, 1), "x_first": (1, 0), "x_step": (1, 0),
         "y_first": (1, 0), "y_step": (1, 0), "hardness": (0, 1), "yield_stress": (0, 1),
         "plastic_yield_stress": (0, 1), "work_of_adhesion": (1, 1), "equilibrium_distance": (1, 0)}
VALUES = {"load": (2, 1), "vertical_load": (2, 1), "approach": (1, 0), "pressure": (0, 1)}
GRID = 2.0 ** -14
# Results are bit for bit the same, or differ by rounding: of coordinates up to 20 in sums of up to
# 64 contacts, through the slope of load over compression. Contacts of 1e-9 of the compression lose
# 1e9
# roundings; scenes close by 1e-3 at least, or to a load that is met to 1e-11.
ROUNDING = 1e-9
# What neighbours take away is solved to so much of the load where circles carry it.
COUPLED = 1e-8


@dataclass
class Scene:
    """Two surfaces, rows (x, y, height, radius), and the groups beside them."""

    upper: list
    lower: list
    groups: dict
    kind: str = ""

    def write(self, folder):
        """Effects that a scene does not name are off."""
        upper, lower = (write_surface(folder / f"{side}.csv", getattr(self, side))
                        for side in ("upper", "lower"))
        return write_scene(folder / "s.scene", surfaces={"upper": upper, "lower": lower},
                           **self.groups)

    def scaled(self, lengths, moduli):
        """In units of length and of modulus that are so many powers of two smaller."""
        return mapped(self, lambda row: tuple(c * 2.0 ** lengths for c in row),
                      of_number=lambda v, a, b: v * 2.0 ** (a * lengths + b * moduli))

    def share(self):
        """How far two solutions of one problem may differ: where contacts are resolved on cells,
        each is as near to the truth as was asked for."""
        effects = self.groups.get("effects", {})
        asked = {"coupled": COUPLED, "auto": 2 * effects.get("tolerance", 0.01),
                 "boundary": 2 * effects.get("boundary_tolerance", 1e-3)}
        return asked.get(effects.get("interaction"), ROUNDING)


def on_grid(value):
    return round(value / GRID) * GRID


def run(exe, scene):
    """The answer, with all tables."""
    return ask(exe, scene.write, curve=True, timeout=600)


# ---------------------------------------------------------------- what is done to a scene

def mapped(scene, of_row, of_plan=None, of_number=None):
    """A copy with other rows, other vectors in plan, and other numbers by their unit."""
    new = copy.deepcopy(scene)
    new.upper = [of_row(row) for row in scene.upper]
    new.lower = [of_row(row) for row in scene.lower]
    groups = new.groups
    if of_plan:
        for what in ("first", "step"):
            motion = groups.get("motion", {})
            if any(f"{axis}_{what}" in motion for axis in "xy"):
                pair = of_plan(*(motion.get(f"{axis}_{what}", 0.0) for axis in "xy"))
                motion.update({f"{axis}_{what}": value for axis, value in zip("xy", pair)})
        for name, value in groups.get("tilt", {}).items():
            if name.endswith("_slope"):
                groups["tilt"][name] = list(of_plan(*value))
    if of_number:
        for names in groups.values():
            for name, value in names.items():
                unit = UNITS.get(name)
                if name == "value":
                    unit = VALUES[names.get("control", names.get("criterion"))]
                if unit:
                    many = isinstance(value, (list, tuple))
                    values = [of_number(v, *unit) for v in (value if many else [value])]
                    names[name] = values if many else values[0]
    return new


def mirrored(scene):
    return mapped(scene, lambda row: (-row[0], *row[1:]), lambda x, y: (-x, y))


def turned(scene):
    return mapped(scene, lambda row: (-row[1], row[0], *row[2:]), lambda x, y: (-y, x))


def exchanged(scene):
    """Mirrored at the mean plane: slopes and displacements change their signs."""
    new = mapped(scene, lambda row: row, lambda x, y: (-x, -y))
    new.upper, new.lower = new.lower, new.upper
    for values in new.groups["material"].values():
        values.reverse()
    new.groups["tilt"] = {{"upper": "lower", "lower": "upper"}[name[:5]] + name[5:]: value
                          for name, value in new.groups.get("tilt", {}).items()}
    return new


def permuted(scene, rng):
    new = copy.deepcopy(scene)
    rng.shuffle(new.upper)
    rng.shuffle(new.lower)
    return new


def in_copies(scene, number, distance):
    """So many copies of the whole, far from one another; a load is shared by them."""
    new = copy.deepcopy(scene)
    for side in ("upper", "lower"):
        setattr(new, side, [(x + i * distance, y, height, radius) for i in range(number)
                            for x, y, height, radius in getattr(scene, side)])
    loading = new.groups["loading"]
    if loading["control"] in ("load", "vertical_load"):
        value = loading["value"]
        loading["value"] = [number * v for v in value] if isinstance(value, list) \
            else number * value
    return new


# ---------------------------------------------------------------- random scenes

def surfaces(rng):
    """A few asperities a side that meet: apart, dense, unlike in size, steep, or in one place."""
    kind = rng.choice(["apart", "dense", "unlike", "steep", "one place", "a plate"])
    n = rng.choice([1, 2, 3, 5, 8])
    if kind == "apart":
        upper = [(4.0 * i, 0.0, 0.1 + 0.05 * rng.random(), rng.uniform(0.5, 2)) for i in range(n)]
        lower = [(4.0 * i + 0.1 * rng.random(), 0.1 * rng.random(), 0.1 + 0.05 * rng.random(),
                  rng.uniform(0.5, 2)) for i in range(n)]
    elif kind == "dense":
        upper, lower = ([(rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5),
                          0.1 + 0.02 * rng.random(), rng.uniform(0.5, 2))
                         for _ in range(min(n, 4))] for _ in range(2))
    elif kind == "unlike":
        upper = [(3.0 * i, 0.0, 0.1 + 0.02 * rng.random(), 10 ** rng.uniform(-1, 2))
                 for i in range(n)]
        lower = [(3.0 * i, 0.05, 0.1, 10 ** rng.uniform(-1, 2)) for i in range(n)]
    elif kind == "steep":
        upper = [(6.0 * i, 0.0, 1.0, 1.0) for i in range(min(n, 2))]
        lower = [(6.0 * i + rng.uniform(0.3, 1.7), 0.0, 1.0, 1.0) for i in range(min(n, 2))]
    elif kind == "one place":
        upper = [(0.0, 0.0, 0.1, 1.0)] * min(n, 3)
        lower = [(rng.choice([0.0, 0.01]), 0.0, 0.1, 1.5)]
    else:
        pitch = rng.choice([0.2, 0.5, 2.0])
        upper = [(pitch * (i % 3), pitch * (i // 3), 0.1 + 0.01 * rng.random(), 1.0)
                 for i in range(n)]
        lower = [(0.0, 0.0, 0.0, 2.0 ** 14)]
    return [[tuple(map(on_grid, row)) for row in rows] for rows in (upper, lower)], kind


def own_effects(rng):
    """Effects that go together, with their numbers."""
    draw = rng.randrange(9)
    chosen = {}
    if draw in (1, 4, 8):
        chosen |= {"interaction": rng.choice(["coupled", "auto", "auto"])}
    if draw == 1 and rng.random() < 0.15:
        chosen |= {"interaction": "boundary", "boundary_tolerance": 0.02}
    if draw in (2, 4, 7):
        chosen |= {"friction": rng.choice(["on", "auto"]),
                   "friction_coefficient": rng.choice([0.1, 0.3, 1.0])}
    if draw in (3, 7):
        chosen |= {"plasticity": rng.choice(["on", "auto"]),
                   "plastic_yield_stress": rng.choice([300.0, 2000.0, 2e4])}
    if draw == 5:
        chosen |= {"adhesion": rng.choice(["on", "auto"]),
                   "work_of_adhesion": rng.choice([0.0, 1e-4, 1e-2, 1.0]),
                   "equilibrium_distance": rng.choice([1e-6, 1e-3])}
    if draw in (6, 8):
        chosen |= {"creep": rng.choice(["on", "auto"]), "hold_time": 10.0, "hold_points": 4,
                   "relaxation_time": rng.choice([1.0, 100.0]), "relaxed_modulus_ratio": 0.5,
                   "hold": rng.choice(["load", "approach"])}
    if chosen:
        chosen["tolerance"] = rng.choice([0.003, 0.01, 0.1])
    return chosen


def random_scene(rng):
    (upper, lower), kind = surfaces(rng)
    groups = {"material": {"elastic_modulus": [2.0e5, 1.0e5], "poisson_ratio": [0.3, 0.25]}}
    if rng.random() < 0.15:
        groups["motion"] = {"x_first": 0.0, "x_step": 0.0625, "y_step": -0.03125, "positions": 3}
    if rng.random() < 0.15:
        groups["tilt"] = {"upper_slope": [2.0 ** -9, -(2.0 ** -10)]}
    draw = rng.random()
    if draw < 0.5:
        groups["loading"] = {"control": "load", "value": float(f"{10 ** rng.uniform(-3, 4):.3g}")}
    elif draw < 0.8:
        # From first touch on, as near as the surfaces come.
        highest = max(row[2] for row in upper) + max(row[2] for row in lower)
        groups["loading"] = {"control": "approach",
                             "value": on_grid(highest - 10 ** rng.uniform(-3, -1.3))}
    else:
        groups["loading"] = {"control": "limit"}
        groups["limit"] = {"criterion": "load", "value": rng.choice([1e-3, 3.0, 300.0])}
    chosen = own_effects(rng)
    if groups["loading"]["control"] == "load" and rng.random() < 0.3:
        value = groups["loading"]["value"]
        groups["loading"]["value"] = [value, 2 * value]
        # Friction, creep and neighbours have no way back.
        if not chosen.keys() & {"friction", "creep", "interaction"} and rng.random() < 0.5:
            groups["loading"]["value"] = [value, 0.0, value]
    if groups["loading"]["control"] != "limit" and rng.random() < 0.2:
        groups["loading"]["points"] = 3
    if chosen:
        groups["effects"] = chosen
    return Scene(upper, lower, groups, kind)


def pull(scene):
    """A bound on what all pairs can pull together: 2 pi w R of each, R at most the smaller radius.
    0 without adhesion."""
    work = scene.groups.get("effects", {}).get("work_of_adhesion", 0.0)
    return sum(2 * math.pi * work * min(upper[3], lower[3])
               for upper in scene.upper for lower in scene.lower)


def scene_of_seed(seed):
    """Draws of its own for what came later: a seed stays what it was."""
    scene = random_scene(random.Random(f"metamorphic {seed}"))
    loading, rng = scene.groups["loading"], random.Random(f"weights {seed}")
    if loading["control"] == "load":
        if rng.random() < 0.3:
            loading["control"] = "vertical_load"
        if "adhesion" in scene.groups.get("effects", {}) and rng.random() < 0.3:
            first = loading["value"]
            loading["value"] = [first[0] if isinstance(first, list) else first,
                                -pull(scene) * rng.choice([0.01, 0.2, 2.0]) / len(scene.upper)]
    return scene
