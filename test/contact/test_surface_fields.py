"""Pressure, gap and displacement of asperities on a grid (`field_spacing`), against Hertz' closed
form, direct sums of Boussinesq's and the contacts of the same run."""

import math
import pickle
import re

import numpy as np
import pytest
from coupled_truth import hertz_displacement
from elements_truth import love
from image_data import read_vti
from programs import run_program
from surfaces_csv import records, write_csv_scene, write_scene, write_surface

E, R, DEPTH, SIDE = 1000.0, 1.0, 0.01, 0.0123


def run(asperity, *words, status=0):
    return run_program(asperity, "solve", *words, status=status)


def plane_scene(folder, rows, side=SIDE, effects=None, surfaces=None, **loading):
    """Spheres under a plane."""
    return write_scene(
        folder / "one.scene", surfaces={
            "upper": "plane", "lower": write_surface(folder / "lower.csv", rows),
            **({"field_spacing": side} if side is not None else {}), **(surfaces or {})},
        material={"contact_modulus": E}, effects=effects or {"interaction": "off"},
        loading=loading or {"control": "compression", "value": DEPTH})


def fields_of(asperity, folder, scene, *words):
    """The fields [x, y] of the last state, coordinates of the centres, contacts and positions."""
    run(asperity, scene, "--quiet", "--fields", folder / "f.vti", "--contacts", folder / "c.csv",
        "--positions", folder / "p.csv", *words)
    origin, spacing, fields = read_vti(folder / "f.vti")
    x, y = (origin[i] + spacing[i] * (np.arange(n) + 0.5)
            for i, n in enumerate(fields["pressure"].shape))
    tables = []
    for name in "cp":
        tables.append([{key: float(cell) for key, cell in row.items()
                        if re.fullmatch(r"[-+.\dEe]+", cell)}
                       for row in records(folder / f"{name}.csv")])
    return np.meshgrid(x, y, indexing="ij"), fields, *tables


def displacement_by(x, y, pressure):
    """Displacement at the centres of cells by uniform pressures, summed directly (Love 1929)."""
    side = x[1, 0] - x[0, 0]
    total = np.zeros(x.shape)
    for i, j in zip(*np.nonzero(pressure > 0)):
        total += pressure[i, j] / (math.pi * E) * love(x - x[i, j], y - y[i, j], side, side)
    return total


def test_one_sphere_against_hertz(asperity, tmp_path):
    """The mean pressure of each cell, displacement and gap; no symmetry of circle and grid."""
    scene = plane_scene(tmp_path, [(0.1237, -0.0311, 1.0, R)])
    (x, y), fields, _, positions = fields_of(asperity, tmp_path, scene)
    a, p0 = math.sqrt(R * DEPTH), 2 / math.pi * E * math.sqrt(DEPTH / R)
    pressure, gap = fields["pressure"], fields["gap"]
    assert pressure.shape == (163, 163)
    assert np.nansum(pressure) * SIDE**2 == pytest.approx(positions[0]["vertical_load"], rel=1e-13)
    # Means by 40 x 40 places of a cell.
    part = (np.arange(40) + 0.5) / 40 - 0.5
    mean = np.zeros(pressure.shape)
    for u in part * SIDE:
        for v in part * SIDE:
            mean += p0 * np.sqrt(np.maximum(0.0, 1 - ((x + u - 0.1237)**2
                                                      + (y + v + 0.0311)**2) / a**2)) / 1600
    there = ~np.isnan(gap)
    assert np.array_equal(np.isnan(pressure), ~there)
    assert np.abs(pressure - mean)[there].max() < 2e-4 * p0
    r = np.hypot(x - 0.1237, y + 0.0311)
    assert np.array_equal(fields["contact"] > 0, (np.hypot(
        np.maximum(0, np.abs(x - 0.1237) - SIDE / 2),
        np.maximum(0, np.abs(y + 0.0311) - SIDE / 2)) < a))
    exact = hertz_displacement(r, a)[0] * positions[0]["vertical_load"] / E
    assert np.abs(fields["displacement"] - exact)[there].max() < 4e-3 * DEPTH
    profile = np.maximum(0.0, 1.0 - r**2 / (R + np.sqrt(np.maximum(0.0, R**2 - r**2))))
    open_ = there & (pressure == 0)
    expected = positions[0]["separation"] - profile + exact
    assert np.abs(gap - expected)[open_].max() < 4e-3 * DEPTH
    assert not gap[there & (pressure > 0)].any()


def test_spacing_is_needed(asperity, tmp_path):
    scene = plane_scene(tmp_path, [(0.0, 0.0, 1.0, R)], side=None)
    for option in ("--fields=f.vti", "--histogram=f.csv"):
        shown = run(asperity, scene, option, status=2).stderr
        assert "expected field_spacing, the side of a pixel, in &surfaces" in shown
    assert "field_spacing: found '0.0', expected" in run(
        asperity, plane_scene(tmp_path, [(0.0, 0.0, 1.0, R)], side=0.0), status=2).stderr
    shown = run(asperity, plane_scene(tmp_path, [(0.0, 0.0, 1.0, R)], side=1e-8), "--fields",
               tmp_path / "f.vti", status=1).stderr
    assert "not enough memory for the fields of 1 state, expected a larger field_spacing" in shown


TWO = [(0.0, 0.0, 1.0, 1.0), (0.15, 0.02, 0.998, 0.9), (0.6, 0.3, 0.995, 0.8)]


def load_near(x, y, pressure, side, place, reach):
    return np.nansum(pressure[np.hypot(x - place[0], y - place[1]) < reach]) * side**2


@pytest.mark.parametrize("interaction, parts", [("off", (0, 3)), ("coupled", (0, 3)),
                                                ("auto", (2, 1)), ("boundary", (3, 0))])
def test_loads_and_displacement(asperity, tmp_path, interaction, parts):
    """Each contact's own load, the displacement by these pressures, and, where neighbours count,
    the gap that they leave."""
    side = 0.02
    scene = plane_scene(tmp_path, TWO, side, {"interaction": interaction, "tolerance": 1e-3})
    (x, y), fields, contacts, positions = fields_of(asperity, tmp_path, scene)
    pressure, there = fields["pressure"], ~np.isnan(fields["gap"])
    assert np.nansum(pressure) * side**2 == pytest.approx(positions[0]["vertical_load"], rel=1e-13)
    # The third contact is away from the other two.
    loads = {contact["lower"]: contact["vertical_load"] for contact in contacts}
    assert load_near(x, y, pressure, side, TWO[2], 0.2) == pytest.approx(loads[3], rel=1e-12)
    assert load_near(x, y, pressure, side, TWO[0], 0.35) == pytest.approx(loads[1] + loads[2],
                                                                          rel=1e-12)
    direct = displacement_by(x, y, np.where(there, pressure, 0.0))
    assert np.abs(fields["displacement"] - direct)[there].max() < 1e-12 * direct.max()
    said = run(asperity, scene, "--fields", tmp_path / "f.vti").stdout
    assert (f" pixels of 0.02; pressures of contacts: {parts[0]} from boundary elements, "
            f"{parts[1]} from Hertz' law\n") in said
    head = (tmp_path / "f.vti").read_bytes().partition(b"<AppendedData")[0].decode()
    assert [int(found) for found in re.findall(r'ascii">(\d+)<', head)] == list(parts)
    if interaction == "off":
        return
    # Under the plane: below 0 by no more than its share of what neighbours change.
    heights = np.full(x.shape, 0.0)
    for a, b, height, radius in TWO:
        r2 = (x - a)**2 + (y - b)**2
        heights = np.maximum(heights, np.where(
            r2 < radius**2, height - radius + np.sqrt(np.maximum(0.0, radius**2 - r2)), 0.0))
    free = positions[0]["separation"] - heights + fields["displacement"]
    open_ = there & (pressure == 0)
    assert np.abs(fields["gap"] - np.maximum(0.0, free))[open_].max() < 1e-12
    # Circles beside each other leave 2.8 % of overlap, boundary elements less.
    assert free[there].min() > (-0.04 if interaction == "coupled" else -0.02) * DEPTH
    inside = np.zeros(x.shape, bool)
    for a, b, *_ in TWO:
        inside |= np.hypot(x - a, y - b) < 0.03
    assert np.abs(free[inside]).max() < 0.02 * DEPTH
    assert positions[0]["mean_gap"] == pytest.approx(fields["gap"][there].mean(), rel=1e-12)
    assert positions[0]["elastic_energy"] == pytest.approx(
        np.nansum(pressure * fields["displacement"]) * side**2 / 2, rel=1e-12)


@pytest.mark.parametrize("scale", [1.0, 1000.0])
def test_boundary_elements_of_one_sphere(asperity, tmp_path, scale):
    """Hertz' pressure again, from the elements to smaller pixels, in small and large units."""
    a, p0, side = scale * 0.1, 2 / math.pi * E * 0.1, 0.005 * scale
    scene = plane_scene(tmp_path, [(0.0, 0.0, scale, scale)], side, {"interaction": "boundary"},
                        control="compression", value=DEPTH * scale)
    (x, y), fields, *_ = fields_of(asperity, tmp_path, scene)
    pressure = np.nan_to_num(fields["pressure"])
    hertz = p0 * np.sqrt(np.maximum(0.0, 1 - (x**2 + y**2) / a**2))
    assert np.abs(pressure - hertz).sum() < 0.01 * hertz.sum()
    # Whole pixels that an element reaches: 5.4 % more by pixels alone.
    assert 1.0 < (pressure > 0).sum() * side**2 / (math.pi * a**2) < 1.085


def test_neighbours_move_the_pressure(asperity, tmp_path):
    """A Hertzian contact stands where the sphere is level with the slope of its neighbour's
    displacement, P/(pi E d**2) far from it: R times the slope farther away."""
    rows, side = [(0.0, 0.0, 1.0, R), (0.4, 0.1, 1.0, R)], 0.005
    moves = {}
    for interaction in ("off", "coupled"):
        scene = plane_scene(tmp_path, rows, side, {"interaction": interaction})
        (x, y), fields, contacts, _ = fields_of(asperity, tmp_path, scene)
        first = np.where(np.hypot(x, y) < 0.2, np.nan_to_num(fields["pressure"]), 0.0)
        moves[interaction] = np.array([(x * first).sum(), (y * first).sum()]) / first.sum()
    distance = math.hypot(*rows[1][:2])
    slope = contacts[1]["vertical_load"] / (math.pi * E * distance**2)
    assert moves["coupled"] == pytest.approx(
        -R * slope * np.array(rows[1][:2]) / distance, rel=0.05)
    assert np.abs(moves["off"]).max() < 1e-12


@pytest.mark.parametrize("side", [0.05, 0.3, 1.7, 30.0])
def test_contacts_smaller_than_a_pixel(asperity, tmp_path, side):
    for interaction in ("coupled", "boundary"):
        scene = plane_scene(tmp_path, TWO, side, {"interaction": interaction})
        _, fields, _, positions = fields_of(asperity, tmp_path, scene)
        assert np.nansum(fields["pressure"]) * side**2 == pytest.approx(
            positions[0]["vertical_load"], rel=1e-13)


def test_two_surfaces_with_tilt_and_displacement(asperity, tmp_path):
    """Gap by the rule of the scene; inclined contacts keep their vertical loads."""
    upper = [(0.2, 0.1, 0.31, 0.5), (1.1, 0.4, 0.33, 0.6), (0.5, 1.0, 0.28, 0.4)]
    lower = [(0.4, 0.2, 0.30, 0.6), (1.2, 0.3, 0.32, 0.5), (0.7, 1.2, 0.29, 0.7)]
    side, angle, slopes, move = 0.02, (0.02, -0.03), ((0.01, -0.02), (-0.015, 0.005)), (0.11, 0.04)
    scene = write_csv_scene(
        tmp_path, upper, lower, tilt={"upper_slope": slopes[0], "lower_slope": slopes[1],
                                      "rotation": angle},
        motion={"x_first": move[0], "y_first": move[1]},
        loading={"control": "compression", "value": 0.02}, effects={"interaction": "coupled"})
    scene.write_text(scene.read_text().replace("&surfaces ", f"&surfaces field_spacing = {side}, "))
    (x, y), fields, contacts, positions = fields_of(asperity, tmp_path, scene)
    assert len(contacts) > 1 and max(contact["slope"] for contact in contacts) > 0.05
    assert np.nansum(fields["pressure"]) * side**2 == pytest.approx(positions[0]["vertical_load"],
                                                                    rel=1e-13)
    between = np.full(x.shape, positions[0]["separation"])
    low, high = np.full(2, -np.inf), np.full(2, np.inf)
    for sign, rows, turn, slope, (dx, dy) in ((1, upper, angle[0], slopes[0], move),
                                              (-1, lower, angle[1], slopes[1], (0.0, 0.0))):
        # z of the surface, from its own reference plane upwards.
        edge = slope[0] * (x - dx) + slope[1] * (y - dy)
        boxes = []
        for a, b, height, radius in rows:
            a, b = (a * math.cos(turn) - b * math.sin(turn),
                    a * math.sin(turn) + b * math.cos(turn))
            centre = sign * (radius - height) + slope[0] * a + slope[1] * b
            r2 = (x - a - dx)**2 + (y - b - dy)**2
            sphere = np.full(x.shape, sign * np.inf)
            under = r2 < radius**2
            sphere[under] = centre - sign * np.sqrt(radius**2 - r2[under])
            edge = np.minimum(edge, sphere) if sign > 0 else np.maximum(edge, sphere)
            reach = math.sqrt(height * (2 * radius - height)) if height < radius else radius
            boxes.append([(a + dx - reach, b + dy - reach), (a + dx + reach, b + dy + reach)])
        between += sign * edge
        low = np.maximum(low, np.min([box[0] for box in boxes], 0))
        high = np.minimum(high, np.max([box[1] for box in boxes], 0))
    # The grid has whole cells around what the surfaces have in common.
    for axis, centres in enumerate((x[:, 0], y[0])):
        assert low[axis] - side < centres[0] - side / 2 <= low[axis] + 1e-9
        assert high[axis] - 1e-9 <= centres[-1] + side / 2 < high[axis] + side
    open_ = fields["pressure"] == 0
    assert open_.mean() > 0.9 and not np.isnan(fields["gap"]).any()
    expected = np.maximum(0.0, between + fields["displacement"])
    assert np.abs(fields["gap"] - expected)[open_].max() < 1e-12


def test_a_mirrored_surface_is_near_around_each_contact(asperity, root, tmp_path):
    """A mirrored lower surface: around each contact the surfaces are near."""
    scene = tmp_path / "deck.scene"
    scene.write_text(f"&surfaces deck = '{root}/data/thesis.deck', field_spacing = 0.01 /\n"
                     "&motion x_first = 0.1, positions = 1 /\n"
                     "&loading control = 'vertical_load', value = 300. /\n"
                     "&effects friction = 'on', friction_coefficient = 0.2 /\n")
    (x, y), fields, contacts, positions = fields_of(asperity, tmp_path, scene)
    assert np.nansum(fields["pressure"]) * 0.01**2 == pytest.approx(300.0, rel=1e-6)
    assert len(contacts) > 2 and np.median(fields["gap"]) > 20 * positions[0]["compression"]
    for contact in contacts:
        far = np.hypot(x - contact["x"], y - contact["y"]) / math.sqrt(contact["area"] / math.pi)
        assert (fields["pressure"][far < 0.8] > 0).all()
        ring = fields["gap"][(far > 1.2) & (far < 1.5)]
        assert 0 < ring.min() and ring.max() < 0.7 * positions[0]["compression"]


@pytest.mark.parametrize("height, reach", [(0.2, 0.6), (1.0, 1.0), (1.5, 1.0)])
def test_the_grid_covers_the_cap(asperity, tmp_path, height, reach):
    """To its base circle, of a sphere that stands higher to its widest circle."""
    (x, y), *_ = fields_of(asperity, tmp_path, plane_scene(tmp_path, [(3.0, 0.0, height, R)], 0.1))
    assert (x.min() - 0.05, x.max() + 0.05) == pytest.approx((3 - reach, 3 + reach))
    assert (y.min() - 0.05, y.max() + 0.05) == pytest.approx((-reach, reach))


def test_many_spheres(asperity, tmp_path):
    """Spheres that are chosen by blocks of cells: the highest of all is found everywhere."""
    made = np.random.default_rng(5)
    rows = [(*made.uniform(0, 10, 2), made.normal(0, 0.01), made.uniform(0.5, 3.0))
            for _ in range(300)]
    side = 0.05
    (x, y), fields, _, positions = fields_of(
        asperity, tmp_path, plane_scene(tmp_path, rows, side, {"interaction": "coupled"},
                                        control="load", value=1.0))
    heights = np.full(x.shape, -np.inf)
    for a, b, height, radius in rows:
        r2 = (x - a)**2 + (y - b)**2
        under = r2 < radius**2
        heights[under] = np.maximum(heights[under], height - r2[under] / (
            radius + np.sqrt(radius**2 - r2[under])))
    open_ = fields["pressure"] == 0
    assert np.array_equal(np.isnan(fields["gap"]), ~np.isfinite(heights))
    expected = np.maximum(0.0, positions[0]["separation"] - heights + fields["displacement"])
    assert np.abs(fields["gap"] - expected)[open_].max() < 1e-12


def test_states_and_histogram(asperity, tmp_path):
    scene = plane_scene(tmp_path, TWO, 0.02, {"interaction": "auto"}, control="load",
                        value=(1.0, 2.0, 0.5))
    run(asperity, scene, "--quiet", "--fields", tmp_path / "f.vti", "--fields-of", "all", "--curve",
        tmp_path / "s.csv", "--histogram", tmp_path / "h.csv")
    states = records(tmp_path / "s.csv")
    for number, (load, state) in enumerate(zip((1.0, 2.0, 0.5), states, strict=True), 1):
        _, _, fields = read_vti(tmp_path / f"f_000{number}.vti")
        assert np.nansum(fields["pressure"]) * 0.02**2 == pytest.approx(load, rel=1e-6)
        assert np.nanmean(fields["gap"]) == pytest.approx(float(state["mean_gap"]), rel=1e-12)
    bins = [[float(cell) for cell in row.values()] for row in records(tmp_path / "h.csv")]
    width = 2 * bins[0][0]
    assert width * sum(row[1] for row in bins) == pytest.approx(
        fields["contact"].sum() / (~np.isnan(fields["pressure"])).sum())


def test_refusals(asperity, tmp_path):
    def shown(words=(), effects=None, status=2, **groups):
        scene = write_csv_scene(
            tmp_path, [(0.0, 0.0, 1.0, R)], [(0.0, 0.0, 1.0, R)], effects=effects or {},
            **{"loading": {"control": "compression", "value": DEPTH}, **groups})
        scene.write_text(scene.read_text().replace("&surfaces ", "&surfaces field_spacing = 0.1, "))
        return run(asperity, scene, "--fields", tmp_path / "f.vti", *words, status=status).stderr

    assert "--fields: found 3 positions of asperities, expected one for fields" in shown(
        motion={"positions": 3, "x_step": 0.1})
    assert "a file of --keep has no pressure" in shown(("--keep", tmp_path / "k"))
    adhesion = {"adhesion": "on", "work_of_adhesion": 1.0, "equilibrium_distance": 1e-4}
    assert "fields: the pressure of contacts with adhesion is not Hertz's" in shown(
        effects=adhesion, status=1)
    assert "no area in common in plan" in shown(status=1, motion={"x_first": 3.0})


def test_spacing_beside_a_map(asperity, tmp_path):
    """The fields of a map are those of its pixels."""
    np.savetxt(tmp_path / "m.txt", 0.05 * np.sin(0.21 * np.arange(12))[:, None] * np.ones(8))
    scene = write_scene(
        tmp_path / "m.scene", surfaces={"upper": "plane", "lower": "m.txt",
                                        "map_spacing": (0.1, 0.1), "field_spacing": 0.05},
        material={"contact_modulus": E}, loading={"control": "load", "value": 5.0})
    assert "field_spacing: found beside a map" in run(asperity, scene, status=2).stderr


@pytest.mark.once
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_python_has_the_fields_of_the_file(package, asperity, tmp_path):
    """The same fields as in the file, with and without the contacts; copies keep them."""
    path = plane_scene(tmp_path, TWO, 0.02, {"interaction": "auto", "tolerance": 1e-3}, surfaces={
        "units": ("mm", "N")}, control="load", value=(1.0, 2.0))
    (x, y), arrays, *_ = fields_of(asperity, tmp_path, path)
    for contacts in (True, False):
        results = package.solve(path, fields=True, contacts=contacts)
        fields = pickle.loads(pickle.dumps(results)).fields()
        assert (len(results.contacts) > 0) == contacts
        for name in ("pressure", "gap", "displacement", "contact"):
            assert np.array_equal(getattr(fields, name), arrays[name].T, equal_nan=True), name
        assert fields.origin == pytest.approx((x[0, 0], y[0, 0])) and fields.spacing == (0.02, 0.02)
        assert (fields.boundary_contacts, fields.hertz_contacts) == (2, 1)
        assert (fields.unit, fields.units["pressure"]) == ("mm", "MPa")
    every = package.solve(path, fields="all")
    assert np.nansum(every.fields(step=1).pressure) * 0.02**2 == pytest.approx(1.0, rel=1e-6)
    again = package.Scene(path).solve(loading={"value": 1.5}, fields=True)
    assert np.nansum(again.fields().pressure) * 0.02**2 == pytest.approx(1.5, rel=1e-6)
    with pytest.raises(package.ComputeError, match="or field_spacing in &surfaces for one"):
        package.solve(path, fields=False).fields()
    drawn = pytest.importorskip("matplotlib.pyplot")
    image = fields.plot().images[0]
    assert image.get_extent() == pytest.approx([x[0, 0] - 0.01, x[-1, 0] + 0.01, y[0, 0] - 0.01,
                                                y[0, -1] + 0.01])
    drawn.close("all")
