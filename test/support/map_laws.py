"""Laws of scenes whose surface is a height map: the same laws as of asperities, and two of its own.

A scene is drawn by its seed: a made map of 144 to 6400 pixels (or two of them), rough at the pixel
or smooth, with or without missing pixels; a load, a pressure or a level of the flat, one value or a
path. Each is asked one law; the summits that `asperity summits` finds by either rule are asked the
laws of the plane.
"""

import copy
import csv
import functools
import math
import random
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import made_maps
import metamorphic_laws as laws
import metamorphic_scenes as scenes
from judge import ROOM, number
from map_scenes import write_map
from programs import run_program
from surfaces_csv import write_scene

# Gaps of pixels are closed to 1e-9 of the range of heights: of the load that is, by how stiff the
# contact is, up to some hundred times as much. Mirrored, turned or tilted, a map is levelled by
# sums in another order.
PIXELS = 1e-6
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

    def write(self, folder):
        """Text matrices, one profile a line."""
        files = [write_map(folder / f"s{k}.txt", height) for k, height in enumerate(self.maps)]
        words = dict(zip(("upper", "lower") if self.over else ("lower", "upper"),
                         [*files, "plane"]))
        return write_scene(folder / "s.scene", **{
            **self.groups, "surfaces": {**words, **self.groups["surfaces"]}})

    def scaled(self, lengths, moduli):
        """In units of length and of modulus that are so many powers of two smaller."""
        return mapped(self, lambda h: h * 2.0 ** lengths,
                      of_number=lambda v, a, b: v * 2.0 ** (a * lengths + b * moduli))

    def share(self):
        """How far two solutions of one problem may differ."""
        return PIXELS

    def area(self):
        """Of the pixels that are measured."""
        return sum(~np.isnan(sum(self.maps)).ravel()) * math.prod(
            self.groups["surfaces"]["map_spacing"])


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
    effects = {"interaction": rng.choice(["boundary", "auto"]),
               "tolerance": rng.choice([0.01, 0.1, 0.5])}
    surfaces = {"map_spacing": sides}
    if rng.random() < 0.3:
        surfaces["map_edge"] = "periodic"
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

def same_after(scene, other, exe):
    """The totals of all states, and the compression over the mean plane."""
    one, two = (scenes.run(exe, s) for s in (scene, other))
    laws.look(scene, one)
    laws.look(other, two)
    if not laws.both(one, two):
        return one.status
    for what in ("positions", "curve"):
        rows, others = getattr(one, what), getattr(two, what)
        assert len(rows) == len(others), "number of states"
        for row, far in zip(rows, others):
            for name in ("load", "vertical_load"):
                laws.near(*(number(r, name) for r in (row, far)), PIXELS, name,
                          1e-3 * laws.largest(one, name))
            # A pixel at the rim of a patch may carry next to nothing, or nothing.
            spare = 2 * math.prod(scene.groups["surfaces"]["map_spacing"])
            assert abs(number(row, "area") - number(far, "area")) \
                <= PIXELS * number(row, "area") + spare, "area"
            closings = [top_of(s) - number(r, "separation")
                        for s, r in ((scene, row), (other, far))]
            laws.near(*closings, PIXELS, "closing", 1e-3 * (top_of(scene) or 1.0))
    return one.status


def top_of(scene):
    """The highest pixel over the plane of least squares of each map and of their sum, of periodic
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
    def law(scene, exe, _rng):
        of_map, swap = CHANGES[change]
        if change == "rolled":
            scene = copy.deepcopy(scene)
            scene.groups["surfaces"]["map_edge"] = "periodic"
            scene.groups["effects"] = {"interaction": "boundary"}
        elif change == "raised and tilted" and scene.groups["surfaces"].get("map_edge"):
            # Tilted, it would not be periodic.
            return None
        return same_after(scene, mapped(scene, of_map, swap), exe)
    return law


def law_exchanged(scene, exe, _rng):
    """A map that presses, and one that is pressed."""
    other = copy.deepcopy(scene)
    other.over = not scene.over
    return same_after(scene, other, exe)


def law_given_back(scene, exe, _rng):
    """The level that a load gives, given, gives the load."""
    loading = scene.groups["loading"]
    if loading["control"] == "approach":
        return None
    one = scenes.run(exe, scene)
    laws.look(scene, one)
    if one.status:
        return one.status
    row = one.positions[-1]
    other = copy.deepcopy(scene)
    other.groups["loading"] = {"control": "approach", "value": float(row["separation"])}
    two = scenes.run(exe, other)
    if two.status == 1 and "mean height of a map" in two.stderr:
        return None
    if laws.both(one, two):
        laws.near(number(row, "load"), number(two.positions[-1], "load"), PIXELS,
                  "load at the level found")
    return one.status


def law_of_summits(scene, exe, rng):
    """What `asperity summits` finds, by either rule, on the map and on the changed one."""
    sides = scene.groups["surfaces"]["map_spacing"]
    of_map, swap = rng.choice([CHANGES[name] for name in ("mirrored", "transposed",
                                                          "turned by 90 degrees")])
    rule, found = rng.choice(["eight", "contact"]), []
    for other in (scene, mapped(scene, of_map, swap)):
        spacing = ",".join(map(repr, other.groups["surfaces"]["map_spacing"]))
        with tempfile.TemporaryDirectory(dir=ROOM) as folder:
            other.write(Path(folder))
            done = run_program(exe, "summits", "s0.txt", "--rule", rule, "--spacing", spacing,
                               "--output", "-", cwd=folder)
        found.append(np.array([[float(v) for v in row.values()]
                               for row in csv.DictReader(done.stdout.splitlines())]))
    one, two = (f.reshape(-1, 4) for f in found)
    assert len(one) == len(two), f"{len(one)} and {len(two)} summits by {rule}"
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


LAWS = {"scaled by powers of two": laws.law_scaled,
        **{change: law_changed(change) for change in CHANGES}, "map above and below": law_exchanged,
        "a tighter tolerance": laws.law_tighter,
        "one more state on the way": laws.law_one_more_state,
        "the level found, given": law_given_back, "summits by either rule": law_of_summits}


broken = functools.partial(laws.broken, laws=LAWS, make=random_scene)
