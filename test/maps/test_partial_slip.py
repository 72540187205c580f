"""Partial slip under a tangential load (`tangential_load`, `tangential_displacement`): the closed
forms of Cattaneo and Mindlin on the pixels of a sphere, the tangential problem of rough maps solved
by another method in numpy, refused scenes."""

import numpy as np
import pytest

from elements_truth import product
from image_data import read_vti
from map_press_truth import rough
from programs import run_program
from map_scenes import map_scene
from surfaces_csv import records, solve

MODULUS, RATIO, MU = 2.0e5, 0.3, 0.25
COMBINED = MODULUS / (1 - RATIO**2) / 2
KAPPA = 2 * (1 - RATIO) / (2 - RATIO)  # tangential over normal stiffness (Mindlin 1949)
COLUMNS = ("tangential_load", "tangential_displacement", "tangential_stiffness", "stick_area",
           "slides")


def map_slip(asperity, folder, height, sides, loading, effects=None, ratio=RATIO, **surfaces):
    """Numbers of the position, of the contacts of the last state, and the fields."""
    scene = map_scene(folder, height, sides, name="slip",
                      surfaces={"map_level": "none", **surfaces}, loading=loading,
                      material={"elastic_modulus": (MODULUS, MODULUS),
                                "poisson_ratio": (ratio, ratio)},
                      effects={"friction_coefficient": MU, **(effects or {})})
    run_program(asperity, "solve", scene, "--quiet", "--fields", folder / "f.vti", "--positions",
                folder / "p.csv", "--contacts", folder / "c.csv")
    row, = records(folder / "p.csv")
    steps = row["steps"]
    return ({name: float(row[name] or "nan") for name in (*COLUMNS, "load", "separation")},
            [{name: float(cell or "nan") for name, cell in contact.items()}
             for contact in records(folder / "c.csv") if contact["step"] == steps],
            with_size(read_vti(folder / "f.vti")[2]))


def with_size(fields):
    """Fields with the size of the traction as `traction`."""
    return {**fields, "traction": np.hypot(fields["traction_x"], fields["traction_y"])}


def sphere(pixels, side, radius=1.0):
    """Heights, and places along one side."""
    place = (np.arange(pixels) - (pixels - 1) / 2) * side
    return -(place[:, None] ** 2 + place[None, :] ** 2) / (2 * radius), place


def cattaneo(place, side, contact, stick):
    """Traction of a sphere of radius 1, the mean over each pixel of points within it."""
    parts = 8
    offset = ((np.arange(parts) + 0.5) / parts - 0.5) * side
    fine = (place[:, None] + offset).ravel()
    square = fine[:, None] ** 2 + fine[None, :] ** 2
    traction = 2 * COMBINED * MU / np.pi * (np.sqrt(np.maximum(0, contact**2 - square)) -
                                            np.sqrt(np.maximum(0, stick**2 - square)))
    return traction.reshape(len(place), parts, len(place), parts).mean(axis=(1, 3))


@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.8])
def test_sphere_of_cattaneo_and_mindlin(asperity, tmp_path, ratio):
    contact, pixels = 0.1, 128
    side = 2.1 * contact / pixels
    height, place = sphere(pixels, side)
    load = 4 / 3 * COMBINED * contact**3
    found, (patch,), fields = map_slip(asperity, tmp_path, height, (side, side), {
        "control": "load", "value": load, "tangential_load": ratio * MU * load})
    stick = contact * (1 - ratio) ** (1 / 3)
    truth = cattaneo(place, side, contact, stick)
    errors = {
        "load": found["tangential_load"] / (ratio * MU * load) - 1,
        "displacement": found["tangential_displacement"] / (
            MU / KAPPA * (contact**2 - stick**2)) - 1,
        "stiffness": found["tangential_stiffness"] / (KAPPA * 2 * COMBINED * stick) - 1,
        "stick area": found["stick_area"] / (np.pi * stick**2) - 1,
        # Over the traction of sliding at the centre: mu times the greatest pressure.
        "traction": np.sqrt(np.mean((fields["traction"] - truth) ** 2)) / (
            MU * 2 * COMBINED * contact / np.pi)}
    print(errors)
    for name, error in errors.items():
        assert abs(error) < 5e-3, errors
    assert abs(errors["load"]) < 1e-12
    assert found["slides"] == 0
    assert patch["shear_load"] == pytest.approx(found["tangential_load"], rel=1e-12)
    assert patch["stick_area"] == pytest.approx(found["stick_area"], rel=1e-12)
    assert np.array_equal(fields["stick"] > 0, (fields["pressure"] > 0) & (
        fields["traction"] < MU * fields["pressure"] * (1 - 1e-12)))


def test_cattaneo_case_of_contact(asperity, tmp_path):
    """The second case of examples/cattaneo.ref_out of CONTACT (E. A. H. Vollebregt), revision 2707:
    a ball of polyethylene, 19 x 19 elements, nu 0.42. CONTACT has both tractions and the compliance
    of each direction: shift and tractions differ by what the principle neglects."""
    poisson, shear, side, load, friction = 0.42, 200.0, 2 * 1.26667 / 19, 9.1954, 0.4
    place = (np.arange(19) - 9) * side
    scene = map_scene(
        tmp_path, -0.01 * (place[:, None] ** 2 + place[None, :] ** 2), (side, side),
        surfaces={"map_level": "none"},
        material={"elastic_modulus": (2 * shear * (1 + poisson),) * 2,
                  "poisson_ratio": (poisson, poisson)},
        loading={"control": "load", "value": load, "tangential_load": 0.875 * friction * load},
        effects={"friction_coefficient": friction})
    run_program(asperity, "solve", scene, "--quiet", "--fields", tmp_path / "f.vti", "--positions",
                tmp_path / "p.csv")
    row, = records(tmp_path / "p.csv")
    fields = with_size(read_vti(tmp_path / "f.vti")[2])
    assert f"{float(row['tangential_load']):.3f}" == "3.218"
    assert f"{fields['pressure'].max():.3f}" == "4.393"
    assert f"{-float(row['separation']):.3e}" == "1.998e-02"
    assert (fields["pressure"] > 0).sum() == 177
    stick = fields["stick"] > 0
    assert stick.sum() == 45
    # Rows 7 and 13 of the potential contact have 5 elements that stick, those between them 7.
    assert stick.sum(axis=0).tolist() == [0] * 6 + [5, 7, 7, 7, 7, 7, 5] + [0] * 6
    assert f"{float(row['tangential_displacement']):.3e}" == "8.155e-03"
    # Its stiffness is a secant of its search for the load: 67.6 times mu N.
    assert float(row["tangential_stiffness"]) == pytest.approx(67.6 * friction * load, rel=3e-3)
    # Column 10, rows 3 to 6: elements that slip.
    printed = [0.575, 1.06, 1.31, 1.49]
    assert fields["traction"][9, 2:6] == pytest.approx(printed, abs=6e-3)


def test_small_loads_and_sliding(asperity, tmp_path):
    """Below the ratio at which tractions are differences of two solutions they are proportional to
    the load; at mu times the normal load all slides."""
    contact, pixels = 0.1, 64
    side = 2.1 * contact / pixels
    height, _ = sphere(pixels, side)
    load = 4 / 3 * COMBINED * contact**3
    for ratio in (1e-9, 1e-3):
        found, _, fields = map_slip(asperity, tmp_path, height, (side, side), {
            "control": "load", "value": load, "tangential_load": ratio * MU * load})
        compliance = found["tangential_displacement"] / found["tangential_load"]
        assert compliance * KAPPA * 2 * COMBINED * contact == pytest.approx(1, rel=3e-3)
        assert found["tangential_load"] == pytest.approx(ratio * MU * load, rel=1e-9)
    none, (patch,), fields = map_slip(asperity, tmp_path, height, (side, side),
                                      {"control": "load", "value": load})
    assert none["tangential_load"] == 0 == none["tangential_displacement"] == none["slides"]
    assert none["tangential_stiffness"] == pytest.approx(KAPPA * 2 * COMBINED * contact, rel=5e-3)
    assert not fields["traction"].any() and patch["stick_area"] == patch["area"]
    for ratio in (1.0, 1.5):
        found, (patch,), fields = map_slip(asperity, tmp_path, height, (side, side), {
            "control": "load", "value": load, "tangential_load": ratio * MU * load})
        assert found["slides"] == 1 and found["stick_area"] == 0 == found["tangential_stiffness"]
        assert found["tangential_load"] == pytest.approx(MU * load, rel=1e-12)
        assert np.isnan(found["tangential_displacement"])
        assert np.allclose(fields["traction"], MU * fields["pressure"], rtol=1e-14, atol=0)
        assert not fields["stick"].any() and patch["shear_load"] == pytest.approx(MU * load)


def active_sets(act, bound, displacement):
    """Tractions of 0 <= q <= bound with the displacement A q given where they are less, at most
    that where not: primal and dual active sets with the matrix of the pixels in contact."""
    inside = np.flatnonzero(bound.ravel() > 0)
    matrix = np.empty((len(inside), len(inside)))
    for column, pixel in enumerate(inside):
        unit = np.zeros(bound.size)
        unit[pixel] = 1
        matrix[:, column] = act(unit.reshape(bound.shape)).ravel()[inside]
    top = bound.ravel()[inside]
    slips = np.zeros(len(inside), bool)
    for _ in range(200):
        q = top.copy()
        stick = ~slips
        q[stick] = np.linalg.solve(matrix[np.ix_(stick, stick)],
                                   displacement - matrix[np.ix_(stick, slips)] @ top[slips])
        lag = displacement - matrix @ q
        new = np.where(slips, lag > 0, q > top)
        if np.array_equal(new, slips):
            break
        slips = new
    else:
        raise RuntimeError("the active sets do not settle")
    assert q.min() > 0
    traction = np.zeros(bound.size)
    traction[inside] = q
    sticks = np.zeros(bound.size, bool)
    sticks[inside] = ~slips
    return traction.reshape(bound.shape), sticks.reshape(bound.shape)


@pytest.mark.parametrize("edge", ["free", "periodic"])
@pytest.mark.parametrize("hardness", [None, 0.03])
@pytest.mark.parametrize("ratio", [0.3, 0.8])
def test_rough_map_against_active_sets(asperity, tmp_path, edge, hardness, ratio):
    """With nu = 0 the principle is the solution of the tangential problem on the same pixels."""
    sides = (0.01, 0.013)
    modulus = MODULUS / 2  # nu = 0
    height = 1e-3 * rough(40, 32, shortest=6, seed=3)
    height -= height.mean()
    slope = np.gradient(height, *sides)
    rms = np.sqrt(np.mean(slope[0]**2 + slope[1]**2))
    load = float(0.06 * modulus * rms * height.size * np.prod(sides))
    effects = {}
    if hardness:
        effects = {"plasticity": "on", "plastic_hardness": hardness * modulus}
    given = {"control": "load", "value": load, "tangential_load": ratio * MU * load}
    found, patches, fields = map_slip(asperity, tmp_path, height, sides, given, effects, ratio=0.0,
                                      map_edge=edge)
    pressure = fields["pressure"]
    if hardness:
        assert 0 < (pressure > 0.999 * hardness * modulus).sum() < (pressure > 0).sum()
    act = product(height.shape, sides, modulus, edge == "periodic")
    # kappa is 1 for nu = 0.
    traction, sticks = active_sets(act, MU * pressure, found["tangential_displacement"])
    assert traction.sum() * np.prod(sides) == pytest.approx(ratio * MU * load, rel=1e-8)
    assert np.abs(traction - fields["traction_x"]).max() < 1e-6 * traction.max()
    assert np.abs(fields["traction_y"]).max() < 1e-6 * traction.max()
    assert np.array_equal(sticks, fields["stick"] > 0) and 0 < sticks.sum() < (pressure > 0).sum()
    moved = act(fields["traction_x"])
    assert np.ptp(moved[sticks]) < 1e-6 * moved.max()
    slip = (found["tangential_displacement"] - moved)[(pressure > 0) & ~sticks]
    assert fields["slip_x"][(pressure > 0) & ~sticks] == pytest.approx(slip, abs=1e-6 * slip.max())

    assert sum(patch["shear_load"] for patch in patches) == pytest.approx(ratio * MU * load)
    assert sum(patch["stick_area"] for patch in patches) == pytest.approx(found["stick_area"])
    # The displacement that was found, given; a little more of it is the stiffness.
    del given["tangential_load"]
    found_loads = []
    for more in (1.0, 1.0 + 1e-4):
        other, _, _ = map_slip(asperity, tmp_path, height, sides, {
            **given, "tangential_displacement": float(more * found["tangential_displacement"])},
            effects, ratio=0.0, map_edge=edge)
        found_loads.append(other["tangential_load"])
    assert found_loads[0] == pytest.approx(ratio * MU * load, rel=1e-6)
    stiffness = (found_loads[1] - found_loads[0]) / (1e-4 * found["tangential_displacement"])
    assert found["tangential_stiffness"] == pytest.approx(stiffness, rel=2e-3)


def test_missing_pixels_and_a_path(asperity, tmp_path):
    """Missing pixels have no traction; a path back to a load has the same slip as the load."""
    sides = (0.01, 0.01)
    height = 1e-3 * rough(24, 24, shortest=6, seed=9)
    height[3:6, 7:9] = np.nan
    load = 1.0
    slips = []
    for value in (load, (load, 3 * load, load)):
        found, _, fields = map_slip(asperity, tmp_path, height, sides, {
            "control": "load", "value": value, "tangential_load": 0.1})
        assert np.array_equal(np.isnan(fields["slip_y"]), np.isnan(height))
        assert np.nansum(fields["traction_x"]) * 1e-4 == pytest.approx(0.1)
        slips.append((found["tangential_displacement"], found["stick_area"]))
    assert slips[1] == pytest.approx(slips[0], rel=1e-6)


def test_sliding_by_displacement(asperity, tmp_path):
    contact, pixels = 0.1, 32
    side = 2.1 * contact / pixels
    height, _ = sphere(pixels, side)
    separation = -float(contact**2)
    limit = MU / KAPPA * (contact**2 + float(height.max()))
    for share in (0.9, 1.1):
        found, _, fields = map_slip(asperity, tmp_path, height, (side, side), {
            "control": "separation", "value": separation,
            "tangential_displacement": float(share * limit)})
        assert found["slides"] == (share > 1)
        assert found["tangential_displacement"] == pytest.approx(share * limit, rel=1e-12)
        full = MU * found["load"]
        truth = full if share > 1 else full * (1 - 0.1**1.5)
        assert found["tangential_load"] == pytest.approx(truth, rel=2e-3)


@pytest.mark.parametrize("loading, effects, material, text", [
    ({"tangential_load": 1.0}, {}, {}, "it needs friction: found friction = 'off'"),
    ({"tangential_load": 1.0}, {"friction_coefficient": 0.1}, {"contact_modulus": 10.0},
     "it needs friction: found friction = 'off', expected friction_coefficient in &effects and "
     "both elastic_modulus and poisson_ratio in &material"),
    ({"tangential_load": 1.0}, {"friction": "on", "friction_coefficient": 0.1, "creep": "auto",
                                "hold_time": 1.0, "relaxation_time": 1.0,
                                "relaxed_modulus_ratio": 0.5}, {}, "creep"),
    ({"tangential_path": (1.0, 0.0, 2.0)}, {"friction_coefficient": 0.1}, {},
     "found 3 values, expected x and y of each point"),
    ({"tangential_path": (1.0, 0.0), "tangential_load": 1.0}, {"friction_coefficient": 0.1}, {},
     "found beside another tangential load"),
    ({"tangential_load": 1.0, "tangential_displacement": 0.1}, {"friction_coefficient": 0.1}, {},
     "found beside tangential_load, expected one of them")])
def test_refused_scenes(asperity, tmp_path, loading, effects, material, text):
    height, _ = sphere(16, 0.1)
    scene = map_scene(
        tmp_path, height, (0.1, 0.1), by_default=True,
        material=material or {"elastic_modulus": (10.0, 10.0), "poisson_ratio": (0.3, 0.3)},
        loading={"control": "load", "value": 1.0, **loading}, effects=effects)
    found = solve(asperity, scene)
    assert found.status == 2 and text in found.stderr, found.stderr


def test_friction_without_tangential_load(asperity, tmp_path):
    """It is not simulated, and the tangential stiffness of the contact stays a column."""
    height, _ = sphere(16, 0.01)
    scene = map_scene(tmp_path, height, (0.01, 0.01), name="still", surfaces={"map_level": "none"},
                      loading={"control": "load", "value": 1.0},
                      material={"elastic_modulus": (MODULUS, MODULUS),
                                "poisson_ratio": (RATIO, RATIO)},
                      effects={"friction": "on", "friction_coefficient": MU})
    row = solve(asperity, scene).positions[0]
    assert row["friction"] == "off" and float(row["tangential_stiffness"]) > 0
    assert float(row["tangential_load"]) == 0


def row_of(asperity, folder, height, sides, loading, ratio=RATIO, effects=None, **surfaces):
    """Numbers of the position of a map between two equal bodies."""
    scene = map_scene(folder, height, sides, name="one", surfaces={"map_level": "none", **surfaces},
                      loading=loading, effects=effects or {"friction_coefficient": MU},
                      material={"elastic_modulus": (MODULUS, MODULUS),
                                "poisson_ratio": (ratio, ratio)})
    run_program(asperity, "solve", scene, "--quiet", "--positions", folder / "one.csv", "--fields",
                folder / "one.vti")
    row, = records(folder / "one.csv")
    return {name: float(cell or "nan") for name, cell in row.items() if name != "unit" and
            cell.replace(".", "").replace("-", "").replace("+", "").replace("E", "").isdigit()}, \
        read_vti(folder / "one.vti")[2]


@pytest.mark.parametrize("ratio, along, across", [(0.3, 0.78262, 0.86895), (0.5, 0.60676, 0.73969)])
def test_stiffness_of_an_ellipse(asperity, tmp_path, ratio, along, across):
    """Tangential over normal stiffness of an ellipse of 3.6:1 without friction: tractions
    1/sqrt(1 - x**2/a**2 - y**2/b**2), whose displacements are uniform, by quadrature (scipy)."""
    from scipy.integrate import quad
    # Displacement by 1/sqrt along the angle t is the mean of 1/sqrt(cos**2/a**2 + sin**2/b**2).
    inner = lambda t, power: (np.cos(t)**2 / 3.6**2 + np.sin(t)**2)**-0.5 * np.cos(t)**power
    both, part = (quad(inner, 0, np.pi / 2, args=(power,))[0] for power in (0, 2))
    truth = [(1 - ratio) * both / ((1 - ratio) * both + ratio * one) for one in (part, both - part)]
    assert truth == pytest.approx((along, across), abs=1.1e-4)
    x, y = np.arange(-93, 94)[:, None], np.arange(-27, 28)[None, :]
    punch = np.where((x / 90.0)**2 + (y / 25.0)**2 < 1, 0.0, -1.0)
    for height, turned in ((punch, False), (punch.T, True)):
        row, _ = row_of(asperity, tmp_path, height, (0.01, 0.01), {
            "control": "load", "value": 1e-4}, ratio, {"friction": "off"})
        found = [row[f"tangential_stiffness_{axis}"] / row["contact_stiffness"]
                 for axis in ("xx", "yy")]
        assert (found[::-1] if turned else found) == pytest.approx(truth, rel=1e-3)
        assert abs(row["tangential_stiffness_xy"]) < 2e-5 * row["contact_stiffness"]


@pytest.mark.parametrize("ratio", [0.3, 0.5])
def test_stiffness_of_ridges(asperity, tmp_path, ratio):
    """Plane strain across ridges, antiplane shear along them."""
    wave = np.tile(2e-4 * np.cos(2 * np.pi * np.arange(64) / 64), (12, 1))
    for height, axes in ((wave.T, ("xx", "yy")), (wave, ("yy", "xx"))):
        row, _ = row_of(asperity, tmp_path, height, (0.01, 0.01), {
            "control": "pressure", "value": 40.0, "tangential_load": (1e-3, 2e-3)}, ratio,
            map_edge="periodic")
        across, along = (row[f"tangential_stiffness_{axis}"] for axis in axes)
        assert across == pytest.approx(row["contact_stiffness"], rel=1e-6)
        assert along == pytest.approx((1 - ratio) * row["contact_stiffness"], rel=1e-6)
        # The displacement of a small load is that of the matrix.
        shift = [1e-3 / row["tangential_stiffness_xx"], 2e-3 / row["tangential_stiffness_yy"]]
        assert [row["tangential_displacement_x"], row["tangential_displacement_y"]] == \
            pytest.approx(shift, rel=1e-3)


def test_full_contact(asperity, tmp_path):
    """All sticks: the least energy, 0, is that of uniform tractions, which displace nothing."""
    height = 1e-5 * np.random.default_rng(1).normal(size=(8, 12))
    for path, load in (((0.02, 0.0), 0.02), ((0.02, 0.0, 0.0, 0.0), 0.0)):
        found, _, fields = map_slip(asperity, tmp_path, height, (0.1, 0.1), {
            "control": "pressure", "value": 40.0, "tangential_path": path}, map_edge="periodic")
        assert found["slides"] == 0 and abs(found["tangential_displacement"]) < 1e-15
        assert fields["traction_x"] == pytest.approx(load / height.size / 0.01, abs=1e-12)


@pytest.mark.parametrize("shift", [1e-12, 1e-7, 1e-5, 1e-3])
def test_displacement_in_full_contact(asperity, tmp_path, shift):
    """Equal tractions displace nothing: some pixel slips at any displacement. Where a pixel sticks
    the displacement by the waves of the tractions is that of the bodies, else the rest of it is the
    slip, along the traction; no traction is above mu p."""
    height = 1e-4 * np.random.default_rng(1).normal(size=(9, 13))
    found, _, fields = map_slip(asperity, tmp_path, height, (0.1, 0.1), {
        "control": "pressure", "value": 900.0, "tangential_displacement": (shift, 0.3 * shift)},
        map_edge="periodic")
    tractions = np.array([fields["traction_x"], fields["traction_y"]])
    waves = [2 * np.pi * np.fft.fftfreq(n, 0.1) for n in fields["gap"].shape]
    q = np.array(np.meshgrid(*waves, indexing="ij"))
    size = np.hypot(*q)
    size[0, 0] = np.inf
    spectrum = np.fft.fft2(tractions)
    moved = np.fft.ifft2(2 / (1 - RATIO) / COMBINED / size * (
        spectrum - RATIO * q * (q * spectrum).sum(0) / size**2)).real
    slip = np.array([shift, 0.3 * shift])[:, None, None] - moved
    room = MU * fields["pressure"] - fields["traction"]
    sticks = room > 1e-9 * MU * fields["pressure"]
    assert (room > -1e-12 * MU * fields["pressure"]).all()
    assert 0 < (~sticks).sum() and found["slides"] == (not sticks.any())
    assert np.abs(slip[:, sticks]).max(initial=0) < 1e-6 * shift
    assert ((slip * tractions).sum(0) > (1 - 1e-6) * np.hypot(*slip) * fields["traction"])[
        ~sticks & (np.hypot(*slip) > 1e-4 * shift)].all()


def test_strips(asperity, tmp_path):
    """A cylinder that repeats itself along its axis: the displacements by loads along and across it
    are 1/(1 - nu) and 1 of those of plane strain, from the same distance without displacement."""
    profile = np.tile(-np.linspace(-1, 1, 64)**2 * 2e-3, (12, 1)).T
    found = [row_of(asperity, tmp_path, profile, (0.01, 0.01), {
        "control": "load", "value": 5.0, "tangential_load": load}, map_edge=["free", "periodic"])[0]
        for load in ((1e-4, 0.0), (0.0, 1e-4))]
    assert found[1]["tangential_displacement"] == pytest.approx(
        found[0]["tangential_displacement"] / (1 - RATIO), rel=1e-3)


def test_loop_of_mindlin_and_deresiewicz(asperity, tmp_path):
    """A tangential load that is reversed twice at nu = 0: shift at the turns, at T = 0 on the way
    back, and the energy of the loop (Mindlin and Deresiewicz 1953)."""
    contact, pixels, share = 0.1, 96, 0.8
    side = 2.1 * contact / pixels
    height, _ = sphere(pixels, side)
    modulus = MODULUS / 2
    load = 4 / 3 * modulus * contact**3
    most = MU * load
    turn = share * most
    shift = lambda part: 3 * most / (4 * modulus * contact) * (1 - (1 - part)**(2 / 3))
    back = lambda part: 2 * shift((share - part) / 2) - shift(share)   # less the sign
    given = {"control": "load", "value": load}
    up, _ = row_of(asperity, tmp_path, height, (side, side), {
        **given, "tangential_path": (turn, 0)}, 0.0)
    assert up["tangential_displacement_x"] == pytest.approx(shift(share), rel=3e-3)
    half, _ = row_of(asperity, tmp_path, height, (side, side), {
        **given, "tangential_path": (turn, 0, 0, 0)}, 0.0)
    assert half["tangential_displacement_x"] == pytest.approx(-back(0.0), abs=5e-3 * shift(share))
    loop, _ = row_of(asperity, tmp_path, height, (side, side), {
        **given, "tangential_path": (turn, 0, -turn, 0, turn, 0)}, 0.0)
    assert loop["tangential_displacement_x"] == pytest.approx(shift(share), rel=3e-3)
    # The area between both branches, by quadrature.
    part = np.linspace(-share, share, 20001)
    width = -back(part) - -(-back(-part))
    energy = np.trapezoid(width, part) * most
    assert loop["cycle_energy"] == pytest.approx(abs(energy), rel=1e-2)
    assert loop["friction_energy"] > loop["cycle_energy"] and loop["path_error_estimate"] == 0


def test_a_load_that_turns(asperity, tmp_path):
    """Three sides of a polygon: more points on them change the displacement by the estimate."""
    contact, pixels = 0.1, 32
    side = 2.1 * contact / pixels
    height, _ = sphere(pixels, side)
    load = 4 / 3 * COMBINED * contact**3
    found = []
    for parts in (1, 8):
        angle = np.linspace(0, np.pi / 2, 4)
        corners = 0.6 * MU * load * np.column_stack([np.cos(angle), np.sin(angle)])
        steps = np.linspace(0, 3, 3 * parts + 1)
        path = np.column_stack([np.interp(steps, range(4), part) for part in corners.T])
        found.append(row_of(asperity, tmp_path, height, (side, side), {
            "control": "load", "value": load,
            "tangential_path": tuple(map(float, path.ravel()))})[0])
    first, second = (np.array([row["tangential_displacement_x"], row["tangential_displacement_y"]])
                     for row in found)
    change = np.linalg.norm(first - second) / np.linalg.norm(second)
    assert 0 < change < 2 * found[0]["path_error_estimate"] < 0.05
    assert 0 < found[1]["path_error_estimate"] < found[0]["path_error_estimate"]


def test_dense_convex_solver(asperity, tmp_path):
    """An oblique load on 80 pixels or so: tractions of the least energy on discs by SLSQP (scipy),
    with the matrix of Cerruti's integrals over the pixels. SLSQP ends at 2e-6: the conditions of
    Karush, Kuhn and Tucker are solved from there, and found to hold, which is the minimum."""
    from scipy.optimize import minimize, root
    ratio, side, pixels = 0.4, 0.01, 16
    place = (np.arange(pixels) - 7.5) * side
    height = -(place[:, None]**2 / 2 + place[None, :]**2) / 2
    load = 18.0
    angle = (0.8, 0.6)
    row, fields = row_of(asperity, tmp_path, height, (side, side), {
        "control": "load", "value": load,
        "tangential_load": tuple(0.6 * MU * load * part for part in angle)}, ratio)
    inside = np.argwhere(fields["pressure"] > 0)
    number = len(inside)
    assert 60 < number < 110 and 0 < (fields["stick"] > 0).sum() < number
    x, y = (np.subtract.outer(part, part) * side for part in inside.T)

    def integral(corner):
        half = side / 2
        return sum(i * j * corner(x + i * half, y + j * half) for i in (1, -1) for j in (1, -1))

    squares_y = integral(lambda a, b: a * np.arcsinh(b / np.abs(a)))
    squares_x = integral(lambda a, b: b * np.arcsinh(a / np.abs(b)))
    product_xy = integral(lambda a, b: -np.hypot(a, b))
    g = 2 * 2 * (1 + ratio) / MODULUS / (2 * np.pi)  # of both bodies
    matrix = np.block([[g * ((1 - ratio) * squares_y + squares_x), g * ratio * product_xy],
                       [g * ratio * product_xy, g * ((1 - ratio) * squares_x + squares_y)]])
    limit = MU * fields["pressure"][tuple(inside.T)]
    scale = limit.mean()
    total = 0.6 * MU * load / side**2 / scale * np.array(angle)
    bound, matrix = limit / scale, matrix / np.abs(matrix).max()
    ones = np.kron(np.eye(2), np.ones(number))
    start = (ones.T @ (total / bound.sum())) * np.tile(bound, 2)
    best = minimize(lambda q: q @ matrix @ q / 2, start, jac=lambda q: matrix @ q, method="SLSQP",
                    options={"maxiter": 500, "ftol": 1e-15},
                    constraints=[
                        {"type": "eq", "fun": lambda q: ones @ q - total, "jac": lambda q: ones},
                        {"type": "ineq", "fun": lambda q: bound**2 - q[:number]**2 - q[number:]**2,
                         "jac": lambda q: -2 * np.hstack([np.diag(q[:number]),
                                                          np.diag(q[number:])])}])
    found = np.concatenate([fields[f"traction_{axis}"][tuple(inside.T)] for axis in "xy"]) / scale
    slides = np.hypot(*best.x.reshape(2, -1)) > bound * (1 - 1e-5)

    def conditions(unknown):
        q, shift, pull = np.split(unknown, [2 * number, 2 * number + 2])
        slip = np.zeros(number)
        slip[slides] = pull
        return np.concatenate([matrix @ q - shift @ ones + np.tile(slip, 2) * q, ones @ q - total,
                               (q[:number]**2 + q[number:]**2 - bound**2)[slides]])

    force = (ones @ matrix @ best.x) / number
    exact = root(conditions, np.concatenate([best.x, force, np.full(slides.sum(), 0.1)]), tol=1e-13)
    least, pull = exact.x[:2 * number], exact.x[2 * number + 2:]
    assert np.abs(conditions(exact.x)).max() < 1e-11 and pull.min() > 0
    assert (np.hypot(*least.reshape(2, -1)) <= bound * (1 + 1e-10)).all()
    assert found @ matrix @ found == pytest.approx(least @ matrix @ least, rel=1e-11)
    assert np.abs(found - least).max() < 1e-6 * np.abs(found).max()
    assert np.abs(np.hypot(*found.reshape(2, -1)) / bound).max() < 1 + 1e-12
