"""Scenes that are changed and solved again: the same results with and without an earlier outcome,
fewer iterations, units of all tables."""

import threading

import numpy as np
import pytest
from builds import ROOT

# Depends on no build under test: the package has the release build.
pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

# Two random surfaces whose summits keep a distance, and two whose summits may nearly coincide.
APART = {"number": 400, "length": 29.0, "width": 29.0, "least_distance": 0.762}
PACKED = {"number": 300, "length": 14.0, "width": 14.0, "least_distance": 0.0}
COUPLED = {"interaction": "coupled"}
# What the solver leaves of its equations, over the deepest penetration, is at most 1e-9.
NEAR = 5e-9


def random_groups(package, surfaces, seed, value=1e4):
    """The groups of a scene of two random surfaces."""
    upper, lower = package.generate({
        "surfaces": surfaces, "random": {"seed": seed},
        "radii": {"mean": 1.27, "deviation": 0.1, "lowest": 0.8, "highest": 1.8},
        "heights": {"mean": 0.127, "deviation": 0.03, "lowest_deviation": -1.0,
                    "highest_deviation": 1.9}})
    return {"surfaces": {"upper": upper, "lower": lower}, "material": {"contact_modulus": 1e5},
            "loading": {"control": "load", "value": value}, "motion": {"x_step": 0.4},
            "effects": COUPLED}


def after(scene, earlier=None):
    """The scene with the outcome of another solve as its earlier one."""
    made = type(scene).__new__(type(scene))
    vars(made).update(vars(scene))
    made._earlier = earlier and earlier._earlier
    return made


def solved(scene, **changes):
    """All numbers of positions, states and contacts."""
    results = scene.solve(threads=1, **changes)
    return repr([one.to_dict() for one in (results.positions, results.states, results.contacts)])


def compare(package, base, changes, threads=1):
    """Solves a scene with its changes one after the other, alone and with the outcome before.
    Returns the largest relative differences by column, and both sums of iterations."""
    scene, worst, iterations = package.Scene(base), {}, [0, 0]
    for change in changes:
        alone, again = (one.solve(threads=threads, **change) for one in (after(scene), scene))
        for name in ("upper", "lower"):
            assert np.array_equal(alone.contacts[name], again.contacts[name])
        for name in ("load", "vertical_load", "compression", "area"):
            one, other = alone.positions[name], again.positions[name]
            worst[name] = max(np.max(np.abs(one - other) / np.abs(one)), worst.get(name, 0.0))
        for i, results in enumerate((alone, again)):
            iterations[i] += np.nansum(
                results.positions.to_dict().get("interaction_iterations", [0]))
    return worst, iterations


LOADS = np.linspace(2e4, 6e4, 12)
RANDOM = np.random.default_rng(7)
ORDERS = {"up": LOADS, "down": LOADS[::-1],
          "random": np.concatenate([RANDOM.permutation(LOADS) for _ in range(4)])}


def loads(values):
    return [{"loading": {"value": value}} for value in values]


@pytest.mark.parametrize("order", ORDERS)
def test_loads(package, order):
    """Loads up, down and in random order: the same contacts and totals with fewer iterations."""
    worst, (alone, again) = compare(package, random_groups(package, APART, 3),
                                    loads(ORDERS[order]))
    print(order, worst, alone, again)
    assert max(worst.values()) < NEAR and worst["load"] < 1e-11
    # In random order the start is farther off.
    assert again <= (0.85 if order == "random" else 0.8) * alone


@pytest.mark.long
@pytest.mark.parametrize("seed", range(1, 4))
def test_contacts_that_nearly_coincide(package, seed):
    """Near contacts have several solutions: the one that is found does not depend on the start."""
    values = np.random.default_rng(seed).uniform(1e3, 1e5, 12)
    worst, _ = compare(package, random_groups(package, PACKED, seed), loads(values))
    assert max(worst.values()) < NEAR


CHANGES = {
    "control": [{}, {"loading": {"control": "compression", "value": 0.08}},
                {"loading": {"control": "compression", "value": 0.09}},
                {"loading": {"control": "vertical_load", "value": 3.5e4}}],
    "modulus": [{}, *({"material": {"contact_modulus": modulus}} for modulus in (1.1e5, 1.2e5))],
    "effects": [{}, {**loads([3.1e4])[0], "effects": {"interaction": "auto"}},
                {**loads([3.2e4])[0], "effects": {"interaction": "auto", "tolerance": 0.003}},
                {**loads([3.3e4])[0], "effects": {"interaction": "off"}}, *loads([3.4e4])],
    "positions": [{**one, "motion": {"positions": 3}} for one in loads((3e4, 3.2e4, 3.4e4))],
    "fewer positions": [{"motion": {"positions": number}} for number in (1, 3, 2)],
}


@pytest.mark.parametrize("change", CHANGES)
def test_other_changes(package, change):
    """Other control, modulus, effects, tolerance, positions."""
    worst, iterations = compare(package, random_groups(package, APART, 4, 3e4), CHANGES[change],
                                threads=2)
    print(change, worst, iterations)
    assert max(worst.values()) < NEAR


@pytest.mark.parametrize("value, effects", [
    (3e4, {**COUPLED, "work_of_adhesion": 0.5}),
    (3e4, {**COUPLED, "plasticity": "on", "plastic_yield_stress": 1e4}),
    ((3e4, 1e4, 2e4), COUPLED)], ids=["adhesion", "plasticity", "path"])
def test_memory_of_contacts(package, value, effects):
    """Paths and effects that remember start from rest: every byte is that of a solve alone."""
    base = random_groups(package, APART, 5)
    base["material"] = {"elastic_modulus": (1e5, 1e5), "poisson_ratio": (0.3, 0.3)}
    change = {"loading": {"value": value}, "effects": effects}
    scene = package.Scene(base)
    scene.solve()
    assert solved(scene, **change) == solved(after(scene), **change)


def test_outcomes_of_other_scenes(package):
    """An earlier outcome of other surfaces is left alone, and so is a solve that failed: every byte
    is that of a solve alone."""
    scene, other = (package.Scene(random_groups(package, APART, seed, 3e4)) for seed in (5, 6))
    alone = solved(after(scene))
    other.solve()
    assert solved(after(scene, other)) == alone
    with pytest.raises(package.ComputeError):
        scene.solve(loading={"value": 1e30})
    assert solved(scene) == alone


@pytest.mark.parametrize("ratio, starts_alone", [(1.45, False), (1.55, True)])
def test_a_far_load_begins_anew(package, ratio, starts_alone):
    """Above 1.5 times the load**(2/3) of the earlier outcome a solve starts as one alone."""
    scene = package.Scene(random_groups(package, APART, 5, 2e4))
    scene.solve()
    (change,) = loads([2e4 * ratio ** 1.5])
    alone, again = (one.solve(**change).contacts.to_dict() for one in (after(scene), scene))
    assert starts_alone == (repr(alone) == repr(again))


def test_two_threads_share_an_outcome(package):
    """Solves at once with the same earlier outcome give what one gives after the other."""
    scene = package.Scene(random_groups(package, APART, 8, 3e4))
    scene.solve()
    changes = loads(3e4 + 500 * i for i in range(8))
    expected, found = [solved(after(scene, scene), **change) for change in changes], [None] * 8

    def work(numbers):
        for i in numbers:
            found[i] = solved(after(scene, scene), **changes[i])
    threads = [threading.Thread(target=work, args=(range(k, 8, 2),)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=100)
    assert found == expected


# ---------------------------------------------------------------- groups and units

SCENES = ["data/examples/thesis.scene", "data/thesis.deck",
          "data/examples/summits/press_samples.scene", "data/examples/csv_surfaces.scene"]


@pytest.mark.parametrize("path", SCENES)
def test_groups_of_a_file_make_the_same_scene(package, path):
    """A scene made from the groups of a file prints the same summary."""
    scene = package.Scene(ROOT / path)
    assert scene.solve(effects={}).summary == scene.solve().summary != ""


def test_rebuilt_scenes(package, tmp_path):
    """The surfaces are not read again, and what their group states stays; the rest is new."""
    for name in ("upper", "lower"):
        (tmp_path / f"{name}.csv").write_text("x,y,height\n0,0,1\n3,0,0.9\n", encoding="ascii")
    (tmp_path / "a.scene").write_text(
        "&surfaces upper = 'upper.csv', lower = 'lower.csv', radius = 5., 5., nominal_area = 12.,\n"
        "units = 'mm', 'N' / ! a comment\n&material elastic_modulus = 2*1e3,\n  poisson_ratio ="
        " 0.3, 0.4 /\n&tilt upper_slope = 0.1, 0. /\n&loading control = 'load', value = 1. /\n",
        encoding="ascii")
    scene = package.Scene(tmp_path / "a.scene")
    assert scene.groups["material"] == {"elastic_modulus": "2*1e3", "poisson_ratio": "0.3, 0.4"}
    (tmp_path / "upper.csv").unlink()
    found = scene.solve(material={"elastic_modulus": None, "poisson_ratio": None,
                                  "contact_modulus": 1e3}, tilt=None,
                        loading={"control": "pressure", "value": 0.5})
    assert abs(found.positions["vertical_load"][0] - 6.0) < 1e-6
    assert found.positions.units["nominal_pressure"] == "MPa"
    # Without the tilt both pairs are level with each other: 3 mm apart, 0.2 mm deep.
    assert found.contacts["slope"][0] == 0.0
    with pytest.raises(package.InputError, match="needs elastic_modulus"):
        scene.solve(material=None, loading={"value": -1.0})
