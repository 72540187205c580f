"""Pressures of unlike bodies with friction (`coupling`): CONTACT's compression of a sphere after
Spence, an independent iteration in numpy, refused scenes."""

import numpy as np
import pytest

from image_data import read_vti
from map_scenes import map_scene
from programs import run_program
from surfaces_csv import solve

# A compliant sphere on a rigid body: G = 0.5 and 1e5, nu = 0 of both.
SPENCE = {"elastic_modulus": (1.0, 2e5), "poisson_ratio": (0.0, 0.0)}
FRICTION = 0.2986


def sphere():
    """Heights of 45 x 45 pixels, 0.004116 r**2 below the summit."""
    place = (np.arange(45) - 22) * 0.2
    return -0.004116 * (place[:, None]**2 + place[None, :]**2)


def pressed(asperity, folder, loads, material=SPENCE, **effects):
    """Position and fields of the sphere under the last load of a path."""
    scene = map_scene(folder, sphere(), (0.2, 0.2), name="unlike", surfaces={"map_level": "none"},
                      material=material, loading={"control": "load", "value": loads},
                      effects={"friction_coefficient": FRICTION, **effects})
    found = solve(asperity, scene)
    run_program(asperity, "solve", scene, "--quiet", "--fields", folder / "unlike.vti")
    return found, found.positions[0], read_vti(folder / "unlike.vti")[2]


@pytest.mark.parametrize("steps, greatest, approach, sticks", [
    (6, "3.941e-03", "2.901e-03", 5), (18, "1.220e-02", "2.610e-02", 61),
    (35, "2.392e-02", "9.874e-02", 225)])
def test_compression_of_spence(asperity, tmp_path, steps, greatest, approach, sticks):
    """examples/spence35.ref_out of CONTACT (E. A. H. Vollebregt), revision 2707: greatest pressure,
    approach and elements of adhesion after so many steps of (k/45)**3. Its iteration ends at 1e-4:
    the approach of step 6 is 2.9017e-3 in a dense solution of the same equations."""
    loads = tuple((k / 45)**3 for k in range(1, steps + 1))
    found, row, fields = pressed(asperity, tmp_path, loads, loading_steps=1)
    assert fields["pressure"].max() == pytest.approx(float(greatest), rel=3e-4)
    assert -float(row["separation"]) == pytest.approx(float(approach), rel=3e-4)
    assert steps == 6 or f"{-float(row['separation']):.3e}" == approach
    assert (fields["stick"] > 0).sum() == sticks
    assert "Dundurs" not in found.stderr
    traction = np.hypot(fields["traction_x"], fields["traction_y"])
    assert (traction <= FRICTION * fields["pressure"] * (1 + 1e-12)).all()
    assert float(row["tangential_load"]) < 1e-12
    # The few steps of one load are within 0.1 % of it, 0.2 % on so few pixels.
    _, once, other = pressed(asperity, tmp_path, loads[-1])
    assert other["pressure"].max() == pytest.approx(float(greatest),
                                                    rel=2e-3 if steps == 6 else 1e-3)
    # Without friction the pressures are lower by a fifth.
    note, _, without = pressed(asperity, tmp_path, loads[-1], coupling="off")
    assert without["pressure"].max() < 0.85 * float(greatest) and "Dundurs" in note.stderr


def test_the_upper_body_is_the_softer_one(asperity, tmp_path):
    """With the materials exchanged the pressures are the same, and the tractions opposite."""
    turned = {name: both[::-1] for name, both in SPENCE.items()}
    fields = [pressed(asperity, tmp_path, 0.05, material, loading_steps=3)[2]
              for material in (SPENCE, turned)]
    for name, factor in (("pressure", 1), ("gap", 1), ("traction_x", -1), ("slip_y", -1)):
        assert fields[0][name] == pytest.approx(factor * fields[1][name],
                                                abs=1e-6 * np.abs(fields[0][name]).max())


def test_gap_and_displacement(asperity, tmp_path):
    """The gap is 0 in contact, and the normal displacement has the part by the tractions."""
    _, row, fields = pressed(asperity, tmp_path, 0.05, loading_steps=3)
    touches = fields["pressure"] > 0
    gap = float(row["separation"]) - sphere() + fields["displacement"]
    assert np.abs(gap[touches]).max() < 1e-8 and gap[~touches].min() > -1e-9
    assert fields["gap"][~touches] == pytest.approx(gap[~touches], abs=1e-9)


def test_tangential_load_on_unlike_bodies(asperity, tmp_path):
    """The shift of a load of half of that of sliding is 17 % larger than without coupling (measured
    in numpy for beta 0.5 and a friction of 0.3)."""
    shifts = []
    for coupling in ("on", "off"):
        scene = map_scene(
            tmp_path, sphere(), (0.2, 0.2), name="load", surfaces={"map_level": "none"},
            material=SPENCE, effects={"friction_coefficient": FRICTION, "coupling": coupling},
            loading={"control": "load", "value": 0.2, "tangential_load": 0.5 * FRICTION * 0.2})
        shifts.append(float(solve(asperity, scene).positions[0]["tangential_displacement"]))
    assert 1.1 < shifts[0] / shifts[1] < 1.25


@pytest.mark.parametrize("effects, text", [
    ({"coupling": "on", "work_of_adhesion": 1e-5, "equilibrium_distance": 0.1},
     "coupling: its theory has no adhesion"),
    ({"coupling": "on", "plastic_hardness": 0.02}, "coupling: its theory has no plasticity")])
def test_refused_scenes(asperity, tmp_path, effects, text):
    scene = map_scene(tmp_path, sphere(), (0.2, 0.2), surfaces={"map_level": "none"},
                      by_default=True, material=SPENCE,
                      loading={"control": "load", "value": 0.05},
                      effects={"friction_coefficient": FRICTION, **effects})
    found = solve(asperity, scene)
    assert found.status == 2 and text in found.stderr, found.stderr
