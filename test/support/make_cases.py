"""Write the catalogue of hard cases.

    python test/support/make_cases.py [FOLDER]      (default: data/hard)
"""

import sys
from pathlib import Path

import numpy as np
from cases import scenes
from deck_cases import decks
from effect_cases import effect_cases
from model_cases import model_cases
from surfaces_csv import write_csv_scene, write_scene, write_surface


def comment(label, text):
    """The text behind a label, broken into comment lines."""
    lines, line = [], f"! {label}:"
    for word in text.split():
        if len(line) + 1 + len(word) > 100:
            lines.append(line)
            line = "!  "
        line += " " + word
    return "\n".join([*lines, line]) + "\n"


def write_case(folder, case, _):
    """One scene and its two surfaces."""
    return write_csv_scene(folder, case.upper, case.lower, case.name, case.modulus, case.ratio,
                           **case.groups)


def surface_writer(folder):
    """A function that writes rows as a surface, once, and gives the file's name."""
    names = {}

    def surface(rows, name):
        key = tuple(rows)
        if key not in names:
            names[key] = write_surface(folder / f"{name}.csv", rows)
        return names[key]

    return surface


def write_effect_case(folder, case, surface):
    """One scene with effects, and its surfaces if no case before has them."""
    return write_scene(
        folder / f"{case.name}.scene",
        surfaces={"upper": surface(case.upper, f"{case.name}_upper"),
                  "lower": surface(case.lower, f"{case.name}_lower")},
        material={"elastic_modulus": case.modulus, "poisson_ratio": case.ratio}, **case.groups)


def write_model_case(folder, case, surface):
    """One scene of caps or of heights under a plane."""
    if case.heights is None:
        lower = surface(case.caps, f"{case.name}_lower")
    else:
        lower = f"{case.name}.txt"
        np.savetxt(folder / lower, case.heights, fmt="%.17g")
    return write_scene(folder / f"{case.name}.scene", **{
        **case.groups,
        "surfaces": {"upper": "plane", "lower": lower, **case.groups.get("surfaces", {})}})


def field(value, width):
    """A number with its point, in as many columns as the card has."""
    for decimals in range(width, -1, -1):
        text = f"{value:.{decimals}f}" + "." * (decimals == 0)
        text = text.replace("0.", ".", 1) if text.lstrip("-").startswith("0.") else text
        if len(text) <= width:
            if float(text) != value:
                raise ValueError(f"{value} does not fit {width} columns")
            return text.rjust(width)
    raise ValueError(f"{value} does not fit {width} columns")


def write_deck(path, upper, lower, width=3.455, angles=(0.0, 0.0), displacement=(0.0, 0.0)):
    """A deck of any numbers; a model is a dict as in the regression tests' decks."""
    cards = ["NO  YES "]
    for model in (upper, lower):
        cards.append(f"{len(model['asperities']):5d}" + "".join(
            field(model[name], columns) for name, columns in (
                ("radius", 5), ("height_max", 5), ("modulus", 10), ("ratio", 5), ("stress", 10))))
    cards[-1] += field(width, 7)
    cards.append("".join(map(field, (*angles, *displacement), (8, 8, 7, 7))))
    for model in (upper, lower):
        cards += [field(x, 6) + field(y, 6) + field(z, 7) for x, y, z in model["asperities"]]
    path.write_text("\n".join(cards) + "\n")
    return path


def write_all(folder):
    for part, cases, write in (("", scenes, write_case),
                               ("effects", effect_cases, write_effect_case),
                               ("models", model_cases, write_model_case)):
        (folder / part).mkdir(parents=True, exist_ok=True)
        surface = surface_writer(folder / part)
        for case in cases():
            path = write(folder / part, case, surface)
            path.write_text(comment("Hard", case.why) + comment("Truth", case.truth)
                            + path.read_text())
    index = ["# Decks\n\nWhy each deck is hard and where its truth comes from; a deck has no room "
             "for comments.\n"]
    for deck in decks():
        write_deck(folder / f"{deck.name}.deck", **deck.deck)
        index.append(f"- `{deck.name}.deck`\n  - Hard: {deck.why}\n  - Truth: {deck.truth}\n")
    (folder / "decks.md").write_text("\n".join(index))


if __name__ == "__main__":
    write_all(Path(sys.argv[1]) if len(sys.argv) > 1
              else Path(__file__).resolve().parents[2] / "data" / "hard")
