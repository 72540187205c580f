"""The Python package and the C interface: built from the checkout as a user does it, and used."""

import csv
import math
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
from builds import ROOT, build
from programs import run_program
from surfaces_csv import records

# States nothing about the build under test: the package has the release build.
pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]

BUMPS = [(0.2 * (i % 3), 0.2 * (i // 3), 0.005 + 0.0002 * (5 * i % 9), 2.0) for i in range(9)]
BALL = [(0.1, 0.1, 0.01, 10.0)]
STEEL = {"elastic_modulus": (210e3, 70e3), "poisson_ratio": (0.3, 0.33)}
CURVE = {"control": "load", "value": 25.0, "points": 5}
FILES = {"positions": "--positions", "states": "--curve", "contacts": "--contacts"}


def run(venv, *words, cwd=ROOT, timeout=100):
    """The standard output of the venv's Python."""
    return run_program(venv / "bin" / "python", *words, cwd=cwd, timeout=timeout).stdout


def test_build_names_missing_requirements(tmp_path):
    """In one sentence, before anything is built: the compiler, fpm, FFTW, the sources."""
    def reported(folder, **environment):
        done = run_program(sys.executable, "-c", "import build_backend as b; b.build_wheel('.')",
                           status=1, cwd=folder, variables=environment)
        return done.stderr.strip()
    assert reported(ROOT / "python", FPM_FC="no-compiler") == (
        "asperity: gfortran is not found; on Debian or Ubuntu: "
        "sudo apt-get install gfortran libc6-dev")
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/gfortran").symlink_to(shutil.which("gfortran"))
    assert reported(ROOT / "python", PATH=str(tmp_path / "bin")) == (
        "asperity: fpm is not found; pip install fpm==0.12.0")
    # A compiler that finds no FFTW.
    (tmp_path / "bin/gfortran").unlink()
    (tmp_path / "bin/gfortran").write_text("#!/bin/sh\nexit 1\n")
    (tmp_path / "bin/gfortran").chmod(0o755)
    (tmp_path / "bin/fpm").symlink_to(tmp_path / "bin/gfortran")
    assert reported(ROOT / "python", PATH=str(tmp_path / "bin")) == (
        "asperity: FFTW is not found; on Debian or Ubuntu: sudo apt-get install libfftw3-dev")
    shutil.copytree(ROOT / "python", tmp_path / "alone")
    assert reported(tmp_path / "alone").startswith(f"asperity: no Fortran sources in {tmp_path}: ")


# ---------------------------------------------------------------- the same numbers

def scene_as_dict(upper, lower, **groups):
    def columns(rows):
        return dict(zip(("x", "y", "height", "radius"), np.array(rows, order="F").T.copy()))
    return {"surfaces": {"upper": columns(upper), "lower": columns(lower)}, "material": STEEL,
            **groups}


def assert_same(table, path, name):
    """Every cell of a table is that of the file, to the last bit."""
    with open(path, encoding="ascii", newline="") as file:
        header, *rows = csv.reader(file)
    assert list(table) == header and table.rows == len(rows)
    met = 0
    for column, cells in zip(header, zip(*rows)):
        own = table[column]
        assert len(own) == len(cells)
        if own.dtype.kind == "U":
            met += sum(a == b for a, b in zip(own, cells))
        else:
            met += sum(math.isnan(a) if b == "" else a == float(b) for a, b in zip(own, cells))
    assert met == len(header) * len(rows)


@pytest.mark.long
@pytest.mark.parametrize("name", ["data/examples/thesis.scene", "data/thesis.deck",
                                  "data/hard/effects/inside_circle_auto.scene",
                                  "data/examples/effects/ten_minutes.scene"])
def test_as_the_program(package, name, tmp_path):
    done = run_program(build("release"), "solve", name,
                       *sum(([option, tmp_path / which] for which, option in FILES.items()), []),
                       cwd=ROOT)
    results = package.solve(ROOT / name)
    for which in FILES:
        assert_same(getattr(results, which), tmp_path / which, which)
    reported = [line.split(": ", 1)[1] for line in results.warnings]
    assert reported == [line.split(": ", 1)[1] for line in done.stderr.splitlines()
                    if ": warning: " in line]
    assert done.stdout == results.summary.replace(str(ROOT / name), name)


def test_report(package):
    for arithmetic in ("ibm370", "real64"):
        archived = ROOT / f"reference_output/thesis.{arithmetic}.txt"
        report = package.report(ROOT / "data/thesis.deck", arithmetic)
        assert report == archived.read_bytes().decode("ascii")
    short = package.report(ROOT / "data/thesis.deck", tables=())
    assert "TABLE VIIA" not in short and "TABLE VI" in short
    with pytest.raises(package.InputError, match="from 1 to 100"):
        package.report(ROOT / "data/thesis.deck", tables=(0,))


def test_summits(package, tmp_path):
    map_file = ROOT / "data/examples/summits/rough.sdf"
    done = run_program(build("release"), "summits", map_file, "--unit", "um", "--output",
                       tmp_path / "s.csv")
    found = package.summits(map_file, unit="um")
    for name, cells in found.items():
        assert list(cells) == [float(row[name]) for row in records(tmp_path / "s.csv")]
    assert found.summary == done.stdout
    shown = re.search(r"^density of summits +(\S+)", done.stdout, re.M)[1]
    assert found.statistics["density"] == pytest.approx(float(shown), rel=1e-13)
    with pytest.raises(package.InputError, match="rule: found nine, expected one of eight"):
        package.summits(map_file, rule="nine")


@pytest.mark.long
def test_generate(package, tmp_path):
    spec = tmp_path / "a.spec"
    spec.write_text("&surfaces number = 9, length = 1., width = 2. / &radii mean = 3. /\n"
                    "&heights mean = 0.1, deviation = 0.01 / &random ensemble = 2 /\n")
    for number, side in enumerate(("upper", "lower")):
        run_program(build("release"), "generate", spec, f"--{side}", tmp_path / side, "--surface",
                    "2")
        for made in package.generate(spec, 2), package.generate(
                {"surfaces": {"number": 9, "length": 1.0, "width": 2.0}, "radii": {"mean": 3.0},
                 "heights": {"mean": 0.1, "deviation": 0.01}, "random": {"ensemble": 2}}, 2):
            for name, cells in made[number].items():
                assert list(cells) == [float(row[name]) for row in records(tmp_path / side)]
    with pytest.raises(package.InputError, match="not in the ensemble"):
        package.generate(spec, 3)


# ---------------------------------------------------------------- arrays

def test_plane_and_files(package, tmp_path, monkeypatch):
    """A ball on a plane under Hertz' load; the same scene with a file."""
    ball = dict(zip(("x", "y", "height", "radius"), ([0.0], [0.0], [0.1], [10.0])))
    scene = {"surfaces": {"upper": ball, "lower": "plane", "nominal_area": 2.0},
             "material": {"contact_modulus": 1000}, "loading": {"control": "approach",
                                                                "value": 0.09}}
    results = package.solve(scene, threads=1)
    assert results.positions["load"][0] == pytest.approx(4 / 3 * 1000 * 10**0.5 * 0.01**1.5,
                                                         rel=1e-12)
    assert results.positions["nominal_pressure"][0] == results.positions["vertical_load"][0] / 2
    (tmp_path / "it's.csv").write_text("x,y,height,radius\n0,0,.1,10\n")
    monkeypatch.chdir(tmp_path)
    scene["surfaces"]["upper"] = "it's.csv"
    assert package.solve(scene).positions["load"][0] == results.positions["load"][0]
    assert package.solve(scene, contacts=False).contacts.rows == 0


# ---------------------------------------------------------------- what goes wrong

def test_problems(package, tmp_path):
    scene = tmp_path / "a:1:2: b.scene"
    scene.write_text("&surfaces upper = 'none.csv', lower = 'plane' /\n&loadin /\n")
    with pytest.raises(package.InputError) as caught:
        package.solve(scene)
    problems = caught.value.problems
    assert [(p.file, p.line, p.column) for p in problems] == [
        (str(scene), 2, 1), (str(scene), 1, 1), (str(scene), 1, 1), (str(scene), 1, 1),
        (str(tmp_path / "none.csv"), 1, 1)]
    assert problems[0].text.startswith("unknown group: found '&loadin', expected ")
    done = run_program(build("release"), "solve", scene, status=2)
    assert str(caught.value) + "\n" == done.stderr
    assert issubclass(package.InputError, ValueError)


def test_failures(package):
    scene = scene_as_dict(BALL, BUMPS, loading={"control": "load", "value": 1e30})
    with pytest.raises(package.ComputeError, match="^scene: position 1: the load is larger than"):
        package.solve(scene)


def test_warnings_and_nan(package):
    """A warning comes from the line that called; a cell that is empty in the file is NaN."""
    with pytest.warns(package.TheoryWarning, match="position 18 and 2 more: contact circles") as it:
        results = package.solve(ROOT / "data/examples/thesis.scene")
    assert it[0].filename == __file__ and len(it) == len(results.warnings) == 3
    assert min(results.positions["error_estimate"]) >= 0
    coupled = package.solve({"surfaces": {"deck": str(ROOT / "data/thesis.deck")},
                             "effects": {"interaction": "coupled"}})
    assert np.isnan(coupled.positions["interaction_estimate"]).all()
    assert len(results.notes) == 1 and "8 lower asperities are higher" in results.notes[0]


def test_library_is_a_guest(venv):
    """It shows the names of the header alone, takes no one's memory over, and has no STOP."""
    library = next(venv.glob("lib/python*/site-packages/asperity/libasperity.so.*"))
    names = {which: {line.split()[0] for line in subprocess.run(
        ["nm", "-D", "-P", f"--{which}-only", library], check=True, capture_output=True,
        text=True).stdout.splitlines()} for which in ("defined", "undefined")}
    header = (ROOT / "include/asperity.h").read_text(encoding="utf-8")
    assert names["defined"] == set(re.findall(r"\b(asperity_\w+)\(", header))
    assert "malloc" in {name.partition("@")[0] for name in names["undefined"]}
    assert not {name for name in names["undefined"] if "stop" in name}
    # A program that was linked with a library of other functions does not take this one.
    assert f"soname: [{library.name}]" in run_program("readelf", "-d", library).stdout
    assert library.name != "libasperity.so"


@pytest.mark.parametrize("compiler, standard", [("gcc", "c99"), ("g++", "c++17")])
def test_header_is_standard(compiler, standard):
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler} here")
    run_program(compiler, f"-xc{standard[1:-2]}", f"-std={standard}", "-pedantic", "-Wall",
                "-Wextra", "-Werror", "-fsyntax-only", ROOT / "include/asperity.h")


def test_header_and_python_agree(package):
    """Structures and functions of the header are those that the package calls."""
    header = ROOT / "include/asperity.h"
    from asperity import _library
    types = {"int": "c_int", "double": "c_double", "char *": "c_char_p", "int *": "LP_c_int",
             "double *": "LP_c_double", "asperity_outcome *": "c_void_p", "void *": "c_void_p",
             "int64_t": "c_long", "void": "NoneType"}
    for name, own in (("surface", "Surface"), ("height_map", "Map"), ("side", "Side"),
                      ("options", "Options"), ("summits_options", "SummitsOptions"),
                      ("problem", "CProblem"), ("half_space", "Body")):
        types[f"asperity_{name} *"] = f"LP_{own}"
    text = re.sub(r"/\*.*?\*/|\bconst ", "", header.read_text(encoding="utf-8"), flags=re.S)

    def ctype(words):
        """The type of `TYPE *name` or `TYPE name[2]` in Python."""
        kind, stars, length = re.fullmatch(
            r"\s*(\w+) ?(\*?)\s*\w*(?:\[(\d)\])?\s*", words).groups()
        found = types[f"{kind} *" if stars else kind]
        return f"{found}_Array_{length}" if length else found

    structures = re.findall(r"typedef struct \{(.*?)\} (asperity_\w+);", text, re.S)
    assert len(structures) == 7
    for body, name in structures:
        fields = []
        for line in filter(str.strip, body.split(";")):
            kind, first, rest = re.fullmatch(r"\s*(\w+) (\*?\w+[^,]*)((?:, .*)?)", line).groups()
            fields += [(one.strip(" *").partition("[")[0], ctype(f"{kind} {one.strip()}"))
                       for one in [first, *rest.split(",")[1:]]]
        own = getattr(_library, types[f"{name} *"][3:])
        assert fields == [(field, kind.__name__) for field, kind in own._fields_], name
    functions = {name: [ctype(result), *map(ctype, rest.split(","))] for result, name, rest in
                 re.findall(r"^(\w+ \*?)asperity_(\w+)\(([^)]*)\);", text, re.M)}
    functions["get_version"].remove("NoneType")
    assert functions == {name: [getattr(kind, "__name__", "NoneType") for kind in kinds]
                         for name, *kinds in _library._FUNCTIONS}


def test_earlier_names_of_columns(package):
    """`approach` and `decrease` answer with a warning that points at the caller."""
    results = package.solve(scene_as_dict(BALL, BUMPS, loading=CURVE,
                                          effects={"interaction": "off"}))
    for table in (results.positions, results.states, results.contacts):
        assert "approach" not in list(table)
        for earlier, name in (("approach", "separation"), ("decrease", "compression")):
            with pytest.warns(DeprecationWarning, match=name) as reported:
                assert list(table[earlier]) == list(table[name])
            assert reported[0].filename == __file__
    with pytest.raises(KeyError):
        results.states["penetrations"]
