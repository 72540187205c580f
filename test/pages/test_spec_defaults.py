"""The defaults of specifications on the pages: a specification with a default written has the
results of one without it, and another value has others."""

import re

import pytest
from builds import ROOT
from programs import run_program

pytestmark = pytest.mark.pages

PAGE = ROOT / "docs/reference/generate.md"
# Small specifications, by groups; names that are compared are left out of it.
ASPERITIES = {
    "surfaces": {"number": "300", "length": "40.", "width": "40."},
    "heights": {"mean": "0.1", "deviation": "0.02"},
    "radii": {"mean": "1."}, "random": {"ensemble": "2"}}
DECK = {"surfaces": {"number": "9", "length": "3.", "width": "4."},
        "heights": {"mean": "0.1", "deviation": "0.02"}, "radii": {"mean": "0.5"},
        "deck": {"elastic_modulus": "4e5", "poisson_ratio": "0.4", "allowed_stress": "5e3"}}
MAP = {"map": {"pixels": "32", "spacing": "0.5", "hurst": "0.8", "rms_slope": "0.1",
               "roll_off": "8."}}
BASE = {"deck": DECK, "map": MAP, "surfaces": ASPERITIES, "radii": ASPERITIES,
        "random": ASPERITIES}
# Another value of each name that the page gives a default.
OTHER = {("surfaces", "least_distance"): "1.", ("radii", "deviation"): "0.05",
         ("random", "seed"): "2", ("random", "ensemble"): "3", ("deck", "rotation"): "0.1",
         ("deck", "x_displacement"): "0.3", ("deck", "y_displacement"): "0.3",
         ("map", "below_roll_off"): "'none'", ("map", "seed"): "2", ("map", "periodic"): "'off'"}
# Defaults that no small specification can distinguish from others.
NOT_COMPARED = {("random", "tries"): "a surface with room needs few tries"}


def defaults():
    """Group, name and default of the rows of the page that end with one."""
    text = PAGE.read_text(encoding="utf-8")
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


def result(asperity, folder, groups):
    """What the command prints and writes for a specification."""
    (folder / "a.spec").write_text("".join(
        f"&{group} {', '.join(f'{name} = {value}' for name, value in names.items() if value)} /\n"
        for group, names in groups.items()), encoding="ascii")
    for path in folder.glob("out*"):
        path.unlink()
    outputs = ["--upper", "out_%.csv", "--lower", "outl_%.csv"]
    if "map" in groups or "deck" in groups:
        outputs = ["--output", "out_%.txt"]
    run_program(asperity, "generate", "a.spec", *outputs, cwd=folder)
    return [(path.name, path.read_bytes()) for path in sorted(folder.glob("out*"))]


@pytest.mark.parametrize("group, name", OTHER)
def test_default(asperity, tmp_path, group, name):
    base = BASE[group]
    written, other = defaults()[group, name], OTHER[group, name]

    def with_value(value):
        return result(asperity, tmp_path, {**base, group: {**base[group], name: value}})

    without = with_value("")
    assert without and with_value(written) == without
    assert with_value(other) != without


def test_all_defaults_are_compared():
    assert set(defaults()) - set(NOT_COMPARED) == set(OTHER)
