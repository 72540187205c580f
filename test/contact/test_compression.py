"""Compression control: the decrease of the separation since first contact is prescribed."""

import numpy as np
import pytest
from made_maps import write_bytes
from surfaces_csv import solve, write_csv_scene, write_scene

CAPS = [(0.0, 0.0, 0.30, 1.0), (0.9, 0.2, 0.297, 1.5), (0.3, 1.1, 0.293, 0.7)]


def scene(folder, effects, sides=("upper", "lower"), **loading):
    """Three caps above one, or above a plane, that slide over nine positions."""
    path = write_csv_scene(
        folder, CAPS, [(0.1, 0.1, 0.2, 2.0)], loading=loading, effects=effects,
        motion={"x_step": 0.05, "positions": 3})
    if sides[1] == "plane":
        path.write_text(path.read_text().replace("lower = 'pair_lower.csv'", "lower = 'plane'"))
    return path


@pytest.mark.parametrize("lower", ("lower", "plane"))
@pytest.mark.parametrize("interaction", ("off", "coupled", "boundary"))
def test_compression_and_separation(asperity, tmp_path, interaction, lower):
    """The separation that a compression leads to gives the same load and contacts."""
    found = solve(asperity, scene(tmp_path, {"interaction": interaction}, ("upper", lower),
                                  control="compression", value=0.012))
    assert found.status == 0, found.stderr
    assert len(found.positions) == 3
    for row in found.positions:
        assert float(row["compression"]) == pytest.approx(0.012, rel=1e-14)
        assert float(row["load"]) > 0
    separations = {row["position"]: float(row["separation"]) for row in found.positions}
    assert len(set(separations.values())) == (1 if lower == "plane" else 3)
    for m, separation in separations.items():
        again = solve(asperity, scene(tmp_path, {"interaction": interaction}, ("upper", lower),
                                      control="separation", value=separation))
        other = again.positions[int(m) - 1]
        assert other["contacts"] == found.positions[int(m) - 1]["contacts"]
        for name in ("load", "area", "compression"):
            assert float(other[name]) == pytest.approx(
                float(found.positions[int(m) - 1][name]), rel=1e-9)


def test_a_compression_of_a_map_counts_from_its_highest_pixel(asperity, tmp_path):
    """On the pixels of a map it counts from the highest one."""
    rng = np.random.default_rng(5)
    height = rng.normal(size=(24, 32)).cumsum(0).cumsum(1) * 1e-9
    write_bytes(tmp_path / "map.sdf", height, 1e-6, 1e-6)
    rows = []
    for control, value in (("compression", 2e-8), ("separation", None)):
        value = value or float(rows[0]["separation"])
        found = solve(asperity, write_scene(
            tmp_path / "map.scene", surfaces={"upper": "plane", "lower": "map.sdf"},
            material={"contact_modulus": 1e9}, effects={"interaction": "boundary"},
            loading={"control": control, "value": value}))
        assert found.status == 0, found.stderr
        rows += found.positions
    assert float(rows[0]["compression"]) == pytest.approx(2e-8, rel=1e-9)
    assert float(rows[0]["load"]) == pytest.approx(float(rows[1]["load"]), rel=1e-9)


@pytest.mark.parametrize("control, values, apart", [
    ("compression", (2e-8, 0.0, 3e-8), (1,)), ("load", (1e-4, 0.0, 2e-4), (1,)),
    ("separation", (5e-9, 1e-7, 8e-9), (1,))])
@pytest.mark.parametrize("edge", ("free", "periodic"))
def test_pixels_apart_again(asperity, tmp_path, edge, control, values, apart):
    """Where the pixels are apart again on a path, load and area are 0, and no state before counts
    in the states after it."""
    height = np.random.default_rng(6).normal(size=(16, 16)) * 1e-8
    write_bytes(tmp_path / "map.sdf", height, 1e-6, 1e-6)

    def solved(value):
        found = solve(asperity, write_scene(
            tmp_path / "map.scene", surfaces={"upper": "plane", "lower": "map.sdf",
                                              "map_edge": edge},
            material={"contact_modulus": 1e9}, effects={"interaction": "boundary"},
            loading={"control": control, "value": value}), curve=True)
        assert found.status == 0, found.stderr
        return found.curve

    for k, row in enumerate(solved(values)):
        if k in apart:
            assert float(row["load"]) == float(row["area"]) == float(row["contacts"]) == 0
        else:
            alone = solved(values[k])[-1]
            for name in ("load", "area", "compression"):
                assert float(row[name]) == pytest.approx(float(alone[name]), rel=1e-6)


@pytest.mark.parametrize("value", (-0.1, (-1e-9, 0.1)))
def test_below_first_contact(asperity, tmp_path, value):
    """A compression is 0 or more."""
    found = solve(asperity, scene(tmp_path, {"interaction": "off"}, control="compression",
                                  value=value))
    assert found.status == 2 and "value" in found.stderr


def test_the_earlier_name(asperity, tmp_path):
    """'approach' is accepted for 'separation', and gives the same numbers."""
    rows = [solve(asperity, scene(tmp_path, {"interaction": "off"}, control=control,
                                  value=0.485)).positions
            for control in ("separation", "approach")]
    assert rows[0] == rows[1]
