"""Pages on other programs and on the thesis: their numbers and commands."""

import math
import re
import sys

import pytest
from builds import ROOT
from programs import run_program

PROGRAMS = (ROOT / "docs/how-to/other-programs.md").read_text(encoding="utf-8")
THESIS = (ROOT / "docs/theory/thesis-table.md").read_text(encoding="utf-8")


@pytest.mark.once
@pytest.mark.filterwarnings("ignore")
def test_the_same_map_in_three_programs(package, capsys, monkeypatch, checkout):
    """Each block prints the numbers below it, and all agree to 1e-8."""
    monkeypatch.chdir(checkout)
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    monkeypatch.setenv("MPLBACKEND", "Agg")
    ours, *others = [[float(word) for word in line.split()]
                     for line in re.findall(r"```\n(0[.\d]+ [.\d]+ [.\d]+)\n```", PROGRAMS)]
    blocks = re.findall(r"```py(?:thon)?\n(.*?)```", PROGRAMS, re.S)
    save = re.search(r"`(np[.]save\(.*?\))`", PROGRAMS)[1]
    blocks[0] += save
    assert len(blocks) == 3 and len(others) == 2
    curve = blocks[0].partition("results = ")[2].partition("plot()")[0]
    assert curve.count("\n") == 4  # five lines
    for block, numbers in zip(blocks, (ours, *others)):
        if sys.version_info < (3, 11) and block != blocks[0]:
            continue  # No wheels of the others.
        exec(compile(block, "page", "exec"), {})
        printed = re.search(r"^0[.]1\S+ \S+ \S+$", capsys.readouterr().out, re.M)[0]
        assert [float(word) for word in printed.split()] == pytest.approx(numbers, rel=1e-8)
        assert numbers == pytest.approx(ours, rel=1e-8)


@pytest.mark.once
@pytest.mark.parametrize("command", sorted(set(re.findall(r"`asperity ([^`]+)`", THESIS))))
def test_commands_of_the_thesis(asperity, checkout, command):
    """Each command of the table runs without a problem and prints what its row names."""
    done = run_program(asperity, *command.split(), cwd=checkout)
    assert done.stdout
    if "--depths" in command:
        # Under a sphere: 0.31 of the greatest pressure, at 0.48 of the radius for nu = 0.3.
        pressure = float(re.search(r"greatest pressure +(\S+)", done.stdout)[1])
        area = float(re.search(r"contact area +(\S+)", done.stdout)[1])
        shear, depth = re.search(r"shear stress (\S+) at depth ([\d.]+)", done.stdout).groups()
        assert float(shear) == pytest.approx(0.31 * pressure, rel=0.005)
        assert float(depth) == pytest.approx(0.48 * (area / math.pi)**0.5, abs=0.005)


@pytest.mark.once
@pytest.mark.filterwarnings("ignore")
def test_limits_and_nominal_pressures(package, capsys, monkeypatch, checkout):
    """The thesis has 0.021 cm and 380 N; the pressures are total loads over 12 in**2."""
    monkeypatch.chdir(checkout)
    (block,) = re.findall(r"## Limits.*?```python\n(.*?)```", THESIS, re.S)
    exec(compile(block, "page", "exec"), {})
    limit, pressures = ([float(word) for word in line.split()]
                        for line in capsys.readouterr().out.splitlines())
    modulus, radius = 2e4 * 9.8 / (2 * (1 - 0.42**2)), 0.635
    compression = radius * (2200 * 9.8 / modulus)**2
    load = 4 / 3 * modulus * (radius * compression**3)**0.5
    assert limit == pytest.approx([compression, load], rel=1e-9)
    assert f"{compression:.4f} cm and {load:.1f} N" in THESIS
    # Table VI without faults, a vertical load (docs/theory/faults.md), over 12 square inches.
    assert [p * 12 * 2.54**2 for p in pressures] == pytest.approx([400.50, 1357.71], rel=1e-5)


@pytest.mark.once
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
