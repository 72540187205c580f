"""Hard cases of adhesion, plasticity, creep, height maps and dense caps, against their truths."""

from dataclasses import replace

import pytest
from make_cases import write_models
from model_cases import PLACES, WAYS, dense_load, model_cases
from surfaces_csv import solve

CASES = {case.name: case for case in model_cases()}


@pytest.mark.parametrize("name", CASES)
def test_model_case(name, asperity, root, tmp_path, tally):
    solved = solve(asperity, root / "data/hard/models" / f"{name}.scene", folder=tmp_path,
                   curve=True)
    assert solved.status == 0, solved.stderr
    for value in CASES[name].values:
        error = value.error(solved)
        assert error <= value.tolerance, f"{value.column}: {error:.1e}, {value.reason}"
        tally.add("hard cases of models", 1, 1)
        if value.tolerance:
            # A truth twice the tolerance away is seen.
            true = value.true() if callable(value.true) else value.true
            other = replace(value, true=true + 2 * value.tolerance * (abs(true) or 1.0))
            assert other.error(solved) > value.tolerance


@pytest.mark.truth
@pytest.mark.parametrize("name", PLACES)
def test_auto_is_not_worse_than_coupled(name, asperity, root, tmp_path):
    """Errors of the load, to the uncertainty of the truth."""
    errors = {}
    for way in WAYS:
        solved = solve(asperity, root / "data/hard/models" / f"dense_{name}_{way}.scene",
                       folder=tmp_path)
        errors[way] = abs(float(solved.positions[0]["load"]) / dense_load(name) - 1)
    assert errors["auto"] <= errors["coupled"] + 1e-5
    assert errors["boundary"] < errors["coupled"]


def test_files_are_those_of_the_catalogue(root, tmp_path):
    """Names, groups and reasons; heights to the last digit of a library's cosine."""
    write_models(tmp_path)
    kept = root / "data/hard/models"
    assert {path.name for path in kept.iterdir()} == {path.name for path in tmp_path.iterdir()}
    for path in tmp_path.glob("*.scene"):
        assert path.read_text() == (kept / path.name).read_text(), path.name
