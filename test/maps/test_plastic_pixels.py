"""Pressures limited by a hardness on the pixels of a height map (`plastic_hardness`): closed
forms, the conditions of the one solution, projected gradients in numpy, cycles, refused scenes."""

import itertools
import re

import numpy as np
import pytest

from image_data import read_vti
from elements_truth import product
from map_press_truth import first_contact, rough
from programs import run_program
from surfaces_csv import records, solve, write_scene
from test_map_edges import MODULUS, Map, random_map
from map_scenes import E, level, load_for, map_scene, patch_areas, solve_map

SIDES = (0.01, 0.013)
AREA = SIDES[0] * SIDES[1]


def run(asperity, folder, height, hardness, name="map", edge="free", surfaces=None, **groups):
    """States and the position as dicts of numbers, fields of every state."""
    scene = map_scene(folder, height, SIDES, name, surfaces={"map_edge": edge, **(surfaces or {})},
                      effects={"plasticity": "on", "plastic_hardness": hardness}, **groups)
    states, position, _, _ = solve_map(asperity, scene, "--fields-of", "all")
    return states, position, [read_vti(folder / f"{name}_{k:04}.vti")[2]
                              for k in range(1, len(states) + 1)]


def levelled(height, edge):
    return height - height.mean() if edge == "periodic" else level(height)


def clip_to_load(pressure, hardness, total):
    """The nearest pressures from 0 to the hardness whose sum is given: by bisection."""
    low, high = pressure.min() - hardness, pressure.max()
    for _ in range(200):
        middle = (low + high) / 2
        if np.clip(pressure - middle, 0, hardness).sum() > total:
            low = middle
        else:
            high = middle
    return np.clip(pressure - high, 0, hardness)


def projected_gradients(height, hardness, edge, total=None, flat=None):
    """Level of the flat and pressures: Nesterov's accelerated projected gradients with restarts, of
    a given sum or at a given level; violations are closed to 1e-10 of the range of heights."""
    act = product(height.shape, SIDES, 1.0, edge == "periodic")
    probe = np.random.default_rng(0).random(height.shape)
    for _ in range(200):
        probe = act(probe) / np.linalg.norm(probe)
    step = 0.98 * E / np.linalg.norm(probe)

    def project(p):
        return np.clip(p, 0, hardness) if total is None else clip_to_load(p, hardness, total)

    p = project(np.full(height.shape, hardness / 2))
    ahead, weight = p, 1.0
    for _ in range(100000):
        rest = act(p) / E - height
        moving = (p > 0) & (p < hardness)
        lower = flat if flat is not None else -rest[moving].mean()
        rest += lower
        worst = max(np.abs(rest[moving]).max(initial=0), -rest[p < hardness].min(initial=0),
                    rest[p > 0].max(initial=0))
        if worst < 1e-10 * np.ptp(height):
            return lower, p
        new = project(ahead - step * (act(ahead) / E - height + (0 if flat is None else flat)))
        if ((ahead - new) * (new - p)).sum() > 0:
            ahead, weight = p, 1.0
            continue
        more = (1 + np.sqrt(1 + 4 * weight**2)) / 2
        ahead, p, weight = new + (weight - 1) / more * (new - p), new, more
    raise RuntimeError(f"violations of {worst:.1e} are left")


def deformed_shape(height, state, field):
    """How far the pixels are pressed down, from the fields, wherever the flat is above them."""
    return field["gap"] - (state["separation"] - height + field["displacement"])


@pytest.mark.parametrize("edge", ["free", "periodic"])
@pytest.mark.parametrize("share, hard", [(0.05, 0.2), (0.2, 0.1), (0.1, 1.0), (0.3, 0.03)])
def test_against_projected_gradients(asperity, tmp_path, edge, share, hard):
    """Hardness as a share of the modulus times the slope of the map; load, then separation."""
    height = 1e-3 * rough(32, shortest=5, seed=int(1000 * share))
    of = levelled(height, edge)
    slope = 2 * load_for(height, SIDES, 1.0) / (E * height.size * AREA)
    hardness = hard * E * slope
    load = min(load_for(height, SIDES, share), 0.6 * hardness * height.size * AREA)
    states, row, (field,) = run(asperity, tmp_path, height, hardness, edge=edge,
                                loading={"control": "load", "value": load})
    flat, true = projected_gradients(of, hardness, edge, total=load / AREA)
    full = true == hardness
    assert 0 < full.sum() < (true > 0).sum() or hard > 0.9
    errors = [row["separation"] / flat - 1, np.abs(field["pressure"] - true).max() / true.max(),
              row["load"] / load - 1, field["pressure"].sum() * AREA / load - 1]
    assert max(map(abs, errors)) < 1e-7, errors
    act = product(of.shape, SIDES, E, edge == "periodic")
    overlap = np.where(full, of - flat - act(true), 0)
    assert overlap.min() > -1e-9 * np.ptp(of)
    assert row["plastic_area"] == pytest.approx(full.sum() * AREA, rel=1e-12)
    assert row["dissipated_work"] == pytest.approx(hardness * overlap.sum() * AREA, rel=1e-7,
                                                   abs=1e-12)
    assert states[-1]["plastic_area"] == row["plastic_area"]
    # The same at the separation that was found.
    _, there, (other,) = run(asperity, tmp_path, height, hardness, name="there", edge=edge,
                             loading={"control": "separation", "value": row["separation"]})
    _, at_level = projected_gradients(of, hardness, edge, flat=row["separation"])
    more = [there["load"] / load - 1, np.abs(other["pressure"] - at_level).max() / true.max()]
    assert max(map(abs, more)) < 1e-6, more


@pytest.mark.parametrize("edge", ["free", "periodic"])
def test_conditions_on_the_fields(asperity, tmp_path, edge):
    """Of every state of a path on 128 x 96 pixels, coarse starts included."""
    height = 1e-3 * rough(128, 96, shortest=8, seed=5)
    of = levelled(height, edge)
    load = load_for(height, SIDES, 0.1)
    hardness = 0.15 * E * 2 * load_for(height, SIDES, 1.0) / (E * height.size * AREA)
    states, _, fields = run(asperity, tmp_path, height, hardness, edge=edge, loading={
        "control": "load", "value": (load, 0.3 * load, 1.5 * load), "points": 2})
    shape = np.zeros_like(of)
    work = 0.0
    act = product(of.shape, SIDES, 1.0, edge == "periodic")
    reach = np.ptp(of)
    for state, field in zip(states, fields):
        p, gap = field["pressure"], field["gap"]
        # Before any load the flat is at the top between the pixels.
        lowest = first_contact(of, edge == "periodic") - of.max() if state is states[0] else 0
        assert p.min() == 0 and p.max() <= hardness
        assert gap.min() == pytest.approx(lowest, rel=1e-9)
        assert p.sum() * AREA == pytest.approx(state["load"], rel=1e-12)
        assert np.abs(field["displacement"] - act(p) / E).max() <= 1e-12 * reach
        now = deformed_shape(of, state, field)
        grown = now - shape
        full = p == hardness
        # Pixels sink where the pressure is the hardness and nowhere else.
        assert grown.min() > -1e-9 * reach
        assert np.abs(grown[~full]).max() < 1e-9 * reach
        assert not (gap * p).any()
        work += hardness * grown[full].sum() * AREA
        assert state["dissipated_work"] == pytest.approx(work, rel=1e-6, abs=1e-12 * load)
        assert state["plastic_area"] == pytest.approx(full.sum() * AREA, rel=1e-12)
        shape = now
    assert states[2]["plastic_area"] > 0.02 * of.size * AREA
    assert states[4]["plastic_area"] == 0


@pytest.mark.parametrize("edge", ["free", "periodic"])
def test_a_second_loading_follows_the_unloading(asperity, tmp_path, edge):
    """Reloading follows unloading; no work is dissipated up to the largest load; the residual shape
    stays at no load."""
    height = 1e-3 * rough(64, 48, shortest=6, seed=8)
    of = levelled(height, edge)
    load = load_for(height, SIDES, 0.15)
    hardness = 0.15 * E * 2 * load_for(height, SIDES, 1.0) / (E * height.size * AREA)
    states, row, fields = run(asperity, tmp_path, height, hardness, edge=edge, loading={
        "control": "load", "value": (load, 0.0, load, 1.2 * load), "points": 4})
    up, down, again, on = states[1:5], states[4:9], states[8:13], states[12:17]
    reach = np.ptp(of)
    for one, other in zip(down, again[::-1]):
        assert abs(one["separation"] - other["separation"]) < 1e-8 * reach
        assert other["area"] == pytest.approx(one["area"], rel=1e-3)
    assert all(a["dissipated_work"] < b["dissipated_work"] for a, b in zip(up, up[1:]))
    lost = [state["dissipated_work"] for state in down + again]
    assert lost[0] > 0 and max(lost) / min(lost) - 1 < 1e-8
    assert on[-1]["dissipated_work"] > 1.1 * lost[0]
    # Without load: the shape of the largest load, touched at its highest point.
    shapes = [deformed_shape(of, state, field) for state, field in zip(states, fields)]
    assert np.abs(shapes[8] - shapes[4]).max() < 1e-8 * reach
    assert shapes[8].max() > 0.05 * reach
    assert states[8]["separation"] == pytest.approx((of - shapes[4]).max(), rel=1e-8)
    assert states[8]["elastic_energy"] == 0 and states[8]["plastic_area"] == 0
    assert row["plasticity"] == "on"


@pytest.mark.parametrize("seed", range(24))
def test_laws_of_patches(asperity, tmp_path, seed):
    """Random maps, elastic and with a hardness, over a cycle of three equal maxima: of every patch
    of every state mean <= greatest pressure <= hardness, plastic area <= area; areas are those of
    the pressures; at each maximum the same pixels are at the hardness."""
    of, random = random_map(seed)
    slope = np.nanstd(np.diff(of.height, axis=0)) / of.spacing[1]
    hardness = float(MODULUS * slope * 10 ** random.uniform(-1.5, 0.3)) if seed % 3 else np.inf
    load = float(min(MODULUS * slope * of.area() * 10 ** random.uniform(-4, 0),
                     0.8 * hardness * of.area()))
    of.write(tmp_path / "m.txt")
    scene = write_scene(
        tmp_path / "m.scene", material={"contact_modulus": MODULUS},
        surfaces={"upper": "plane", "lower": "m.txt", "map_spacing": of.spacing,
                  "map_edge": "periodic" if of.periodic else "free"},
        loading={"control": "load", "value": (load, 0.3 * load, load, 0.0, load)},
        effects={"interaction": "boundary",
                 **({"plastic_hardness": hardness, "plasticity": "on"}
                    if hardness < np.inf else {})})
    run_program(asperity, "solve", scene, "--quiet", "--fields", tmp_path / "m.vti", "--fields-of",
                "all", "--curve", tmp_path / "curve", "--contacts", tmp_path / "contacts")
    plastic = []
    for state in records(tmp_path / "curve"):
        contacts = [row for row in records(tmp_path / "contacts") if row["step"] == state["step"]]
        mean, greatest, area, forces = (
            np.array([float(row[name]) for row in contacts]) for name in
            ("average_pressure", "maximum_pressure", "area", "load"))
        assert (mean <= greatest).all() and (greatest <= hardness).all()
        # Of a patch of few pixels the area is below the load over its greatest pressure.
        np.testing.assert_allclose(mean, np.minimum(forces / area, greatest), rtol=1e-12)
        total = float(state["area"])
        assert area.sum() == pytest.approx(total, rel=1e-12)
        assert forces.sum() == pytest.approx(float(state["load"]), rel=1e-6)
        pressure = read_vti(tmp_path / f"m_{int(state['step']):04}.vti")[2]["pressure"]
        np.testing.assert_allclose(np.sort(area), np.sort(patch_areas(
            pressure, of.spacing, of.periodic, hardness)), rtol=1e-12)
        if hardness < np.inf:
            plastic.append(float(state["plastic_area"]))
            assert plastic[-1] <= total * (1 + 1e-12)
            assert plastic[-1] == pytest.approx(
                (pressure == hardness).sum() * np.prod(of.spacing), rel=1e-12)
    if plastic:
        assert plastic[0] == plastic[2] == plastic[4] and plastic[1] == plastic[3] == 0


@pytest.mark.parametrize("kind", ["elastic", "hardness"])
def test_the_area_grows_with_the_load(asperity, tmp_path, kind):
    """Small maps, where a patch has few pixels, from first touch to ten times full contact: under
    each larger load no pixel opens and no patch is smaller (Barber 1974)."""
    for seed in range(40):
        random = np.random.default_rng(seed)
        of = Map(random.standard_normal(random.integers(4, 12, 2)), (1.0, 0.5), seed % 2 == 0)
        of.write(tmp_path / "m.txt")
        full = MODULUS * np.ptp(of.height) * of.area()
        effects = {"interaction": "boundary"}
        loads = np.geomspace(1e-6, 10, 20) * full
        if kind == "hardness":
            hardness = float(MODULUS * 10 ** random.uniform(-1.5, 0.5))
            effects.update(plasticity="on", plastic_hardness=hardness)
            loads = np.geomspace(1e-4, 1, 20) * hardness * of.area()
        scene = write_scene(
            tmp_path / "m.scene", material={"contact_modulus": MODULUS}, effects=effects,
            surfaces={"upper": "plane", "lower": "m.txt", "map_spacing": of.spacing,
                      "map_edge": "periodic" if of.periodic else "free"},
            loading={"control": "load", "value": tuple(float(load) for load in loads)})
        run_program(asperity, "solve", scene, "--quiet", "--curve", tmp_path / "curve")
        area = [float(state["area"]) for state in records(tmp_path / "curve")]
        assert np.diff(area).min() > -1e-12 * of.area(), (seed, area)
        assert area[-1] == pytest.approx(of.area(), rel=1e-12) or not of.periodic


@pytest.mark.parametrize("edge", ["free", "periodic"])
def test_no_load_is_above_the_hardness_on_all_pixels(asperity, tmp_path, edge):
    """The largest load is the hardness times the measured area; more is refused."""
    height = 1e-3 * rough(33, 32, shortest=5, seed=3)
    hardness = 0.01
    most = hardness * height.size * AREA
    for load in (most, 0.999 * most):
        states, _, (field,) = run(asperity, tmp_path, height, hardness, edge=edge,
                                  loading={"control": "load", "value": load})
        assert field["pressure"].sum() * AREA == pytest.approx(load, rel=1e-12)
        assert (field["pressure"] == hardness).sum() >= 0.99 * load / most * height.size
    states, _, (field,) = run(asperity, tmp_path, height, hardness, edge=edge,
                              loading={"control": "compression", "value": 1.0})
    assert states[0]["load"] == pytest.approx(most, rel=1e-12)
    assert (field["pressure"] == hardness).all() and not field["gap"].any()
    scene = map_scene(tmp_path, height, SIDES, name="more", surfaces={"map_edge": edge},
                      loading={"control": "load", "value": 1.001 * most})
    scene.write_text(scene.read_text().replace("plasticity = 'off'", "plastic_hardness = 0.01"))
    found = solve(asperity, scene)
    assert found.status == 1 and "plastic_hardness times the measured area" in found.stderr


@pytest.mark.parametrize("edge, shape, seeds", [("free", (23, 4), (10, 14)),
                                                ("periodic", (12, 12), (3, 9, 10))])
def test_missing_pixels_carry_nothing(asperity, tmp_path, edge, shape, seeds):
    """As pixels that are too deep for a contact: the load is carried by the others. Projections on
    the load put forces on missing pixels: loads were refused as too small, or not met."""
    for seed, share in itertools.product(seeds, (0.3, 0.7)):
        height = 1e-3 * rough(*shape, shortest=3, seed=seed)
        at = np.random.default_rng(seed).integers(0, shape, (5, 2))
        fields = []
        for depth in (np.nan, -0.02):
            height[tuple(at.T)] = depth
            load = share * 0.0015 * float((height > -0.02).sum() * AREA)
            _, _, (field,) = run(asperity, tmp_path, height, 0.0015, edge=edge,
                                 surfaces={"map_level": "none"},
                                 loading={"control": "load", "value": load})
            fields.append(np.nan_to_num(field["pressure"]))
            assert fields[-1].sum() * AREA == pytest.approx(load, rel=1e-9)
        assert fields[0] == pytest.approx(fields[1], abs=1e-6 * 0.0015), seed


def test_a_soft_ridge(asperity, tmp_path):
    """Steps of one height, soft as wax beside the modulus: each is at the hardness over its whole
    width or touches nowhere, and the area is the load over the hardness."""
    height = np.zeros((40, 24))
    height[5:9] = 0.02
    height[25:33] = 0.05
    hardness = 1e-4
    for load_share, rows in ((0.5, 8), (1.0, 8)):
        load = load_share * hardness * 8 * 24 * AREA
        states, _, (field,) = run(asperity, tmp_path, height, hardness, edge="periodic",
                                  loading={"control": "load", "value": load})
        pressed = field["pressure"] > 0
        assert pressed[25:33].all() and pressed.sum() == rows * 24
    assert states[0]["plastic_area"] == pytest.approx(load / hardness, rel=1e-9)


@pytest.mark.parametrize("effects, words", [
    (", plastic_hardness = 0.1", r"plasticity +auto"),
    (", plastic_hardness = 0.1, plasticity = 'on'", r"plasticity +on"),
    (", plastic_hardness = 0.1, plasticity = 'off'", None)])
@pytest.mark.parametrize("interaction", ["boundary", "auto"])
def test_a_hardness_calls_for_pixels(asperity, tmp_path, effects, words, interaction):
    """By its number as by its word; a map under 'auto' is then solved on its pixels."""
    height = 1e-3 * rough(32, shortest=5, seed=3)
    scene = map_scene(tmp_path, height, SIDES, interaction=interaction,
                      loading={"control": "load", "value": load_for(height, SIDES, 0.1)})
    scene.write_text(scene.read_text().replace(", plasticity = 'off'", effects))
    found = solve(asperity, scene)
    assert found.status == 0, found.stderr
    if words is None:
        assert "plastic_area" not in found.positions[0]
    else:
        assert re.search(words, found.stdout)
        assert found.positions[0]["interaction"] == "boundary"
        assert "greatest pressure" in found.stdout


@pytest.mark.parametrize("interaction, effects, sentence", [
    ("boundary", "plasticity = 'on'", "expected one with plasticity on the pixels of a map"),
    ("boundary", "plasticity = 'on', plastic_yield_stress = 1., plastic_hardness = 1.",
     "expected plastic_hardness in its place"),
    ("boundary", "plasticity = 'on', plastic_yield_stress = 1.",
     "expected plastic_hardness in its place"),
    ("coupled", "plastic_hardness = 1.", "a map is solved on its pixels: found coupled"),
    ("boundary", "plastic_hardness = 0.", "plastic_hardness"),
    ("boundary", "plastic_hardness = 1., friction = 'on', friction_coefficient = .1",
     "friction needs shear moduli")])
def test_refused(asperity, tmp_path, interaction, effects, sentence):
    height = 1e-3 * rough(32, shortest=5, seed=3)
    scene = map_scene(tmp_path, height, SIDES, interaction=interaction,
                      loading={"control": "load", "value": 1e-6})
    scene.write_text(scene.read_text().replace("plasticity = 'off'", effects))
    found = solve(asperity, scene)
    assert found.status == 2 and sentence in found.stderr, found.stderr


@pytest.mark.truth
@pytest.mark.parametrize("interaction", ["boundary", "auto"])
def test_accuracy_against_numpy(asperity, tmp_path, interaction):
    """`asperity accuracy`: the reference has the hardness; without plasticity the contacts are
    elastic."""
    height = 1e-3 * rough(32, shortest=5, seed=50)
    load = load_for(height, SIDES, 0.15)
    hardness = load / (0.3 * height.size * AREA)
    scene = map_scene(tmp_path, height, SIDES, interaction=interaction,
                      loading={"control": "load", "value": load})
    elastic = scene.read_text()
    scene.write_text(elastic.replace("plasticity = 'off'", "plasticity = 'on', "
                                     f"plastic_hardness = {hardness!r}"))
    run_program(asperity, "accuracy", scene, "--quiet", "--seconds", "3", "--csv",
                tmp_path / "a.csv")
    rows = {row["method"]: row for row in records(tmp_path / "a.csv")}
    of = level(height)
    flat, _ = projected_gradients(of, hardness, "free", total=load / AREA)
    softer, _ = projected_gradients(of, 1e9, "free", total=load / AREA)
    assert [way for way, row in rows.items() if row["reference"] == "1"] == ["pixels of the map"]
    for way, true in (("pixels of the map", flat), ("as in the scene", flat),
                      ("without plasticity", softer)):
        assert float(rows[way]["separation"]) == pytest.approx(true, abs=1e-7 * np.ptp(of)), way
        assert float(rows[way]["error_max"]) == pytest.approx(
            abs(true - flat) / (first_contact(of) - flat), abs=1e-6), way
    assert float(rows["without plasticity"]["error_max"]) > 1e-2
    assert not any(way.startswith("auto") for way in rows)


@pytest.mark.parametrize("edge", ["periodic", "free"])
def test_a_hardness_that_no_load_reaches(edge, asperity, tmp_path):
    """The elastic result to the last digit: 1e20 times the modulus was refused, as forces lost all
    digits beside it."""
    height = 0.01 * rough(32)
    load = {"loading": {"control": "load", "value": load_for(height, SIDES, 0.3)}}
    fields = [run(asperity, tmp_path, height, hardness, f"map{i}", edge, **load)[2][-1]["pressure"]
              for i, hardness in enumerate((1e9 * E, 1e20 * E, 1e200))]
    elastic = solve_map(asperity, map_scene(tmp_path, height, SIDES, "elastic", surfaces={
        "map_edge": edge}, **load))[2]["pressure"]
    for pressure in fields:
        assert np.array_equal(pressure, elastic)


@pytest.mark.parametrize("seed, hardness, separations", [
    (551, 25.6, (-0.00085, 0.00012)), (607, 13.98, (-0.0032, 0.0009))])
def test_level_above_full_contact(asperity, tmp_path, seed, hardness, separations):
    """Nearly all pixels at the hardness, then the flat rises: equal pressures displace
    nothing, so that from great ones the least has to be taken from all at once."""
    height = np.random.default_rng(seed).normal(size=(8, 10)).round(3)
    height -= height.mean()
    if seed % 3:
        height = sum(np.roll(height, shift, (0, 1)) for shift in np.ndindex(2, 2)) / 4
    states, *_ = solve_map(asperity, map_scene(
        tmp_path, height.T, (1.0, 1.0), material=1.0, surfaces={"map_edge": "periodic"},
        loading={"control": "separation", "value": separations},
        effects={"plasticity": "on", "plastic_hardness": hardness}))
    assert 0 < states[1]["load"] < 0.1 * states[0]["load"]
