"""Edges of height maps: a periodic map has none in any step; flat maps, punches and full contact.

Laws of changed maps are in test/support/map_laws.py, values against numpy in test_map_scene.py and
test_fields.py, those of Westergaard here.
"""

import numpy as np
import pytest

from map_press_truth import press, rough
from map_scenes import map_scene, solve_map
from programs import run_program
from surfaces_csv import records

MODULUS = 3.0


class Map:
    """Heights indexed [y, x], spacings along x and y, whether it is periodic."""

    def __init__(self, height, spacing, periodic):
        self.height, self.spacing, self.periodic = height, spacing, periodic

    def write(self, path):
        np.savetxt(path, self.height, fmt="%.17g")

    def area(self):
        return np.count_nonzero(~np.isnan(self.height)) * self.spacing[0] * self.spacing[1]


def random_map(seed):
    random = np.random.default_rng(seed)
    rows, columns = (int(n) for n in random.integers(6, 34, 2))
    if seed % 4 == 0:
        rows = columns
    kind = seed % 3
    height = random.standard_normal((rows, columns))
    if kind > 0:
        q = np.hypot(np.fft.fftfreq(rows)[:, None], np.fft.fftfreq(columns)[None, :])
        q[0, 0] = 1.0
        height = np.fft.ifft2(q ** (-0.9 * kind) * np.fft.fft2(height)).real
    height = (height - height.mean()) / height.std()
    if seed % 5 == 1:
        height += 1e6
    if seed % 6 == 2:
        height[random.random(height.shape) < 0.05] = np.nan
        height[0, 0] = 0.0
    spacing = (0.5, float(random.choice([0.5, 0.4, 1.1])))
    return Map(height, spacing, periodic=seed % 2 == 0), random


def command(asperity, folder, *words):
    return run_program(asperity, *words, status=None, cwd=folder)


def column(rows, name):
    return np.array([float(row[name] or "nan") for row in rows])


def solve(asperity, folder, of, pressure, interaction="boundary", name="m"):
    """Last state and contacts, sorted by load, of a map pressed by a nominal pressure."""
    scene = map_scene(folder, of.height.T, of.spacing, name, interaction=interaction,
                      surfaces={"map_edge": "periodic" if of.periodic else "free"},
                      loading={"control": "pressure", "value": float(pressure)})
    run = command(asperity, folder, "solve", scene, "--quiet", "--threads", "1",
                  "--positions", "p.csv", "--contacts", "c.csv")
    assert run.returncode == 0, run.stderr
    contacts = records(folder / "c.csv")
    order = np.argsort(column(contacts, "load"))
    return records(folder / "p.csv")[0], [contacts[i] for i in order], run.stderr


def summits(asperity, folder, of, rule, *options, name="m"):
    """The statistics that are printed, and the summits sorted by height."""
    of.write(folder / f"{name}.txt")
    run = command(asperity, folder, "summits", f"{name}.txt", "--rule", rule, "--spacing",
                  f"{of.spacing[0]!r},{of.spacing[1]!r}", "--edge",
                  "periodic" if of.periodic else "free", "--output", "s.csv", *options)
    assert run.returncode == 0, run.stderr
    rows = records(folder / "s.csv")
    return run.stdout, np.array(sorted((float(row["height"]), float(row["radius"]))
                                       for row in rows)).reshape(-1, 2)


def printed(text, name):
    for line in text.splitlines():
        if line.startswith(name):
            value = line[len(name):].split()[0]
            return np.nan if value == "-" else float(value)
    raise AssertionError(f"no {name} in:\n{text}")


def test_spikes_on_the_seam(asperity, tmp_path):
    """The pixels around a spike at the end of a periodic map are those of both ends: rolled to the
    middle, as many spikes are taken out and the same heights are left. (Not the same summits: a
    spike becomes as high as a neighbour, and of equal ridges the first one is filled.)"""
    for seed in range(20):
        random = np.random.default_rng(seed)
        q = np.hypot(np.fft.fftfreq(24)[:, None], np.fft.fftfreq(30)[None, :])
        height = np.fft.ifft2(np.exp(-(q / 0.12) ** 2)
                              * np.fft.fft2(random.standard_normal((24, 30)))).real
        height /= height.std()
        for place in ((0, 7), (11, 0), (23, 29), (12, 15)):
            height[place] += 6.0
        one = summits(asperity, tmp_path, Map(height, (1.0, 1.0), True), "contact", "--despike")
        two = summits(asperity, tmp_path, Map(np.roll(height, (9, 13), (0, 1)), (1.0, 1.0), True),
                      "contact", "--despike")
        assert printed(one[0], "spikes removed") == printed(two[0], "spikes removed") > 0
        for name in ("rms height", "rms slope", "Nayak's alpha"):
            assert printed(one[0], name) == pytest.approx(printed(two[0], name), rel=1e-10)


@pytest.mark.parametrize("periodic", [False, True])
def test_a_flat_map_is_in_full_contact_without_summits(asperity, tmp_path, periodic):
    """What levelling leaves of a plane is rounding: no summits, and full contact at any load."""
    y, x = np.mgrid[:12, :16]
    planes = [np.full(x.shape, 7.3e5), 0 * x + 0.1]
    if not periodic:
        planes += [0.1 * x + 0.3 * y, 1e6 + 1e-3 * x / 3, 123.4 * x - 77.7 * y + 1e5]
    for height in planes:
        of = Map(height.astype(float), (1.0, 0.7), periodic)
        for pressure in (1e-9, 1e-3, 1.0):
            state, contacts, shown = solve(asperity, tmp_path, of, pressure)
            assert float(state["area_fraction"]) == pytest.approx(1.0, rel=1e-12)
            assert len(contacts) == 1
            assert "the map is flat" in shown
        for rule in ("eight", "contact"):
            text, found = summits(asperity, tmp_path, of, rule)
            assert len(found) == 0
            assert "map is flat" in text
    heights = np.random.default_rng(1).standard_normal((12, 16)) * 1e-9 + 1.0
    rough = Map(heights, (1.0, 1.0), periodic)
    state, contacts, shown = solve(asperity, tmp_path, rough, 1e-12)
    assert float(state["area_fraction"]) < 0.9 and "the map is flat" not in shown


@pytest.mark.truth
@pytest.mark.long
def test_from_first_touch_to_far_beyond_full_contact(asperity, tmp_path):
    """100 maps from 4 x 4 to 150 x 100 pixels at 20 pressures from 1e-6 to 10 times full contact:
    all are solved, area and load grow, and full contact has the area of the map exactly."""
    random = np.random.default_rng(7)
    for number in range(100):
        columns, rows = 4 + int(146 * random.random() ** 3), 4 + int(96 * random.random() ** 3)
        height = random.standard_normal((rows, columns))
        if number % 3:
            q = np.hypot(np.fft.fftfreq(rows)[:, None], np.fft.fftfreq(columns)[None, :])
            q[0, 0] = 1.0
            height = np.fft.ifft2(q ** -1.8 * np.fft.fft2(height)).real
            height /= height.std()
        if number % 10 == 3:
            height = np.round(height * 2)
        of = Map(height, (1.0, float(random.choice([1.0, 0.5, 3.0]))), number % 2 == 0)
        # Full contact: pressures of -E q h/2 are above 0, of a mean of some rms slopes.
        full = MODULUS * 4 * sum(np.diff(height, axis=a).std() / of.spacing[1 - a] for a in (0, 1))
        scene = map_scene(tmp_path, height.T, of.spacing, loading={
            "control": "pressure", "value": tuple((np.geomspace(1e-6, 10, 20) * full).tolist())},
            surfaces={"map_edge": "periodic" if of.periodic else "free"})
        states = solve_map(asperity, scene)[0]
        area = column(states, "area") / of.area()
        assert len(states) == 20
        assert area.max() < 1 + 1e-12 and np.all(np.diff(column(states, "sample_area")
                                                         if "sample_area" in states[0] else area)
                                                 > -1e-12)
        if of.periodic:
            assert area[-1] == pytest.approx(1.0, abs=1e-12), number


def test_area_of_a_punch_and_of_full_contact(asperity, tmp_path):
    """The rim of a patch is corrected between a pressed and an open pixel only: a punch whose
    surroundings are missing, and a map in full contact, have the area of their pixels."""
    punch = np.full((20, 30), np.nan)
    punch[:6, :17] = 1.0
    state, contacts, _ = solve(asperity, tmp_path, Map(punch, (1.0, 0.5), False), 1e-6)
    assert float(state["area"]) == pytest.approx(6 * 17 * 0.5, rel=1e-12)
    random = np.random.default_rng(3)
    for periodic in (False, True):
        height = random.standard_normal((24, 40))
        height[random.random(height.shape) < 0.1] = np.nan
        height[0, 0] = 0.0
        of = Map(height, (0.3, 0.2), periodic)
        state, _, _ = solve(asperity, tmp_path, of, 1e4 * MODULUS)
        assert float(state["area_fraction"]) == pytest.approx(1.0, rel=1e-12)


def test_centres_on_a_periodic_map(asperity, tmp_path):
    """Centres lie in the map; a patch that spans it in a direction has none there."""
    y, x = np.mgrid[:64, :48]
    wave = 2 * np.pi / np.array([48, 64])
    hill = np.cos(wave[0] * (x - 10.5)) + np.cos(wave[1] * (y + 0.5))
    _, contacts, _ = solve(asperity, tmp_path, Map(hill, (2.0, 1.0), True), 1e-3)
    assert [(float(c["x"]), float(c["y"])) for c in contacts] == [(pytest.approx(21.0),
                                                                  pytest.approx(63.5))]
    corner = np.cos(wave[0] * x) + np.cos(wave[1] * y)
    _, contacts, _ = solve(asperity, tmp_path, Map(corner, (2.0, 1.0), True), 1e-3)
    assert [(float(c["x"]), float(c["y"])) for c in contacts] == [(pytest.approx(0.0, abs=1e-5),
                                                                  pytest.approx(0.0, abs=1e-5))]
    ridge = np.cos(wave[0] * (x - 5.0)) + 1e-9 * hill
    _, contacts, _ = solve(asperity, tmp_path, Map(ridge, (2.0, 1.0), True), 1e-3)
    assert [(float(c["x"]), c["y"]) for c in contacts] == [(pytest.approx(10.0, abs=1e-6), "")]
    diagonal = np.cos(2 * np.pi * (x / 48 + y / 64))
    _, contacts, _ = solve(asperity, tmp_path, Map(diagonal, (2.0, 1.0), True), 1e-3)
    assert [(c["x"], c["y"]) for c in contacts] == [("", "")]


def westergaard(share):
    """Area fraction and greatest pressure over p* = pi E A/L, at a share of p*."""
    if share >= 1:
        return 1.0, 1 + share
    return 2 / np.pi * np.arcsin(np.sqrt(share)), 2 * np.sqrt(share)


@pytest.mark.truth
@pytest.mark.long
def test_a_cosine_of_any_phase(asperity, tmp_path):
    """Westergaard (1939), over eight phases: the greatest pressure within 1 % at 256 pixels, the
    width of the contact within half a pixel on each side (and 5 % of that), both better with each
    doubling in the root mean square, which is within 1 % at 256 pixels."""
    for share in (0.1, 0.5, 0.9, 1.1):
        before = None
        for n in (64, 128, 256, 512, 1024):
            errors = []
            for phase in np.linspace(0, 1, 8, endpoint=False):
                height = np.tile(1e-3 * np.cos(2 * np.pi * (np.arange(n) + phase) / n), (4, 1))
                full = np.pi * MODULUS * 1e-3 / n
                state, contacts, _ = solve(asperity, tmp_path, Map(height, (1.0, 1.0), True),
                                           share * full)
                area, greatest = westergaard(share)
                errors.append((float(state["area_fraction"]) / area - 1,
                               column(contacts, "maximum_pressure").max() / (greatest * full) - 1))
            errors = np.abs(errors)
            assert np.all(errors[:, 0] < 1.05 / (n * area)), (share, n, errors)
            mean = np.sqrt((errors ** 2).mean(axis=0))
            if n == 256:
                assert mean.max() < 0.01 and errors[:, 1].max() < 0.01, (share, errors)
            if before is not None:
                assert np.all((mean < before) | (mean < 1e-6)), (share, n, mean, before)
            before = mean


def test_a_plane_is_refused_for_a_periodic_map(asperity, tmp_path):
    """Without its plane a periodic map would not be periodic: refused, in both commands."""
    np.savetxt(tmp_path / "m.txt", np.eye(5))
    (tmp_path / "m.scene").write_text(
        "&surfaces upper = 'plane', lower = 'm.txt', map_spacing = 1, 1, map_edge = 'periodic',\n"
        "  map_level = 'plane' /\n&material contact_modulus = 1 /\n"
        "&loading control = 'load', value = 1 /\n&effects interaction = 'boundary' /\n")
    run = command(asperity, tmp_path, "solve", "m.scene")
    assert run.returncode == 2 and run.stderr.startswith("m.scene:2:3: map_level: "), run.stderr
    run = command(asperity, tmp_path, "summits", "m.txt", "--spacing", "1,1", "--edge", "periodic",
                  "--level", "plane")
    assert run.returncode == 2 and "level" in run.stderr


def test_levels_of_a_scene(asperity, tmp_path):
    """The separation counts from the level that is asked for."""
    height = np.random.default_rng(5).standard_normal((16, 24)) + 3.0
    height += 0.05 * np.arange(24)
    found = {}
    for how in ("plane", "mean", "none"):
        scene = map_scene(tmp_path, height.T, (1.0, 1.0), material=1.0,
                          surfaces={"map_level": how}, loading={"control": "load", "value": 20.0})
        found[how] = solve_map(asperity, scene)[1]["separation"]
    level, _ = press((height - height.mean()).T, (1.0, 1.0), 1.0, 20.0)
    assert found["mean"] == pytest.approx(level, abs=1e-8)
    assert found["none"] == pytest.approx(level + height.mean(), abs=1e-8)
    assert abs(found["plane"] - level) > 0.01


def test_auto_is_boundary(asperity, tmp_path):
    """`auto` solves the pixels, as `boundary` does; neither has a limit."""
    of = Map(rough(48, 40, shortest=6, seed=11), (0.5, 0.5), True)
    for pressure in (1e-3, 0.05, 0.5):
        auto, _, _ = solve(asperity, tmp_path, of, pressure, "auto")
        boundary, _, _ = solve(asperity, tmp_path, of, pressure)
        for name in ("separation", "area", "load", "contacts"):
            assert auto[name] == boundary[name]
    text = (tmp_path / "m.scene").read_text().replace("'pressure', value = 0.5", "'limit'")
    for mode in ("'boundary'", "'auto'"):
        (tmp_path / "m.scene").write_text(text.replace("'boundary'", mode) +
                                          "&limit criterion = 'load', value = 1 /\n")
        run = command(asperity, tmp_path, "solve", "m.scene")
        assert run.returncode == 2 and "patches of pixels merge under load" in run.stderr
