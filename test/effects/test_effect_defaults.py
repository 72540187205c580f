"""Effects of a scene that does not write how they are simulated."""

import re

import numpy as np
import pytest

from effect_runs import DECK, effect_rows
from judge import check, number, solved
from surfaces_csv import solve, write_csv_scene, write_scene

POSITION_56 = {"surfaces": {"deck": str(DECK)}, "motion": {"x_first": 5.6, "positions": 1}}
LOADED = {**POSITION_56, "loading": {"control": "load", "value": 1000.0}}
# Two balls far apart, and beside each other.
BALLS = [(0.0, 0.0, 1.0, 1.0), (30.0, 0.0, 1.0, 1.0)]
CLOSE = [(0.0, 0.0, 1.0, 1.0), (1.5, 0.0, 1.0, 1.0)]


def row_of(done):
    assert done.status == 0, done.stderr
    return done.positions[0]


def influence_warned_of(done):
    """The share that a warning states; None: there is none."""
    shown = re.search(r"position \d+: interaction is off, (\S+) % is its estimated influence on "
                      r"the load, ", done.stderr)
    return shown and float(shown.group(1)) / 100


def test_position_56(asperity, tmp_path):
    """By default within 1 % of boundary elements; `off` warns of 28 % and more."""
    default, boundary, off = (
        solve(asperity, write_scene(tmp_path / f"{name}.scene", by_default=True, **POSITION_56,
                                    **({"effects": {"interaction": name}} if name else {})))
        for name in ("", "boundary", "off"))
    truth = float(row_of(boundary)["load"])
    assert float(row_of(default)["load"]) == pytest.approx(truth, rel=0.01)
    assert not influence_warned_of(default)
    lost = 1 - truth / float(row_of(off)["load"])
    assert lost <= influence_warned_of(off) <= 2 * lost
    assert "set interaction = 'auto'" in off.stderr
    assert float(off.positions[0]["error_estimate"]) == pytest.approx(influence_warned_of(off),
                                                                      rel=0.01)


def test_no_effect_without_its_numbers_is_printed(asperity, tmp_path):
    """Contacts far apart: no warning, and the bytes of `off`. The unlike bodies have a note."""
    loading = {"loading": {"control": "load", "value": 1.0}, "motion": {"x_step": 0.1,
                                                                       "positions": 3}}
    runs = [solve(asperity, write_csv_scene(tmp_path, [BALLS[0]], BALLS, name=f"s{i}",
                                            by_default=not i, **loading)) for i in range(2)]
    for done in runs:
        assert ["unlike bodies" in line for line in done.stderr.splitlines()] == [True]
    for default, off in zip(runs[0].positions, runs[1].positions, strict=True):
        assert default["interaction"] == "off"
        assert all(default[name] == off[name] for name in off if name != "error_estimate")


def test_a_deck_has_no_effects(asperity, root, tmp_path):
    """The thesis is met: a deck in the place of a scene stays without effects."""
    done = solve(asperity, root / "data" / "thesis.deck", folder=tmp_path)
    off = solve(asperity, write_scene(
        tmp_path / "off.scene", surfaces={"deck": str(DECK)},
        motion={"x_first": 0.1, "x_step": 0.1, "positions": 100}))
    assert done.positions == off.positions
    assert "non-interacting contacts (Hertz); control" in done.stdout


@pytest.mark.parametrize("effect, numbers", (
    ("plasticity", {"plastic_yield_stress": 300.0}),
    ("adhesion", {"work_of_adhesion": 1e-2, "equilibrium_distance": 1e-7}),
    ("friction", {"friction_coefficient": 0.3}),
    ("creep", {"relaxation_time": 1.0, "relaxed_modulus_ratio": 0.5, "hold_time": 2.0})))
def test_an_effect_with_numbers_is_estimated(effect, numbers, asperity, tmp_path):
    """It is `auto`; without its numbers it is no effect of the scene; written off it stays off."""
    loading = {"loading": {"control": "approach", "value": 0.27}}
    auto, default, without = (row_of(solve(asperity, write_scene(
        tmp_path / f"{i}.scene", by_default=True, **POSITION_56, **loading,
        effects={"interaction": "off", **given}))) for i, given in enumerate((
            {effect: "auto", **numbers}, numbers, {})))
    assert default == auto and auto[effect] == "on" or effect == "friction"
    assert effect not in without
    off = solve(asperity, write_scene(tmp_path / "off.scene", by_default=True, **POSITION_56,
                                      **loading, effects={effect: "off", **numbers}))
    assert effect not in row_of(off)
    row = effect_rows(off.stdout)[effect]
    assert row["mode"] == "off" and float(row["left out"].removesuffix("%")) > 0


def test_a_limit_is_where_flow_begins(asperity, tmp_path):
    """A group &limit calls for plasticity where loading goes on beyond it."""
    limit = {"limit": {"criterion": "load", "value": 50.0}}
    beyond = solve(asperity, write_scene(tmp_path / "a.scene", by_default=True, **LOADED, **limit))
    assert row_of(beyond)["plasticity"] == "on"
    to_it = solve(asperity, write_scene(tmp_path / "b.scene", by_default=True, **POSITION_56,
                                        **limit))
    assert "plasticity" not in row_of(to_it)


@pytest.mark.parametrize("given, why", (
    ({"material": {"contact_modulus": 1e5}, "effects": {"plastic_yield_stress": 100.0}},
     "plasticity is left out: plasticity needs Poisson's ratio"),
    ({"material": {"contact_modulus": 1e5}, "limit": {"criterion": "load", "value": 5.0}},
     "plasticity is left out: plasticity needs Poisson's ratio"),
    ({"loading": {"control": "load", "value": (9.0, 3.0)},
      "effects": {"friction_coefficient": 1.0}},
     "friction is left out: friction is computed for surfaces that close without going back"),
    ({"effects": {"work_of_adhesion": 1.0}}, "adhesion is left out: it needs equilibrium_distance"),
    ({"effects": {"hold_time": 1.0, "relaxation_time": 1.0}},
     "creep is left out: it needs relaxed_modulus_ratio")))
def test_an_effect_without_a_method_is_left_out_with_a_note(given, why, asperity, tmp_path):
    """Such a scene is not refused, as its effects are not written."""
    done = solve(asperity, write_scene(tmp_path / "a.scene", by_default=True,
                                       **{**LOADED, **given}))
    assert why in done.stderr, done.stderr
    effect = why.split()[0]
    assert effect not in row_of(done)


def map_scene(folder, pressure, edge="periodic", n=128, **effects):
    """A self-affine map of the newcomer's kind, rms height 0.1."""
    rng, step = np.random.default_rng(1), 0.5
    q = np.fft.fftfreq(n, step) * 2 * np.pi
    wave = np.hypot(*np.meshgrid(q, q))
    wave[0, 0] = 1
    power = np.where((wave < 8 * np.pi / (n * step)) | (wave > np.pi / (4 * step)), 0, wave**-3.6)
    heights = np.fft.ifft2(np.sqrt(power) * np.fft.fft2(rng.standard_normal((n, n)))).real
    np.savetxt(folder / "h.txt", heights * 0.1 / heights.std())
    return write_scene(folder / "map.scene", by_default=True,
                       surfaces={"upper": "plane", "lower": "h.txt", "map_spacing": (step, step),
                                 "map_edge": edge},
                       material={"contact_modulus": 1e5},
                       loading={"control": "pressure", "value": pressure}, effects=effects)


@pytest.mark.long
def test_a_periodic_map(asperity, tmp_path):
    """A map is solved on its pixels, by default too; isolated or coupled contacts are refused."""
    for mode in ("coupled", "off"):
        refused = solve(asperity, map_scene(tmp_path, 90.0, interaction=mode))
        assert refused.status == 2 and not refused.stdout
        assert f"on its pixels: found {mode}, expected 'auto' or 'boundary'" in refused.stderr
    for pressure in (10.0, 90.0, 300.0):
        default, boundary = (float(row_of(solve(asperity, map_scene(tmp_path, pressure, **effects),
                                                contacts=False))["separation"])
                             for effects in ({}, {"interaction": "boundary"}))
        assert abs(default - boundary) < 1e-3 * 0.1
    limit = map_scene(tmp_path, 90.0)
    limit.write_text(re.sub("&loading.*", "&limit criterion = 'load', value = 1. /",
                            limit.read_text()))
    done = solve(asperity, limit, contacts=False)
    assert done.status == 2 and "found control = 'limit' or none" in done.stderr, done.stderr
    # The pixels have adhesion, also where the default of interaction is written.
    for mode in ({}, {"interaction": "auto"}):
        done = solve(asperity, map_scene(tmp_path, 90.0, **mode, adhesion="on",
                                         work_of_adhesion=1e-4, equilibrium_distance=1e-3),
                     contacts=False)
        assert done.status == 0 and not done.stderr
        assert (row_of(done)["interaction"], row_of(done)["adhesion"]) == ("boundary", "on")


def test_estimates_stand_in_the_tables(asperity, tmp_path):
    """Influence of what is off, in positions and states, with a position without contact first."""
    scene = write_csv_scene(tmp_path, CLOSE, BALLS[:1], by_default=True,
                            motion={"x_first": -30.0, "x_step": 30.0, "positions": 2},
                            loading={"control": "approach", "value": 1.9},
                            effects={"interaction": "off", "friction": "off",
                                     "friction_coefficient": 0.3, "hold_time": 0.0})
    done = solve(asperity, scene, curve=True)
    for table in (done.positions, done.curve):
        for row in table:
            assert float(row["error_estimate"]) >= float(row["interaction_estimate"]) >= 0.0
            assert "friction_estimate" in row and "creep_estimate" not in row


def test_error_of_an_effect_left_out_on_a_path(asperity, tmp_path):
    """Interaction beside adhesion is left out: its share in the worst state of a path bounds the
    error estimate also where the path ends with contacts in tension."""
    caps = [(3 * np.cos(a), 3 * np.sin(a), 0.3 + 0.002 * (k % 3), 1 + 0.1 * k)
            for k, a in enumerate(np.arange(12) * np.pi / 6)]
    scene = write_csv_scene(
        tmp_path, caps, caps, by_default=True,
        loading={"control": "separation", "value": (0.284, 0.304), "points": 3},
        effects={"work_of_adhesion": 0.5e3, "equilibrium_distance": 1e-3})
    scene.write_text(scene.read_text().replace("lower = 'pair_lower.csv'", "lower = 'plane'"))
    done = solved(asperity, scene, contacts=False)
    shown = re.search(r"\(interaction beside adhesion\), (\S+) % is the estimated", done.stderr)
    assert float(shown.group(1)) > 1
    assert float(row_of(done)["error_estimate"]) >= 0.0095 * float(shown.group(1))


EFFECTS = {
    "interaction": {},
    "friction": {"friction_coefficient": 0.1},
    "plasticity": {"plastic_yield_stress": 2.0},
    "adhesion": {"work_of_adhesion": 1e-3, "equilibrium_distance": 1e-3},
    "creep": {"hold_time": 1.0, "relaxation_time": 1.0, "relaxed_modulus_ratio": 0.5}}


@pytest.mark.parametrize("edge", ("periodic", pytest.param("free", marks=pytest.mark.once)))
def test_an_effect_of_a_map_is_simulated_or_left_out(edge, asperity, tmp_path):
    """Not both, for random sets of numbers; a note or a row of the summary names each."""
    rng = np.random.default_rng(3)
    numbers = {**EFFECTS, "plasticity": {"plastic_hardness": 20000.0}}
    for _ in range(10):
        chosen = [name for name in sorted(set(numbers) - {"interaction"}) if rng.random() < 0.6]
        given = {k: v for name in chosen for k, v in numbers[name].items()}
        if "adhesion" in chosen:
            given["work_of_adhesion"] = 10 ** rng.uniform(-4, 1)
            given["equilibrium_distance"] = 10 ** rng.uniform(-3, -1)
        done = solved(asperity, map_scene(tmp_path, 90.0, edge, 64, **given), contacts=False)
        rows = effect_rows(done.stdout)
        noted = re.findall(r"note: ([a-z]+) is left out", done.stderr)
        assert set(chosen) <= {*rows, *noted}, (given, done.stdout)
        simulated = [name for name in chosen if row_of(done).get(name, "off") != "off"]
        for name in simulated:
            assert f"warning: position 1: {name} is" not in done.stderr, done.stderr


@pytest.mark.parametrize("effect", sorted(EFFECTS))
def test_auto_leaves_out_effects_below_the_tolerance(effect, asperity, tmp_path):
    """The error without the effect, relative to the result with it, is within the tolerance."""
    rng = np.random.default_rng(6)
    left_out = 0
    for k in range(24):
        tolerance = (0.03, 0.1, 0.4)[k % 3]
        caps = [(3 * (i % 3) + u, 3 * (i // 3) + v, 0.3 + 0.002 * w, 1.0)
                for i, (u, v, w) in enumerate(rng.random((6, 3)))]
        numbers = dict(EFFECTS[effect])
        # Near the tolerance, where the choice is made.
        share = tolerance * rng.uniform(0.6, 1.1)
        if effect == "creep":
            numbers.update(relaxed_modulus_ratio=1 / (1 + share), hold_time=50.0,
                           hold=("load", "separation")[k // 3 % 2])
        if effect == "plasticity":
            numbers["plastic_yield_stress"] *= rng.uniform(0.5, 3.0)
        if effect == "adhesion":
            numbers["work_of_adhesion"] *= rng.uniform(0.1, 10.0)
        value, scenes = 10.0 ** rng.uniform(-2.7, -1.5), []
        for mode in ("auto", "coupled" if effect == "interaction" else "on"):
            scenes.append(write_csv_scene(
                tmp_path, [(3.0, 2.0, 0.0, 1e3)], caps, modulus=(200.0, 200.0), ratio=(0.3, 0.3),
                loading={"control": "compression", "value": value}, name=mode,
                effects={"interaction": "off", **numbers, effect: mode, "tolerance": tolerance}))
        auto, full = (row_of(solve(asperity, scene, contacts=False)) for scene in scenes)
        if auto[effect] != "off":
            continue
        left_out += 1
        for name in ("vertical_load", "area"):
            check(f"{name} of scene {k}", number(auto, name), number(full, name), tolerance)
    assert left_out >= 3
