"""Scenes with effects for tests: the thesis sweep, caps on a flat, and what runs left."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from boundary_patch import Contact
from exact_contact import Truth, read_deck
from judge import column, solved
from surfaces_csv import write_csv_scene, write_scene

ROOT = Path(__file__).resolve().parents[2]
DECK = ROOT / "data" / "thesis.deck"
# Material of the caps: equal bodies of 275760 N/cm2 and 0.42, the thesis' plastic.
MODULUS, RATIO = 275760.0, 0.42
COMBINED = MODULUS / (2 * (1 - RATIO ** 2))
CAP = 1.27
# An upper sphere so large that it is a flat for caps below it.
FLAT = 1.0e6
# Of the factor load together / load alone: the promises of the project.
COUPLED_APART, COUPLED_OVERLAPPING = 0.002, 0.02
# What the last halving of cells may change of a load (boundary_tolerance).
CELLS = 1e-3
# What a position reports of the run and not of the contacts.
SHOWN = ("warnings", "error_estimate")
# A solve of `coupled` calls itself converged at this residual.
CONVERGED = 1e-10


class Sweeps:
    """The thesis sweep with effects, each solved once."""

    def __init__(self, asperity, folder):
        self.asperity, self.folder, self.done = asperity, folder, {}

    def solve(self, *options, positions=100, x_first=0.1, curve=False, loading=None, material=None,
              **effects):
        """The sweep, or a part of it; effects are the names of &effects."""
        key = repr((options, positions, x_first, curve, loading, material, effects))
        if key not in self.done:
            folder = self.folder / str(len(self.done))
            folder.mkdir()
            groups = {"loading": loading, "material": material, "effects": effects}
            scene = write_scene(
                folder / "sweep.scene", surfaces={"deck": str(DECK)},
                motion={"x_first": x_first, "x_step": 0.1, "positions": positions},
                **{name: values for name, values in groups.items() if values})
            self.done[key] = solved(self.asperity, scene, *options, curve=curve)
        return self.done[key]


def effect_rows(stdout):
    """The table of the effects in a summary: cells by column, for each effect."""
    starts, lines = (0, 12, 21, 31, 46, 58, 73), iter(stdout.splitlines())
    for line in lines:
        if line.startswith("effect      mode "):
            cells = [[line[a:b].strip() for a, b in zip(starts, (*starts[1:], None))]
                     for line in lines]
            assert len({name for name, *_ in cells}) == len(cells), stdout
            return {name: dict(zip(("mode", "tolerance", "simulated at", "influence", "left out",
                                    "note"), rest)) for name, *rest in cells}
    return {}


def by_position(rows):
    """Rows of each position."""
    found = {}
    for row in rows:
        found.setdefault(int(row["position"]), []).append(row)
    return found


def total(rows, name):
    """Sum of a column."""
    return column(rows, name).sum()


@cache
def thesis():
    """The deck placed: centres as doubles, from the evaluation with many digits."""
    return Truth(read_deck(DECK), 30)


@dataclass(frozen=True)
class Place:
    """How the two spheres of a contact stand to each other, in plan."""

    upper_radius: float
    lower_radius: float
    distance: float
    outward: tuple  # unit vector from the lower centre to the upper one


def place_of(row):
    """Of a contact of the thesis sweep."""
    truth = thesis()
    upper = truth.upper_doubles[int(row["upper"]) - 1]
    lower = truth.lower_doubles[int(row["lower"]) - 1]
    away = upper[:2] + (float(row["x_displacement"]), float(row["y_displacement"])) - lower[:2]
    distance = float(np.hypot(*away))
    return Place(float(upper[3]), float(lower[3]), distance, tuple(away / distance))


# Caps below one sphere that is nearly a flat.

@dataclass
class Caps:
    """Places and tops of caps, the scene, and the gap of each at the first touch."""

    places: np.ndarray
    heights: np.ndarray
    scene: Path

    def gaps(self):
        """Compression at which each touches."""
        touch = self.heights - self.sag()
        return touch.max() - touch

    def sag(self):
        """What the large sphere rises by away from its middle, at the place of a cap."""
        square, reach = (self.places ** 2).sum(1), FLAT + CAP
        return square / (reach + np.sqrt(reach ** 2 - square))

    def contacts(self, closing):
        """For the evaluation of `boundary`: two spheres each, however large."""
        return [Contact(0.0, 0.0, FLAT, x, y, CAP, closing - gap)
                for (x, y), gap in zip(self.places, self.gaps()) if closing > gap]


def write_caps(folder, places, heights, **groups):
    """Spherical caps of one radius on a plane, the flat above; the origin is its middle."""
    places, heights = np.asarray(places, float), np.asarray(heights, float)
    lower = [(x, y, h, CAP) for (x, y), h in zip(places, heights)]
    scene = write_csv_scene(folder, [(0.0, 0.0, 1.0, FLAT)], lower, name="caps",
                            modulus=(MODULUS, MODULUS), ratio=(RATIO, RATIO), **groups)
    return Caps(places, heights, scene)


def random_caps(number, width, depth, seed):
    """Places on a rectangle about the origin; heights half-normal 0.01 cm below 1 cm."""
    rng = np.random.default_rng(seed)
    places = (rng.random((number, 2)) - 0.5) * (width, depth)
    return places, 1.0 - 0.01 * np.abs(rng.standard_normal(number))
