"""Some of the random scenes that `coupled` must solve (solved_cases.py), by fixed seeds."""

import pytest
from solved_cases import OF_SEEDS, rough_case, run

pytestmark = pytest.mark.truth

SAMPLE = 24


@pytest.mark.parametrize("part", OF_SEEDS)
def test_sample(part, asperity):
    """All are solved, in 4 to 9 steps on average; a single scene may take some tens."""
    steps = []
    for seed in range(1, SAMPLE + 1):
        outcome = run(asperity, "coupled", OF_SEEDS[part](seed))
        assert outcome.status == 0, (seed, outcome.message)
        steps.append(outcome.steps)
    assert sum(steps) <= 12 * SAMPLE, steps


@pytest.mark.parametrize("part, seed, most, was", [
    ("random", 7801035, 40, "151 steps: cut circle by circle a step went up, and was cut on"),
    ("packed", 1586, 100, "267 steps: no shift went with the loads where Phi curved down"),
    ("packed", 2179, 100, "the same, 151 steps"),
    ("random", 9101463, 40, "no end: a pair on the border between near and far came and went"),
    ("packed", 9102369, 100, "the same, among 227 circles that overlap"),
    ("packed", 9300384, 100, "the same, a pair that changed penetrations by 2e-5"),
    ("random", 9603963, 60, "220 steps: a circle went around another by its own radius a step"),
    ("stepped", 21111, 40, "no end: who is near was shown at a top, far from where it touches"),
    ("stepped", 43019, 40, "no end: a circle to and fro between two places around another"),
    ("stepped", 12741, 40, "63 steps: a circle around another hardly larger"),
])
def test_found_steps(part, seed, most, was, asperity):
    outcome = run(asperity, "coupled", OF_SEEDS[part](seed))
    assert outcome.status == 0 and outcome.steps <= most, was


def test_many_contacts_that_open_each_other(asperity):
    """Did not end: all open ones that would touch joined at a time, and opened each other."""
    outcome = run(asperity, "coupled", rough_case())
    assert outcome.status == 0 and int(outcome.positions[0]["contacts"]) > 500, outcome.message


@pytest.mark.parametrize("part, seed, was", [
    ("random", 12709, "one near pair far from its solution kept the steps of all contacts short"),
    ("random", 30977, "a pair of overlapping circles: 400 steps with a residual of 1e-6"),
    ("random", 704345, "a cap went to and fro between two places of touch"),
    ("random", 708618, "the same, 4023 caps"),
    ("random", 809716, "a step cut to a small circle at a large one's rim went up, and was cut on"),
    ("random", 807001, "the same, among 2115 caps"),
    ("random", 905849, "a small circle crept around a large one, as its shift was too stiff"),
    *(("stepped", seed, "the correction took more from a cap than that carries: a load above that "
       "of the isolated contact") for seed in (770008, 770021, 770037, 770055))])
def test_found_seed(part, seed, was, asperity):
    outcome = run(asperity, "coupled", OF_SEEDS[part](seed))
    assert outcome.status == 0, (was, outcome.message)


@pytest.mark.parametrize("seed, was", [
    (9750100, "a ring stiffer than its circle: rounds alternated"),
    (9750063, "a ring on cells, without the contact that it is around"),
    (9750137, "two circles for a contact and the wider ring around it"),
    (9850296, "two circles nearly in one place found one solution, then the other, by turns"),
    (9800246, "circles of a cluster were one, then two, by turns"),
])
def test_rings_on_boundary_elements(seed, was, asperity):
    """`circles and cells do not settle`."""
    outcome = run(asperity, "auto", OF_SEEDS["stepped"](seed))
    assert outcome.status == 0, (was, outcome.message)
