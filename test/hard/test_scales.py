"""Any unit of length and of modulus: the same digits, in every command and file.

Units from 1e-12 to 1e12, as powers of two where the files hold binary numbers, as powers of ten
where they hold decimal ones. Beyond the range of a double a run ends with a sentence.
"""

import csv
from decimal import Decimal

import metamorphic_scenes as scenes
import pytest
from programs import run_program
from surfaces_csv import records


@pytest.mark.parametrize("control", ["limit", "approach"])
@pytest.mark.parametrize("lengths, moduli", [(-330, -480), (-330, 0), (300, 500), (-170, -800)])
def test_solve_beyond_range(asperity, lengths, moduli, control):
    """A load or an area that a double does not hold is reported, and is never 0 or Infinity."""
    groups = {"material": {"elastic_modulus": [2.0e5, 1.0e5], "poisson_ratio": [0.3, 0.25]},
              "loading": {"control": control}}
    if control == "approach":
        groups["loading"]["value"] = 0.9375
    else:
        groups["limit"] = {"criterion": "pressure", "value": 1e3}
    row = (0.0, 0.0, 0.5, 1.0)
    scene = scenes.Scene([row], [row], groups)
    done = scenes.run(asperity, scene)
    assert done.status == 0 and float(done.positions[0]["load"]) > 0.0
    held = all(-1000 < a * lengths + b * moduli < 1000 for a, b in ((2, 0), (2, 1), (0, 1)))
    done = scenes.run(asperity, scene.scaled(lengths, moduli))
    assert done.status == (0 if held else 1), done.stderr
    if not held:
        assert "range" in done.stderr or "too small" in done.stderr


SPEC = """&surfaces number = 200, length = 20{L}, width = 30{L}, least_distance = .5{L} /
&heights mean = 127{L}, deviation = 30.48{L}, lowest = 95.5{L}, highest = 185.9{L} /
&radii mean = 1270{L}, deviation = 100{L}, lowest_deviation = -2., highest_deviation = 2. /
&random seed = 1976, ensemble = 2 /
"""


@pytest.mark.parametrize("power", [12, -12, 100, -100])
def test_a_surface_has_the_same_digits_in_any_power_of_ten(power, asperity, tmp_path):
    """Decimal numbers: the same digits behind another power of ten."""
    def surface(power):
        (tmp_path / "g.spec").write_text(SPEC.replace("{L}", f"e{power}"), encoding="ascii")
        done = run_program(asperity, "generate", "g.spec", "--surface", "1", cwd=tmp_path)
        return [[Decimal(cell) for cell in row]
                for row in list(csv.reader(done.stdout.splitlines()))[1:]]

    one, two = surface(0), surface(power)
    assert len(one) == 200
    assert [[cell.scaleb(power) for cell in row] for row in one] == two


def test_a_march_has_as_many_steps_in_any_unit(asperity, tmp_path):
    """The steps of a march are so long for the surfaces, not for their unit: as many rows, and the
    errors of exact events and of steps are alike, in a time that is bounded."""
    rows = []
    for scale in (1.0, 1e-12, 1e12):
        for name, height in (("u", 0.5), ("l", 0.4)):
            (tmp_path / f"{name}.csv").write_text("x,y,height,radius\n" + "".join(
                f"{3 * i * scale!r},{0.1 * i * scale!r},{(height + 0.001 * i) * scale!r},"
                f"{scale!r}\n" for i in range(3)), encoding="ascii")
        (tmp_path / "s.scene").write_text(
            "&surfaces upper = 'u.csv', lower = 'l.csv' /\n"
            "&material elastic_modulus = 2*2e5, poisson_ratio = 2*0.3 /\n"
            f"&limit criterion = 'load', value = {10 * scale ** 2!r} /\n", encoding="ascii")
        run_program(asperity, "accuracy", "s.scene", "--seconds", "1", "--quiet", "--csv", "a.csv",
                    cwd=tmp_path)
        rows.append(records(tmp_path / "a.csv"))
    named = [[(row["family"], row["arithmetic"], row["overlap"]) for row in table]
             for table in rows]
    assert named[0] and named[0] == named[1] == named[2]
