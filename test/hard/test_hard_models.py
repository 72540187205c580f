"""Hard cases of adhesion, plasticity, creep, height maps and dense caps, against their truths."""

import pytest
from judge import missed, solved
from model_cases import PLACES, WAYS, dense_load, model_cases

CASES = {case.name: case for case in model_cases()}


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=[pytest.mark.truth] * (
        name.startswith("dense_") and name != "dense_pair_auto"))
    for name in CASES])
def test_model_case(name, asperity, root, tmp_path):
    run = solved(asperity, root / "data/hard/models" / f"{name}.scene", folder=tmp_path)
    for value in CASES[name].values:
        figure = value.figure(run)
        assert not missed([figure], value.tolerance), figure


@pytest.mark.truth
@pytest.mark.parametrize("name", PLACES)
def test_auto_is_not_worse_than_coupled(name, asperity, root, tmp_path):
    """Errors of the load, to the uncertainty of the truth."""
    errors = {}
    for way in WAYS:
        run = solved(asperity, root / "data/hard/models" / f"dense_{name}_{way}.scene",
                     folder=tmp_path)
        errors[way] = abs(float(run.positions[0]["load"]) / dense_load(name) - 1)
    assert errors["auto"] <= errors["coupled"] + 1e-5
    assert errors["boundary"] < errors["coupled"]
