"""Random scenes of every pair of effects, with their mirror images and loads next to theirs.

A scene is a path of loads, or one load, with a hold where there is creep. All of them are small,
and all of them must be solved. Seeds begin with the number of the pair.
"""

import copy
from itertools import combinations

import numpy as np
from map_scenes import write_map
from metamorphic_scenes import Scene, mirrored
from surfaces_csv import solve, write_scene

EFFECTS = ("interaction", "friction", "plasticity", "adhesion", "creep")
# Relative change of all loads of a path.
STEP = 1e-9
# Pairs without a common theory (docs/reference/scene-files.md).
APART = {"asperities": {("friction", "adhesion"), ("friction", "creep"), ("plasticity", "adhesion"),
                        ("plasticity", "creep"), ("adhesion", "creep"),
                        ("interaction", "adhesion")},
         "pixels": {("friction", "creep")}}
PAIRS = [(model, *pair) for model in APART for pair in combinations(EFFECTS, 2)
         if pair not in APART[model]]


class Map:
    """A height map, indexed [x, y], and the groups beside it."""

    def __init__(self, height, sides, groups):
        self.height, self.sides, self.groups = height, sides, groups

    def write(self, folder):
        groups = copy.deepcopy(self.groups)
        groups["surfaces"] = {"upper": "plane", "lower": write_map(folder / "map.txt", self.height),
                              "map_spacing": self.sides, **groups["surfaces"]}
        return write_scene(folder / "s.scene", by_default=True, **groups)


def path_of(rng, load, most=np.inf, unloads=True):
    """One load, or three: unloading, and a larger or a smaller one again."""
    if rng.random() < 0.3 or not unloads:
        return float(load)
    return tuple(float(min(load * share, most)) for share in
                 (1, rng.uniform(0.05, 0.95), rng.uniform(0.3, 1.5)))


def creep_of(rng):
    return {"creep": "on", "relaxation_time": 1.0, "hold_time": float(rng.uniform(0.3, 4)),
            "relaxed_modulus_ratio": float(rng.uniform(0.1, 0.9)),
            "hold": str(rng.choice(["load", "separation"])), "hold_points": int(rng.integers(2, 6)),
            "loading_time": float(rng.choice([0.0, rng.uniform(0.2, 5)]))}


def asperities(rng, pair):
    """Three to twelve caps a body, of which many meet, at loads of a few penetrations."""
    n, extra = int(rng.integers(2, 7)), int(rng.integers(0, 7))
    width = np.sqrt(n) * rng.uniform(0.3, 2)
    places = rng.uniform(0, width, (n, 2))
    lower = np.vstack([places + rng.uniform(-0.3, 0.3, (n, 2)), rng.uniform(0, width, (extra, 2))])

    def caps(places):
        size = len(places)
        return [tuple(map(float, row)) for row in
                np.column_stack([places, 0.3 + rng.uniform(0.01, 0.04) * rng.uniform(-1, 1, size),
                                 rng.uniform(0.7, 2, size)])]

    effects = {"interaction": "off"}
    if "interaction" in pair:
        effects["interaction"] = str(rng.choice(["coupled", "coupled", "auto", "boundary"]))
        if "adhesion" in pair or "plasticity" in pair and effects["interaction"] == "boundary":
            effects["interaction"] = "coupled"
    if "friction" in pair:
        effects |= {"friction": "on", "friction_coefficient": float(rng.uniform(0.05, 0.6))}
    if "plasticity" in pair:
        effects |= {"plasticity": "on", "plastic_yield_stress": float(10 ** rng.uniform(0.7, 2.3))}
    if "adhesion" in pair:
        effects |= {"adhesion": "on", "work_of_adhesion": 0.01, "equilibrium_distance": 1e-3}
    if "creep" in pair:
        effects |= creep_of(rng)
    load = 2000 * rng.uniform(0.002, 0.025) ** 1.5
    return Scene(caps(places), caps(lower), {
        "material": {"elastic_modulus": (2000.0, 2000.0), "poisson_ratio": (0.3, 0.3)},
        "loading": {"control": "load", "value": path_of(rng, load, unloads="friction" not in pair)},
        "effects": effects})


def pixels(rng, pair):
    """A smooth random map, from light contact to full contact."""
    shape = rng.integers(8, 17, 2)
    wave = np.hypot(*np.meshgrid(*(np.fft.fftfreq(n) * n for n in shape), indexing="ij"))
    spectrum = np.where((wave > 0) & (wave < 4), np.maximum(wave, 1.0) ** -1.8, 0)
    height = np.fft.ifft2(np.fft.fft2(rng.normal(size=tuple(shape))) * spectrum).real
    height *= rng.uniform(0.002, 0.03) / height.std()
    sides = (0.1, float(rng.choice([0.1, 0.05])))
    slope = np.gradient(height, *sides)
    slope = np.sqrt(np.mean(slope[0] ** 2 + slope[1] ** 2))
    area = height.size * np.prod(sides)
    effects, loading = {"interaction": "boundary"}, {"control": "load"}
    pressure, most = slope * 10 ** rng.uniform(-2, 0.5), np.inf
    if "plasticity" in pair:
        hardness = float(slope * rng.uniform(0.2, 3))
        effects |= {"plasticity": "on", "plastic_hardness": hardness}
        most = 0.6 * hardness * area
    if "adhesion" in pair:
        distance = float(height.std() * 10 ** rng.uniform(-1, 1))
        effects |= {"adhesion": "on", "equilibrium_distance": distance,
                    "work_of_adhesion": float(distance ** 2 / 0.1 * 10 ** rng.uniform(-2, -0.9)),
                    "adhesion_law": str(rng.choice(["exponential", "van_der_waals"]))}
    if "creep" in pair:
        effects |= creep_of(rng)
    load = min(pressure * area, most)
    material = {"contact_modulus": 1.0}
    if "friction" in pair:
        material = {"elastic_modulus": (2.0, 2.0), "poisson_ratio": (0.3, 0.3)}
        effects |= {"friction": "on", "friction_coefficient": float(rng.uniform(0.1, 0.6))}
        loading["tangential_load"] = float(effects["friction_coefficient"] * rng.uniform(0, 0.95)
                                           * load)
    loading["value"] = path_of(rng, load, most)
    if "friction" in pair:
        last = np.atleast_1d(loading["value"])[-1]
        loading["tangential_load"] *= float(last / load)
    return Map(height, sides, {
        "surfaces": {"map_edge": str(rng.choice(["periodic", "periodic", "free"])),
                     "map_level": "none"},
        "material": material, "loading": loading, "effects": effects})


def scene_of(number, seed):
    """A scene of the pair of this number."""
    model, *pair = PAIRS[number]
    rng = np.random.default_rng((number, seed))
    return (asperities if model == "asperities" else pixels)(rng, pair)


def mirror(scene):
    """Its mirror image in x."""
    if isinstance(scene, Map):
        return Map(scene.height[::-1], scene.sides, scene.groups)
    return mirrored(scene)


def loaded(scene, factor):
    """The same with all loads multiplied."""
    new = copy.deepcopy(scene)
    loading = new.groups["loading"]
    loading["value"] = tuple(factor * value for value in np.atleast_1d(loading["value"]).tolist())
    if len(loading["value"]) == 1:
        loading["value"] = loading["value"][0]
    return new


def tolerance_of(scene):
    """How far the results of two of its copies may differ."""
    effects = scene.groups["effects"]
    if isinstance(scene, Map):
        return 1e-5 if "adhesion" in effects else 1e-6
    return {"auto": 2e-2, "boundary": 1e-2}.get(effects["interaction"], 1e-6)


def faults(asperity, folder, scene):
    """What is wrong with a scene: copies that are not solved, results that differ."""
    found, rows = [], {}
    for name, other in (("base", scene), ("mirrored", mirror(scene)),
                        ("less", loaded(scene, 1 - STEP)), ("more", loaded(scene, 1 + STEP))):
        answer = solve(asperity, other.write(folder), "--threads", "1", contacts=False, curve=True,
                       timeout=600)
        if answer.status:
            found.append(f"{name}: status {answer.status}, {answer.stderr.strip()[-200:]}")
            continue
        rows[name] = [{key: float(row[key]) for key in ("load", "compression", "area")}
                      for row in answer.curve]
    share = tolerance_of(scene)
    for name, table in rows.items():
        if "base" not in rows or len(table) != len(rows["base"]):
            continue
        for key in ("load", "compression", "area"):
            scale = max(row[key] for row in rows["base"])
            least = share * scale
            if isinstance(scene, Map):
                # One pixel may be in contact or not; compressions are differences of heights.
                if key == "area":
                    least = max(least, 1.01 * np.prod(scene.sides))
                if key == "compression":
                    least = max(least, share * np.ptp(scene.height))
            apart = max(abs(row[key] - other[key]) for row, other in zip(table, rows["base"]))
            if apart > least:
                found.append(f"{name}: {key} apart by {apart / scale:.1e}")
    return found
