"""The hard decks: for the historic port, and as scenes for the present-day solver.

`historic` is what the port must do: "runs", or the words with which it stops. `note` is what it
must state beside a report; `coarse` is how far its real64 may be off, relatively: W is a difference
of large numbers (fault 3), displacements are sums of steps (fault 2). `solver_refused` is what the
present-day solver states, if it cannot solve.
"""

from dataclasses import dataclass

RESTATED = "The marching algorithm restated with 60 digits; the solver by geometry and Hertz."
NO_NUMBER = ("The port stops where, by the original's text, its numbers lose their meaning; the "
             "solver by geometry and Hertz.")
FAULT_5 = "read past its end (fault 5)"
FAULT_6 = "ran on with separations of 100 and read past its arrays (fault 6)"
FAULT_7 = "further apart than RU + RL: root of a negative number (fault 7)"


@dataclass
class DeckCase:
    """A deck; `deck` holds the keyword arguments of write_deck."""

    name: str
    why: str
    deck: dict
    truth: str = RESTATED
    historic: str = "runs"
    note: str = ""
    coarse: float = 1.0e-9
    solver_refused: str = ""


def model(asperities, radius, height_max=None, modulus=400000.0, ratio=0.42):
    height_max = max(z for _, _, z in asperities) if height_max is None else height_max
    return {"radius": radius, "height_max": height_max, "modulus": modulus, "ratio": ratio,
            "stress": 11200.0, "asperities": asperities}


def row(count, first, step):
    """Asperities one step apart, as cards hold them."""
    return [tuple(round(f + i * s, 4) for f, s in zip(first, step)) for i in range(count)]


def deck(upper, lower, **other):
    return {"upper": upper, "lower": lower, **other}


# Radii of 9 in: one pair stays within the candidate distance over the sweep of 4 in.
MIDDLE = [(4.0, 1.5, 0.75)]
UNDER = [(2.0, 1.9, 0.8)]


def decks():
    """All deck cases."""
    below = model(MIDDLE, 9.5)
    yield DeckCase("deck_one_pair", "One asperity a model.", deck(model(UNDER, 9.0), below))
    yield DeckCase("deck_ties_2", "Two upper asperities in one place: every separation is a tie.",
                   deck(model(UNDER * 2, 9.0), below))
    yield DeckCase("deck_ties_10", "Ten upper asperities in one place, a tie of ten, and one "
                   "0.0001 in lower.", deck(model(UNDER * 10 + [(2.0, 1.9, 0.7999)], 9.0), below))
    yield DeckCase("deck_ties_all", "Three and two coincident asperities: all separations tie, "
                   "and the list of NU places holds three of six.",
                   deck(model(UNDER * 3, 9.0), model(MIDDLE * 2, 9.5)),
                   note="all places of the list of least separations are in contact")
    yield DeckCase("deck_list_full", "12 and 12 soft asperities, all 144 pairs near: more contacts "
                   "than the list of NU least separations holds.",
                   deck(model(row(12, (2.0, 1.9, 0.8), (0.01, 0.0, -0.0001)), 9.0, modulus=9000.0),
                        model(row(12, (4.0, 1.5, 0.75), (0.0, 0.01, -0.0001)), 9.5)),
                   note="any further contact is lost (fault 5)")
    yield DeckCase("deck_past_37", "40 soft asperities over one, all in contact before the limit: "
                   "the original read SEPMIN past its end.",
                   deck(model(row(8, (2.0, 1.9, 0.8), (0.0, 0.0, -0.0001)) * 5, 9.0,
                              modulus=900.0), below),
                   truth=NO_NUMBER, historic=FAULT_5)
    yield DeckCase("deck_25_approaches", "So soft that 25 approaches of 0.001 cm end far below the "
                   "limit load.", deck(model(UNDER, 9.0, modulus=20.0), below),
                   note="the approaches ran out before a contact reached WLIMIT (fault 5)")
    yield DeckCase("deck_none_at_all", "No candidate pair at any position.",
                   deck(model([(0.5, 0.5, 0.07)], 0.5), model([(9.0, 0.5, 0.07)], 0.5)),
                   truth=NO_NUMBER, historic="position 1: no pair of asperities is within OFSTMX "
                   "and less than 100 cm apart: the original " + FAULT_6)
    yield DeckCase("deck_none_at_some", "The only pair parts after 14 positions.",
                   deck(model([(1.5, 1.5, 0.07)], 0.5), model([(1.7, 1.955, 0.07)], 0.5)),
                   truth=NO_NUMBER, historic="position 15: no pair of asperities is within OFSTMX "
                   "and less than 100 cm apart: the original " + FAULT_6)
    yield DeckCase("deck_none_at_one", "No candidate pair at position 50 alone.",
                   deck(model([(0.0, 1.5, 0.25)], 5.0),
                        model([(-0.287, 1.955, 0.25), (4.224, 1.955, 0.25)], 5.0)),
                   truth=NO_NUMBER, historic="position 50: no pair of asperities is within OFSTMX "
                   "and less than 100 cm apart: the original " + FAULT_6)
    yield DeckCase("deck_beyond_sum", "OFSTMX knows RU alone and exceeds RU + RL: a pair far apart "
                   "is a candidate.",
                   deck(model([(0.5, 1.5, 0.07)], 0.5, height_max=0.99),
                        model([(1.5, 1.955, 0.07)], 0.1)),
                   truth=NO_NUMBER, historic=FAULT_7)
    yield DeckCase("deck_radii_1e6", "Radii of 9000 and 0.009 in.",
                   deck(model([(2.0, 1.9, 0.004)], 9000.0, height_max=0.009),
                        model([(4.0, 1.5, 0.004)], 0.009)), coarse=1.0e-7)
    yield DeckCase("deck_moduli_1e12", "Moduli of 9e8 and 9e-4 psi: no approach bears the limit.",
                   deck(model(UNDER, 9.0, modulus=900000000.0),
                        model(MIDDLE, 9.5, modulus=0.0009)),
                   note="the approaches ran out before a contact reached WLIMIT (fault 5)",
                   solver_refused="no pair of asperities reaches the limit")
    yield DeckCase("deck_poisson_half", "Poisson's ratio 0.5 on both models.",
                   deck(model(UNDER, 9.0, ratio=0.5), model(MIDDLE, 9.5, ratio=0.5)))
    yield DeckCase("deck_offset", "The mold lies 5000 in from the origin: the plate's tilt lifts "
                   "it by 20 in, and a step of 0.1 cm is 26 units of the last place in ibm370.",
                   deck(model([(5000.0, 1.9, 0.8)], 9.0), model([(5002.0, 1.5, 0.75)], 9.5)))
    yield DeckCase("deck_offset_far", "The mold lies 90000 in from the origin: the plate's tilt "
                   "lifts it by more than the 100 cm with which the list of separations is filled.",
                   deck(model([(90000.0, 1.9, 0.8)], 9.0), model([(90002.0, 1.5, 0.75)], 9.5)),
                   truth=NO_NUMBER, historic="position 1: no pair of asperities is within OFSTMX "
                   "and less than 100 cm apart: the original " + FAULT_6)
    yield DeckCase("deck_turned", "Both models turned by pi: everything lies on the other side of "
                   "the origin.",
                   deck(model([(-2.0, -1.9, 0.8)], 9.0), model([(-4.0, -1.5, 0.75)], 9.5),
                        angles=(3.1416, 3.1416)))
