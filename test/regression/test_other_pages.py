"""Pages on other programs and on the thesis: their numbers, and rows without a gap."""

import math
import re
import sys

import pytest
from builds import ROOT
from programs import run_program

PROGRAMS = (ROOT / "docs/how-to/other-programs.md").read_text(encoding="utf-8")
THESIS = (ROOT / "docs/theory/thesis-table.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")
VALIDATION = (ROOT / "docs/reference/validation.md").read_text(encoding="utf-8")


def rows(text, heading):
    """The cells of the first table below a heading, without its head."""
    lines = text.split(f"\n## {heading}\n")[1].split("\n## ")[0].splitlines()
    table = [line for line in lines if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table[2:]]


@pytest.mark.once
@pytest.mark.filterwarnings("ignore")
def test_the_same_map_in_three_programs(package, capsys, monkeypatch, tmp_path):
    """Each block prints the numbers below it, and all agree to 1e-8."""
    (tmp_path / "data").symlink_to(ROOT / "data")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    ours, *others = [[float(word) for word in line.split()]
                     for line in re.findall(r"```\n(0[.\d]+ [.\d]+ [.\d]+)\n```", PROGRAMS)]
    blocks = re.findall(r"```py(?:thon)?\n(.*?)```", PROGRAMS, re.S)
    save = re.search(r"`(np[.]save\(.*?\))`", PROGRAMS)[1]
    blocks[0] += save
    assert len(blocks) == 3 and len(others) == 2
    for block, numbers in zip(blocks, (ours, *others)):
        if sys.version_info < (3, 11) and block != blocks[0]:
            continue  # No wheels of the others.
        exec(compile(block, "page", "exec"), {})
        printed = re.search(r"^0[.]1\S+ \S+ \S+$", capsys.readouterr().out, re.M)[0]
        assert [float(word) for word in printed.split()] == pytest.approx(numbers, rel=1e-8)
        assert numbers == pytest.approx(ours, rel=1e-8)


@pytest.mark.once
def test_rows_of_the_thesis():
    """Each table and figure has a row; no cell is empty; a `none` has a reason."""
    tables, figures = rows(THESIS, "Tables"), rows(THESIS, "Figures")
    numbers = [number for row in figures for low, high in re.findall(r"(\d+)(?: to (\d+))?", row[0])
               for number in range(int(low), int(high or low) + 1)]
    assert sorted(numbers) == list(range(1, 29))
    assert [row[0].split(",")[0].split(" ")[0] for row in tables] == \
        ["I", "II", "IIIA", "IV", "V", "VI", "VIIA"]
    for row in (*tables, *figures, *rows(THESIS, "Theories")):
        assert len(row) == 3 and all(row), row
        # The tests run the commands, and the blocks of this page and of that on balls.
        assert re.match(r"none: \w+|as Figures|`asperity |\[(below|ball on disc)\]\(", row[2]), row


@pytest.mark.once
@pytest.mark.parametrize("command", sorted(set(re.findall(r"`asperity ([^`]+)`", THESIS))))
def test_commands_of_the_thesis(asperity, tmp_path, command):
    """Each command of the table runs without a problem and prints what its row names."""
    for path in ROOT.glob("[!.]*"):
        (tmp_path / path.name).symlink_to(path)
    done = run_program(asperity, *command.split(), cwd=tmp_path)
    assert done.stdout
    if "--depths" in command:
        # Under a sphere: 0.31 of the greatest pressure, at 0.48 of the radius for nu = 0.3.
        pressure = float(re.search(r"greatest pressure +(\S+)", done.stdout)[1])
        area = float(re.search(r"contact area +(\S+)", done.stdout)[1])
        shear, depth = re.search(r"shear stress (\S+) at depth ([\d.]+)", done.stdout).groups()
        assert float(shear) == pytest.approx(0.31 * pressure, rel=0.005)
        assert float(depth) == pytest.approx(0.48 * (area / math.pi)**0.5, abs=0.005)


@pytest.mark.once
def test_cells_of_the_readme():
    """Each cell of asperity has a link to its page, or is a `no`."""
    table = rows(README, "Beside other programs")
    assert len(table) >= 9
    for row in table:
        assert len(row) == 4 and all(row) and (row[1] == "no" or "](docs/" in row[1]), row
    compared, met, missed = re.search(r"\| all \| \| (\d+) \| (\d+) \| (\d+) \|",
                                      VALIDATION).groups()
    assert f"{met} of {compared} numbers" in README and missed == "10" and "ten are" in README


@pytest.mark.parametrize("scale, load", [(100.0, 300.0), (0.01, 1e-4), (1e4, 7.0), (3.0, 9.0)])
def test_similitude(package, scale, load):
    """Table II of the thesis: factors of lengths, areas and limits by those of radii and loads."""
    def pair(factor, loading, **limit):
        upper, lower = ({"x": [0.0], "y": [0.0], "height": [0.2 * factor], "radius": [r * factor]}
                        for r in (1.0, 3.0))
        results = package.solve({
            "surfaces": {"upper": upper, "lower": lower}, "material": {"contact_modulus": 1e5},
            "loading": loading, "effects": {"interaction": "off"}, **limit})
        return {**{name: results.states[name][-1] for name in ("compression", "area", "load")},
                "radius": results.contacts["contact_radius"][-1]}

    real = pair(1.0, {"control": "load", "value": 20.0})
    model = pair(scale, {"control": "load", "value": 20.0 * load})
    factors = {"compression": (load**2 / scale)**(1 / 3), "radius": (load * scale)**(1 / 3),
               "area": (load * scale)**(2 / 3)}
    for name, factor in factors.items():
        assert model[name] / real[name] == pytest.approx(factor, rel=1e-9), name
    limit = {"limit": {"criterion": "pressure", "value": 3000.0}}
    real, model = (pair(factor, {"control": "limit"}, **limit) for factor in (1.0, scale))
    assert model["load"] / real["load"] == pytest.approx(scale**2, rel=1e-9)
    assert model["compression"] / real["compression"] == pytest.approx(scale, rel=1e-9)
