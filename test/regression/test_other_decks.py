"""Other decks in real64 against an independent restatement of what the program computes.

The restatement below is written from the geometry and Hertz's equations with whole arrays; it
shares the marching rule with the original, because the results depend on it.
"""


import numpy as np
import pytest

from decks import random_deck, write_deck
from programs import run_program
from surfaces_csv import records

INCH, PSI = 2.54, 0.6894
LIMIT = 65 * 9.8 / 2.205


def centres(model, angle, slopes, mirror_at, height_of):
    x, y, z = np.array(model["asperities"]).T
    u = x * np.cos(angle) - y * np.sin(angle)
    v = x * np.sin(angle) + y * np.cos(angle)
    if mirror_at is not None:
        v = mirror_at - v
    return INCH * u, INCH * v, INCH * (height_of(z) + u * slopes[0] + v * slopes[1])


def restate(upper, lower, width, angles, displacement):
    """Per position: steps, approach, contacts, load, area, projected area, limit reached."""
    ru, rl = INCH * upper["radius"], INCH * lower["radius"]
    xu, yu, zu = centres(upper, angles[0], (0.004, -0.00058), None,
                         lambda z: 0.5 + upper["radius"] - z)
    xl, yl, zl = centres(lower, angles[1], (-0.00067, -0.00045), width,
                         lambda z: z - lower["radius"])
    compliance = sum((1 - m["ratio"] ** 2) / (PSI * m["modulus"]) for m in (upper, lower))
    radius = ru * rl / (ru + rl)
    reach = 2 * np.sqrt(ru * INCH * max(upper["height_max"], lower["height_max"]))
    share = ru / (ru + rl)
    approach = 0.5 * INCH
    results = []
    for m in range(1, 101):
        xu = xu + 0.1
        plan = np.hypot(xu[:, None] - xl, yu[:, None] - yl)
        near = plan < reach
        gap = np.full(plan.shape, 100.0)
        gap[near] = ((zu[:, None] - zl)[near] - np.sqrt(ru ** 2 - (plan[near] * share) ** 2)
                     - np.sqrt(rl ** 2 - (plan[near] * (1 - share)) ** 2))
        order = np.argsort(gap, axis=None, kind="stable")[:len(xu)]
        least, j, k = gap.ravel()[order], *np.unravel_index(order, gap.shape)
        step = least[0]
        for count in range(1, 26):
            approach, zu, least = approach - step, zu - step, least - step
            touching = np.count_nonzero(least <= 0)
            loaded = least < 0
            d, rise = plan[j, k][loaded], (zu[j] - zl[k])[loaded]
            overlap = ru + rl - np.sqrt(d ** 2 + rise ** 2)
            area = 3.1416 * overlap * radius
            load = 4 / 3 / compliance * np.sqrt(radius) * overlap ** 1.5
            if np.any(load >= LIMIT):
                break
            following = least[touching] if touching < len(least) else 100.0
            step = min(following, 0.001)
        results.append((count, approach, touching, load.sum(), area.sum(),
                        (area / np.sqrt(1 + (d / rise) ** 2)).sum(), bool(np.any(load >= LIMIT))))
    return results


@pytest.mark.parametrize("seed", range(14))
def test_random_deck(seed, asperity, tmp_path):
    deck = random_deck(seed)
    path = write_deck(tmp_path / "random.deck", **deck)
    run_program(asperity, path, "--arithmetic", "real64", "--tables", "none", "--positions",
                tmp_path / "positions.csv")
    found = records(tmp_path / "positions.csv")
    expected = restate(**deck)
    names = ("steps", "approach", "contacts", "load", "area", "projected_area", "limit_reached")
    worst = 0.0
    for m, (want, row) in enumerate(zip(expected, found, strict=True), 1):
        assert float(row["x_displacement"]) == pytest.approx(
            INCH * deck["displacement"][0] + 0.1 * m, abs=1e-12)
        for name, value in zip(names, want):
            have = float(row[name])
            if name in ("steps", "contacts", "limit_reached"):
                assert have == value, f"position {m} {name}"
            else:
                worst = max(worst, abs(have - value) / abs(value))
    print(f"deck {seed}: largest relative difference {worst:.1e}")
    # W is known to about 4e-15 cm of 1e-2 cm; the sum of 100 positions' decrements adds its own.
    assert worst < 1e-9


@pytest.mark.parametrize("arithmetic", ("ibm370", "real32", "real128"))
def test_other_arithmetics_run_other_decks(arithmetic, asperity, tmp_path):
    path = write_deck(tmp_path / "random.deck", **random_deck(1))
    done = run_program(asperity, path, "--arithmetic", arithmetic)
    assert "TABLE VI\n" in done.stdout and "nan" not in done.stdout.lower()
