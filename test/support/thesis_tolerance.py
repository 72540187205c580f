"""How far another arithmetic may be from a printed cell: what the original's rounding explains."""

import math

COMBINED_RADIUS = 0.635  # cm: two spheres of 1.27 cm
# One unit in the last place of a System/370 short number between 1 and 16: the size of the
# sphere centres' heights and of their distance, from which the original takes its overlap W.
UNIT = 16.0 ** -5
POSITION = {"VIIA": 13, "VIIB": 55, "VIIC": 56}


def half_unit(text):
    """Half a unit in the last printed place."""
    return 0.5 * 10.0 ** -len(text.partition(".")[2])


def overlap_error(step):
    """Largest error of the original's W at a step of a position, cm (fault 3).

    W is RL + RU - SQRT(DIST**2 + Z**2): six operations on numbers of this size, each cut by up to
    a unit; and each step so far has cut up to a unit off the height of a centre.
    """
    return (6 + step) * UNIT


def approach_error(position):
    """Largest error of the original's approach at a position, cm (fault 2).

    Half a unit is cut off on average at each of about 16 steps of every position so far.
    """
    return 0.5 * UNIT * 16 * position


def exact_everywhere(cell):
    """Cells that every arithmetic must print as the thesis does: displacements and zeros."""
    return cell.table.endswith("heading") or cell.text in ("0.0", "0.")


def tolerance(cell, number):
    """How far real64 may be from the exact value behind the original's printed number.

    `real32` and `real128` are held to the same.
    """
    row, column = cell.row, cell.column
    if cell.table == "VI":
        return approach_error(100) if row["quantity"] == "approach" else 2.0e-3 * number
    if not cell.table.startswith("VII"):
        return 0.0
    if column == "approach":
        return approach_error(POSITION[cell.table])
    area_error = math.pi * COMBINED_RADIUS * overlap_error(cell.step)
    if column in ("area", "projected_area"):
        return cell.contacts * area_error
    if column in ("load", "average_pressure", "maximum_pressure"):
        # Pressure goes with the root of W, load with its power 1.5. A total is dominated by its
        # larger contacts, so the error of the mean contact stands for all.
        area = row["area"] if row["area"] != "?" else row["projected_area"]
        power = 1.5 if column == "load" else 0.5
        return number * power * cell.contacts * area_error / float(area)
    return 0.0
