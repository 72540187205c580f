"""Adhesion on the pixels of a height map: the sphere by a radial equation, rough periodic maps by
tamaas, states of one and of eight steps, a hardness, pulls that are not carried, refused scenes."""

import re

import numpy as np
import pytest

from adhesive_radial import largest_pull
from map_press_truth import rough
from map_scenes import map_scene, solve_map

WORK = 2e-5
RANGE = 9 * 3**0.5 / 16  # of the exponential law over the equilibrium distance


def run(asperity, folder, height, side, values, control="load", law="exponential", distance=1.0,
        work=WORK, edge="free", status=0, **more):
    """Rows of the states, the position, fields of the last state, standard error."""
    return solve_map(asperity, map_scene(
        folder, height, (side, side), material=1.0, by_default=True,
        surfaces={"map_edge": edge, "map_level": "none"},
        loading={"control": control, "value": tuple(map(float, np.atleast_1d(values)))},
        effects={"adhesion": "on", "work_of_adhesion": float(work),
                 "equilibrium_distance": float(distance), "adhesion_law": law, **more}),
                     status=status)


def sphere(side, n):
    """A paraboloid of radius 1 on a disc; beyond it pixels are missing."""
    x = (np.arange(n) - (n - 1) / 2) * side / n
    r = np.hypot(x[:, None], x[None, :])
    return np.where(r < side / 2, -r**2 / 2, np.nan)


def law_of(name, distance):
    """Attraction and its slope."""
    if name == "exponential":
        rho = RANGE * distance
        return (lambda g: WORK / rho * np.exp(-np.maximum(g, 0) / rho),
                lambda g: -WORK / rho**2 * np.exp(-np.maximum(g, 0) / rho))
    return (lambda g: 2 * WORK / distance * (1 + np.maximum(g, 0) / distance)**-3,
            lambda g: -6 * WORK / distance**2 * (1 + np.maximum(g, 0) / distance)**-4)


@pytest.mark.parametrize("law, tabor, side", [
    ("exponential", 0.2, 0.26), *(pytest.param(*case, marks=pytest.mark.truth) for case in (
        ("exponential", 0.5, 0.18), ("exponential", 1.0, 0.14), ("exponential", 2.0, 0.12),
        ("exponential", 3.0, 0.11),
        ("van_der_waals", 1.0, 0.16)))])
def test_pull_off_of_a_sphere(asperity, tmp_path, law, tabor, side):
    """The largest pull on a path of separations, against rings to 1 %."""
    distance = WORK**(2 / 3) / tabor
    unit = WORK**(2 / 3)
    separations = np.linspace(-0.5 * unit, 2.2 * unit, 20)
    rows, *_ = run(asperity, tmp_path, sphere(side, 60), side / 60, tuple(separations),
                     "separation", law, distance)
    loads = np.array([row["load"] for row in rows])
    i = loads.argmin()
    left, least, right = loads[i - 1:i + 2]
    pull = -(least - (right - left)**2 / (8 * (left - 2 * least + right)))
    exact = largest_pull(*law_of(law, distance), side / 2, -0.5 * unit, 2.2 * unit, 40, rings=140)
    assert abs(pull / exact - 1) < 0.01, (pull / np.pi / WORK, exact / np.pi / WORK)


def test_a_pull_that_is_not_carried(asperity, tmp_path):
    """The message has the largest pull: that of a path of separations within its steps, and a pull
    0.1 % below it is carried."""
    distance, side = WORK**(2 / 3), 0.14
    height = sphere(side, 32)
    load = np.pi * WORK
    said = run(asperity, tmp_path, height, side / 32, (load, -2 * load), distance=distance,
               status=1)
    most, mean = map(float, re.search(r"the pull is larger than the contacts carry: (\S+) at most, "
                                      r"a nominal pressure of ([^\s,]+)", said).groups())
    assert "from first contact" not in said and 1.5 < most / load < 1.7
    pixels = np.isfinite(height).sum()
    assert mean == pytest.approx(most / (pixels * (side / 32) ** 2), rel=1e-5)
    rows, *_ = run(asperity, tmp_path, height, side / 32, (load, -0.999 * most),
                     distance=distance)
    assert abs(rows[-1]["load"] / most + 0.999) < 1e-6
    run(asperity, tmp_path, height, side / 32, (load, -1.002 * most), distance=distance, status=1)
    said = run(asperity, tmp_path, height, side / 32, -2 * load, distance=distance, status=1)
    assert "from first contact" in said and "expected a path" in said
    # Without load the surfaces pull each other into contact.
    rows, position, *_ = run(asperity, tmp_path, height, side / 32, (load, 0.0), distance=distance)
    assert rows[-1]["area"] > 0 and abs(rows[-1]["load"]) < 1e-9 * load
    assert position["gap_attraction"] > 0


def tamaas_solution(height, mean_gap, work, rho):
    """Mean traction, contact area fraction and gaps of the adhesive solver of tamaas."""
    import tamaas
    tamaas.set_log_level(tamaas.LogLevel.error)
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [1.0, 1.0],
                                            list(height.shape))
    model.E, model.nu = 1.0, 0.0
    solver = tamaas.PolonskyKeerRey(model, height, 1e-9, tamaas.PolonskyKeerRey.gap,
                                    tamaas.PolonskyKeerRey.gap)
    attraction = tamaas.ExponentialAdhesionFunctional(height)
    attraction.parameters = {"rho": rho, "surface_energy": work}
    solver.addFunctionalTerm(attraction)
    solver.max_iter = 5000
    solver.solve(mean_gap)
    gap = np.array(model.displacement).reshape(height.shape) - height
    return np.array(model.traction).mean(), (gap < 1e-9 * height.std()).mean(), gap


@pytest.mark.parametrize("n, share", [
    (64, 0.2), (64, 0.6), pytest.param(128, 0.2, marks=pytest.mark.long),
    pytest.param(128, 0.6, marks=pytest.mark.long)])
def test_rough_maps_against_tamaas(asperity, tmp_path, n, share):
    """A periodic map at a mean gap: five digits of mean traction, area and gaps."""
    height = 0.01 * rough(n, shortest=8, seed=3)
    height -= height.mean()
    rms = height.std()
    rho = 0.1 * rms
    work = share * rho**2 * n
    rows, position, fields, lines = run(asperity, tmp_path, height, 1 / n, 1.5 * rms, "separation",
                                distance=rho / RANGE, work=work, edge="periodic")
    traction, area, gap = tamaas_solution(height, 1.5 * rms, work, rho)
    assert abs(rows[0]["load"] / traction - 1) < 1e-5
    assert position["samples_in_contact"] / n**2 == area
    assert np.abs(fields["gap"] - gap).max() < 1e-5 * rms
    assert abs(rows[0]["mean_gap"] / (1.5 * rms) - 1) < 1e-9
    # No warning but those of the size of the pixels, whose own error is not that of tamaas, and of
    # the slope and the pressures, beyond the theory of both.
    expected = "estimated error", "is its rms slope", "pressures are near"
    assert all(any(words in line for words in expected) for line in lines.splitlines()), lines


@pytest.mark.parametrize("edge, control", [("free", "separation"), ("free", "load"),
                                           ("periodic", "load")])
def test_number_of_states(asperity, tmp_path, edge, control):
    """Loading, then unloading, in one state and in eight: the same state to 1e-8."""
    n = 32
    height = 0.01 * rough(n, shortest=8, seed=5)
    height -= height.mean()
    rms, rho = height.std(), 0.1 * height.std()
    work = 0.6 * rho**2 * n
    far, near, back = (5 * rms, -1.0 * rms, 1.5 * rms) if control == "separation" else \
        (1e-6, 0.01, 0.0005)
    fields = []
    for path in ((near,), tuple(np.linspace(far, near, 8)), (near, back),
                 (near, *np.linspace(near, back, 8)[1:])):
        fields.append(run(asperity, tmp_path, height, 1 / n, path, control,
                          distance=rho / RANGE, work=work, edge=edge)[2])
    for one, other in (fields[:2], fields[2:]):
        assert np.abs(one["gap"] - other["gap"]).max() < 1e-8 * rms
        assert np.abs(one["pressure"] - other["pressure"]).max() < 1e-6 * work / rho


def test_hardness_bounds_the_net_traction(asperity, tmp_path):
    """The limit is that of the net traction; unloading of the deformed shape pulls more."""
    side, distance = 0.14, WORK**(2 / 3)
    height = sphere(side, 48)
    unit = WORK**(2 / 3)
    path = (-3 * unit, *np.linspace(-3 * unit, 2 * unit, 16)[1:])
    pulls = []
    for hardness in (0.0, 0.02):
        more = {"plastic_hardness": hardness} if hardness else {}
        _, position, last, _ = run(asperity, tmp_path, height, side / 48, path[:1], "separation",
                                distance=distance, **more)
        pressure = last["pressure"]
        if hardness:
            assert np.nanmax(pressure) == hardness and position["plastic_area"] > 0
        else:
            assert np.nanmax(pressure) > 0.022
        rows, *_ = run(asperity, tmp_path, height, side / 48, path, "separation",
                         distance=distance, **more)
        pulls.append(-min(row["load"] for row in rows))
    assert pulls[1] > 1.05 * pulls[0]


def test_plastic_area_of_equal_loads(asperity, tmp_path):
    """The area at the hardness is the same at every equal largest load, and so are the pixels that
    do not carry more of the next load."""
    height, side = rough(24, 24, shortest=4, seed=5), 1 / 24
    load = float(0.05 * np.ptp(height))
    rows, *_ = run(asperity, tmp_path, height, side, (load, load, load / 3, load, load),
                   edge="periodic", distance=0.1 * np.ptp(height), work=1e-3 * np.ptp(height)**2,
                   plasticity="on", plastic_hardness=4 * load)
    areas = [row["plastic_area"] for row in rows]
    assert areas[0] > 0.01 and areas == [areas[0], areas[0], 0, areas[0], areas[0]]


@pytest.mark.parametrize("seed, law, distance, work, gaps", [
    (52, "exponential", 30.0, 853.808, (0.22,)),
    (107, "van_der_waals", 30.0, 150.0, (0.78, 1.24, 0.3))])
def test_steep_attraction(asperity, tmp_path, seed, law, distance, work, gaps):
    """Where the attraction is nearly as steep as the solid is stiff, gaps change by a small part in
    each step: a held gap needs contact problems that are solved to less than these changes."""
    height = np.random.default_rng(seed).normal(size=(8, 10) if seed % 2 else (12, 14)).round(3)
    height = sum(np.roll(height, shift, (0, 1)) for shift in np.ndindex(2, 2)) / 4
    rows, *_ = run(asperity, tmp_path, height.T.round(3), 1.0, gaps, "mean_gap", law, distance,
                   work, "periodic", creep="on", relaxation_time=1.0, relaxed_modulus_ratio=0.5,
                   loading_time=1.0, hold_time=2.0, hold_points=3, hold="separation")
    assert rows[-1]["time"] == 3.0 and rows[-1]["mean_gap"] == pytest.approx(gaps[-1], rel=1e-6)


def test_wide_pixels(asperity, tmp_path):
    """Pixels wider than the range are warned of, with the spacing that resolves it, or refused;
    states of a periodic map at held separations are warned of; a law has a name."""
    height = 0.01 * rough(32, shortest=8, seed=5)
    height -= height.mean()
    rho = 0.1 * height.std()
    for share, status in ((0.69, 0), (0.75, 0), (1.19, 0), (1.21, 1)):
        work = share * rho**2 * 32
        found = run(asperity, tmp_path, height, 1 / 32, 0.01, distance=rho / RANGE, work=work,
                    edge="periodic", status=status)
        if status:
            expected = float(re.search(r"spacing of \S+, expected at most (\S+), or a larger "
                                       "equilibrium_distance", found)[1])
            assert abs(expected * share * 32 / 0.7 - 1) < 1e-5
        else:
            assert ("the pixels are wide for the range of adhesion" in found[3]) == (share > 0.7)
    work = 0.5 * rho**2 * 32
    for values, control, warned in (((0.02, 0.03), "separation", True),
                                    ((0.01, 0.0), "load", False)):
        lines = run(asperity, tmp_path, height, 1 / 32, values, control, distance=rho / RANGE,
                    work=work, edge="periodic")[3]
        assert ("holds the mean gap at each separation" in lines) == warned
    said = run(asperity, tmp_path, height, 1 / 32, 0.01, law="dugdale", status=2)
    assert "'exponential' or 'van_der_waals'" in said


@pytest.mark.parametrize("law, wide", [("exponential", 6.0), ("van_der_waals", 15.0)])
def test_range_beyond_the_edge(asperity, tmp_path, law, wide):
    """A hard ball in touch, whose full pull is 2 pi w R (Bradley 1932): the warning has at least
    the share that the map cuts off, at most twice it. None on a wide map, on one of many hills."""
    distance, n = 1e-3, 40
    for gap in (0.5, 2.0, wide):
        spacing = 2 * (2 * gap * distance)**0.5 / (n - 1)
        x = (np.arange(n) - (n - 1) / 2) * spacing
        height = -(x[:, None]**2 + x[None, :]**2) / 2
        rows, *_, lines = run(asperity, tmp_path, height, spacing, 0.0, "separation", law, distance,
                             work=1e-9)
        lost = 1 + rows[0]["load"] / (2 * np.pi * 1e-9)
        said = re.search(r"range of adhesion, (\S+) % of the work of adhesion is left", lines)
        assert (said is None) == (gap == wide), lines
        if said:
            assert lost < float(said[1]) / 100 < 2 * lost, (gap, lost)
    hills = 0.2 * distance * rough(n, shortest=8, seed=5)
    *_, lines = run(asperity, tmp_path, hills, spacing, float(hills.max()), "separation", law,
                      distance, work=1e-9)
    assert "range of adhesion" not in lines


def test_no_level_below_the_mean_on_a_path(asperity, tmp_path):
    """The second separation of a path was not looked at: a load of 1e31."""
    x = np.arange(16) / 16
    height = np.cos(2 * np.pi * x)[:, None] * np.ones(4)
    for second in (-0.1, -1e-3):
        said = run(asperity, tmp_path, height, 1 / 16, (1.5, second), "separation", work=0.02,
                   distance=0.128, edge="periodic", status=1)
        assert "the flat is not above the mean height" in said
