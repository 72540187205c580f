"""The same ball as a row of a table and as pixels: what is prescribed without time, or cannot be
estimated, is the same in both."""

import re

import numpy as np
import pytest

from map_scenes import map_scene, numbers
from surfaces_csv import solve, write_scene

SIDE, PIXELS, RADIUS, MODULUS = 0.05, 64, 10.0, 1e3


def as_pixels(asperity, folder, effects, load, **loading):
    x = (np.arange(PIXELS) - PIXELS // 2) * SIDE
    height = -(x[:, None]**2 + x[None, :]**2) / (2 * RADIUS)
    return solve(asperity, map_scene(
        folder, height, (SIDE, SIDE), material=MODULUS, interaction="auto", by_default=True,
        surfaces={"map_level": "none"}, effects=effects,
        loading={"control": "load", "value": load, **loading}))


def as_table(asperity, folder, effects, load, **loading):
    (folder / "ball.csv").write_text(f"x,y,height,radius\n0,0,0.5,{RADIUS}\n")
    return solve(asperity, write_scene(
        folder / "ball.scene", by_default=True,
        surfaces={"upper": "plane", "lower": "ball.csv"},
        material={"contact_modulus": MODULUS}, effects={"interaction": "auto", **effects},
        loading={"control": "load", "value": load, **loading}))


@pytest.mark.parametrize("run", [as_table, as_pixels])
def test_creep_of_no_time(run, asperity, tmp_path):
    """Relaxed at once: under a held load the compression is r**(-2/3) times the elastic one."""
    elastic, crept = (float(run(asperity, tmp_path, effects, 20.0).positions[0]["compression"])
                      for effects in ({}, {"relaxation_time": 0.0, "relaxed_modulus_ratio": 0.5,
                                           "hold_time": 2.0}))
    assert abs(crept / elastic / 2**(2 / 3) - 1) < 0.02


def test_influence_of_creep(asperity, tmp_path):
    """The estimate of creep that is off: 1 - E(t)/E(0) = (1 - r)(1 - exp(-t/tau)), here below a
    half, over E(t)/E(0); both models have it."""
    left = (1 - 0.9) * (1 - np.exp(-2.0))
    effects = {"relaxation_time": 1.0, "relaxed_modulus_ratio": 0.9, "hold_time": 2.0,
               "creep": "off"}
    for run in (as_table, as_pixels):
        position = numbers(run(asperity, tmp_path, effects, 20.0).positions[0])
        assert abs(position["creep_estimate"] / (left / (1 - left)) - 1) < 1e-12


def test_yield_of_pixels(asperity, tmp_path):
    """A yield stress on a map: the greatest pressure of Hertz over that of first yield, 1.295 of
    the stress (Jackson and Green 2005, Poisson's ratio 0), in both models to the digits printed; of
    pixels to 1.6 times the printed error of their greatest pressure."""
    load = 20.0
    stress = (6 * load * MODULUS**2 / (np.pi**3 * RADIUS**2))**(1 / 3) / 1.295 / 2
    found = []
    for run in (as_table, as_pixels):
        done = run(asperity, tmp_path, {"plastic_yield_stress": float(stress)}, load)
        line, = (line for line in done.stderr.splitlines() if "loaded beyond yield" in line)
        found.append(float(re.search(r", ([\d.]+) times the average pressure", line)[1]))
    error = float(done.positions[0]["pressure_error_estimate"])
    assert abs(found[0] - 2) <= 0.005 and abs(found[1] - 2) <= 0.005 + 3.2 * error


def test_conductances_have_a_line(asperity, tmp_path):
    """A conductance that the scene asks for is in the summary: 4 a over the sum of the
    resistivities, 0.4, of a circle (Holm 1967)."""
    x = (np.arange(PIXELS) - PIXELS // 2) * SIDE
    done = solve(asperity, map_scene(
        tmp_path, -(x[:, None]**2 + x[None, :]**2) / (2 * RADIUS), (SIDE, SIDE),
        material={"contact_modulus": MODULUS, "electrical_conductivity": (5.0, 5.0)},
        surfaces={"map_level": "none", "units": ("m", "N")},
        loading={"control": "load", "value": 20.0}))
    line, = (line for line in done.stdout.splitlines() if line.startswith("electrical conductance"))
    radius = (0.75 * 20.0 * RADIUS / MODULUS)**(1 / 3)
    assert abs(float(line.split()[3]) / (4 * radius / 0.4) - 1) < 0.05, line


def test_every_position_has_its_window(asperity, tmp_path):
    """Free maps over each other: their window is the load over the pressure, at one position and at
    two."""
    rng = np.random.default_rng(3)
    q = np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(32)]))
    height = 0.02 * np.fft.ifft2(
        np.fft.fft2(rng.normal(size=(32, 32))) * np.exp(-(q / 0.12)**2)).real
    for positions in (1, 2):
        scene = map_scene(tmp_path, height, (1.0, 1.0), material=MODULUS,
                          motion={"x_first": 3.0, "x_step": 2.0, "positions": positions},
                          loading={"control": "pressure", "value": 0.3})
        text = scene.read_text()
        scene.write_text(text.replace("upper = 'plane'", "upper = 'map.txt'"))
        for row in map(numbers, solve(asperity, scene).positions):
            assert abs(row["nominal_pressure"] / 0.3 - 1) < 1e-9
            assert abs(row["area_fraction"] / (row["area"] * 0.3 / row["load"]) - 1) < 1e-9
