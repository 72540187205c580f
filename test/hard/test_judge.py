"""The judge of the tests sees what is wrong."""

import numpy as np
import pytest

from judge import Answer, Figure, check, compare, estimates, has_result, is_met, missed

RESULT = {"status": 0, "stdout": "s.scene: 1 asperity\nmodel: none\n", "stderr": "",
          "positions": [{"load": "1.0", "interaction": "coupled", "error_estimate": ""}],
          "contacts": [], "curve": [], "scene": "s.scene"}
REFUSAL = {**RESULT, "status": 1, "stdout": "", "positions": [],
           "stderr": "s.scene: note: a note\ns.scene: the load is too large\n"}


def test_error_of_tolerance_and_bound_is_met():
    assert is_met(-0.3, 0.2, 0.1 + 1e-15) and not is_met(0.31, 0.2, 0.1)
    assert not is_met(np.nan, 0.2) and not is_met(0.1, np.nan)
    figures = [Figure("load", found, 2.0, 0.1) for found in (1.5, 2.5, 2.7, np.nan)]
    assert missed(figures, 0.2).startswith("2: load 2.7 for 2.0")
    assert Figure("area", 0.0, 0.0).within(0.0) and not Figure("area", 1e-300, 0.0).within(1e9)
    assert Figure("load", 1e-3, 0.0, scale=-10.0).within(1e-4)
    with pytest.raises(AssertionError, match="load 2.7 for 2.0"):
        check("load", 2.7, 2.0, 0.2, 0.1)
    shown = [Figure("load", 1.1, 1.0, estimate=estimate) for estimate in (0.05, 0.2, 2.0, np.nan)]
    assert vars(estimates(shown)) == {"known": 3, "below": 1 / 3, "above": 1 / 3}


@pytest.mark.parametrize("errors, tolerance", [([0.1, -0.3], 0.2), ([0.1, 0.3], [0.2, 0.2]),
                                               ([np.nan], 1.0), ([], 1.0)])
def test_compare_fails(errors, tolerance):
    with pytest.raises(AssertionError):
        compare("errors", errors, tolerance)


@pytest.mark.parametrize("change", [
    {"positions": []}, {"stdout": "s.scene:\nmodel: none, load NaN\n"}, {"status": 2},
    {"positions": [{"load": "Infinity"}]}, {"contacts": [{"load": "nan"}]}, {"status": -11}])
def test_neither_result_nor_refusal(change):
    assert has_result(Answer(**RESULT)) and not has_result(Answer(**REFUSAL))
    with pytest.raises(AssertionError):
        has_result(Answer(**{**RESULT, **change}))


@pytest.mark.parametrize("change", [
    {"stdout": "a result"}, {"contacts": [{"load": "1.0"}]}, {"stderr": ""}, {"status": 2},
    {"stderr": REFUSAL["stderr"] + "s.scene: and another one\n"}, {"stderr": "Backtrace\n"}])
def test_refusal_without_reason(change):
    with pytest.raises(AssertionError):
        has_result(Answer(**{**REFUSAL, **change}))
