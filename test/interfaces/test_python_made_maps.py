"""Random height maps and power spectra in Python: the numbers of the command."""

import numpy as np
import pytest
from builds import ROOT
from programs import run_program
from surfaces_csv import records

pytestmark = pytest.mark.once

SPEC = ROOT / "data/examples/generate/self_affine.spec"
NAMES = {"pixels": (42, 30), "spacing": (0.5, 0.75), "hurst": 0.7, "rms_slope": 0.3, "unit": "um",
         "roll_off": 9, "cut_off": 2.5, "seed": 5}


def run(asperity, folder, *words):
    run_program(asperity, *words, cwd=folder)


def test_a_map_from_a_file_from_names_and_from_groups(package, asperity, tmp_path):
    run(asperity, tmp_path, "generate", SPEC, "--output", "m.npy")
    made = package.generate_map(SPEC)
    assert made.heights.tobytes() == np.load(tmp_path / "m.npy").tobytes()
    facts = made.shape, made.spacing, made.unit, made.periodic
    assert facts == ((512, 512), (0.2, 0.2), "um", True)
    one, two = package.generate_map(**NAMES), package.generate_map({"map": NAMES})
    assert one.heights.tobytes() == two.heights.tobytes()
    assert one.shape == (30, 42) and one.spacing == (0.5, 0.75)
    free = package.generate_map(**NAMES, periodic=False)
    assert not free.periodic and (free.heights != one.heights).all()


@pytest.mark.parametrize("periodic", (True, False))
def test_spectra_are_those_of_the_command(periodic, package, asperity, tmp_path):
    made = package.generate_map(**NAMES, periodic=periodic)
    made.write(tmp_path / "m.sdf")
    run(asperity, tmp_path, "summits", "m.sdf", "--unit", "um", "--edge",
        "periodic" if periodic else "free", "--quiet", "--spectrum", "s.csv")
    rows = records(tmp_path / "s.csv")
    for kind, name, unit in (("iso", "c_iso", "um4"), ("x", "c_1d", "um3"), ("y", "c_1d", "um3")):
        table = made.power_spectrum(kind)
        assert list(table) == ["q", name, "number"]
        assert table.units == {"q": "1/um", name: unit, "number": ""}
        for column in table:
            wanted = [float(row[column]) for row in rows if row["spectrum"] == kind]
            # The file has metres; beyond the cut-off there is rounding alone.
            np.testing.assert_allclose(table[column], wanted, rtol=1e-10, atol=1e-20 * max(wanted))
    assert list(made.power_spectrum()) == list(made.power_spectrum("iso"))


def test_level_of_a_spectrum(package, asperity, tmp_path):
    """Whole periods of a sine along x: mean square 1/2 of the lines but for `plane`, which removes
    a part of the sine. The command agrees."""
    wave = np.tile(np.sin(4 * np.pi * np.arange(64) / 64), (4, 1))
    surface = package.HeightMap(wave, 1 / 64, periodic=True)
    assert 2 * sum(surface.power_spectrum("x")["c_1d"]) == pytest.approx(0.5, rel=1e-12)
    free = package.HeightMap(wave + 3.0, 1 / 64)
    free.write(tmp_path / "m.txt")
    for level in ("plane", "mean", "none"):
        run(asperity, tmp_path, "summits", "m.txt", "--spacing", "0.015625", "--level", level,
            "--quiet", "--spectrum", "s.csv")
        wanted = [float(row["c_1d"]) for row in records(tmp_path / "s.csv")
                  if row["spectrum"] == "x"]
        found = free.power_spectrum("x", level=level)["c_1d"]
        np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-12 * max(wanted))
        assert (level == "plane") == (found.tolist() == free.power_spectrum("x")["c_1d"].tolist())
    lines = {level: 2 * sum(package.HeightMap(wave, 1 / 64).power_spectrum("x", level)["c_1d"])
             for level in ("plane", "mean", "none")}
    assert lines["mean"] == pytest.approx(0.5, rel=1e-12) == lines["none"]
    assert abs(lines["plane"] - 0.5) > 0.01
    with pytest.raises(package.InputError, match="level: .*expected .*plane.*mean.*none"):
        surface.power_spectrum(level="plain")


def test_spectra_out_of_range_are_refused(package, tmp_path):
    with pytest.raises(package.InputError, match="map.hurst: found '1.5', expected a number more"):
        package.generate_map(pixels=64, spacing=1, hurst=1.5, rms_height=1)
    with pytest.raises(package.InputError, match="^map: needs hurst: found none, expected"):
        package.generate_map(pixels=64, spacing=1)
    with pytest.raises(package.InputError, match="unknown name in &map: found 'hight'"):
        package.generate_map(pixels=64, spacing=1, hurst=1, rms_height=1, hight=1)
    with pytest.raises(package.InputError, match="found surfaces, expected a group &map"):
        package.generate_map(ROOT / "data/examples/generate/thesis.spec")
    with pytest.raises(package.InputError, match="found a height map, expected surfaces"):
        package.generate(SPEC)
    with pytest.raises(TypeError, match="found both, hurst"):
        package.generate_map(SPEC, hurst=1)
    with pytest.raises(package.InputError, match="kind: found 'z', expected 'iso', 'x' or 'y'"):
        package.generate_map(SPEC).power_spectrum("z")
    holes = package.HeightMap([[0, 1, 2], [0, float("nan"), 2], [0, 1, 3]], spacing=1)
    with pytest.raises(package.InputError, match="found 1 missing pixels, expected none"):
        holes.power_spectrum()
