"""Coverage of the error estimates of pixels, on 22 kinds of maps; some rules were chosen with it.

    python test/bench/pixel_estimates.py [--seeds 6] [--pixels 48] [--save]

Each map is solved on its pixels under three loads, the second with friction and a tangential load,
at one separation and at one compression; with an effect, at three loads. The true error, relative
to what is printed, is the difference from the
closed form (heads that are powers of the radius, cylinders) or from the same surface on pixels a
quarter as wide. With --save the table goes to
reference_output/bench/pixel_estimates.csv.
"""

import argparse
import csv
import io
import tempfile
from functools import partial
from math import gamma, pi, sqrt
from pathlib import Path

import numpy as np
from builds import build
from whole_runs import KEPT, Failed, heading, press_map

E, FINER, ROUNDING = 2.0, 4, 1e-9
RATIO, FRICTION = 0.3, 0.25
BODIES = ", ".join(f"{name} = {value!r}, {value!r}" for name, value in (
    ("elastic_modulus", 2 * E * (1 - RATIO**2)), ("poisson_ratio", RATIO)))
QUANTITIES = {"separation": "separation_error_estimate", "compression": "error_estimate",
              "area": "area_error_estimate",
              "mean_gap": "gap_error_estimate", "pressure": "pressure_error_estimate",
              "contact_stiffness": "stiffness_error_estimate",
              "interface_stiffness": "interface_error_estimate",
              "conductance_length": "conductance_error_estimate",
              "tangential_stiffness_xx": "sticking_error_estimate",
              "tangential_stiffness_yy": "sticking_error_estimate",
              "tangential_stiffness": "slip_error_estimate", "stick_area": "stick_error_estimate",
              "load": "error_estimate", "load at a compression": "error_estimate"}


def spectrum(random, pixels, hurst, shortest, stretch=1.0):
    """A random self-affine surface without waves shorter than `shortest` pixels of the coarse map,
    on the fine pixels; `stretch` > 1 draws it out along y."""
    n = FINER * pixels
    k = np.fft.fftfreq(n) * FINER
    q = np.hypot(k, stretch * k[:, None])
    scale = np.where((q >= 2 / pixels) & (q <= 1 / shortest), np.maximum(q, 1e-9)**(-1 - hurst), 0)
    return np.fft.ifft2(scale * np.fft.fft2(random.standard_normal((n, n)))).real


def bumps(random, pixels):
    """Gaussian hills at random places, widths of 2 to 5 pixels; periodic."""
    n = FINER * pixels
    x = np.arange(n) / FINER
    height = np.zeros((n, n))
    for _ in range(40):
        place, width = random.uniform(0, pixels, 2), random.uniform(2, 5)
        d = [(x - p + pixels / 2) % pixels - pixels / 2 for p in place]
        height += random.uniform(0.5, 1) * width * np.exp(
            -(d[0]**2 + d[1][:, None]**2) / (2 * width**2))
    return height


def caps(random, pixels):
    """The upper envelope of spherical caps, with kinks between them; periodic."""
    n = FINER * pixels
    x = np.arange(n) / FINER
    height = np.full((n, n), -np.inf)
    for _ in range(30):
        place = random.uniform(0, pixels, 2)
        d = [(x - p + pixels / 2) % pixels - pixels / 2 for p in place]
        height = np.maximum(height, random.uniform(0, 0.5) - (
            d[0]**2 + d[1][:, None]**2) / (2 * random.uniform(5, 40)))
    return height


def grooves(random, pixels, along):
    """Waves of a turned surface, crests along the rows or a few rows aslant, with a little waviness
    across; periodic."""
    n = FINER * pixels
    x = np.arange(n) / n
    turns = 0 if along else random.integers(1, 4)
    number = random.integers(3, 7)
    wave = np.cos(2 * pi * (turns * x + number * x[:, None] + random.random()))
    return wave + random.uniform(0, 0.3) * np.cos(2 * pi * (2 * x + random.random()))


def skewed(random, pixels):
    """The exponential of a random surface: plateaus with deep valleys."""
    wide = spectrum(random, pixels, 0.8, random.uniform(6, 16))
    return -np.exp(-wide / spectrum(random, pixels, 0.8, 8).std())


def ridges(random, pixels):
    """Rounded ridges a few rows aslant, of heights that vary along them; periodic."""
    n = FINER * pixels
    x = np.arange(n) / n
    turns, number = random.integers(0, 4), random.integers(2, 5)
    across = np.sin(pi * (turns * x + number * x[:, None] + random.random()))
    return -np.hypot(across, random.uniform(0.2, 0.5)) + random.uniform(0, 0.2) * np.cos(
        2 * pi * (random.integers(1, 4) * x + random.random()))


def crates(random, pixels):
    """Waves along rows and columns, or one aslant; periodic."""
    x = np.arange(FINER * pixels) / (FINER * pixels)
    k, phase = random.integers(2, 7, 2), random.random(2)
    waves = [np.cos(2 * pi * (k * x + p)) for k, p in zip(k, phase)]
    if random.random() < 0.5:
        return np.cos(2 * pi * (k[0] * x + k[1] * x[:, None] + phase[0]))
    return waves[0] + random.uniform(0.3, 1) * waves[1][:, None]


def smoothed(random, pixels):
    """A surface that is rough down to half a pixel, smoothed by a Gaussian with half its height at
    waves of three pixels, as a measured one is."""
    rough = spectrum(random, pixels, random.uniform(0.4, 0.9), 0.5)
    k = np.fft.fftfreq(FINER * pixels) * FINER
    return np.fft.ifft2(np.fft.fft2(rough) * 2.0**-(9 * (k**2 + k[:, None]**2))).real


def sampled(fine):
    """The heights in the middle of pixels, whose sides are sides of the fine ones: a free edge is
    at the same place. The surface is of waves, and periodic."""
    k = np.fft.fftfreq(len(fine)) * pi * (FINER - 1)
    turned = np.fft.fft2(fine) * np.exp(1j * (k + k[:, None]))
    return np.fft.ifft2(turned).real[::FINER, ::FINER]


def without(random, height, fine):
    """Leave out six squares of two pixels."""
    for i, j in random.integers(0, len(height) - 2, (6, 2)):
        height[i:i + 2, j:j + 2] = np.nan
        fine[FINER * i:FINER * (i + 2), FINER * j:FINER * (j + 2)] = np.nan


EDGES = {"free edges": "free", "strips": ("free", "periodic"), "missing pixels": "free"}


def effect_of(kind, random, fine, slope):
    """The names in &effects of an effect that is on."""
    if kind == "plasticity":
        return f", plasticity = 'on', plastic_hardness = {E * slope * random.uniform(0.2, 1)!r}"
    if kind == "adhesion":
        reach = float(fine.std()) * random.uniform(0.05, 0.3)
        return (f", adhesion = 'on', equilibrium_distance = {reach / 0.9743!r}, "
                f"work_of_adhesion = {random.uniform(0.05, 0.55) * E * reach**2!r}")
    if kind == "creep":
        return (", creep = 'on', hold_time = 3., relaxation_time = 1., hold_points = 4, "
                f"relaxed_modulus_ratio = {random.uniform(0.3, 0.9)!r}")
    return ""


def usual(random, pixels):
    return spectrum(random, pixels, 0.8, random.uniform(5, 14))


MAPS = {
    "self-affine, H 0.3": lambda r, n: spectrum(r, n, 0.3, r.uniform(4, 12)),
    "self-affine, H 0.5": lambda r, n: spectrum(r, n, 0.5, r.uniform(4, 12)),
    "self-affine, H 0.95": lambda r, n: spectrum(r, n, 0.95, r.uniform(3, 12)),
    "drawn out 1:4": lambda r, n: spectrum(r, n, 0.8, r.uniform(3, 8), 4.0),
    "skewed heights": skewed, "hills": bumps,
    "caps with kinks": caps,
    "grooves aslant": lambda r, n: grooves(r, n, False),
    "grooves along rows": lambda r, n: grooves(r, n, True),
    "rough at the pixels": lambda r, n: spectrum(r, n, r.uniform(0.3, 0.9), 0.5),
    "ridges": ridges, "crates and waves aslant": crates, "smoothed to three pixels": smoothed,
    "two scales": lambda r, n: spectrum(r, n, 0.8, r.uniform(12, 20)) / n + 0.2 * spectrum(
        r, n, 0.6, r.uniform(3, 6)) / n,
    "exponential heights": lambda r, n: -1 / skewed(r, n), "dimples": lambda r, n: -bumps(r, n),
    "plateaus": lambda r, n: np.tanh(1.2 * (lambda h: h / h.std())(usual(r, n))),
    "missing pixels": usual, "free edges": usual, "strips": usual,
    "plasticity": usual, "adhesion": usual, "creep": usual}


def solve(asperity, folder, height, spacing, edge, control, value, effects="", pull=None):
    """The numbers of the position that are there, and the greatest pressure of its last state;
    with friction under a tangential load along x and y."""
    slip = {} if pull is None else {
        "material": BODIES, "loading": f", tangential_load = {pull[0]!r}, {pull[1]!r}"}
    if slip:
        effects += f", friction_coefficient = {FRICTION}"
    np.savetxt(folder / "m.txt", height, fmt="%.17g")
    _, _, (row,), contacts = press_map(
        asperity, folder / "m.txt", [value], "--quiet", control=control, spacing=spacing, edge=edge,
        modulus=E, level="none", files=("positions", "contacts"), effects=effects, **slip)
    found = {name: float(row[name]) for name in {*QUANTITIES, *QUANTITIES.values()} & {*row}
             if row[name]}
    found["pressure"] = max(float(one["maximum_pressure"]) for one in contacts
                            if one["step"] == contacts[-1]["step"])
    return found


def power_head(random, pixels, power):
    """The head h = -c r**n: height, load, separation and area at a contact radius of 2 to 16
    pixels (Galin 1946, Sneddon 1965); the cone has n = 1."""
    spacing = 1 / random.uniform(2, 16)
    x, y = (np.arange(pixels) - pixels / 2 + random.random(2)[:, None]) * spacing
    c = 0.02
    deep = c * sqrt(pi) * gamma(power / 2 + 1) / gamma((power + 1) / 2)
    height = -c * np.hypot(x, y[:, None])**power
    return height, spacing, 2 * E * power / (power + 1) * deep, -deep, pi


def cases(runs, seeds, pixels):
    """Kind, quantity, true error and estimate of each map, load and separation."""
    for power in (1, 2, 3, 4):
        random = np.random.default_rng(6500 + power)
        for _ in range(3 * seeds):
            height, spacing, load, level, area = power_head(random, pixels, power)
            found = runs(height, spacing, "free", "load", load)
            kind = {1: "cones", 2: "balls"}.get(power, f"heads r**{power}")
            yield (kind, "separation", abs(found["separation"] - level) / found["compression"],
                   found["separation_error_estimate"])
            yield (kind, "compression", abs(found["compression"] + level) / found["compression"],
                   found["error_estimate"])
            yield kind, "area", abs(found["area"] / area - 1), found["area_error_estimate"]
            yield (kind, "contact_stiffness", abs(2 * E / found["contact_stiffness"] - 1),
                   found["stiffness_error_estimate"])
            found = runs(height, spacing, "free", "separation", level)
            yield kind, "load", abs(load / found["load"] - 1), found["error_estimate"]
            found = runs(height, spacing, "free", "compression", -level)
            if "error_estimate" in found:  # the top lies between pixels that are not in contact
                yield (kind, "load at a compression", abs(load / found["load"] - 1),
                       found["error_estimate"])
    for number, (kind, make) in enumerate(MAPS.items()):
        for seed in range(seeds):
            random = np.random.default_rng([65, number, seed])
            fine = make(random, pixels)
            slope = sqrt(sum((np.diff(fine, axis=a)**2).mean() for a in (0, 1))) * FINER
            coarse = sampled(fine) if kind in EDGES else fine[::FINER, ::FINER]
            if kind == "missing pixels":
                without(random, coarse, fine)
            edge, effects = EDGES.get(kind, "periodic"), effect_of(kind, random, fine, slope)
            for turn, fraction in enumerate(10 ** random.uniform([-1.8, -1.2, -0.6],
                                                                 [-1.2, -0.6, -0.2])):
                load = float(fraction * E * slope / 2 * pixels**2)
                pull = random.uniform(0.1, 0.6, 2) * FRICTION * load
                pull = None if turn != 1 or kind == "creep" else pull.tolist()
                try:
                    true = runs(fine, 1 / FINER, edge, "load", load, effects, pull)
                    found = runs(coarse, 1.0, edge, "load", load, effects, pull)
                except Failed:  # beyond the hardness
                    continue
                for quantity in QUANTITIES:
                    # The pressure of a rough map; the gap of a state in full contact; a stiffness
                    # of a strip; what slides.
                    if "load" in quantity or not found.get(quantity) or not true.get(quantity) \
                            or QUANTITIES[quantity] not in found:
                        continue
                    size = found["compression" if quantity == "separation" else quantity]
                    yield (kind, quantity, abs(found[quantity] - true[quantity]) / size,
                           found[QUANTITIES[quantity]])
            if effects or kind == "strips":  # a strip has a load alone
                continue
            found = runs(coarse, 1.0, edge, "separation", true["separation"])
            yield (kind, "load", abs(load / found["load"] - 1), found["error_estimate"])
            try:
                found = runs(coarse, 1.0, edge, "compression", true["compression"])
            except Failed:  # beyond full contact of these pixels
                continue
            if "error_estimate" in found:
                yield (kind, "load at a compression", abs(load / found["load"] - 1),
                       found["error_estimate"])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--pixels", type=int, default=48)
    parser.add_argument("--save", action="store_true")
    words = parser.parse_args()
    ratios = {}
    with tempfile.TemporaryDirectory() as folder:
        for kind, quantity, error, estimate in cases(
                partial(solve, build("release"), Path(folder)), words.seeds, words.pixels):
            if error <= ROUNDING and estimate <= 0:
                continue  # a pressure that is the hardness is exact
            for key in ((kind, quantity), ("all", quantity)):
                ratios.setdefault(key, []).append(
                    error / estimate if estimate > 0 else float(error > ROUNDING))
    buffer = io.StringIO()
    buffer.write(f"{heading()}pixel_estimates.py --seeds {words.seeds} --pixels {words.pixels}\n")
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(("kind", "quantity", "errors", "below_estimate_percent",
                     "median_estimate_over_error", "largest_error_over_estimate"))
    for (kind, quantity), values in sorted(ratios.items(), key=lambda one: one[0][::-1]):
        values = np.array(values)
        writer.writerow((kind, quantity, len(values), f"{100 * (values <= 1).mean():.1f}",
                         f"{1 / max(np.median(values), ROUNDING):.2g}", f"{values.max():.2g}"))
    print(buffer.getvalue(), end="")
    if words.save:
        (KEPT / "pixel_estimates.csv").write_text(buffer.getvalue(), encoding="ascii")


if __name__ == "__main__":
    main()
