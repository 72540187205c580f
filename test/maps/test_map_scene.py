"""A height map in a scene: its pixels against Polonsky and Keer's method in numpy, and what is
refused."""

import itertools
import re

import numpy as np
import pytest

from map_press_truth import press, rough
from map_scenes import E, level, load_for, map_scene, patch_areas, solve_map, write_map
from programs import run_program
from surfaces_csv import solve


@pytest.mark.parametrize("edge", ["free", "periodic"])
@pytest.mark.parametrize("share", [0.003, 0.05, 0.2])
def test_pixels_against_numpy(asperity, tmp_path, edge, share):
    sides = (0.01, 0.017)
    height = 1e-3 * rough(56, 41, shortest=5, seed=11)
    load = load_for(height, sides, share)
    scene = map_scene(tmp_path, height, sides, surfaces={"map_edge": edge},
                      loading={"control": "load", "value": load})
    found = solve(asperity, scene)
    assert found.status == 0, found.stderr
    of = height - height.mean() if edge == "periodic" else level(height)
    flat, pressure = press(of, sides, E, load, edge == "periodic")
    row = found.positions[0]
    errors = [float(row["separation"]) / flat - 1, float(row["load"]) / load - 1,
              float(row["sample_area"]) / ((pressure > 0).sum() * np.prod(sides)) - 1,
              float(row["area"]) / patch_areas(pressure, sides, edge == "periodic").sum() - 1,
              max(float(c["maximum_pressure"]) for c in found.contacts) / pressure.max() - 1,
              sum(float(c["load"]) for c in found.contacts) / load - 1,
              sum(float(c["area"]) for c in found.contacts) / float(row["area"]) - 1]
    assert max(map(abs, errors)) < 1e-6, errors
    # The same at the separation that was found.
    there = map_scene(tmp_path, height, sides, name="there", surfaces={"map_edge": edge},
                      loading={"control": "approach", "value": float(row["separation"])})
    again = solve(asperity, there)
    assert abs(float(again.positions[0]["load"]) / load - 1) < 1e-6


def test_missing_pixels_and_a_curve(asperity, tmp_path):
    sides = (0.02, 0.02)
    height = 1e-3 * rough(40, shortest=5, seed=12)
    height[10:14, 5:8] = np.nan
    load = load_for(np.nan_to_num(height), sides, 0.05)
    scene = map_scene(tmp_path, height, sides, loading={"control": "load", "value": load,
                                                        "points": 3})
    found = solve(asperity, scene, curve=True)
    assert found.status == 0, found.stderr
    assert len(found.curve) == 4 and float(found.curve[0]["load"]) == 0.0
    assert float(found.curve[0]["separation"]) == pytest.approx(np.nanmax(level(height)))
    for k, row in enumerate(found.curve[1:], 1):
        flat, pressure = press(level(height), sides, E, load * k / 3)
        assert abs(float(row["separation"]) / flat - 1) < 1e-6
        assert not pressure[10:14, 5:8].any()


@pytest.mark.parametrize("criterion, value, column, factor", [
    ("load", "value", "load", 1.0), ("pressure", "value", "average_pressure", 1.0),
    ("greenwood_williamson", "hardness", "maximum_pressure", 2 / np.pi),
    ("hardy", "yield_stress", "maximum_pressure", 2.76)])
def test_limits_of_patches(asperity, tmp_path, criterion, value, column, factor):
    """Each patch beyond the limit is marked: its load, its average pressure, or the greatest
    pressure of Hertz at the limit of Greenwood and Williamson (W = R (H/E)^2) and of Hardy. A
    position is at the limit where a patch of its last state is. Patches have no circles."""
    sides = (0.02, 0.02)
    height = 1e-3 * rough(40, shortest=5, seed=12)
    load = load_for(height, sides, 0.05)
    limit = 0.01 * E if column != "load" else 0.1 * load
    for k, values in enumerate(((load, 1e-3 * load), (1e-3 * load, load))):
        scene = map_scene(tmp_path, height, sides, name=f"m{k}",
                          loading={"control": "load", "value": values},
                          limit={"criterion": criterion, value: limit / factor})
        found = solve(asperity, scene)
        assert found.status == 0, found.stderr
        marks = {row["step"]: set() for row in found.contacts}
        for row in found.contacts:
            marks[row["step"]].add(row["limit_exceeded"])
            assert row["limit_exceeded"] == ("1" if float(row[column]) >= limit else "0")
            assert row["overlap"] == "" and float(row["penetration"]) > 0
        assert marks["2" if k else "1"] == {"0", "1"} and marks["1" if k else "2"] == {"0"}
        assert found.positions[0]["limit_reached"] == str(k)
        assert found.positions[0]["overlapping_circles"] == ""


def test_two_maps_are_their_sum(asperity, tmp_path):
    sides = (0.02, 0.02)
    lower, upper = (1e-3 * rough(32, shortest=4, seed=s) for s in (13, 14))
    load = load_for(lower, sides, 0.05)
    write_map(tmp_path / "upper.txt", upper)
    scene = map_scene(tmp_path, lower, sides, upper="upper.txt",
                      loading={"control": "load", "value": load})
    found = solve(asperity, scene)
    assert "two height maps of" in found.stdout
    flat, _ = press(level(lower + upper), sides, E, load)
    assert abs(float(found.positions[0]["separation"]) / flat - 1) < 1e-6


@pytest.mark.parametrize("interaction", ["off", "coupled"])
def test_summits_are_asperities(asperity, tmp_path, interaction):
    """A map is solved on its pixels alone: the refusal names the command that writes its summits,
    and their surface is solved."""
    sides = (1 / 64, 1 / 64)
    height = 1e-4 * rough(64, shortest=8, seed=16)
    loading = {"control": "load", "value": load_for(height, sides, 0.03)}
    scene = map_scene(tmp_path, height, sides, interaction=interaction, loading=loading)
    found = solve(asperity, scene)
    assert found.status == 2 and found.stderr.count("\n") == 1
    assert f"found {interaction}, expected 'auto' or 'boundary'" in found.stderr
    words = re.search(r"asperity (summits MAP --rule contact --output FILE)$", found.stderr)[1]
    run_program(asperity, *words.replace("MAP", "map.txt").replace("FILE", "s.csv").split(),
                "--spacing", "0.015625", cwd=tmp_path)
    scene.write_text(scene.read_text().replace("map.txt", "s.csv").replace(
        "map_spacing = 0.015625, 0.015625", "nominal_area = 1."))
    assert solve(asperity, scene).status == 0


def test_a_pressure_is_a_load_over_the_map(asperity, tmp_path):
    """Over its own area, or over the one that is given."""
    sides = (0.02, 0.03)
    height = 1e-3 * rough(32, 40, shortest=4, seed=17)
    for area in ({}, {"nominal_area": 0.5}):
        scene = map_scene(tmp_path, height, sides, surfaces=area,
                          loading={"control": "pressure", "value": 1e-3})
        found = solve(asperity, scene)
        over = area.get("nominal_area", height.size * sides[0] * sides[1])
        row = found.positions[0]
        assert abs(float(row["vertical_load"]) / (1e-3 * over) - 1) < 1e-9
        assert abs(float(row["nominal_pressure"]) / 1e-3 - 1) < 1e-9
        assert abs(float(row["area_fraction"]) * over / float(row["projected_area"]) - 1) < 1e-12


@pytest.mark.parametrize("change, said", [
    (("map_spacing", "radius = 1., 1., map_spacing"), "radius: found beside a map"),
    (("&material", "&motion x_first = 1. / &material"), "found beside a map"),
    (("&material", "&tilt upper_slope = .1, .1 / &material"), "it is levelled"),
    (("'plane'", "'notes.txt'"), "notes.txt:1:1: found 'neither asperities"),
    (("control = 'load', value = 0.001", "control = 'limit'"), "patches of pixels merge"),
    ((", map_spacing = (0.1, 0.1)", ""), "spacing"),
    (("'map.txt'", "'caps.csv'"), "found without a map"),
])
def test_refused(asperity, tmp_path, change, said):
    scene = map_scene(tmp_path, rough(32, shortest=4), (0.1, 0.1),
                      loading={"control": "load", "value": 0.001})
    (tmp_path / "caps.csv").write_text("x,y,height,radius\n0,0,0.1,1\n")
    (tmp_path / "notes.txt").write_text("neither asperities nor a map\n")
    write_map(tmp_path / "small.txt", rough(24, shortest=4))
    text = scene.read_text()
    old = change[0].replace("(", "").replace(")", "")
    assert old in text
    scene.write_text(text.replace(old, change[1]))
    found = solve(asperity, scene)
    assert found.status == 2
    assert said in found.stderr, found.stderr


@pytest.mark.parametrize("control, value, said", [
    ("load", 1e-30, ""), ("load", (1e-3, 1e-300), ""),
    ("load", 5e-324, "too small beside the modulus and the heights"),
    ("pressure", 1e-323, "too small for a double")])
def test_loads_near_zero(asperity, tmp_path, control, value, said):
    """A load far below the rounding of the gaps is carried by the highest pixel, or refused."""
    scene = map_scene(tmp_path, 1e-3 * rough(32, shortest=4), (0.01, 0.01),
                      loading={"control": control, "value": value})
    found = solve(asperity, scene)
    assert found.status == (1 if said else 0) and said in found.stderr, found.stderr
    if not said:
        last = found.contacts[-1]
        assert float(last["load"]) == pytest.approx(np.ravel(value)[-1], rel=1e-12)
        assert float(last["samples"]) == 1
    smallest = 1e-12 * load_for(1e-3 * rough(32, shortest=4), (0.01, 0.01), 1e-3)
    scene = map_scene(tmp_path, 1e-3 * rough(32, shortest=4), (0.01, 0.01),
                      loading={"control": "load", "value": smallest})
    found = solve(asperity, scene)
    assert found.status == 0, found.stderr
    assert sum(float(row["load"]) for row in found.contacts) == pytest.approx(smallest, rel=1e-6)


def test_paths_start_from_the_better_of_two_starts(asperity, tmp_path):
    """A state that is far from the one before it is that of its load alone, from coarser maps; near
    ones start along the path, in fewer steps."""
    height, sides = 1e-3 * rough(96, 88, shortest=6, seed=21), (0.01, 0.01)
    load = load_for(height, sides, 0.1)

    def last(name, *shares, control="load", most=load):
        row = dict(solve(asperity, map_scene(tmp_path, height, sides, name=name, loading={
            "control": control, "value": [most * share for share in shares]})).positions[0])
        return int(row["interaction_iterations"]), {n: row[n] for n in row if n != "steps"}

    cold, alone = last("alone", 1)
    assert last("far", 0.7, 1) == (cold, alone) and last("beside", 0.81, 1)[1] != alone
    (extrapolated, row), (near, _) = last("two", 0.86, 0.93, 1), last("one", 0.93, 1)
    assert extrapolated < near < cold
    for name in ("separation", "area", "contact_stiffness"):
        assert abs(float(row[name]) / float(alone[name]) - 1) < 1e-8
    there = {"control": "compression", "most": float(alone["compression"])}
    level = last("level", 1, **there)
    assert last("low", 0.976, 1, **there) == level != last("lower", 0.984, 1, **there)


def test_egg_crates_on_a_path_meet_their_loads(asperity, tmp_path):
    """Pixels at equal gaps leave a direction of rounding errors alone, which once lost the load."""
    for rows, columns in itertools.product(range(14, 20), (16, 17)):
        waves = [np.cos(2 * np.pi * np.arange(n) / n) for n in (rows, columns)]
        fields = solve_map(asperity, map_scene(
            tmp_path, np.outer(*waves), (1.0, 1.0), surfaces={"map_edge": "periodic"},
            loading={"control": "load", "value": tuple(
                E * rows * columns * 0.01 * (k / 9)**3 for k in range(1, 10))}))[2]
        assert fields["pressure"].sum() == pytest.approx(
            E * rows * columns * 0.01, rel=1e-12), (rows, columns)
