"""The closed forms of the tests of ContactMechanics, with the tolerances of these tests.

Source: https://github.com/ContactEngineering/ContactMechanics, commit 40ad18e of 2026-07-28:
`ContactMechanics/ReferenceSolutions/Hertz.py`, `Westergaard.py`, `Cone.py`, and the tests
`test_reference_solutions.py`, `test_hertz.py`, `test_flat_punch.py`, `test_westergaard.py`,
`test_fft_elastic_half_space.py`, `test_plastic.py`. Grids and loads are our own.
"""

import math

import numpy as np
from comparisons import Suite, last_contact, pixels, spheres

BALL, BALL_MODULUS, SIDE = 20.0, 102.0, 5.0


def hertz(found):
    """Hertz.py: load, radius of contact and greatest pressure of a penetration."""
    contact = last_contact(spheres(0.6507879989531481, 4.0, 5.0))
    # The three numbers that test_Hertz_refVals prints, to its 1e-7.
    for name, expected, value in (
            ("load", 7.0, contact["load"]),
            ("radius", 1.6134286460245437, contact["contact_radius"]),
            ("pressure", 1.2839257217043503, contact["maximum_pressure"])):
        found.within(f"test_Hertz_refVals, {name}", expected, value, 1e-7)
    for radius, modulus in ((1.0, 1.0), (12.5, 3.0e4), (0.02, 2.1e5)):
        for depth in (1e-5, 1e-4, 1e-3, 1e-2):
            delta = depth * radius
            contact = last_contact(spheres(delta, radius, modulus))
            for name, expected, value in (
                    ("load", 4 / 3 * modulus * math.sqrt(delta**3 * radius), contact["load"]),
                    ("area", math.pi * radius * delta, contact["area"]),
                    ("pressure", 2 * modulus / math.pi * math.sqrt(delta / radius),
                     contact["maximum_pressure"])):
                found.within(f"Hertz, R {radius}, E {modulus}, depth {depth}, {name}", expected,
                             value, 1e-10)


def ball_on_pixels(found):
    """test_hertz.py on smaller grids: penetration given, then load."""
    for rows, columns in ((128, 128), (128, 127), (127, 128)):
        x = (np.arange(columns) - columns // 2) * SIDE / columns
        y = (np.arange(rows) - rows // 2) * SIDE / rows
        square = x[None, :]**2 + y[:, None]**2
        for control, value in (("separation", -0.1), ("load", 15.0)):
            results = pixels(np.sqrt(BALL**2 - square) - BALL, (SIDE / columns, SIDE / rows),
                             BALL_MODULUS, control, value)
            states = {name: column[-1] for name, column in results.states.items()}
            load, depth = states["load"], -states["separation"]
            given = 0.1 if control == "separation" else (9 * value**2 / (
                16 * BALL * BALL_MODULUS**2))**(1 / 3)
            radius = BALL * (0.75 * load / (BALL_MODULUS * BALL**2))**(1 / 3)
            name = f"test_hertz, {rows} x {columns}, {control}"
            found.within(f"{name}, penetration", given, depth, 1e-2)
            found.within(f"{name}, load", 4 / 3 * BALL_MODULUS * math.sqrt(given**3 * BALL), load,
                         1e-2)
            found.within(f"{name}, area", math.pi * radius**2, states["area"], 1e-1)
            found.within(f"{name}, energy", 8 / 15 * math.sqrt(BALL) * BALL_MODULUS * given**2.5,
                         states["elastic_energy"], 1e-2)
            greatest = 1.5 * load / (math.pi * radius**2)
            inside = square < (0.99 * radius)**2
            exact = greatest * np.sqrt(1 - square[inside] / radius**2)
            pressure = np.asarray(results.fields().pressure)[inside]
            found.near(f"{name}, largest difference of pressure over the modulus", 0.0,
                       np.abs(pressure - exact).max() / BALL_MODULUS, 1e-3)


def punch(found):
    """test_flat_punch.py: stiffness of a rigid punch over 2 a E*, to two decimals."""
    for rows in (127, 128):
        for columns in (127, 128):
            for control, value in (("load", 15.0), ("separation", -0.1)):
                y = (np.arange(rows) - rows // 2) * 50.0 / rows
                x = (np.arange(columns) - columns // 2) * 50.0 / columns
                flat = np.where(x[None, :]**2 + y[:, None]**2 > 400.0, np.nan, 0.0)
                states = pixels(flat, (50.0 / columns, 50.0 / rows), 3.56, control, value).states
                found.near(f"test_flat_punch, {rows} x {columns}, {control}", 1.0,
                           states["load"][-1] / -states["separation"][-1] / (40.0 * 3.56), 1.5e-2)


def westergaard(found):
    """Westergaard.py: a cosine under a flat, by the half width of contact over its period."""
    period, modulus, count = 30.0, 3.56, 256
    phase = np.arange(count) / count
    heights = np.resize(np.cos(2 * math.pi * phase), (4, count))
    distance = np.minimum(phase, 1 - phase)
    full = math.pi * modulus / period
    for half in (0.05, 0.1, 0.2, 0.3, 0.4):
        share = math.sin(math.pi * half)**2
        results = pixels(heights, (period / count, period / count), modulus, "pressure",
                         share * full, periodic=True)
        states = {name: column[-1] for name, column in results.states.items()}
        inside = np.maximum(share - np.sin(math.pi * distance)**2, 0.0)
        exact = 2 * full * np.cos(math.pi * distance) * np.sqrt(inside)
        pressure = np.asarray(results.fields().pressure)[0]
        name = f"Westergaard, a {half}"
        found.near(f"{name}, largest difference of pressure", 0.0, np.abs(pressure - exact).max(),
                   1e-2)
        found.near(f"{name}, share of contact", 2 * half, (pressure > 0).mean(), 1.0 / count)
        found.near(f"{name}, mean gap over 2 h",
                   math.cos(math.pi * half)**2 / 2 + share * math.log(math.sin(math.pi * half)),
                   states["mean_gap"] / 2, 1e-3)
        found.within(f"{name}, elastic energy", (1 / 4 - math.log(share) / 2) * share**2 * full,
                     states["elastic_energy"] / (period * 4 * period / count), 1e-2)


def waves(found):
    """Full contact with a wave: its pressure is E q h/2 cos(q x), to the 1e-7 of unit neutrality
    in test_fft_elastic_half_space.py."""
    for rows, columns, k_x, k_y in ((64, 32, 1, 0), (64, 32, 0, 3), (64, 32, 2, 5), (65, 33, 1, 0),
                                    (65, 33, 0, 3), (65, 33, 3, 7)):
        spacing = (0.7, 0.4)
        angle = 2 * math.pi * (k_x * np.arange(columns)[None, :] / columns
                               + k_y * np.arange(rows)[:, None] / rows)
        number = 2 * math.pi * math.hypot(k_x / (columns * spacing[0]), k_y / (rows * spacing[1]))
        amplitude = 0.5 * 50.0 * number * 0.1
        pressure = np.asarray(pixels(0.1 * np.cos(angle), spacing, 50.0, "pressure",
                                     1.5 * amplitude, periodic=True).fields().pressure)
        found.near(f"wave {k_x}, {k_y} of {rows} x {columns}", 0.0,
                   np.abs(pressure / amplitude - 1.5 - np.cos(angle)).max(), 1e-7)


def cone(found):
    """Cone.py: F/(E A) = tan(beta)/2 and radius over penetration 2/(pi tan(beta)); the grid of 129
    pixels resolves a circle to 3 %."""
    count, side = 129, 2.0
    x = (np.arange(count) - count // 2) * side / count
    distance = np.hypot(x[None, :], x[:, None])
    for slope in (0.02, 0.05, 0.1):
        states = {name: column[-1] for name, column in pixels(
            -slope * distance, (side / count, side / count), 1e4, "separation",
            -slope).states.items()}
        radius = 2 / math.pi
        found.within(f"Cone, slope {slope}, area", math.pi * radius**2, states["area"],
                     3e-2)
        found.within(f"Cone, slope {slope}, load", 1e4 * slope / 2 * math.pi * radius**2,
                     states["load"], 1e-2)


def bearing_area(found):
    """test_hard_wall_bearing_area: at a hardness far below the elastic pressure the contact is the
    set of the highest pixels; a load of n pixels at the hardness takes the n highest."""
    rng = np.random.default_rng(7)
    heights = rng.normal(size=(48, 48))
    order = np.argsort(-heights, axis=None)
    for number in (20, 100, 500, 1500):
        results = pixels(heights, (1.0, 1.0), 1e6, "load", number * 1e-6, periodic=True,
                         plastic_hardness=1e-6)
        inside = np.asarray(results.fields().pressure).ravel() > 0
        found.count(f"test_hard_wall_bearing_area, {number} pixels, those that differ", 0,
                    number - inside[order[:number]].sum())


def suite():
    found = Suite("ContactMechanics", "closed forms of its tests, with the tolerances there")
    for part in (hertz, ball_on_pixels, punch, westergaard, waves, cone, bearing_area):
        part(found)
    return found
