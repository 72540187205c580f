"""What `auto` leaves out: on random maps the result by default is that with the effects on, within
the tolerance, or the effect is named; a number below the tolerance changes no digit."""

import numpy as np
import pytest

from map_scenes import map_scene, numbers
from surfaces_csv import solve

TOLERANCE = 1e-2  # of `auto` by default
MODULUS = 1e3
RANGE = 9 * 3**0.5 / 16  # of the exponential law over the equilibrium distance


def random_map(rng):
    """Heights with a random spectrum and rms slope; whether they are periodic."""
    pixels = int(rng.choice([24, 32]))
    q = np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(pixels)]))
    q[0, 0] = 1
    keeps = (q <= 1 / rng.uniform(4, 8)) & (q >= 1 / rng.uniform(10, pixels))
    height = np.fft.ifft2(np.where(keeps, q**-(1 + rng.uniform(0.3, 1)), 0) *
                          np.fft.fft2(rng.standard_normal((pixels, pixels)))).real
    slope = rng.uniform(0.02, 0.2)
    steps = np.gradient(height)
    height *= slope / np.sqrt(np.mean(steps[0]**2 + steps[1]**2))
    return height, slope, bool(rng.integers(2))


def random_effects(rng, height, slope):
    """Numbers of one effect or two, over decades of their influence. The pixels resolve the
    attraction: its steepness w/(range**2 E) is at most 1."""
    reach = np.std(height) * 10**rng.uniform(-1.5, 0.7)
    every = {"adhesion": {"work_of_adhesion": float(10**rng.uniform(-5, -0.9) * reach**2 * MODULUS),
                          "equilibrium_distance": float(reach / RANGE),
                          "adhesion_law": str(rng.choice(["exponential", "van_der_waals"]))},
             "creep": {"hold_time": float(10**rng.uniform(-1, 1)), "relaxation_time": 1.0,
                       "relaxed_modulus_ratio": float(1 - 10**rng.uniform(-3, -0.1))},
             "plasticity": {"plastic_hardness": float(MODULUS * slope * 10**rng.uniform(0, 0.7))}}
    return {name: every[name] for name in
            map(str, rng.choice(list(every), rng.integers(1, 3), replace=False))}


def judge(asperity, folder, seed):
    """Solves a scene by default and with its effects on. The number of effects left out."""
    rng = np.random.default_rng(seed)
    height, slope, periodic = random_map(rng)
    effects = random_effects(rng, height, slope)
    given = {key: value for group in effects.values() for key, value in group.items()}
    pressure = float(MODULUS * slope * 10**rng.uniform(-3.5, -0.1))

    def run(**words):
        done = solve(asperity, map_scene(
            folder, height, (1.0, 1.0), material=MODULUS, interaction="auto", by_default=True,
            surfaces={"map_edge": "periodic" if periodic else "free"},
            loading={"control": "pressure", "value": pressure}, effects={**given, **words}))
        return done, numbers(done.positions[0]) if done.positions else None

    done, default = run()
    if default is None:
        # The hardness carries no more.
        assert "plastic_hardness times the measured area" in done.stderr, (seed, done.stderr)
        return 0
    left = [name for name in effects if default[name] == "off"]
    named = [name for name in left if f"{name} is left out" in done.stderr]
    assert all(f"\n{name} " in done.stdout for name in effects), (seed, done.stdout)
    other, on = run(**{name: "on" for name in effects})
    if on is None:
        assert "too wide for the range of adhesion" in other.stderr and left, (seed, other.stderr)
        return len(left)
    for column in ("area", "compression", "load"):
        change = abs(default[column] / on[column] - 1)
        # The area is that of whole pixels and their rims: two more of them may close or open.
        step = 2 / on["samples_in_contact"] if column == "area" else 0
        assert change <= TOLERANCE + step or named, (seed, left, column, change)
    return len(left)


def judge_all(asperity, folder, seeds):
    left = sum(judge(asperity, folder, seed) for seed in seeds)
    assert 0.1 * len(seeds) < left < len(seeds), left


def test_default_is_on_or_named(asperity, tmp_path):
    judge_all(asperity, tmp_path, range(40))


@pytest.mark.long
def test_default_is_on_or_named_often(asperity, tmp_path):
    judge_all(asperity, tmp_path, range(40, 340))


def test_left_out_changes_no_digit(asperity, tmp_path):
    """Adhesion and creep far below the tolerance: the solution is the one without their numbers."""
    height, slope, _ = random_map(np.random.default_rng(3))
    rows = []
    for effects in ({}, {"work_of_adhesion": 1e-9, "equilibrium_distance": 0.1},
                    {"hold_time": 1.0, "relaxation_time": 1.0, "relaxed_modulus_ratio": 1 - 1e-6}):
        done = solve(asperity, map_scene(
            tmp_path, height, (1.0, 1.0), material=MODULUS, interaction="auto", by_default=True,
            effects=effects,
            loading={"control": "pressure", "value": 0.05 * MODULUS * slope}))
        rows.append({key: done.positions[0][key] for key in (
            "load", "area", "separation", "mean_gap", "area_error_estimate",
            "interaction_iterations")})
    assert rows[0] == rows[1] == rows[2]
