"""Results in a file and as a dataset; solves that start no thread; modules without a circle."""

import csv
import io
import json
import os
import random
import zipfile

import numpy as np
import pandas as pd
import pytest
from builds import ROOT
from programs import run_program

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

NAMES = ("pressure", "gap", "displacement", "contact")


@pytest.fixture(scope="module")
def solved(package):
    """A map with missing pixels and unequal spacing, fields of four states."""
    y, x = np.mgrid[:12, :17]
    heights = np.sin(0.9 * x + 0.3 * y) + 0.7 * np.cos(1.1 * y - 0.2 * x)
    heights[4, 7:9] = np.nan
    return package.solve({
        "surfaces": {"upper": "plane", "lower": package.HeightMap(heights, (0.5, 0.25), "um"),
                     "units": ("um", "uN")},
        "material": {"contact_modulus": 100.0}, "effects": {"interaction": "boundary"},
        "loading": {"control": "load", "value": 20.0, "points": 3}}, fields="all")


def assert_same(found, expected, steps=()):
    for name in ("positions", "states", "contacts"):
        mine, their = getattr(found, name), getattr(expected, name)
        assert mine == their and mine.units == their.units and mine.name == their.name
        assert [cells.dtype for cells in mine.values()] == [
            cells.dtype for cells in their.values()]
    for name in ("summary", "warnings", "notes"):
        assert getattr(found, name) == getattr(expected, name)
    for step in steps:
        mine, their = found.fields(step=step), expected.fields(step=step)
        for name in NAMES:
            assert np.array_equal(mine[name], their[name], equal_nan=True)
            assert mine[name].dtype == their[name].dtype and not mine[name].flags.writeable
        for name in ("shape", "spacing", "origin", "unit", "units", "position", "step",
                     "boundary_contacts", "hertz_contacts"):
            assert getattr(mine, name) == getattr(their, name), name


def test_saved_with_fields(package, solved, tmp_path):
    solved.save(tmp_path / "a.zip")
    loaded = package.load(tmp_path / "a.zip")
    assert_same(loaded, solved, range(1, 5))
    loaded.save(tmp_path / "b.zip")
    assert_same(package.load(tmp_path / "b.zip"), solved, range(1, 5))
    assert {path.name for path in tmp_path.iterdir()} == {"a.zip", "b.zip"}


@pytest.mark.parametrize("name", ["data/examples/thesis.scene", "data/thesis.deck",
                                  "data/examples/effects/cycle.scene"])
def test_saved_tables(package, name, tmp_path):
    results = package.solve(ROOT / name)
    results.save(tmp_path / "a.zip")
    loaded = package.load(tmp_path / "a.zip")
    assert_same(loaded, results)
    with pytest.raises(package.ComputeError, match="no fields"):
        loaded.fields()


def test_parts_are_read_by_others(solved, tmp_path):
    """json, csv, numpy and pandas alone."""
    solved.save(tmp_path / "a.zip")
    fields = solved.fields(step=3)
    with np.load(tmp_path / "a.zip") as arrays:
        for name in NAMES:
            assert np.array_equal(arrays[f"fields/position_0001_step_0003/{name}"], fields[name],
                                  equal_nan=True)
    with zipfile.ZipFile(tmp_path / "a.zip") as archive:
        facts = json.loads(archive.read("results.json"))
        assert facts["tables"]["states"]["units"] == solved.states.units
        assert facts["summary"] == solved.summary and facts["fields"][2]["spacing"] == [0.5, 0.25]
        rows = list(csv.DictReader(io.StringIO(archive.read("states.csv").decode())))
        assert [float(row["load"]) for row in rows] == solved.states["load"].tolist()
        with archive.open("contacts.csv") as file:
            frame = pd.read_csv(file)
    assert np.allclose(frame["area"], solved.contacts["area"], rtol=1e-15, atol=0)
    assert list(frame) == list(solved.contacts)


def test_refused_files(package, solved, tmp_path):
    (tmp_path / "text.zip").write_text("no archive")
    with zipfile.ZipFile(tmp_path / "other.zip", "w") as archive:
        archive.writestr("results.json", json.dumps({"format": "other"}))
    for name in ("text.zip", "other.zip"):
        with pytest.raises(package.InputError, match=f"{name}: found another kind of file, exp"):
            package.load(tmp_path / name)
    with pytest.raises(package.InputError, match="none.zip: No such file"):
        package.load(tmp_path / "none.zip")
    with pytest.raises(package.ComputeError, match="a.zip: No such file or directory"):
        solved.save(tmp_path / "none" / "a.zip")
    with pytest.raises(TypeError, match="path: found 3, expected a path"):
        solved.save(3)


@pytest.mark.parametrize("name", ["r.h5", "r.json", "r.NPZ"])
def test_ending_of_another_format(package, solved, name, tmp_path):
    with pytest.raises(package.InputError, match="a name that ends with .zip, as that is what"):
        solved.save(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_damaged_files(package, solved, tmp_path):
    """One changed byte: the same results, or another kind of file."""
    solved.save(tmp_path / "a.zip")
    whole, rng, refused = (tmp_path / "a.zip").read_bytes(), random.Random(66), 0
    for _ in range(400):
        changed = bytearray(whole)
        changed[rng.randrange(len(whole))] = rng.randrange(256)
        (tmp_path / "b.zip").write_bytes(changed)
        try:
            package.load(tmp_path / "b.zip")
        except package.InputError:
            refused += 1
    assert refused > 200


def changed_copy(source, target, change):
    """A copy of a file whose members a function has changed; what it makes None is left out."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            content = change(name, old.read(name))
            if content is not None:
                new.writestr(name, content)


@pytest.mark.parametrize("change", [
    lambda name, raw: raw.replace(b"<f8", b">f8"),
    lambda name, raw: raw.replace(b"'<f8'", b"'<f4'"),
    lambda name, raw: raw[:-8] if name.endswith(".npy") else raw,
    lambda name, raw: raw.replace(b"{'descr'", b"[" * 2000) if name.endswith(".npy") else raw,
    lambda name, raw: None if name == "states.csv" else raw,
    lambda name, raw: b"" if name == "states.csv" else raw,
    lambda name, raw: raw.replace(b'"summary"', b'"other"'),
    lambda name, raw: raw.replace(b'"tables"', b'"tables": null, "others"')],
    ids=["bytes swapped", "other type", "array cut", "deep", "no table", "empty", "no summary",
         "null"])
def test_crafted_files(package, solved, change, tmp_path):
    """A header of an array that is not the one of `save` is not read as if it were."""
    solved.save(tmp_path / "a.zip")
    changed_copy(tmp_path / "a.zip", tmp_path / "b.zip", change)
    with pytest.raises(package.InputError, match="b.zip: found another kind of file"):
        package.load(tmp_path / "b.zip")
    changed_copy(tmp_path / "a.zip", tmp_path / "c.zip", lambda name, raw: raw)
    assert package.load(tmp_path / "c.zip").states == solved.states


def test_link_in_the_place_of_an_unfinished_file(solved, tmp_path):
    (tmp_path / "other").write_text("precious")
    (tmp_path / f"a.zip.{os.getpid()}.part").symlink_to("other")
    solved.save(tmp_path / "a.zip")
    assert (tmp_path / "other").read_text() == "precious"
    assert not (tmp_path / "a.zip").is_symlink()
    assert (tmp_path / "a.zip").stat().st_mode & 0o777 == 0o666 & ~mask_of_files()


def mask_of_files():
    mask = os.umask(0)
    os.umask(mask)
    return mask


def test_saved_without_numpy(package, venv, solved, tmp_path):
    """Written without numpy and read with it; the other way round."""
    solved.save(tmp_path / "a.zip")
    program = f"""
import asperity
results = asperity.load({str(tmp_path / "a.zip")!r})
print(repr(results.fields(step=2).gap[2][3]), results.states["contacts"].tolist())
results.save({str(tmp_path / "b.zip")!r})
"""
    done = run_program(venv / "bin/python", "-c", program)
    assert done.stdout == f"{float(solved.fields(step=2).gap[2, 3])!r} " \
                          f"{solved.states['contacts'].tolist()}\n"
    assert_same(package.load(tmp_path / "b.zip"), solved, range(1, 5))


def test_dataset(package, solved):
    """Fields by coordinates, states along the steps."""
    made = solved.to_xarray()
    assert dict(made.sizes) == {"step": 4, "y": 12, "x": 17}
    for step in range(1, 5):
        for name in NAMES:
            assert np.array_equal(made[name].sel(step=step), solved.fields(step=step)[name],
                                  equal_nan=True)
    assert float(made.x[3]) == 1.5 and float(made.y[3]) == 0.75 and made.x.units == "um"
    assert made.pressure.units == "MPa" and made["load"].values.tolist() == \
        solved.states["load"].tolist()
    one = solved.fields(step=2).to_xarray()
    assert one.gap.dims == ("y", "x") and int(one.step) == 2
    assert np.array_equal(one.gap, solved.fields(step=2).gap, equal_nan=True)
    with pytest.raises(package.ComputeError, match="no fields"):
        package.solve(ROOT / "data/examples/one_pair.scene").to_xarray()


def test_dataset_without_xarray(venv):
    program = """
import asperity
try:
    asperity.solve({"surfaces": {"upper": "plane", "lower": [[0.0, 1.0, 0.0]] * 3,
                                 "map_spacing": 1.0}, "material": {"contact_modulus": 100.0},
                    "loading": {"control": "load", "value": 1.0}}, fields=True).to_xarray()
except ImportError as error:
    print(error)
"""
    done = run_program(venv / "bin/python", "-W", "ignore", "-c", program)
    assert done.stdout == "a dataset needs xarray: pip install xarray, or asperity[xarray]\n"
