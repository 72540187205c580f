"""The rounding bound that `--accuracy` prints, against 60 digits, on scenes of steep contacts.

docs/reference/exit-status.md states the bound: it grows with the slope of a contact.
"""

import math
import random
import re

import pytest

from exact_contact import TOTALS, Truth
from surfaces_csv import exact_csv_scene, solve, write_csv_scene


def steep_scene(generator):
    """Pairs far from each other, whose slopes at first touch go up to the steepest."""
    unit = 10.0 ** generator.uniform(-6, 6)
    upper, lower = [], []
    offset = generator.choice((0.0, 10.0 ** generator.uniform(0, 3)))
    levels = []
    for k in range(generator.randint(1, 6)):
        a, b = (generator.uniform(0.5, 3.0) for _ in range(2))
        slope = generator.choice((generator.uniform(0, 1), 10 ** generator.uniform(-1, 1.3)))
        d = (a + b) * slope / math.hypot(1, slope)
        turn = generator.uniform(0, 2 * math.pi)
        # All begin at nearly the same separation.
        fall = (a + b) * (1 - 1 / math.hypot(1, slope))
        heights = [generator.uniform(0, 0.1) + fall / 2 - generator.uniform(0, 1e-3)
                   for _ in range(2)]
        heights = [min(h, 1.9 * r) for h, r in zip(heights, (a, b))]
        x, y = offset + 20.0 * k, offset
        upper.append((x + d * math.cos(turn), y + d * math.sin(turn), heights[0], a))
        lower.append((x, y, heights[1], b))
        levels.append(sum(heights) - fall)
    compression = 10.0 ** generator.uniform(-6, -1)
    control = generator.choice(("approach", "approach", "load", "vertical_load", "limit"))
    groups = {"loading": {"control": control}}
    if control == "approach":
        groups["loading"]["value"] = (max(levels) - compression) * unit
    elif control == "limit":
        groups["limit"] = {"criterion": "load", "value": 1e5 * compression**1.5 * unit**2}
    else:
        groups["loading"]["value"] = 1e5 * compression**1.5 * unit**2
    scale = [[tuple(c * unit for c in row) for row in rows] for rows in (upper, lower)]
    return *scale, groups


def blunt_scene(generator):
    """A large sphere on a small one, as a plane: its summit is near."""
    unit, large = 10.0 ** generator.uniform(-6, 6), 10.0 ** generator.uniform(0, 7)
    compression = 10.0 ** generator.uniform(-5, -2)
    lower = [(generator.uniform(-1, 1), generator.uniform(-1, 1), 0.1, generator.uniform(0.5, 2.0))]
    near = 0.5 * math.sqrt(compression * large)
    upper = [(*(c + generator.uniform(-near, near) for c in lower[0][:2]), 0.0, large)]
    groups = {"loading": generator.choice((
        {"control": "approach", "value": (0.1 - compression) * unit},
        {"control": "load", "value": 1e5 * compression**1.5 * unit**2}))}
    return *([tuple(c * unit for c in row) for row in rows] for rows in (upper, lower)), groups


def test_bound_of_blunt_contacts(asperity, tmp_path):
    """The bound holds, and does not grow with the radius of the larger sphere."""
    generator = random.Random(5)
    for number in range(40):
        upper, lower, groups = blunt_scene(generator)
        run = solve(asperity, write_csv_scene(tmp_path, upper, lower, name="blunt", **groups),
                    "--accuracy", "0.5")
        assert run.status == 0, run.stderr
        bound = float(re.search(r"error bound ([\d.E+-]+)", run.stdout)[1])
        state = Truth(exact_csv_scene(upper, lower, **groups), 60).state(1)
        for name in (*TOTALS, "separation"):
            true = getattr(state, name)
            error = abs(float((float(run.positions[0][name]) - true) / true)) if true else 0.0
            assert error <= bound < 1e-7, (number, name, error, bound)


@pytest.mark.parametrize("seed", range(40))
def test_bound_of_steep_contacts(seed, asperity, tmp_path):
    generator = random.Random(seed)
    steepest = 0.0
    for number in range(8):
        upper, lower, groups = steep_scene(generator)
        scene = write_csv_scene(tmp_path, upper, lower, name=f"steep{number}", **groups)
        run = solve(asperity, scene, "--accuracy", "0.5")
        if run.status == 1:
            continue  # centres come level, or the load cannot be carried
        assert run.status == 0, run.stderr
        bound = float(re.search(r"error bound ([\d.E+-]+)", run.stdout)[1])
        if groups["loading"]["control"] == "vertical_load":
            groups["loading"] = {"control": "approach",
                                 "value": float(run.positions[0]["separation"])}
        state = Truth(exact_csv_scene(upper, lower, **groups), 60).state(1)
        for name in (*TOTALS, "separation"):
            true = getattr(state, name)
            error = abs(float((float(run.positions[0][name]) - true) / true))
            assert error <= bound, (number, name, error, bound)
        steepest = max(steepest, *(float(row["slope"]) for row in run.contacts))
    assert steepest > 0.5
