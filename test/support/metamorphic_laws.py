"""Laws that a change of the scene must keep, and the harness' own look at each result.

A law states what a result of the changed scene must be, given that of the scene. What the program
states of itself is not asked: totals are summed from the file of contacts, loads are compared with
what was asked for, contacts are held against their caps.
"""

import copy
import math
import random

import metamorphic_scenes as scenes
from judge import check, has_result, number

LOAD_MET = 1e-6
UNSURE = "the area is less sure than the tolerance"
TOTALS = ("load", "vertical_load", "area", "projected_area")


def near(a, b, share, what, size=0.0):
    check(what, a, b, share, scale=max(abs(a), abs(b), size))


# ---------------------------------------------------------------- one result

def look(scene, run):
    """What must hold of any result."""
    if not has_result(run):
        return
    rows, curve = run.positions, run.curve
    contacts = {}
    for contact in run.contacts:
        contacts.setdefault((contact["position"], contact["step"]), []).append(contact)
    for row in curve:
        own = contacts.get((row["position"], row["step"]), [])
        for name in TOTALS:
            total = math.fsum(number(contact, name) for contact in own)
            size = math.fsum(abs(number(contact, name)) for contact in own)
            near(number(row, name), total, 1e-12, f"{name} and its contacts", size)
    last = {row["position"]: row for row in curve}
    for row in rows:
        for name in (*TOTALS, "separation"):
            assert row[name] == last[row["position"]][name], f"{name} of the last state"
    loads_are_met(scene, rows, curve)
    if scene.lower:
        caps_are_kept(scene, run)


def asked_loads(scene):
    """The loads of the states of a position, in order, those of a hold left out, and their column;
    a pressure is a vertical load over the area of a map."""
    loading = scene.groups["loading"]
    control, values = loading["control"], loading.get("value")
    if control not in ("load", "vertical_load", "pressure"):
        return [], ""
    unit, column = (scene.area(), "vertical_load") if control == "pressure" else (1.0, control)
    if not isinstance(values, list):
        return [values * unit], column
    parts, asked, before = loading.get("points", 1), [], 0.0
    for value in values:
        asked += [unit * (before + (value - before) * (part + 1) / parts) for part in range(parts)]
        before = value
    return asked if parts == 1 else [0.0] + asked, column


def loads_are_met(scene, rows, curve):
    """Load asked is load found, at every state that names one; held loads are held. A load near 0
    is a difference of pushes and pulls, each 6 pi w R in a contact after Johnson, Kendall and
    Roberts that carries nothing: it is met to 1e-12 of them."""
    (asked, name), effects = asked_loads(scene), scene.groups.get("effects", {})
    if not asked:
        return
    size = 1e-6 * (max(asked) + 3 * scenes.pull(scene))
    for row in rows:
        states = [state for state in curve if state["position"] == row["position"]]
        held = [number(state, name) for state in states if float(state.get("time", 0.0)) > 0.0]
        loads = [number(state, name) for state in states][:len(states) - len(held)]
        assert len(loads) >= len(asked), "states of the path are missing"
        for load, value in zip(loads[-len(asked):], asked):
            near(load, value, LOAD_MET, "load asked and found", size)
        for load in held if effects.get("hold") == "load" else ():
            near(load, asked[-1], LOAD_MET, "load held", size)


def caps_are_kept(scene, run):
    """No contact reaches beyond its cap without a warning: the lowest point of the edge of its
    circle, turned by the contact's slope and by the angle of the circle, lies above the plane from
    which the sphere rises."""
    warned = {row["position"] for row in run.positions if int(row["warnings"])}
    for contact in run.contacts:
        if contact["position"] in warned:
            continue
        circle = math.sqrt(number(contact, "area") / math.pi)
        tilt = math.atan(number(contact, "slope"))
        for name, rows in (("upper", scene.upper), ("lower", scene.lower)):
            _, _, height, radius = rows[int(contact[name]) - 1]
            depth = radius * (1.0 - math.cos(tilt + math.asin(min(1.0, circle / radius))))
            assert depth <= height + 1e-9 * radius, \
                f"{name} asperity {contact[name]}: a contact reaches {depth}, not {height}"


# ---------------------------------------------------------------- two results

def both(one, two):
    """Whether both have results; a refusal of one alone breaks a law."""
    assert one.status == two.status, f"{one.message or 'a result'}\n{two.message or 'a result'}"
    return one.status == 0


def same_totals(scene, one, two, factor=1.0, share=None):
    """The totals of all positions and states, those of the second over a factor."""
    share = share or scene.share()
    for rows, others in zip((one.positions, one.curve),
                            (two.positions, two.curve)):
        assert len(rows) == len(others), "number of states"
        for row, other in zip(rows, others):
            for name in TOTALS:
                near(number(row, name), number(other, name) / factor, share, name,
                     1e-3 * largest(one, name))
            near(number(row, "separation"), number(other, "separation"), share, "separation", 0.1)


def largest(run, name):
    return max((abs(number(row, name)) for row in run.curve), default=0.0)


def same_digits(one, two, lengths, moduli):
    """Every number of every file is that of the other times one power of two a column."""
    for what in ("positions", "contacts", "curve"):
        rows, others = getattr(one, what), getattr(two, what)
        assert len(rows) == len(others), f"rows of {what}"
        for name in rows[0] if rows else ():
            power = None
            for row, other in zip(rows, others):
                power = same_cell(row[name], other[name], power, f"{what}, {name}")
            powers = {a * lengths + b * moduli for a in range(-2, 5) for b in (-1, 0, 1)}
            assert power in powers | {None}, f"{what}, {name}: times 2**{power}"


def same_cell(cell, other, power, where):
    try:
        value, scaled = float(cell), float(other)
    except ValueError:
        assert cell == other, f"{where}: {cell!r} and {other!r}"
        return power
    if value == 0.0 or scaled == 0.0:
        assert value == scaled, f"{where}: {cell} and {other}"
        return power
    (digits, exponent), (digits_2, exponent_2) = math.frexp(value), math.frexp(scaled)
    assert digits == digits_2, \
        f"{where}: {value!r} is {math.ldexp(scaled, exponent - exponent_2)!r} in the other unit"
    assert power in (None, exponent_2 - exponent), f"{where}: not one power of two"
    return exponent_2 - exponent


# ---------------------------------------------------------------- the laws

def law_scaled(scene, exe, rng):
    lengths, moduli = rng.choice([(40, 0), (-40, 0), (0, 40), (0, -40), (39, -41), (-39, 3)])
    one, two = (scenes.run(exe, s) for s in (scene, scene.scaled(lengths, moduli)))
    look(scene, one)
    if both(one, two):
        same_digits(one, two, lengths, moduli)
    return one.status


def law_mirrored(scene, exe, _rng):
    return same_after(scene, scenes.mirrored(scene), exe)


def law_turned(scene, exe, _rng):
    return same_after(scene, scenes.turned(scene), exe)


def law_permuted(scene, exe, rng):
    return same_after(scene, scenes.permuted(scene, rng), exe)


def law_copied(scene, exe, _rng):
    """Twice the surfaces, far apart: twice of all at one approach, one approach at twice the load.

    A limit is met by a contact, and by its copy. Far neighbours lower each other by the circle over
    the distance, less than 2**-20 times a few dozen.
    """
    share = scene.share()
    if "interaction" in scene.groups.get("effects", {}):
        share = max(share, 1e-5)
    if "tilt" in scene.groups:
        return None
    return same_after(scene, scenes.in_copies(scene, 2, 2.0 ** 20), exe, 2.0, share)


def law_tighter(scene, exe, _rng):
    """What `auto` leaves out is at most the tolerance. In a hold that is left out both load and
    approach stay; in one that is not, one moves."""
    effects = scene.groups.get("effects", {})
    if "auto" not in effects.values() or effects.get("creep") == "auto":
        return None
    other = copy.deepcopy(scene)
    other.groups["effects"]["tolerance"] = effects["tolerance"] / 30
    return same_after(scene, other, exe, share=effects["tolerance"] * 31 / 30,
                      names=("load", "area"))


def law_one_more_state(scene, exe, _rng):
    """Where loading only grows, a state more on the way changes nothing at its end."""
    loading = scene.groups["loading"]
    if loading["control"] == "limit" or isinstance(loading["value"], list):
        return None
    effects = scene.groups.get("effects", {})
    if "creep" in effects:
        return None
    other = copy.deepcopy(scene)
    other.groups["loading"]["points"] = loading.get("points", 1) + 1
    one, two = (scenes.run(exe, s) for s in (scene, other))
    look(scene, one)
    look(other, two)
    if both(one, two):
        one.curve = two.curve = []
        same_totals(scene, one, two)
    return one.status


def law_shifted(scene, exe, rng):
    """Both surfaces elsewhere in plan. Under a tilt of one of them they touch higher or lower."""
    if "tilt" in scene.groups:
        return None
    dx, dy = (scenes.on_grid(rng.uniform(-10, 10)) for _ in "xy")
    return same_after(scene, scenes.mapped(scene, lambda row: (row[0] + dx, row[1] + dy, *row[2:])),
                      exe)


def law_raised(scene, exe, rng):
    """Heights count from any plane: raised surfaces have the same contacts, and a separation that
    is larger by as much."""
    other = copy.deepcopy(scene)
    lifts = [scenes.on_grid(rng.uniform(-1, 0.6)) for _ in range(2)]
    for side, lift in zip(("upper", "lower"), lifts):
        setattr(other, side, [(x, y, height + lift, radius)
                              for x, y, height, radius in getattr(scene, side)])
    if scene.groups["loading"]["control"] == "approach":
        other.groups["loading"]["value"] += sum(lifts)
    one, two = (scenes.run(exe, s) for s in (scene, other))
    look(scene, one)
    if both(one, two):
        for row in two.positions + two.curve:
            row["separation"] = repr(float(row["separation"]) - sum(lifts))
        same_totals(scene, one, two)
    return one.status


def without_effects(scene, **loading):
    """One position of isolated contacts under the first value of the loading, changed."""
    other = copy.deepcopy(scene)
    other.groups.pop("motion", None)
    other.groups["effects"] = {"interaction": "off"}
    old = other.groups["loading"]
    if isinstance(old.get("value"), list):
        old["value"] = old["value"][0]
    old.update(loading)
    return other


def law_falls_never(scene, exe, rng):
    """No contact, load or area falls while isolated contacts are loaded."""
    run = scenes.run(exe, without_effects(scene, points=rng.randint(2, 40)))
    if run.status == 0:
        for one, two in zip(run.curve, run.curve[1:]):
            assert number(one, "separation") >= number(two, "separation"), "separation grows"
            for name in ("contacts", "load", "area"):
                assert number(one, name) <= number(two, name), f"{name} falls"
    return run.status


def law_inverse(scene, exe, _rng):
    """The load at a separation has this separation: isolated contacts, either way round."""
    run = scenes.run(exe, without_effects(scene))
    if run.status or not number(run.positions[0], "load") > 0.0:
        return None
    found, is_load = run.positions[0], scene.groups["loading"]["control"] == "load"
    again = scenes.run(exe, without_effects(
        scene, control="approach" if is_load else "load",
        value=number(found, "separation" if is_load else "load")))
    assert again.status == 0, again.message
    near(number(again.positions[0], "load"), number(found, "load"), scenes.ROUNDING, "load")
    near(closing(again, again.positions[0]), closing(run, found), scenes.ROUNDING, "closing")
    return 0


def same_after(scene, other, exe, factor=1.0, share=None, names=None):
    one, two = (scenes.run(exe, s) for s in (scene, other))
    look(scene, one)
    look(other, two)
    if both(one, two):
        if names:
            # A load that is held moves the approach, whatever gave it.
            held = scene.groups.get("effects", {}).get("hold") == "load"
            within(one, two, share, names, "load" if held else scene.groups["loading"]["control"])
        else:
            same_totals(scene, one, two, factor, share)
    return one.status


def within(one, two, share, names, control):
    """Totals, and at a given load the approach over the compression, within a share; areas of which
    was stated that they are less sure than that, within what was stated of both."""
    for row, other in zip(one.positions, two.positions):
        for name in names:
            shown = sum(number(r, "area_error_estimate") for run, r in ((one, row), (two, other))
                       if name == "area" and UNSURE in run.stderr)
            near(number(row, name), number(other, name), share + shown, name)
        if control == "approach":
            # As given, or first touch less a compression, each rounded.
            near(number(row, "separation"), number(other, "separation"), 1e-12, "separation")
        else:
            near(closing(one, row), closing(two, other), share, "closing")


def closing(run, row):
    """How far the surfaces of a position came nearer after they first touched, at its end."""
    ends = [s for s in run.curve if s["position"] == row["position"]]
    return number(ends[-1], "compression")


LAWS = {"scaled by powers of two": law_scaled, "mirrored": law_mirrored,
        "turned by 90 degrees": law_turned, "asperities in another order": law_permuted,
        "two copies far apart": law_copied, "a tighter tolerance": law_tighter,
        "one more state on the way": law_one_more_state, "shifted in plan": law_shifted,
        "raised": law_raised, "nothing falls while loading": law_falls_never,
        "load and separation": law_inverse}


def broken(seed, exe, name=None, laws=None, make=scenes.scene_of_seed):
    """A law, by default that of the seed: its name, the status of the run (None: not asked), and
    what is broken."""
    laws = laws or LAWS
    name = name or list(laws)[seed % len(laws)]
    try:
        return name, laws[name](make(seed), exe, random.Random(f"law {seed}")), ""
    except AssertionError as fault:
        return name, 0, str(fault) or "broken"
