"""Whether `coupled` solves all that has a solution: random scenes, loads of a table, summits.

Solved is: status 0, sums that are those of the contacts, and contacts that carry what they
penetrate, or nothing where they do not.

Random scenes: 2 to 5000 contacts, from .1 to 30 % of the area, heights from one level to widely
spread, equal and mixed radii (to 1:30), at random, in heaps, in packed lattices and with coincident
caps, under an approach or a load. Scene K is made of the seed K: `--first K --count 1` runs it
alone. Packed, of seeds too: 9 to 300 equal caps, .02 to .5 of a radius apart, on a lattice or in a
heap, level or nearly, so lightly pressed that they cover 1 to 30 % of the area, or so deeply that
circles are wider than caps are apart. Stepped: caps of which some stand on blunter ones, with
nearly the same axis. Loads: 2000 to 32000 caps at 40 loads from 3 to 90 N a cap.
Rough: the summits of a made-up rough surface, and of others (`x,y,height,radius`), up to 20 %
contact.

"""

from functools import partial

import numpy as np

from judge import Figure, ask, is_met, missed, number
from solved_cases import COMBINED, OF_SEEDS, SPHERE


def run(exe, mode, timeout, case):
    """Solve a case: the answer, with the steps that it took and what is wrong with it."""
    answer = ask(exe, partial(case.write, mode=mode), timeout=timeout)
    answer.steps = float("nan")
    for row in answer.positions:
        answer.steps = number(row, "interaction_iterations")
        if fault := fault_of(case, row, answer.contacts):
            answer.status, answer.stderr = WRONG, fault
    return answer


# Status of a result that is not what it states; relative error of a load by its penetration.
WRONG, OF_LAW = -2, 1e-6


def fault_of(case, position, contacts):
    """What is wrong with the sums of the contacts, or with one of them: "" when nothing is.

    A loaded contact carries what its penetration, alone and less what it is lowered by, states;
    what
    carries nothing does not penetrate. No contact is lowered where `auto` leaves the interaction
    off.
    """
    names = ("vertical_load", "projected_area", "alone_load", "lowered")
    if position["interaction"] == "off":
        contacts = [row | {"lowered": 0} for row in contacts]
    load, area, alone, lowered = (np.array([float(row[n]) for row in contacts]) for n in names)
    sums = [Figure(name, number(position, name), values.sum(), scale=abs(values).sum())
            for name, values in (("vertical_load", load), ("projected_area", area))]
    if wrong := missed(sums, 1e-9):
        return f"sums of the contacts: {wrong}"
    if load.min(initial=0) < 0:
        return f"a contact bears {load.min()}"
    radius = case.caps[[int(row["lower"]) - 1 for row in contacts], 3]
    stiff = 4 / 3 * COMBINED * np.sqrt(1 / (1 / radius + 1 / SPHERE))
    deep = (alone / stiff) ** (2 / 3) - lowered
    borne = stiff * np.maximum(deep, 0) ** 1.5
    wrong = ~is_met(borne - load, OF_LAW * load.max(initial=0))
    return f"{wrong.sum()} contacts do not bear what they penetrate" if wrong.any() else ""


def run_seed(exe, mode, timeout, seed, part="random"):
    """Made where it runs: scenes are not sent between processes."""
    return run(exe, mode, timeout, OF_SEEDS[part](seed))
