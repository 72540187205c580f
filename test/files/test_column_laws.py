"""Every number of the tables of `asperity solve` is computed or empty: random scenes, all columns.

Each column has a law: its definition from the surfaces and from other columns, or where it is empty
and where it may be 0. A column without a law here fails.
"""

import math
import random
from collections import defaultdict

import pytest
import csv_rows
from programs import run_program
from surfaces_csv import write_surface
from test_written_defaults import FILES, NUMBERS, random_scene, write

pytestmark = pytest.mark.fuzz

SCENES = 300
EFFECTS = (*NUMBERS, "interaction")
EMPTY = None
PIXELS_AREA = 16.0  # of the maps


def close(value, expected, scale=0.0):
    """Equal to rounding, or of sums of numbers of a scale."""
    return value is not None and math.isclose(value, expected, rel_tol=1e-8, abs_tol=1e-9 * scale)


class Scene:
    """The tables of a solved scene, with the numbers of its surfaces."""

    def __init__(self, scene, caps, tables):
        self.scene, self.effects, self.loading = scene, scene["effects"], scene["loading"]
        self.is_map = "map_spacing" in scene["surfaces"]
        self.upper, self.lower = caps
        for name, rows in zip(FILES, tables):
            setattr(self, name, rows)
        self.rows, self.states = defaultdict(list), defaultdict(list)
        for row in self.contacts:
            self.rows[row["position"], row["step"]].append(row)
        for row in self.curve:
            self.states[row["position"]].append(row)
        material = scene["material"]
        self.modulus = material.get("contact_modulus", 1 / (2 * (1 - 0.3**2) / 200))
        limit = scene.get("limit")
        self.limit = limit["value"] if limit else math.inf
        self.area = PIXELS_AREA if self.is_map else 9.0

    def shows(self, position, effect):
        """Whether the last state of a position simulates an effect."""
        return position.get(effect, "off") != "off"

    def last(self, position):
        return self.states[position["position"]][-1]

    def rows_of(self, state):
        """The contacts of a state, or of the last one of a position."""
        step = state["step"] if "step" in state else self.last(state)["step"]
        return self.rows[state["position"], step]

    def simulates(self, row, effect):
        """Whether the state of a contact or of a curve does; None where that is unknown."""
        position = self.positions[int(row["position"]) - 1]
        if row.get("step", position["steps"]) == position["steps"]:
            return self.shows(position, effect)
        return None

    def is_hertz(self, row):
        return all(self.simulates(row, effect) is False for effect in EFFECTS)

    def pair(self, row):
        """Distance in plan, distance of the centres at first touch, gap, combined radius."""
        x, y, height, radius = self.lower[int(row["lower"]) - 1]
        if row["upper"] == 0:
            first = max(cap[2] for cap in self.lower)
            return 0.0, math.inf, first - height, radius
        top = self.upper[int(row["upper"]) - 1]
        d = math.hypot(top[0] + row["x_displacement"] - x, top[1] + row["y_displacement"] - y)
        return d, math.sqrt((radius + top[3])**2 - d**2), None, radius * top[3] / (radius + top[3])


def sum_of(name):
    """The total of a state is the sum over its contacts."""
    def law(scene, state):
        values = [row[name] for row in scene.rows_of(state)]
        return close(state[name], sum(values), sum(map(abs, values)))
    return law


def is_one_of(*values):
    return lambda name: lambda scene, row: row[name] in values


def of(name, bound=0.0, strict=False, effect=None):
    """A number above its bound; of an effect, empty only where that is left out."""
    def law(scene, row):
        value = row[name]
        if effect and value is EMPTY:
            return scene.simulates(row, effect) is not True
        return value is not EMPTY and (value > bound if strict else value >= bound)
    return law


def stiffness(name):
    """More than 0 in contact, except where all pixels carry their limit; empty in full contact of a
    periodic map without missing pixels."""
    def law(scene, row):
        if row[name] is EMPTY:
            return row["area_fraction"] == 1
        return row[name] > 0 or row[name] == 0 and (
            row["contacts"] == 0 or scene.simulates(row, "plasticity") is True)
    return law


def any_sign(name, effect=None):
    return of(name, -math.inf, effect=effect)


def fails_of(scene):
    """Cells that break the law of their column."""
    for name in FILES:
        for row in getattr(scene, name):
            for column, value in row.items():
                if not (value is EMPTY or isinstance(value, str) or math.isfinite(value)):
                    yield name, column, value, row
                elif not LAWS[name][column](scene, row):
                    yield name, column, value, row


def compression(scene, row):
    """The separation and the compression have one sum at a position: that of first contact."""
    state = scene.states[row["position"]][0]
    total = state["separation"] + state["compression"]
    if not scene.is_map and not scene.upper:
        total = max(cap[2] for cap in scene.lower)
    if row.get("contacts") == 0 and row["compression"] == 0:
        return row["separation"] >= total * (1 - 1e-12)
    return close(row["separation"] + row["compression"], total)


def overlapping(scene, row):
    if scene.is_map:
        return row["overlapping_circles"] is EMPTY
    circles = [(c["x"], c["y"], c["contact_radius"]) for c in scene.rows_of(row)
               if c["contact_radius"] > 0]
    return row["overlapping_circles"] == sum(
        math.hypot(a[0] - b[0], a[1] - b[1]) < a[2] + b[2]
        for k, a in enumerate(circles) for b in circles[:k])


def estimate(effect):
    def law(scene, row):
        value = row[effect + "_estimate"]
        if value == 0:
            loaded = sum(c["penetration"] > 0 for c in scene.rows_of(row))
            return loaded < 1 or effect in ("friction", "plasticity") or loaded < 2 and \
                effect == "interaction"
        mode = scene.effects.get(effect, "auto")
        if scene.is_map or mode in ("on", "coupled", "boundary"):
            return value is EMPTY
        return value is not EMPTY and value > 0 or effect == "interaction" and value is EMPTY
    return law


def influence(effect):
    def law(scene, row):
        value = row[effect + "_influence"]
        return (value is EMPTY or math.isfinite(value)) if scene.is_map else \
            (value is EMPTY) == (not scene.shows(row, effect)) or row["load"] == 0
    return law


def iteration(effect):
    def law(scene, row):
        pair = [row[f"{effect}_{name}"] for name in ("residual", "iterations")]
        if pair == [EMPTY, EMPTY]:
            return effect != "interaction" or not scene.shows(row, effect)
        return scene.shows(row, effect) and 0 <= pair[0] < 1e-3 and pair[1] >= 0
    return law


def gap(name, is_positive):
    """Empty without pixels; 0 only in full contact or without any."""
    return lambda scene, row: (row[name] is EMPTY) if not scene.is_map else \
        row[name] is not EMPTY and (row[name] > 0) == is_positive(row)


def pressure(scene, row):
    """The load over the area, 0 without load; on pixels at most the largest."""
    if row["area"] == 0:
        return row["average_pressure"] == 0
    mean = row["load"] / row["area"]
    return close(row["average_pressure"], min(mean, row["maximum_pressure"]) if scene.is_map
                 else mean)


def largest_pressure(scene, row):
    if scene.is_hertz(row) and not scene.is_map:
        return close(row["maximum_pressure"], 1.5 * row["average_pressure"])
    return row["maximum_pressure"] >= row["average_pressure"] * (1 - 1e-12) or row["load"] < 0


def penetration(scene, row):
    if scene.is_map:
        # The mean displacement of a periodic map is part of its separation.
        return row["penetration"] >= 0 or "map_edge" in scene.scene["surfaces"]
    if row["upper"] > 0:
        return row["penetration"] is not EMPTY
    lowered = row.get("lowered") or 0.0
    expected = row["compression"] - scene.pair(row)[2]
    # On elements it is that of Hertz at their load: deeper by what their residual leaves at most.
    left = row["penetration"] - expected
    if scene.effects.get("interaction") in ("boundary", "auto") and lowered == 0 < left:
        return left <= 1e-3 * scene.effects.get("tolerance", 0.01) * row["compression"]
    return close(row["penetration"] + lowered, expected, row["compression"])


def overlap(scene, row):
    """The decrease of the distance of the centres for this penetration."""
    if scene.is_map:
        return row["overlap"] is EMPTY
    d, z, _, _ = scene.pair(row)
    p = row["penetration"]
    return close(row["overlap"], p if z == math.inf else
                 math.hypot(d, z) - math.hypot(d, z - p), abs(p))


def slope(scene, row):
    if scene.is_map:
        return row["slope"] == 0
    d, z, _, _ = scene.pair(row)
    return close(row["slope"], 0.0 if z == math.inf else d / (z - row["penetration"]), 1e-3)


def load(scene, row):
    """That of Hertz where no effect is simulated; without adhesion it has an area."""
    if scene.is_map:
        return row["load"] > 0
    hertz = 4 / 3 * scene.modulus * math.sqrt(scene.pair(row)[3]) * max(row["overlap"], 0)**1.5
    if scene.is_hertz(row):
        return close(row["load"], hertz, hertz)
    return (row["load"] > 0) == (row["area"] > 0) or "work_of_adhesion" in scene.effects


def vertical(scene, row):
    """The vertical part of the load and, where friction is simulated, of the tangential load."""
    simulated = scene.simulates(row, "friction")
    loads = [row["load"]] if not simulated else []
    if simulated is not False and row.get("tangential_load") is not EMPTY:
        loads.append(row["load"] + row["slope"] * row["tangential_load"])
    return any(close(row["vertical_load"], load / math.hypot(1, row["slope"]), abs(row["load"]))
               for load in loads)


def area(scene, row):
    if scene.is_hertz(row) and not scene.is_map:
        return close(row["area"], math.pi * scene.pair(row)[3] * max(row["overlap"], 0))
    return row["area"] > 0 or row["load"] <= 0


def alone(scene, row):
    """Vertical load of Hertz at the compression, where no other law acts; computed everywhere."""
    value = row["alone_load"]
    if set(scene.effects) & {"work_of_adhesion", "plastic_yield_stress", "hold_time"} or \
            "plastic" in row or row["upper"] > 0:
        return value is not EMPTY and value > -math.inf
    _, _, gap_of_pair, radius = scene.pair(row)
    return close(value, 4 / 3 * scene.modulus * math.sqrt(radius) *
                 max(row["compression"] - gap_of_pair, 0)**1.5, 1e-3 * value)


def largest_overlap(scene, row):
    """The greatest of this contact so far in the states that were solved."""
    value, simulated = row["largest_overlap"], scene.simulates(row, "plasticity")
    if value is EMPTY:
        return simulated is not True
    past = [c["overlap"] for c in scene.contacts if c["position"] == row["position"] and
            c["lower"] == row["lower"] and c["upper"] == row["upper"] and c["step"] <= row["step"]]
    return value >= max(past) * (1 - 1e-12) and value > 0 or max(past) <= 0


def residual_overlap(scene, row):
    value = row["residual_overlap"]
    if value is EMPTY:
        return scene.simulates(row, "plasticity") is not True
    return 0 <= value <= row["largest_overlap"] and (value > 0 or not row["plastic"])


def tabor(scene, row):
    """(R w^2 / (E^2 z0^3))^(1/3)."""
    value = row["tabor_parameter"]
    if value is EMPTY:
        return scene.simulates(row, "adhesion") is not True
    w, z0 = scene.effects["work_of_adhesion"], scene.effects["equilibrium_distance"]
    return close(value, (scene.pair(row)[3] * w**2 / (scene.modulus**2 * z0**3))**(1 / 3))


def relaxed(scene, row):
    value = row["relaxed_share"]
    if value is EMPTY:
        return scene.simulates(row, "creep") is not True
    elastic = row["elastic_load"]
    return close(value, row["load"] / elastic if elastic else 0.0, 1.0)


def limit_exceeded(scene, row):
    if any(effect in scene.effects for effect in EFFECTS) and not scene.is_hertz(row):
        return row["limit_exceeded"] in (0, 1)
    return row["limit_exceeded"] == (row["load"] >= scene.limit * (1 - 1e-12))


def time(scene, row):
    last = scene.effects.get("hold_time", 0.0)
    states = scene.states[row["position"]]
    return 0 <= row["time"] <= last and (row["time"] == 0 or row is not states[0]) and \
        (row["time"] in (0, last) or row is not states[-1])


def work(scene, row):
    value = row["dissipated_work"]
    if "step" not in row and scene.last(row)["dissipated_work"] != value:
        return False
    if value is EMPTY:
        return scene.simulates(row, "plasticity") is not True
    past = [state["dissipated_work"] or 0 for state in scene.states[row["position"]]
            if state["step"] <= row.get("step", math.inf)]
    return value >= max(past) * (1 - 1e-9) >= 0


def plastic_area(scene, row):
    hardness = scene.effects.get("plastic_hardness") if scene.is_map else None
    if hardness is None:
        return row["plastic_area"] is EMPTY
    full = any(c["maximum_pressure"] >= hardness * (1 - 1e-9) for c in scene.rows_of(row))
    return 0 <= row["plastic_area"] <= row["area"] and (row["plastic_area"] > 0) == full


def of_nominal(name, total):
    return lambda scene, row: close(row[name], row[total] / scene.area)


def displaced(name):
    return lambda scene, row: close(row[name], scene.scene.get("motion", {}).get(
        name[0] + "_first", 0.0) + (row["position"] - 1) * scene.scene.get("motion", {}).get(
            name[0] + "_step", 0.0))


def centre(axis):
    def law(scene, row):
        if scene.is_map:
            return row["xy"[axis]] is not EMPTY or scene.scene["surfaces"]["map_edge"] == "periodic"
        cap = scene.lower[int(row["lower"]) - 1]
        if row["upper"] == 0:
            return close(row["xy"[axis]], cap[axis])
        top = scene.upper[int(row["upper"]) - 1]
        at = top[axis] + row["xy"[axis] + "_displacement"]
        return min(cap[axis], at) - 1e-9 <= row["xy"[axis]] <= max(cap[axis], at) + 1e-9
    return law


def counted(name, condition, effect):
    """A number of contacts of the last state."""
    def law(scene, row):
        if row[name] is EMPTY:
            return not scene.shows(row, effect)
        return row[name] == sum(condition(c) for c in scene.rows_of(row))
    return law


def total_of(name, column, effect, combine=sum):
    def law(scene, row):
        if row[name] is EMPTY:
            return not scene.shows(row, effect)
        values = [c[column] or 0.0 for c in scene.rows_of(row)]
        return close(row[name], combine(values) if values else 0.0,
                     max(map(abs, values), default=0))
    return law


def alone_total(scene, row):
    """More than the contacts that are listed: some touch only without their neighbours."""
    values = [c["alone_load"] for c in scene.rows_of(row)]
    total = row["alone_load"]
    most = max(map(abs, values), default=0)
    return close(total, sum(values), most) or row["factor"] is not EMPTY and total > sum(values)


def error_of(name):
    """An estimate of pixels; empty without contact or where it is not computed."""
    return lambda scene, row: row[name] is EMPTY or scene.is_map and row[name] >= 0


def time_of_position(scene, row):
    return row["time"] == scene.last(row)["time"] if row["time"] is not EMPTY else \
        not scene.shows(row, "creep")


TOTALS = {name: sum_of(name) for name in ("area", "projected_area", "load", "vertical_load")}
COMMON = {
    "position": lambda scene, row: 1 <= row["position"] <= len(scene.positions),
    "separation": compression, "compression": compression,
    "contacts": lambda scene, row: row["contacts"] == len(scene.rows_of(row)),
    "nominal_pressure": of_nominal("nominal_pressure", "vertical_load"),
    "area_fraction": of_nominal("area_fraction", "projected_area"),
    "mean_gap": gap("mean_gap", lambda row: row["area"] < PIXELS_AREA),
    "rms_gap": gap("rms_gap", lambda row: row["area"] < PIXELS_AREA),
    "contact_perimeter": gap("contact_perimeter", lambda row: 0 < row["area"] < PIXELS_AREA),
    "elastic_energy": gap("elastic_energy", lambda row: row["load"] > 0),
    "dissipated_work": work, "plastic_area": plastic_area,
    "error_estimate": lambda scene, row: row["error_estimate"] is EMPTY or row[
        "error_estimate"] >= 0,
    "area_error_estimate": lambda scene, row: row["area_error_estimate"] is EMPTY or row[
        "area_error_estimate"] > 0 or sum(c["load"] > 0 for c in scene.rows_of(row)) < 2,
    **{name: error_of(name) for name in (
        "gap_error_estimate", "pressure_error_estimate", "separation_error_estimate")},
    **{f"{effect}_estimate": estimate(effect) for effect in EFFECTS}, **TOTALS}
PLACES = {"x_displacement": displaced("x_displacement"),
          "y_displacement": displaced("y_displacement")}
LAWS = {
    "positions": {
        **COMMON, **PLACES, "steps": lambda scene, row: row["steps"] == len(
            scene.states[row["position"]]),
        "limit_reached": lambda scene, row: row["limit_reached"] == max(
            (c["limit_exceeded"] for c in scene.rows_of(row)), default=0),
        "overlapping_circles": overlapping, "time": time_of_position,
        **{effect: is_one_of("on", "off", "coupled", "boundary", "coupled+boundary")(effect)
           for effect in EFFECTS},
        **{f"{effect}_{name}": law(effect) for effect in EFFECTS for name, law in
           (("influence", influence), ("residual", iteration), ("iterations", iteration))},
        "hertz_load": of("hertz_load", effect="plasticity"),
        "contacts_flowing": of("contacts_flowing", effect="plasticity"),
        "residual_flattening": total_of("residual_flattening", "residual_overlap", "plasticity",
                                        max),
        "adhering_contacts": counted("adhering_contacts", lambda c: c["adhering"], "adhesion"),
        "pulling_contacts": counted("pulling_contacts", lambda c: c["load"] < 0, "adhesion"),
        "pull_off_sum": total_of("pull_off_sum", "pull_off_force", "adhesion"),
        "alone_load": alone_total,
        "factor": lambda scene, row: row["factor"] is EMPTY if not scene.shows(row, "interaction")
        else row["factor"] == 1 or row["alone_load"] > 0 and row["factor"] > 0,
        "cells": lambda scene, row: (row["cells"] > 0) == ("boundary" in row["interaction"]),
        "resolved": lambda scene, row: (row["resolved"] > 0) == (row["cells"] > 0),
        "elastic_load": total_of("elastic_load", "elastic_load", "creep"),
        "frictionless_load": of("frictionless_load", strict=True, effect="friction"),
        "sliding_contacts": counted("sliding_contacts", lambda c: c["sliding"], "friction"),
        **{f"rig_{name}": any_sign(f"rig_{name}", "friction") for name in (
            "force_x", "force_y", "moment_x", "moment_y", "moment_z")},
        "samples_in_contact": total_of("samples_in_contact", "samples", "interaction"),
        "contact_stiffness": stiffness("contact_stiffness"),
        "interface_stiffness": stiffness("interface_stiffness"),
        "conductance_length": stiffness("conductance_length"),
        **{name: error_of(name) for name in (f"{kind}_error_estimate" for kind in (
            "stiffness", "interface", "conductance", "sticking"))},
        # Empty without two bodies and on strips.
        **{f"tangential_stiffness_{axes}": lambda scene, row, name=f"tangential_stiffness_{axes}":
           row[name] is EMPTY or row[name] > 0 or row["contacts"] == 0 for axes in ("xx", "yy")},
        "tangential_stiffness_xy": lambda scene, row: True,
        **{f"open_path_{axis}": lambda scene, row, axis=axis: row[f"open_path_{axis}"] == 1 or (
            row[f"open_path_{axis}"] == 0 and row["samples_in_contact"] > 0) for axis in "xy"},
        "sample_area": lambda scene, row: close(row["sample_area"],
                                                0.25 * row["samples_in_contact"]),
        "warnings": of("warnings")},
    "curve": {**COMMON, "step": of("step", 1), "time": time,
              "greatest_pressure": lambda scene, row: close(row["greatest_pressure"], max(
                  (c["maximum_pressure"] for c in scene.rows_of(row)), default=0.0))},
    "contacts": {
        **PLACES, "position": COMMON["position"], "step": of("step", 1), "separation": compression,
        "compression": compression, "area_no": of("area_no", 1), "x": centre(0), "y": centre(1),
        "upper": lambda scene, row: 0 <= row["upper"] <= len(scene.upper),
        "lower": of("lower", 1), "area": area, "projected_area": lambda scene, row: close(
            row["projected_area"], row["area"] / math.hypot(1, row["slope"])),
        "slope": slope, "load": load, "vertical_load": vertical, "average_pressure": pressure,
        "maximum_pressure": largest_pressure, "limit_exceeded": limit_exceeded,
        "penetration": penetration, "overlap": overlap,
        "plastic": lambda scene, row: row["plastic"] in (0, 1) if row["plastic"] is not EMPTY else
        not scene.simulates(row, "plasticity"),
        "largest_overlap": largest_overlap, "residual_overlap": residual_overlap,
        "adhering": lambda scene, row: row["adhering"] in (0, 1) if row["adhering"] is not EMPTY
        else not scene.simulates(row, "adhesion"),
        "pull_off_force": of("pull_off_force", strict=True, effect="adhesion"),
        "tabor_parameter": tabor, "lowered": of("lowered", effect="interaction"),
        "alone_load": alone, "elastic_load": any_sign("elastic_load", "creep"),
        "relaxed_share": relaxed, "tangential_load": any_sign("tangential_load", "friction"),
        "sliding": lambda scene, row: row["sliding"] in (0, 1) if row["sliding"] is not EMPTY
        else not scene.simulates(row, "friction"),
        "slip_annulus": lambda scene, row: row["slip_annulus"] is EMPTY if row["sliding"] is EMPTY
        else 0 <= row["slip_annulus"] <= 1 and (row["slip_annulus"] == 1) == (row["sliding"] == 1),
        **{name: any_sign(name, "friction") for name in ("lateral_x", "lateral_y")},
        "samples": of("samples", 1), "contact_radius": lambda scene, row: close(
            row["contact_radius"], math.sqrt(row["area"] / math.pi))}}


def values_of(row):
    """The cells as numbers, where they are; None where they are empty."""
    assert not any(cell.startswith("-0.0") and not float(cell) for cell in row.values()), row
    return {name: EMPTY if cell == "" else cell if name in EFFECTS else float(cell)
            for name, cell in row.items()}


def caps_of(path):
    return [tuple(float(row[name]) for name in ("x", "y", "height", "radius"))
            for row in csv_rows.records(path)] if path.exists() else []


def more_of(rng, scene, folder):
    """Caps on both sides, a sweep, effects by word, boundary elements, the states of events."""
    (folder / "upper.csv").unlink(missing_ok=True)
    if rng.random() < 0.4:
        scene["surfaces"]["upper"] = write_surface(folder / "upper.csv", [
            (rng.uniform(0, 3), rng.uniform(0, 3), 0.3, rng.uniform(2.0, 5.0))
            for _ in range(rng.randint(3, 9))])
        if scene["loading"].get("control") == "separation":
            scene["loading"]["control"], scene["loading"]["value"] = "compression", 0.005
    if rng.random() < 0.3:
        scene["motion"] = {"x_first": 0.1, "x_step": 0.2, "y_step": -0.1, "positions": 3}
    for effect, numbers in NUMBERS.items():
        if set(numbers) <= set(scene["effects"]):
            scene["effects"][effect] = rng.choice(("on", "auto", "off"))
    if rng.random() < 0.3:
        scene["effects"]["interaction"] = rng.choice(("boundary", "auto"))
    if rng.random() < 0.2 and not isinstance(scene["loading"].get("value"), tuple):
        scene["loading"]["events"] = "on"


def test_column_laws(asperity, tmp_path):
    rng = random.Random(20261127)
    solved, columns = 0, set()
    for k in range(SCENES):
        is_map = k % 6 == 5
        scene = random_scene(rng, tmp_path, is_map)
        if is_map:
            hardness = scene["effects"].get("plastic_hardness")
            scene["effects"] = {"interaction": "boundary"}
            if hardness:
                scene["effects"]["plastic_hardness"] = hardness
        else:
            more_of(rng, scene, tmp_path)
        write(tmp_path / "s.scene", scene)
        done = run_program(asperity, "solve", "s.scene", "--threads", "1", "--quiet",
                           *(word for name in FILES for word in (f"--{name}", name)),
                           status=None, cwd=tmp_path)
        if done.returncode:
            assert done.returncode in (1, 2) and done.stderr, (scene, done)
            continue
        solved += 1
        tables = [[values_of(row) for row in csv_rows.records(tmp_path / name)] for name in FILES]
        caps = [[] if is_map else caps_of(tmp_path / f"{side}.csv") for side in ("upper", "lower")]
        fails = list(fails_of(Scene(scene, caps, tables)))
        assert not fails, (scene, fails[0])
        columns |= {(name, column) for name, rows in zip(FILES, tables)
                    for row in rows[:1] for column in row}
    assert solved > SCENES // 2
    assert not {(name, column) for name in FILES for column in LAWS[name]} - columns
