"""Error estimates of maps solved on their pixels, against closed forms and finer pixels."""

import csv
import io
import re
import warnings

import numpy as np
import pytest

from map_press_truth import first_contact, rough
from map_scenes import map_scene, solve_map
from programs import run_program
from surfaces_csv import records, write_plane_scene

E = 2.0
N = 40


def solve(asperity, folder, height, spacing, edge="periodic", effects=None, material=E, **loading):
    """The cells that are not empty of the one position of a map, indexed [y, x]."""
    position = solve_map(asperity, map_scene(
        folder, height.T, (spacing, spacing), name="m", material=material, loading=loading,
        surfaces={"map_edge": edge, "map_level": "none"}, effects=effects))[1]
    return {name: value for name, value in position.items() if value == value}


def ball(random):
    """Hertz' ball of radius 1 anywhere between the pixels, contact radius 2 to 16 of them."""
    spacing = 0.02 / random.uniform(2, 16)
    x, y = (np.arange(N) - N / 2 + random.random(2)[:, None]) * spacing
    return (-(x**2 + y[:, None] ** 2) / 2, spacing, "free", 4 / 3 * E * 0.02**3,
            (-0.02**2, np.pi * 0.02**2, 0.02**2))


def finer(asperity, folder, random, kind):
    """A random surface of no waves shorter than 4 to 16 pixels, solved on pixels a quarter as
    wide; rough: of waves down to half a pixel."""
    shortest = 2 if kind == "rough" else random.uniform(16, 64)
    fine = rough(4 * N, longest=0.5, shortest=shortest, seed=random.integers(10**6))
    slope = np.sqrt(sum((np.diff(fine, axis=a) ** 2).mean() for a in (0, 1))) * 4
    load = 10 ** random.uniform(-1.7, -0.3) * E * slope / 2 * N**2
    effects = None
    if kind == "plastic":
        hardness = E * slope * random.uniform(0.2, 1)
        effects = {"plasticity": "on", "plastic_hardness": float(hardness)}
    if kind == "adhesive":
        reach = fine.std() * random.uniform(0.05, 0.3)
        effects = {"adhesion": "on", "equilibrium_distance": float(reach / 0.9743),
                   "work_of_adhesion": float(random.uniform(0.05, 0.55) * E * reach**2)}
    if kind == "creeping":
        effects = {"creep": "on", "hold_time": 3.0, "relaxation_time": 1.0, "hold_points": 4,
                   "relaxed_modulus_ratio": float(random.uniform(0.3, 0.9))}
    true = solve(asperity, folder, fine, 0.25, effects=effects, control="load", value=float(load))
    return (fine[::4, ::4], 1.0, "periodic", load,
            (true["separation"], true["area"], true["compression"]), effects)


@pytest.mark.parametrize("kind", ["ball", "random", "rough", "plastic", "adhesive", "creeping"])
def test_estimates_cover_the_errors(asperity, tmp_path, kind):
    """Of 10 maps of each kind: at most one error of a kind is above its estimate, none 2.5 times,
    and the median estimate is at most 15 errors."""
    random = np.random.default_rng(3)
    ratios = []
    for _ in range(10):
        case = ball(random) if kind == "ball" else finer(asperity, tmp_path, random, kind)
        height, spacing, edge, load, (level, area, compression), *effects = case
        found = solve(asperity, tmp_path, height, spacing, edge, effects=effects and effects[0],
                      control="load", value=float(load))
        ratios.append([abs(found["separation"] - level) / found["compression"]
                       / found["separation_error_estimate"],
                       abs(1 - compression / found["compression"]) / found["error_estimate"],
                       abs(1 - area / found["area"]) / found["area_error_estimate"]])
        assert found["interaction_residual"] < 1e-9 or kind == "adhesive"
    ratios = np.array(ratios)
    assert ((ratios > 1).sum(axis=0) <= 1).all() and ratios.max() < 2.5, ratios
    # The separation of a creeping map has the widest estimate, 26 times the error.
    assert (np.median(1 / ratios, axis=0) < (30 if kind == "creeping" else 15)).all(), ratios


@pytest.mark.parametrize("control", ["load", "separation", "compression"])
def test_estimates_of_balls_in_the_middle(asperity, tmp_path, control):
    """Hertz' balls with their apex between four pixels, so that the maps of every second pixel are
    mirror images: one error in twenty may be above its estimate, none 1.5 times."""
    random = np.random.default_rng(8)
    ratios = []
    for _ in range(20):
        n, m = 2 * random.integers(10, 30, 2)
        radius = random.uniform(0.15, 0.45) * min(n, m) / 2
        x, y = np.arange(n) - (n - 1) / 2, np.arange(m) - (m - 1) / 2
        load, deep = 4 / 3 * E * radius**3, radius**2
        value = {"load": load, "separation": -deep, "compression": deep}[control]
        found = solve(asperity, tmp_path, -(x**2 + y[:, None]**2) / 2, 1.0, "free", control=control,
                      value=float(value))
        if control == "load":
            ratios += [abs(1 - deep / found["compression"]) / found["error_estimate"],
                       abs(found["separation"] / deep + 1) / found["separation_error_estimate"]]
        else:
            ratios.append(abs(1 - load / found["load"]) / found["error_estimate"])
    assert np.mean(np.array(ratios) > 1) <= 0.05 and max(ratios) < 1.5, ratios


def waves(random, kind):
    """A height of amplitude 1 at N and at 4 N pixels a side and its top: an egg crate, every third
    with tops in the middle between four pixels, or crests that run aslant."""
    count = int(random.integers(2, 5))
    x = [np.arange(n) / n for n in (N, 4 * N)]
    if kind == "egg crate":
        phase = random.uniform(0, 2 * np.pi, 2)
        if random.random() < 1 / 3:
            phase[:] = np.pi * count / N
        return [np.cos(2 * np.pi * count * one + phase[0])
                + np.cos(2 * np.pi * count * one + phase[1])[:, None] for one in x] + [2.0]
    shift = random.random()
    return [np.cos(2 * np.pi * (count * one + one[:, None] + shift)) for one in x] + [1.0]


@pytest.mark.parametrize("kind", ["egg crate", "aslant"])
def test_first_contact_of_waves(asperity, tmp_path, kind):
    """Waves whose top is known, and the load on pixels a quarter as wide at the same separation:
    compressions, and loads at them, are within their estimates."""
    random = np.random.default_rng(6)
    ratios = []
    for _ in range(8):
        coarse, fine, top = waves(random, kind)
        load = 10**random.uniform(-1, 0.3) * E * N
        level = solve(asperity, tmp_path, fine, 0.25, control="load", value=load)["separation"]
        found = solve(asperity, tmp_path, coarse, 1.0, control="load", value=load)
        ratios.append(abs(1 - (top - level) / found["compression"]) / found["error_estimate"])
        found = solve(asperity, tmp_path, coarse, 1.0, control="compression", value=top - level)
        ratios.append(abs(1 - load / found["load"]) / found["error_estimate"])
    assert max(ratios) < 1, ratios


def test_errors_of_each_state(asperity, tmp_path):
    """Each row of a curve has the errors of its state alone, and its greatest pressure; the row
    without contact has none. A ridge that a free edge cuts has none of the pressure in any row."""
    height, loads = rough(36, shortest=8, seed=5), (0.05, 0.4, 2.0)
    names = ("error_estimate", "area_error_estimate", "gap_error_estimate",
             "pressure_error_estimate", "separation_error_estimate", "greatest_pressure")
    solve(asperity, tmp_path, height, 1.0, control="load", value=(0.0, *loads))
    run_program(asperity, "solve", tmp_path / "m.scene", "--curve", tmp_path / "all.csv")
    first, *rows = records(tmp_path / "all.csv")
    assert [first[name] for name in names[:-1]] == [""] * 5
    for load, row in zip(loads, rows):
        solve(asperity, tmp_path, height, 1.0, control="load", value=load)
        run_program(asperity, "solve", tmp_path / "m.scene", "--curve", tmp_path / "one.csv")
        alone = records(tmp_path / "one.csv")[-1]
        for name in names:
            assert float(row[name]) == pytest.approx(float(alone[name]), 1e-3), name
    assert float(rows[0]["error_estimate"]) > 2 * float(rows[-1]["error_estimate"])
    x = np.arange(24) - 11.5
    solve(asperity, tmp_path, np.repeat(-(x**2)[None, :] / 100, 24, 0), 1.0, "free",
          control="load", value=(1.0, 5.0))
    run_program(asperity, "solve", tmp_path / "m.scene", "--curve", tmp_path / "cut.csv")
    for row in records(tmp_path / "cut.csv"):
        assert row["pressure_error_estimate"] == ""


@pytest.mark.parametrize("kind", ["cone", "tent", "ridge"])
def test_kinks(asperity, tmp_path, kind):
    """The compression of a cone (Sneddon 1965) anywhere between the pixels, and the first contact
    of tents and ridges that end between them: the greatest pressure of all has no limit."""
    random = np.random.default_rng(11)
    ratios = []
    for _ in range(10):
        x, y = np.arange(N)[None, :] - random.uniform(18, 21), np.arange(N)[:, None] - \
            random.uniform(18, 21)
        if kind == "cone":
            deep = 0.01 * np.pi * random.uniform(3, 12)
            found = solve(asperity, tmp_path, -0.02 * np.hypot(x, y), 1.0, "free", control="load",
                          value=float(E * deep**2 * 2 / (np.pi * 0.02)))
        else:
            x, y = ((place + N / 2) % N - N / 2 for place in (x, y))
            height = -abs(x) - (abs(y) if kind == "tent" else 0.3 * np.cos(y * 2 * np.pi / N) + 0.3)
            found = solve(asperity, tmp_path, height, 1.0, control="load",
                          value=float(10**random.uniform(-1, 0.5) * N))
            deep = found["separation"] * -1
        assert "pressure_error_estimate" not in found
        if kind == "cone":
            ratios.append(abs(1 - deep / found["compression"]) / found["error_estimate"])
        else:
            top = (found["separation"] + found["compression"]) / found["compression"]
            ratios.append(abs(top) / found["error_estimate"])
    assert max(ratios) < 1, ratios


def test_first_contact_by_vertices(asperity, tmp_path):
    """Vertices of nine pixels in numpy: free, periodic, with a missing pixel beside the highest. A
    plateau of three pixels is its own top; so is a flat map."""
    height = rough(24, shortest=5, seed=4)
    holed = height.copy()
    i, j = np.unravel_index(height.argmax(), height.shape)
    holed[i, (j + 1) % 24] = np.nan
    plateau = np.roll(height, (12 - i, 12 - j), (0, 1))
    plateau[11:14, 11:14] = height.max()
    for surface, edge in ((height, "free"), (height, "periodic"), (holed, "free"),
                          (plateau, "free"), (np.zeros((8, 8)), "free")):
        found = solve(asperity, tmp_path, surface, 1.0, edge, control="load", value=(0.5, 0.0))
        top = np.nanmax(surface)
        if surface is not plateau:
            top = first_contact(surface, edge == "periodic")
        assert found["separation"] == pytest.approx(top, rel=1e-14, abs=1e-14), edge
        assert abs(found["compression"]) < 1e-14
    assert first_contact(height) > height.max() + 1e-3


def test_a_patch_at_a_free_edge_has_no_greatest_pressure(asperity, tmp_path):
    """A ridge across a free map ends as a punch does, its pressure has no limit: one warning in
    place of the estimate. On a strip along the ridge, and at the hardness, it has one."""
    x = np.arange(24) - 11.5
    ridge = np.repeat(-(x**2)[None, :] / 100, 24, 0)
    why = "an edge of the map cuts contact patches"
    for edge, effects, is_cut in (("free", None, True), (("free", "periodic"), None, False),
                                  ("free", {"plasticity": "on", "plastic_hardness": 0.05}, False)):
        found = solve(asperity, tmp_path, ridge, 1.0, edge, effects=effects, control="load",
                      value=5.0)
        assert ("pressure_error_estimate" in found) != is_cut, edge
        shown = run_program(asperity, "solve", tmp_path / "m.scene").stderr
        assert shown.count(why) == is_cut


def symmetric_map(kind):
    """A map with several equal tops, and its edge."""
    x, y = np.arange(14), np.arange(19)[:, None]
    if kind == "ball":  # in the middle between four pixels
        return -((x - 6.5) ** 2 + (y - 8.5) ** 2) / 100, "free"
    if kind == "tents":  # of a free map, of unequal surroundings
        return np.maximum(-abs(x - 3) - abs(y - 4), -abs(x - 9) - abs(y - 13.0)) / 20, "free"
    if kind == "aslant":
        return 0.2 * np.cos(2 * np.pi * (2 * x / 14 + y / 19)), "periodic"
    if kind == "egg crate":
        waves = np.cos(2 * np.pi * (3 * x + 0.5) / 14) + np.cos(4 * np.pi * y / 19)
        return 0.2 * waves, "periodic"
    return rough(30, shortest=2, seed=2)[:29], "periodic"


@pytest.mark.parametrize("kind", ["ball", "tents", "aslant", "egg crate", "rough"])
@pytest.mark.parametrize("pressure", [0.003, 0.2])
def test_estimates_do_not_depend_on_the_order_of_pixels(asperity, tmp_path, kind, pressure):
    """A map that is mirrored, transposed, begins elsewhere, or differs by rounding, which decides
    which of several equal tops is the first, has the same errors."""
    height, edge = symmetric_map(kind)
    random = np.random.default_rng(5)
    others = [height[:, ::-1], height[::-1], height.T,
              height * (1 + 1e-15 * random.standard_normal(height.shape))]
    if edge == "periodic":
        others += [np.roll(height, (3, 8), (0, 1)), np.roll(height, 1, 1)]
    first, *others = (solve(asperity, tmp_path, one, 1.0, edge, control="load",
                            value=pressure * height.size) for one in (height, *others))
    names = [name for name in first if name.endswith("error_estimate")]
    assert len(names) > 4
    for name in names:
        found = [one[name] for one in others]
        assert found == pytest.approx(len(others) * [first[name]], 0.02), name


def test_first_contact_beside_cliffs(asperity, tmp_path):
    """A rough plateau with pits much deeper than it is rough: the steps into them neither raise the
    top above the plateau nor count as its error."""
    height = rough(N, shortest=2, seed=4) * 0.01
    random = np.random.default_rng(3)
    for i, j in random.integers(1, N - 3, (12, 2)):
        height[i:i + 2, j:j + 2] = -1.0
    found = solve(asperity, tmp_path, height, 1.0, control="load", value=0.02 * N**2)
    rise = found["separation"] + found["compression"] - height.max()
    assert 0 <= rise < height[height > -1].std()
    assert found["error_estimate"] - found["separation_error_estimate"] < \
        2 * height[height > -1].std() / found["compression"]


def test_errors_of_straight_rims(asperity, tmp_path):
    """Waves with crests along the rows, whose rims all err by the same part of a pixel: no error of
    the area is above the estimate. Westergaard: under a pressure p the share
    2/pi asin(sqrt(p l/(pi E g))) of the length l of a height g."""
    length, height = 10.0, 0.05
    wave = height * np.cos(2 * np.pi * (np.arange(N) + 0.3) / length)[:, None] + np.zeros((N, N))
    ratios = []
    for share in np.linspace(0.1, 0.7, 13):
        found = solve(asperity, tmp_path, wave, 1.0, control="load",
                      value=float(share * np.pi * E * height / length * N**2))
        area = 2 / np.pi * np.arcsin(np.sqrt(share)) * N**2
        ratios.append(abs(found["area"] / area - 1) / found["area_error_estimate"])
    assert max(ratios) < 1, ratios


def test_a_separation_has_an_error_of_the_load(asperity, tmp_path):
    """Hertz' load at a prescribed separation; what is prescribed has no estimate."""
    height, spacing, edge, load, (level, *_) = ball(np.random.default_rng(1))
    found = solve(asperity, tmp_path, height, spacing, edge, control="separation", value=level)
    assert 0 < abs(found["load"] / load - 1) < found["error_estimate"] < 0.1
    words = run_program(asperity, "solve", tmp_path / "m.scene").stdout
    assert "error estimate: load " in words
    text = (tmp_path / "m.scene").read_text()
    (tmp_path / "m.scene").write_text(text.replace(
        f"'separation', value = {level!r}", f"'load', value = {load!r}"))
    words = run_program(asperity, "solve", tmp_path / "m.scene").stdout
    assert "error estimate: compression " in words
    assert re.search(r"^interaction boundary +1 of 1 +boundary", words, re.M)


RATIO, FRICTION = 0.3, 0.25
BODIES = {"elastic_modulus": (2 * E * (1 - RATIO**2),) * 2, "poisson_ratio": (RATIO,) * 2}
ESTIMATED = {"contact_stiffness": "stiffness", "interface_stiffness": "interface",
             "conductance_length": "conductance", "tangential_stiffness_xx": "sticking",
             "tangential_stiffness_yy": "sticking", "tangential_stiffness": "slip",
             "stick_area": "stick"}


def slipping_ball(random):
    """Hertz' ball and the closed forms of Mindlin (1949) under a tangential load along x."""
    height, spacing, edge, load, _ = ball(random)
    a, share = 0.02, random.uniform(0.1, 0.9)
    c, kappa = a * (1 - share)**(1 / 3), 2 * (1 - RATIO) / (2 - RATIO)
    stiff = 2 * E * a
    return (height, spacing, edge, load, (share * FRICTION * load, 0.0), {
        "contact_stiffness": stiff, "conductance_length": 4 * a,
        "tangential_stiffness_xx": kappa * stiff, "tangential_stiffness_yy": kappa * stiff,
        "tangential_stiffness": kappa * 2 * E * c, "stick_area": np.pi * c**2})


@pytest.mark.parametrize("kind", ["ball", "random"])
def test_errors_of_stiffness_and_slip(asperity, tmp_path, kind):
    """Stiffness, conductance and partial slip of balls by closed forms, and of periodic random
    surfaces by pixels a quarter as wide: of 12 each one error may be above its estimate, none 2.5
    times. The summary prints those of the numbers that it prints; a strip has no stiffness."""
    random, ratios = np.random.default_rng(4), {}
    for _ in range(12):
        if kind == "ball":
            height, spacing, edge, load, pull, true = slipping_ball(random)
        else:
            fine = rough(4 * N, longest=0.5, shortest=random.uniform(16, 64),
                         seed=random.integers(10**6))
            slope = np.sqrt(sum((np.diff(fine, axis=a)**2).mean() for a in (0, 1))) * 4
            height, spacing, edge = fine[::4, ::4], 1.0, "periodic"
            load = 10 ** random.uniform(-1.7, -0.3) * E * slope / 2 * N**2
            pull = tuple(float(random.uniform(0.1, 0.6) * FRICTION * load) for _ in "xy")
        how = dict(material=BODIES, effects={"friction_coefficient": FRICTION}, control="load",
                   value=float(load), tangential_load=pull)
        if kind == "random":
            true = solve(asperity, tmp_path, fine, 0.25, **how)
        found = solve(asperity, tmp_path, height, spacing, edge, **how)
        for name, word in ESTIMATED.items():
            if name in true:
                ratios.setdefault(name, []).append(
                    abs(true[name] / found[name] - 1) / found[f"{word}_error_estimate"])
    for name, some in ratios.items():
        assert np.sum(np.array(some) > 1) <= 1 and max(some) < 2.5, (name, some)
        assert np.median(some) > 1 / 15, (name, some)
    shown = run_program(asperity, "solve", tmp_path / "m.scene").stdout
    for words in ("tangential stiffness", "area that sticks"):
        assert re.search(rf"^error estimate: .*, {words} [\d.]+ %", shown, re.M), words
    strip = solve(asperity, tmp_path, height, spacing, ("free", "periodic"), **how)
    assert "stiffness_error_estimate" not in strip and "sticking_error_estimate" not in strip


CREEP = {"creep": "on", "hold_time": 3.0, "relaxation_time": 1.0, "relaxed_modulus_ratio": 0.5}
HARDNESS = {"plasticity": "on", "plastic_hardness": 0.3}
ATTRACTION = {"adhesion": "on", "equilibrium_distance": 0.1, "work_of_adhesion": 2e-3}


@pytest.mark.parametrize("effects, reason", [
    ({**CREEP, **ATTRACTION}, "creep beside another effect"),
    ({**CREEP, **HARDNESS}, "creep beside another effect"),
    (HARDNESS, "unloading after plasticity")])
def test_a_result_without_an_error_estimate(asperity, package, tmp_path, effects, reason):
    """The summary states it once, also in Python, and the columns are empty."""
    values = (1.0, 0.5) if effects is HARDNESS else 1.0
    height = rough(16, shortest=4, seed=2)
    found = solve(asperity, tmp_path, height, 1.0, effects=effects, control="load", value=values)
    assert not [name for name in found if name.endswith("error_estimate")]
    done = run_program(asperity, "solve", tmp_path / "m.scene")
    line = f"error estimate: none with {reason}\n"
    assert (done.stdout + done.stderr).count(line) == 1
    assert (done.stdout + done.stderr).count("error estimate:") == 1
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        results = package.solve(tmp_path / "m.scene")
    assert results.summary.count(line) == 1 and np.isnan(results.positions["error_estimate"]).all()
    assert not any("error estimate" in text for text in results.warnings)


@pytest.mark.parametrize("control", ["load", "separation"])
def test_errors_of_creep_are_those_of_a_softer_body(asperity, tmp_path, control):
    """In a hold the state is elastic with the relaxed modulus (Lee and Radok 1960)."""
    height = rough(32, shortest=8, seed=2)
    ratio, hold = 0.4, 2.0
    relaxed = ratio + (1 - ratio) * np.exp(-hold)
    compliance = 1 / ratio - (1 / ratio - 1) * np.exp(-ratio * hold)
    creep = solve(asperity, tmp_path, height, 1.0, control=control, value=0.5, effects={
        "creep": "on", "hold_time": hold, "relaxation_time": 1.0, "relaxed_modulus_ratio": ratio,
        "hold": control})
    soft = solve(asperity, tmp_path, height, 1.0, control=control, value={
        "load": float(0.5 * compliance), "separation": 0.5}[control])
    load = 0.5 if control == "load" else soft["load"] * relaxed
    assert creep["load"] == pytest.approx(load, 1e-6)
    for name in ("separation", "area", "error_estimate", "area_error_estimate",
                 "gap_error_estimate", "pressure_error_estimate"):
        # Coarser maps are solved to 1e-4.
        tolerance = 1e-3 if "error" in name else 1e-5
        assert creep[name] == pytest.approx(soft[name], tolerance), name


def test_unknown_errors_are_empty(asperity, tmp_path):
    """Without load, after unloading from the hardness, where a pixel has left creeping contacts,
    where pixels twice as wide do not resolve adhesion, and on a map of three pixels."""
    height = rough(16, shortest=4, seed=2)
    for values, effects in (((1.0, 0.0), {}), ((1.0, 0.5), {"plasticity": "on",
                                                            "plastic_hardness": 0.1}),
                            ((30.0, 5.0), {"creep": "on", "loading_time": 3.0,
                                          "relaxation_time": 1.0, "relaxed_modulus_ratio": 0.5}),
                            (1.0, {"adhesion": "on", "equilibrium_distance": 0.1 / 0.9743,
                                   "work_of_adhesion": 0.65 * E * 0.1**2})):
        found = solve(asperity, tmp_path, height, 1.0, effects=effects, control="load",
                      value=values)
        assert "error_estimate" not in found and "area_error_estimate" not in found
    found = solve(asperity, tmp_path, np.eye(3), 1.0, control="load", value=0.1)
    assert "error_estimate" not in found


def test_a_map_of_every_second_pixel_without_a_solution(asperity, tmp_path):
    """At a separation beside full contact the mean of a fourth of the pixels is above the flat:
    the summary prints that the error is unknown, and the reason."""
    height = rough(16, shortest=4, seed=2)
    height[::2, ::2] += 4 * height.std()
    found = solve(asperity, tmp_path, height, 1.0, control="separation",
                  value=float(height.mean() + 0.01 * height.std()))
    assert found["load"] > 0 and "error_estimate" not in found
    for options in ((), ("--keep", tmp_path / "kept"), ("--keep", tmp_path / "kept")):
        words = run_program(asperity, "solve", tmp_path / "m.scene", *options).stdout
        assert ("\nerror estimate: unknown, the map of every second pixel could not be solved: "
                "the flat is not above the mean height of a map that repeats itself\n") in words


def test_a_coarse_ball(asperity, tmp_path):
    """A contact radius of 2.1 pixels: the area is far off, which warning and estimate state, and no
    accuracy is reached by an error that is not known to be small."""
    x = (np.arange(N) - N / 2) * 0.02 / 2.1
    height = -(x**2 + x[:, None] ** 2) / 2
    load = 4 / 3 * E * 0.02**3
    found = solve(asperity, tmp_path, height, 0.02 / 2.1, "free", control="load", value=load)
    error = abs(found["area"] / (np.pi * 0.02**2) - 1)
    assert 0.05 < error < 1.2 * found["area_error_estimate"]
    done = run_program(asperity, "solve", tmp_path / "m.scene")
    assert "not resolved by the pixels of the map" in done.stderr
    for of in ((), ("--of", "area")):
        done = run_program(asperity, "solve", tmp_path / "m.scene", "--accuracy", "1e-3", *of,
                           status=1)
        assert "no method has this accuracy" in done.stderr
        assert re.search(rf"of \S+: set --accuracy \S+{' '.join(['', *of])}, or take a map of "
                         "finer pixels", done.stderr)


def test_an_accuracy_of_the_load_where_areas_have_none(asperity, tmp_path):
    """Noise, with an error of the area of more than 50 %: the refusal names an option for the load
    alone, which is met."""
    found = solve(asperity, tmp_path, np.random.default_rng(0).standard_normal((N, N)), 1.0,
                  control="load", value=2.0 * N**2)
    assert found["area_error_estimate"] > 0.5
    shown = run_program(asperity, "solve", tmp_path / "m.scene", "--accuracy", "1e-3", status=1)
    option = re.search("set (--accuracy .*), or take a map of finer pixels", shown.stderr)
    run_program(asperity, "solve", tmp_path / "m.scene", *option[1].split())


@pytest.mark.parametrize("kind, is_rough", [("noise", True), (2, True), (4, False), (8, False),
                                            ("ball", False)])
def test_maps_rough_at_their_pixels(asperity, tmp_path, kind, is_rough):
    """The slope of a surface of no waves shorter than 4 pixels converges, that of noise and of
    waves down to 2 pixels does not: coarse contacts of both are reported apart by the warning."""
    for seed in range(3):
        edge, load = "periodic" if seed % 2 else "free", 2e-4 * N**2
        if kind == "ball":
            x = np.arange(N) - N / 2
            height, edge, load = -(x**2 + x[:, None] ** 2) / 2, "free", 4 / 3 * E * 1.7**3
        elif kind == "noise":
            height = np.random.default_rng(seed).standard_normal((N, N + 3))
        else:
            height = rough(N, shortest=kind, seed=seed)
        found = solve(asperity, tmp_path, height, 1.0, edge, control="load", value=load)
        if kind != 4:  # of waves of 4 pixels it is not resolved
            assert ("pressure_error_estimate" in found) != is_rough  # it grows without limit
        shown = run_program(asperity, "solve", tmp_path / "m.scene").stderr
        assert "not resolved by the pixels of the map" in shown
        assert ("(it is rough at their size)" in shown) == is_rough


def test_mean_gap_and_greatest_pressure(asperity, tmp_path):
    """Hertz: greatest pressure 2 E a/pi within its estimate; of a wave on a quarter of the
    spacing the mean gap is."""
    height, spacing, edge, load, (level, *_) = ball(np.random.default_rng(2))
    found = solve(asperity, tmp_path, height, spacing, edge, control="load", value=load)
    shown = run_program(asperity, "solve", tmp_path / "m.scene", "--contacts",
                       tmp_path / "c.csv").stdout
    greatest = max(float(row["maximum_pressure"]) for row in records(tmp_path / "c.csv"))
    error = abs(greatest / (2 * E * 0.02 / np.pi) - 1)
    assert 0 < error < found["pressure_error_estimate"] < 0.2
    assert re.search("error estimate: compression .*, separation .*, contact area .*, "
                     "greatest pressure ", shown)
    # An accuracy of this pressure alone: met, or refused with an option that is; not of asperities.
    asked = "--of", "pressure", "--accuracy"
    estimate = found["pressure_error_estimate"]
    run_program(asperity, "solve", tmp_path / "m.scene", *asked, 1.6 * estimate)
    shown = run_program(asperity, "solve", tmp_path / "m.scene", *asked, "1e-3", status=1).stderr
    option = re.search(r"set --accuracy (\S+) --of pressure", shown)
    assert error < float(option[1])
    run_program(asperity, "solve", tmp_path / "m.scene", *asked, option[1])
    alone = write_plane_scene(tmp_path / "alone", [(0.0, 0.0, 0.1, 1.0)],
                              loading={"control": "load", "value": 1.0})
    shown = run_program(asperity, "solve", alone, *asked, "1e-3", status=1).stderr
    assert "expected one, or --of load or --of area" in shown
    waves = [np.cos(np.arange(4 * N) * 2 * np.pi / 40 + phase) for phase in (0.3, 0.7)]
    fine = waves[0] + waves[1][:, None]
    true, coarse = (solve(asperity, tmp_path, h, spacing, control="load", value=0.01 * E * N**2)
                    for h, spacing in ((fine, 0.25), (fine[::4, ::4], 1.0)))
    assert abs(coarse["mean_gap"] / true["mean_gap"] - 1) < coarse["gap_error_estimate"] < 0.1


def test_record_of_other_kinds(root):
    """The kept record of test/bench/pixel_estimates.py: 95 % of the errors of each quantity are
    below their estimate, none is 3 times above. The median estimate is at most 6 times the error,
    that of the greatest pressure and of one stiffness 6.5: of 100 ratios it is known to 15 %. Some
    rules were chosen after this record was seen."""
    kept = (root / "reference_output/bench/pixel_estimates.csv").read_text().partition("\n")[2]
    rows = [row for row in csv.DictReader(io.StringIO(kept)) if row["kind"] == "all"]
    assert {row["quantity"] for row in rows} == {
        *ESTIMATED, "separation", "compression", "area", "mean_gap", "pressure", "load",
        "load at a compression"}
    assert sum(int(row["errors"]) for row in rows if row["quantity"] in ("area", "load")) > 400
    for row in rows:
        assert float(row["below_estimate_percent"]) >= 95 and int(row["errors"]) >= 100
        assert float(row["largest_error_over_estimate"]) < 3
        is_wide = row["quantity"] in ("pressure", "tangential_stiffness_xx")
        assert float(row["median_estimate_over_error"]) <= (6.5 if is_wide else 6)


def test_coarser_maps_without_heights(asperity, tmp_path):
    """Two pixels on every second row: one half of the map is solved, the other has no heights.
    Numbers of the first half without the others ended the program."""
    height = np.full((5, 4), np.nan)
    height[2, [1, 3]] = -0.0125
    found = solve(asperity, tmp_path, height, 1.0, control="load", value=0.2)
    assert found["load"] == pytest.approx(0.2) and "stiffness_error_estimate" not in found
