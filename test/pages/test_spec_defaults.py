"""The defaults of specifications on the pages: a specification with a default written has the
results of one without it, and another value has others."""

import re

import pytest
from builds import ROOT
from programs import run_program

pytestmark = pytest.mark.pages

PAGES = {"generate": "reference/generate.md", "study": "how-to/representative-area.md"}
# A small specification for each command, by groups; names that are compared are left out of it.
ASPERITIES = {
    "surfaces": {"number": "300", "length": "40.", "width": "40."},
    "heights": {"mean": "0.1", "deviation": "0.02"},
    "radii": {"mean": "1."}, "random": {"ensemble": "2"},
    "material": {"elastic_modulus": "1000.", "poisson_ratio": "0.3"},
    "study": {"separation": "0.2", "sizes": "16., 8., 4."}}
DECK = {"surfaces": {"number": "9", "length": "3.", "width": "4."},
        "heights": {"mean": "0.1", "deviation": "0.02"}, "radii": {"mean": "0.5"},
        "deck": {"elastic_modulus": "4e5", "poisson_ratio": "0.4", "allowed_stress": "5e3"}}
MAP = {"map": {"pixels": "32", "spacing": "0.5", "hurst": "0.8", "rms_slope": "0.1",
               "roll_off": "8."}}
OF_GENERATE = {**{name: ASPERITIES[name] for name in ("surfaces", "heights", "radii", "random")}}
BASE = {("generate", "deck"): DECK, ("generate", "map"): MAP,
        **{("generate", group): OF_GENERATE for group in ("surfaces", "radii", "random")},
        ("study", "study"): ASPERITIES}
# Another value of each name that the pages give a default, and what must be beside it.
OTHER = {
    "generate": {("surfaces", "least_distance"): "1.", ("radii", "deviation"): "0.05",
                 ("random", "seed"): "2", ("random", "ensemble"): "3",
                 ("deck", "rotation"): "0.1", ("deck", "x_displacement"): "0.3",
                 ("deck", "y_displacement"): "0.3", ("map", "below_roll_off"): "'none'",
                 ("map", "seed"): "2", ("map", "periodic"): "'off'"},
    "study": {("study", "against"): "'plane'", ("study", "sections"): "2",
              ("study", "places"): "'random'", ("study", "tolerance"): "0.5",
              ("study", "confidence"): "0.05", ("study", "reference"): "'largest'",
              ("study", "steps"): "3", ("study", "factor"): "3."}}
# Defaults that no small specification can distinguish from others.
NOT_COMPARED = {("random", "tries"): "a surface with room needs few tries"}
BESIDE = {("study", "steps"): {"sizes": ""}, ("study", "factor"): {"sizes": "", "steps": "3"}}


def defaults(command):
    """Group, name and default of the rows of a page that end with one."""
    text = (ROOT / "docs" / PAGES[command]).read_text(encoding="utf-8")
    group, found = "", {}
    row = r"^\| (?:`&(\w+)`)? *\| ([^|]*) \| [^|]* \| ([^|]*) \|$"
    for mark, cell, meaning in re.findall(row, text, re.M):
        group = mark or group
        value = re.search(r"(?:^|; |is )`?('\w+'|[\d.]+(?: and [\d.]+)?)`?(?: by default)?$",
                          meaning)
        if value:
            names = re.findall(r"`(\w+)`", cell) or ["deviation"]  # `the same six`
            values = value[1].split(" and ") * (1 if " and " in value[1] else len(names))
            found |= {(group, name): one for name, one in zip(names, values)}
    return found


def result(asperity, folder, command, groups):
    """What a command prints and writes for a specification."""
    (folder / "a.spec").write_text("".join(
        f"&{group} {', '.join(f'{name} = {value}' for name, value in names.items() if value)} /\n"
        for group, names in groups.items()), encoding="ascii")
    for path in folder.glob("out*"):
        path.unlink()
    outputs = ["--upper", "out_%.csv", "--lower", "outl_%.csv"]
    if command == "study":
        outputs = ["--csv", "out.csv"]
    elif "map" in groups or "deck" in groups:
        outputs = ["--output", "out_%.txt"]
    run_program(asperity, command, "a.spec", *outputs, cwd=folder)
    return [(path.name, path.read_bytes()) for path in sorted(folder.glob("out*"))]


@pytest.mark.parametrize("command, group, name", [
    (command, *key) for command, others in OTHER.items() for key in others])
def test_default(asperity, tmp_path, command, group, name):
    base = BASE[command, group]
    written, other = defaults(command)[group, name], OTHER[command][group, name]

    def with_value(value):
        return result(asperity, tmp_path, command, {
            **base, group: {**base[group], **BESIDE.get((group, name), {}), name: value}})

    without = with_value("")
    assert without and with_value(written) == without
    assert with_value(other) != without


@pytest.mark.parametrize("command", PAGES)
def test_all_defaults_are_compared(command):
    assert set(defaults(command)) - set(NOT_COMPARED) == set(OTHER[command])
