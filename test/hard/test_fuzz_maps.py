"""Mutated height maps, a few in every run; more: test/support/fuzz_maps.py."""

import fuzz_maps

import pytest

pytestmark = pytest.mark.fuzz


def test_mutated_maps(asperity):
    ended, faults = fuzz_maps.campaign(asperity, range(300))
    assert not faults
    assert min(ended[0], ended[2]) > 50
