"""Laws of scenes whose surface is a height map: the same laws as of asperities, and two of its own.

    python test/support/map_laws.py --exe PATH --runs 500 [--seed 0]

A scene is drawn by its seed: a made map of 144 to 6400 samples (or two of them), rough at the pixel
or smooth, with or without samples that are missing; a load, a pressure or a level of the flat, one
value or a path; summits by the contact rule, taken alone or coupled, the samples themselves, or
what is good enough. Each is asked one law; the summits that `asperity summits` finds by either rule
are asked the laws of the plane.
"""

import copy
import csv
import functools
import math
import random
from dataclasses import dataclass, field

import numpy as np

import metamorphic_laws as laws
import metamorphic_scenes as scenes

import made_maps
from programs import run_program

# Gaps of samples are closed to 1e-9 of the range of heights: of the load that is, by how stiff the
# contact is, up to some hundred times as much.
SAMPLES = 1e-6
# Mirrored, turned or tilted, a map is levelled by sums in another order; summits are coupled as
# always.
SUMMITS = {"off": 1e-9, "coupled": laws.COUPLED, "auto": SAMPLES, "boundary": SAMPLES}
# Where circles overlap, coupled contacts may have several solutions, up to 4e-4 apart as seen.
OVERLAPPING = 1e-3
UNITS = {**scenes.UNITS, "map_spacing": (1, 0)}


@dataclass
class MapScene:
    """Heights by column and row (x, y), one map or two, and the groups beside them."""

    maps: list
    groups: dict
    over: bool = False  # the map is the upper surface
    kind: str = ""
    upper: list = field(default_factory=list)
    lower: list = field(default_factory=list)


def write(scene, folder, name="s"):
    """Text matrices, one profile a line."""
    files = []
    for k, height in enumerate(scene.maps):
        files.append(f"{name}{k}.txt")
        (folder / files[-1]).write_text("".join(
            " ".join("BAD" if math.isnan(z) else repr(z) for z in row) + "\n"
            for row in height.T.tolist()), encoding="ascii")
    files = [*files, "plane"][:2]
    words = dict(zip(("upper", "lower") if scene.over else ("lower", "upper"), files))
    text = ""
    effects = {"interaction": "off", **scene.groups.get("effects", {})}
    for group, names in {"surfaces": {}, **scene.groups, "effects": effects}.items():
        names = {**words, **names} if group == "surfaces" else names
        text += f"&{group} " + ", ".join(f"{key} = {scenes.text_of(value)}"
                                         for key, value in names.items()) + " /\n"
    (folder / f"{name}.scene").write_text(text, encoding="ascii")


run = functools.partial(scenes.run, write=write)


# ---------------------------------------------------------------- random scenes

def random_scene(seed):
    rng = random.Random(f"map {seed}")
    shape = (rng.randrange(12, 81), rng.randrange(12, 81))
    sides = [rng.choice([1.0, 0.01]), rng.choice([1.0, 0.01])]
    sides[1] = sides[0] * rng.choice([1.0, 1.0, 1.5])

    def made():
        height, _ = made_maps.self_affine(shape, rng.randrange(10 ** 9), hurst=rng.uniform(0.3, 1),
                                          shortest=rng.choice([2, 3, 6, 10]),
                                          stretch=rng.choice([1.0, 1.0, 3.0]))
        return height * sides[0] * 10 ** rng.uniform(-3, -0.5)

    maps = [made() for _ in range(rng.choice([1, 1, 1, 2]))]
    if rng.random() < 0.2:
        x, y = (rng.randrange(2, n - 5) for n in shape)
        maps[0][x:x + 3, y:y + 2] = np.nan
    modulus = rng.choice([1.0, 2.1e5])
    material = {"contact_modulus": modulus}
    slope = np.gradient(np.nan_to_num(sum(maps)), *sides)
    area = shape[0] * shape[1] * sides[0] * sides[1]
    # What presses about a share of the area together: half the rms slope times the modulus.
    pressure = 10 ** rng.uniform(-3.5, -0.3) * modulus / 2 * math.sqrt(
        float(np.mean(slope[0] ** 2 + slope[1] ** 2)))
    control = rng.choice(["load", "vertical_load", "pressure", "approach"])
    value = {"pressure": pressure, "approach": float(np.nanstd(sum(maps))) * rng.uniform(0.5, 2.5)}
    loading = {"control": control, "value": value.get(control, pressure * area)}
    if rng.random() < 0.3:
        loading["points"] = 3
    elif control != "approach" and rng.random() < 0.3:
        loading["value"] = [loading["value"], 2 * loading["value"]]
    effects = {"interaction": rng.choice(["off", "coupled", "coupled", "boundary", "auto", "auto"]),
               "tolerance": rng.choice([0.01, 0.1, 0.5])}
    if effects["interaction"] in ("off", "coupled") and rng.random() < 0.2:
        # Which body yields: E* is the same.
        material = {"elastic_modulus": [2 * modulus * (1 - 0.3 ** 2)] * 2,
                    "poisson_ratio": [0.3, 0.3]}
        effects |= {"plasticity": rng.choice(["on", "auto"]),
                    "plastic_yield_stress": modulus * rng.choice([1e-3, 1e-2])}
    surfaces = {"map_spacing": sides}
    if effects["interaction"] != "off" and rng.random() < 0.3:
        # `coupled` is refused of a periodic map.
        surfaces["map_edge"] = "periodic"
        effects = {"interaction": rng.choice(["boundary", "auto"]), "tolerance": 0.01}
    return MapScene(maps, {"surfaces": surfaces, "material": material, "loading": loading,
                           "effects": effects}, rng.random() < 0.3)


# ---------------------------------------------------------------- what is done to a map

def mapped(scene, of_map, swap=False, of_number=None):
    new = copy.deepcopy(scene)
    new.maps = [of_map(height) for height in scene.maps]
    if swap:
        new.groups["surfaces"]["map_spacing"].reverse()
    for names in new.groups.values() if of_number else ():
        for name, value in names.items():
            unit = scenes.VALUES[names["control"]] if name == "value" else UNITS.get(name)
            if unit:
                names[name] = [of_number(v, *unit) for v in value] if isinstance(value, list) \
                    else of_number(value, *unit)
    return new


def tilted(height):
    """Raised and on a slope, by its own size."""
    x, y = np.indices(height.shape)
    top = float(np.nanmax(np.abs(height)))
    return height + top * (1.0 + x / height.shape[0] - 0.5 * y / height.shape[1])


CHANGES = {"mirrored": (lambda h: h[::-1], False), "transposed": (lambda h: h.T, True),
           "turned by 90 degrees": (lambda h: h.T[::-1], True),
           "raised and tilted": (tilted, False),
           "rolled": (lambda h: np.roll(h, (5, 3), (0, 1)), False)}


# ---------------------------------------------------------------- the laws

def look(scene, done):
    """What must hold of any result; of a pressure the vertical load is looked at."""
    seen = MapScene([], {**scene.groups, "loading": dict(scene.groups["loading"])})
    loading = seen.groups["loading"]
    if loading["control"] == "pressure":
        area = sum(~np.isnan(sum(scene.maps)).ravel()) * math.prod(
            scene.groups["surfaces"]["map_spacing"])
        loading["control"], value = "vertical_load", loading["value"]
        loading["value"] = [v * area for v in value] if isinstance(value, list) else value * area
    laws.look(seen, done)


def same_after(scene, other, exe, folder, share=None, names=None):
    one, two = (run(exe, s, folder) for s in (scene, other))
    look(scene, one)
    look(other, two)
    if not laws.both(one, two):
        return one.status
    control, way = scene.groups["loading"]["control"], scene.groups["effects"]["interaction"]
    if names:
        laws.within(one, two, share, names, control)
        return one.status
    share = share or solved_share(scene, one, two)
    for what in ("positions", "curve"):
        rows, others = one.files[what], two.files[what]
        laws.claim(len(rows) == len(others), "number of states")
        for row, far in zip(rows, others):
            for name in ("load", "vertical_load"):
                laws.near(*(laws.number(r, name) for r in (row, far)), share, name,
                          1e-3 * laws.largest(one, name))
            # A sample at the rim of a spot may bear next to nothing, or nothing.
            of_samples = "sample_area" in rows[0] or way in ("boundary", "auto")
            spare = 2 * math.prod(scene.groups["surfaces"]["map_spacing"]) if of_samples else 0.0
            laws.claim(abs(laws.number(row, "area") - laws.number(far, "area"))
                       <= share * laws.number(row, "area") + spare, "area")
            closings = [top_of(s) - laws.number(r, "separation")
                        for s, r in ((scene, row), (other, far))]
            laws.near(*closings, share, "closing", 1e-3 * (top_of(scene) or 1.0))
    return one.status


def solved_share(scene, *runs):
    """How far two solutions of one problem may differ."""
    way = scene.groups["effects"]["interaction"]
    overlap = way != "off" and any(laws.number(row, "overlapping_circles") > 0 for done in runs
                                   for row in done.files["positions"])
    return OVERLAPPING if overlap else SUMMITS[way]


def top_of(scene):
    """The highest sample over the plane of least squares of each map and of their sum, of periodic
    maps over their mean."""
    def level(height):
        if "map_edge" in scene.groups["surfaces"]:
            return height - np.nanmean(height)
        there = ~np.isnan(height)
        x, y = np.indices(height.shape)
        columns = np.stack([x[there], y[there], np.ones(there.sum())], axis=1)
        found = np.linalg.lstsq(columns, height[there], rcond=None)[0]
        return height - (found[0] * x + found[1] * y + found[2])

    return float(np.nanmax(level(sum(map(level, scene.maps)))))


def law_changed(change):
    def law(scene, exe, folder, _rng):
        of_map, swap = CHANGES[change]
        if change == "rolled":
            scene = copy.deepcopy(scene)
            scene.groups["surfaces"]["map_edge"] = "periodic"
            scene.groups["effects"] = {"interaction": "boundary"}
        elif change == "raised and tilted" and scene.groups["surfaces"].get("map_edge"):
            # Tilted, it would not be periodic.
            return None
        return same_after(scene, mapped(scene, of_map, swap), exe, folder)
    return law


def law_scaled(scene, exe, folder, rng):
    lengths, moduli = rng.choice([(40, 0), (-40, 0), (0, 40), (0, -40), (39, -41), (-39, 3)])
    other = mapped(scene, lambda h: h * 2.0 ** lengths,
                   of_number=lambda v, a, b: v * 2.0 ** (a * lengths + b * moduli))
    one, two = (run(exe, s, folder) for s in (scene, other))
    look(scene, one)
    if laws.both(one, two):
        laws.same_digits(one, two, lengths, moduli)
    return one.status


def law_exchanged(scene, exe, folder, _rng):
    """A map that presses, and one that is pressed."""
    other = copy.deepcopy(scene)
    other.over = not scene.over
    return same_after(scene, other, exe, folder)


def law_tighter(scene, exe, folder, _rng):
    effects = scene.groups["effects"]
    if "auto" not in effects.values():
        return None
    other = copy.deepcopy(scene)
    other.groups["effects"]["tolerance"] = effects["tolerance"] / 30
    return same_after(scene, other, exe, folder, effects["tolerance"] * 31 / 30, ("load", "area"))


def law_one_more_state(scene, exe, folder, _rng):
    loading = scene.groups["loading"]
    if isinstance(loading["value"], list):
        return None
    other = copy.deepcopy(scene)
    other.groups["loading"]["points"] = loading.get("points", 1) + 1
    one, two = (run(exe, s, folder) for s in (scene, other))
    look(scene, one)
    look(other, two)
    if laws.both(one, two):
        for name in (*laws.TOTALS, "separation"):
            laws.near(*(laws.number(r.files["positions"][-1], name) for r in (one, two)),
                      solved_share(scene, one, two), name)
    return one.status


def law_given_back(scene, exe, folder, _rng):
    """The level that a load gives, given, gives the load. The map may not be pressed to where its
    summits are."""
    loading = scene.groups["loading"]
    if loading["control"] == "approach":
        return None
    one = run(exe, scene, folder)
    look(scene, one)
    if one.status:
        return one.status
    row = one.files["positions"][-1]
    other = copy.deepcopy(scene)
    other.groups["loading"] = {"control": "approach", "value": float(row["separation"])}
    two = run(exe, other, folder)
    if two.status == 1 and ("the map " in two.err or "mean height of a map" in two.err):
        return None
    if laws.both(one, two) and "auto" not in scene.groups["effects"].values():
        laws.near(laws.number(row, "load"), laws.number(two.files["positions"][-1], "load"),
                  max(SAMPLES, solved_share(scene, one, two)), "load at the level found")
    return one.status


def law_of_summits(scene, exe, folder, rng):
    """What `asperity summits` finds, by either rule, on the map and on the changed one."""
    sides = scene.groups["surfaces"]["map_spacing"]
    of_map, swap = rng.choice([CHANGES[name] for name in ("mirrored", "transposed",
                                                          "turned by 90 degrees")])
    rule, found = rng.choice(["eight", "contact"]), []
    for other in (scene, mapped(scene, of_map, swap)):
        write(other, folder)
        spacing = ",".join(map(repr, other.groups["surfaces"]["map_spacing"]))
        done = run_program(exe, "summits", "s0.txt", "--rule", rule, "--spacing", spacing,
                           "--output", "-", status=None, cwd=folder)
        laws.claim(done.returncode == 0, done.stderr)
        found.append(np.array([[float(v) for v in row.values()]
                               for row in csv.DictReader(done.stdout.splitlines())]))
    one, two = (f.reshape(-1, 4) for f in found)
    laws.claim(len(one) == len(two), f"{len(one)} and {len(two)} summits by {rule}")
    width = (scene.maps[0].shape[0] - 1) * sides[0]
    places = one.copy()
    if of_map is CHANGES["transposed"][0] or swap:
        places[:, :2] = places[:, 1::-1]
    if not swap:
        places[:, 0] = width - places[:, 0]
    elif of_map is not CHANGES["transposed"][0]:
        places[:, 0] = (scene.maps[0].shape[1] - 1) * sides[1] - places[:, 0]
    size = [width, width, float(np.nanmax(np.abs(scene.maps[0]))), None]
    for rows in (places, two):
        rows[:] = rows[np.lexsort(np.round(rows[:, 2::-1] / (1e-6 * size[2]), 0).T)]
    for column, scale in enumerate(size):
        for a, b in zip(places[:, column], two[:, column]):
            laws.near(float(a), float(b), 1e-9, "xyhr"[column], scale or 0.0)
    return 0


LAWS = {"scaled by powers of two": law_scaled,
        **{change: law_changed(change) for change in CHANGES}, "map above and below": law_exchanged,
        "a tighter tolerance": law_tighter, "one more state on the way": law_one_more_state,
        "the level found, given": law_given_back, "summits by either rule": law_of_summits}


def broken(seed, exe, folder, name=None):
    """A law, by default that of the seed: its name, the status of the run (None: not asked), and
    what is broken."""
    scene, name = random_scene(seed), name or list(LAWS)[seed % len(LAWS)]
    try:
        return name, LAWS[name](scene, exe, folder, random.Random(f"law {seed}")), None
    except laws.Broken as wrong:
        return name, 0, str(wrong)
