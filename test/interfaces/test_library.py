"""The library: its examples, and a project outside that uses it through fpm."""

import os
import re
import shutil

import numpy as np
import pytest
from builds import ROOT, build
from programs import run_program
from surfaces_csv import records, solve, write_csv_scene

# The made-up case of example/close_to_a_load.f90, from its text.
BALL = [(0.1, 0.1, 0.01, 10.0)]
BUMPS = [(0.2 * (i % 3), 0.2 * (i // 3), 0.005 + 0.0002 * (5 * i % 9), 2.0) for i in range(9)]
MODULI, RATIOS, LOAD = (210000.0, 70000.0), (0.3, 0.33), 25.0


@pytest.fixture(scope="module")
def example(asperity):
    """Runs an example by name; fpm builds them beside the executable."""
    folder = asperity.parent.parent / "example"
    if not (folder / "read_a_scene").exists():
        folder = build("release").parent.parent / "example"

    def run(name, *words):
        done = run_program(folder / name, *words, status=None, cwd=ROOT)
        return done.returncode, done.stdout, done.stderr
    return run


def test_read_a_scene(example, asperity, tmp_path):
    """The example prints the totals that the program writes, to its seven digits."""
    status, text, errors = example("read_a_scene")
    assert status == 0 and errors == ""
    run_program(asperity, "solve", ROOT / "data/examples/thesis.scene", "--quiet", "--positions",
                "p.csv", cwd=tmp_path)
    expected = records(tmp_path / "p.csv")
    lines = text.splitlines()[1:]
    assert len(lines) == len(expected) == 100
    met = sum(line == f"{int(row['position']):8d}{int(row['contacts']):10d}"
              f"{float(row['load']):15.6E}{float(row['area']):15.6E}"
              for line, row in zip(lines, expected))
    assert met == 100


@pytest.mark.long
def test_read_a_scene_of_a_map(example, asperity, tmp_path):
    scene = ROOT / "data/examples/summits/press_samples.scene"
    status, text, errors = example("read_a_scene", scene)
    assert status == 0 and errors == ""
    run_program(asperity, "solve", scene, "--quiet", "--positions", "p.csv", cwd=tmp_path)
    row, = records(tmp_path / "p.csv")
    assert text.splitlines()[-1] == (f"{1:8d}{int(row['contacts']):10d}"
                                     f"{float(row['load']):15.6E}{float(row['area']):15.6E}")


def test_read_a_scene_returns_problems(example, tmp_path):
    scene = tmp_path / "bad.scene"
    scene.write_text("&surfaces deck = 'none.deck' /\n")
    status, text, errors = example("read_a_scene", scene)
    assert status == 2 and text == "" and "none.deck" in errors


def test_summits_of_a_map(example, asperity, tmp_path):
    """The example prints what the program prints, to its seven digits."""
    path = ROOT / "data/examples/summits/rough.sdf"
    status, text, errors = example("summits_of_a_map", path)
    assert status == 0 and errors == ""
    done = run_program(asperity, "summits", path)
    for name, own in (("density of summits", "density"), ("mean summit height", "mean height"),
                      ("mean summit curvature", "mean curvature")):
        found = [re.search(rf"^{key} +(\S+)", output, re.M)[1]
                 for key, output in ((name, done.stdout), (own, text))]
        assert abs(float(found[0]) / float(found[1]) - 1) < 1e-6
    status, text, errors = example("summits_of_a_map", tmp_path)
    assert status == 2 and "cannot be read" in errors


def test_close_to_a_load(example, asperity, tmp_path):
    """Surfaces in memory and from CSV files give the same contacts. Their loads add up, and Hertz'
    greatest pressure, (6 P E**2 / (pi**3 R**2))**(1/3), goes with each."""
    status, text, errors = example("close_to_a_load")
    assert status == 0 and errors == ""
    rows = np.array([[float(word) for word in line.split()] for line in text.splitlines()[2:]])
    assert len(rows) >= 3 and abs(rows[:, 4].sum() - LOAD) < 1e-6 * len(rows)
    modulus = 1 / sum((1 - nu**2) / e for e, nu in zip(MODULI, RATIOS))
    radius = 10.0 * 2.0 / 12.0
    hertz = np.cbrt(6 * rows[:, 4] * modulus**2 / (np.pi**3 * radius**2))
    # The printed load has six decimals, the pressure two; inclined contacts touch 1e-6 apart.
    assert np.abs(rows[:, 5] - hertz).max() <= 0.02
    scene = write_csv_scene(tmp_path, BALL, BUMPS, modulus=MODULI, ratio=RATIOS,
                            loading={"control": "load", "value": LOAD},
                            effects={"interaction": "coupled"})
    contacts = solve(asperity, scene, folder=tmp_path).contacts
    lines = [f"{int(c['upper']):6d}{int(c['lower']):6d}{float(c['x']):8.4f}{float(c['y']):8.4f}"
             f"{float(c['load']):11.6f}{float(c['maximum_pressure']):12.2f}" for c in contacts]
    met = sum(a == b for a, b in zip(lines, text.splitlines()[2:]))
    assert len(lines) == len(rows) == met


def test_from_c(example, asperity, tmp_path):
    """The example in C prints what the program writes, to the last bit; what is wrong it
    reports."""
    scene = ROOT / "data/examples/thesis.scene"
    run_program(asperity, "solve", scene, "--quiet", "--positions", "p.csv", cwd=tmp_path)
    status, text, errors = example("press_two_surfaces", scene)
    assert status == 0 and errors.count("warning") == 3
    assert [tuple(map(float, line.split())) for line in text.splitlines()] == [
        (float(row["separation"]), float(row["load"])) for row in records(tmp_path / "p.csv")]
    # One ball under the load of the example.
    status, text, errors = example("press_two_surfaces")
    assert status == 0 and errors == "" and float(text.split()[-1]) == pytest.approx(LOAD, 1e-6)
    status, text, errors = example("press_two_surfaces", tmp_path / "none.scene")
    assert status == 2 and text == "" and "none.scene:1:1: cannot be opened" in errors
    status, text, errors = example("press_two_surfaces", ROOT / "data/hard/load_beyond_all.scene")
    assert status == 1 and text == "" and "position 1: the load is larger than" in errors


OUTSIDE = """program outside
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity, only: build_scene, last_state, problem_list, run_options, scene, scene_results, &
                      scene_surface, solve, take_surface
  implicit none
  character(len=*), parameter :: steel = '&material elastic_modulus = 2*200e3, ' // &
    'poisson_ratio = 2*0.3 / &loading control = ''approach'', value = 0.29 /'
  type(scene_surface) :: upper, lower
  type(scene) :: pair
  type(scene_results) :: results
  type(problem_list) :: problems
  character(len=:), allocatable :: failure

  call take_surface('upper', [0.0_real64], [0.0_real64], [0.2_real64], [1.0_real64], upper, &
                    problems)
  call take_surface('lower', [0.0_real64], [0.0_real64], [0.1_real64], [1.0_real64], lower, &
                    problems)
  call build_scene(upper, lower, steel, pair, problems)
  call solve(pair, results, failure, run_options(threads=2))
  print '(i0, l2, es25.16)', problems%count(), allocated(failure), &
    results%positions(1)%states(1)%load
  call take_surface('upper', [0.0_real64], [0.0_real64, 1.0_real64], [0.2_real64], &
                    [-1.0_real64], upper, problems)
  call take_surface('lower', [0.0_real64], [0.0_real64], [0.1_real64], [-1.0_real64], lower, &
                    problems)
  call build_scene(upper, lower, steel // ' &surfaces deck = ''a'' /', pair, problems)
  print '(a)', problems%text()
end program outside
"""


@pytest.mark.long
@pytest.mark.once
def test_project_outside(asperity, tmp_path):
    """A project that names this one by its path builds with it, and runs. Two spheres of radius 1
    closed by 0.01: load 4/3 E sqrt(R) 0.01**1.5 (Hertz), E = 2e5 / (2 (1 - 0.3**2)), R = 1/2."""
    fpm = ROOT / ".venv" / "bin" / "fpm"
    fpm = fpm if fpm.exists() else shutil.which("fpm")
    # fpm takes no absolute path.
    path = os.path.relpath(ROOT, tmp_path)
    (tmp_path / "fpm.toml").write_text(
        f'name = "outside"\n[dependencies]\nasperity.path = "{path}"\n')
    (tmp_path / "app").mkdir()
    (tmp_path / "app" / "main.f90").write_text(OUTSIDE)
    done = run_program(fpm, "run", "--flag", "-O0", cwd=tmp_path, timeout=500)
    first, rest = re.search(r"^(0 F [^\n]*)\n(.*)", done.stdout, re.M | re.S).groups()
    expected = 4 / 3 * 2e5 / (2 * (1 - 0.3**2)) * np.sqrt(0.5) * 0.01**1.5
    assert float(first.split()[2]) == pytest.approx(expected, rel=1e-14)
    assert "upper: found 1 x, 2 y, 1 heights and 1 radii" in rest
    assert ("lower.radius: found -1.000000E+000 as number 1 of 1, "
            "expected a finite number more than 0") in rest
    assert "deck: found beside a surface that is given as an array, expected none" in rest
