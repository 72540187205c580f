"""The files of `make wheel`, as a user has them: the wheel in an empty environment, where nothing
but the environment is on the path, and the source distribution.

That no library of the system serves is seen twice: in what the dynamic linker finds for the files,
and in what a process that has solved a scene has mapped.
"""

import csv
import email
import os
import re
import shutil
import subprocess
import sys
import tarfile
import time
import tomllib
import zipfile

import pytest
from builds import ROOT

NAMES = ("libgfortran", "libgomp", "libquadmath", "libfftw3")
LIBRARY = re.compile(rf"\b({'|'.join(NAMES)})[-.\w]*\.so[.\w]*")
# Parts of the C library, which every Linux has.
OF_THE_SYSTEM = {"linux-vdso.so.1", "ld-linux-x86-64.so.2", "libc.so.6", "libm.so.6",
                 "libmvec.so.1"}
SCENE = """&surfaces  deck = 'thesis.deck' /
&motion    x_first = 0.1, x_step = 0.1, positions = 10 /
&effects   interaction = 'boundary' /
"""
SOLVE = "import asperity; print(asperity.solve('some.scene').states['load'].tolist())"
# With the files that the process has mapped, which is more than it was linked with.
MAPPED = SOLVE + "; print(open('/proc/self/maps').read())"


def only(pattern, folder="dist"):
    """The one file that a build has left."""
    found = list((ROOT / folder).glob(pattern))
    assert len(found) == 1, f"{folder}/{pattern}: {found}"
    return found[0]


@pytest.fixture(scope="module")
def wheel():
    return only("asperity-*.whl")


@pytest.fixture(scope="module")
def environment(wheel, tmp_path_factory):
    """An empty environment with the wheel, installed without a network."""
    folder = tmp_path_factory.mktemp("environment")
    subprocess.run([sys.executable, "-m", "venv", folder], check=True, timeout=300)
    begun = time.monotonic()
    done = run(folder, "pip", "install", "--no-index", "--no-deps", "--disable-pip-version-check",
               wheel)
    assert done.returncode == 0, done.stdout + done.stderr
    print(f"\npip install {wheel.name}: {time.monotonic() - begun:.1f} s, "
          f"{wheel.stat().st_size / 1e6:.1f} MB")
    return folder


@pytest.fixture
def scene(tmp_path):
    """A folder with a scene whose contacts are resolved with Fourier transforms."""
    shutil.copy(ROOT / "data/thesis.deck", tmp_path)
    (tmp_path / "some.scene").write_text(SCENE)
    return tmp_path


def run(environment, *words, cwd=None, **variables):
    """Runs a command of an environment, which sees nothing else of the machine."""
    return subprocess.run(
        [environment / "bin" / words[0], *words[1:]], cwd=cwd or environment,
        env={"PATH": str(environment / "bin"), **variables}, stdin=subprocess.DEVNULL,
        capture_output=True, text=True, timeout=300)


def printed(*words, **settings):
    done = run(*words, **settings)
    assert done.returncode == 0, done.stderr
    return done.stdout


def package(environment):
    return next(environment.glob("lib/python*/site-packages"))


def linked(path):
    """Libraries that the dynamic linker finds for a file: name and place."""
    lines = subprocess.run(["ldd", path], check=True, capture_output=True, text=True).stdout
    return {words[0].rpartition("/")[2]: words[2] if "=>" in words else words[0]
            for words in map(str.split, lines.splitlines())}


def assert_inside(places, folder):
    """Each of the libraries is there, and all are in a folder."""
    found = {match[1]: place for place in places if (match := LIBRARY.search(place))}
    assert set(found) == set(NAMES), places
    outside = [place for place in places
               if LIBRARY.search(place) and not os.path.realpath(place).startswith(f"{folder}/")]
    assert not outside, f"libraries of the system are used: {outside}"


def test_auditwheel_shows_manylinux(wheel):
    tag = re.search(r"-py3-none-(manylinux_2_\d+_x86_64)\.whl$", wheel.name)
    assert tag, wheel.name
    said = subprocess.run([sys.executable, "-m", "auditwheel", "show", wheel], check=True,
                          capture_output=True, text=True, timeout=300).stdout
    assert f'consistent with the following platform tag: "{tag[1]}"' in " ".join(said.split())


# ---------------------------------------------------------------- whose libraries serve

def test_library_finds_those_of_the_wheel(environment):
    assert_inside(linked(package(environment) / "asperity/libasperity.so.1").values(), environment)


def test_process_uses_those_of_the_wheel(environment, scene):
    text = printed(environment, "python", "-c", MAPPED, cwd=scene)
    assert_inside(set(text.split()), environment)


def test_check_sees_libraries_of_the_system(tmp_path):
    """Without auditwheel the same wheel has them from the system, and that fails."""
    with zipfile.ZipFile(only("asperity-*.whl", "build/wheel")) as bare:
        path = bare.extract("asperity/libasperity.so.1", tmp_path)
    with pytest.raises(AssertionError, match="libraries of the system are used"):
        assert_inside(linked(path).values(), tmp_path)


def test_program_has_its_libraries_inside(environment):
    program = environment / "bin/asperity"
    assert program.read_bytes().startswith(b"\x7fELF")
    assert set(linked(program)) <= OF_THE_SYSTEM


def test_idle_threads_sleep(environment):
    """The settings that the package makes reach the OpenMP runtime of the wheel, and those of the
    user stay."""
    def shown(**variables):
        done = run(environment, "python", "-c", "import asperity", OMP_DISPLAY_ENV="verbose",
                   **variables)
        return dict(re.findall(r"(OMP_WAIT_POLICY|GOMP_SPINCOUNT) = '(\w+)'", done.stderr))
    assert shown() == {"OMP_WAIT_POLICY": "PASSIVE", "GOMP_SPINCOUNT": "2000"}
    assert shown(OMP_WAIT_POLICY="active")["OMP_WAIT_POLICY"] == "ACTIVE"


@pytest.mark.parametrize("first", [True, False], ids=["first", "last"])
def test_beside_other_compiled_packages(environment, scene, first):
    """numpy, scipy and SurfaceTopography bring libraries of the same kind: before and after."""
    others = "import numpy, scipy.fft, SurfaceTopography; x = numpy.ones((300, 300)) @ " \
        "numpy.ones((300, 300)); assert x[0, 0] == 300"
    words = "; ".join(["import asperity", others, SOLVE] if first else [others, SOLVE])
    done = subprocess.run([sys.executable, "-c", words], cwd=scene, check=True, timeout=300,
                          env={**os.environ, "PYTHONPATH": str(package(environment))},
                          capture_output=True, text=True)
    assert done.stdout == printed(environment, "python", "-c", SOLVE, cwd=scene)


# ---------------------------------------------------------------- the command and the package

def test_report_of_the_thesis(environment):
    archived = (ROOT / "reference_output/thesis.ibm370.txt").read_text(encoding="ascii")
    deck = ROOT / "data/thesis.deck"
    assert printed(environment, "asperity", deck) == archived
    text = f"import asperity; print(asperity.report({str(deck)!r}), end='')"
    assert printed(environment, "python", "-c", text) == archived


def test_same_numbers(environment, scene):
    """The program, which has its own libraries inside, and the package: to the last bit."""
    printed(environment, "asperity", "solve", "some.scene", "--quiet", "--curve", "curve.csv",
            cwd=scene)
    with open(scene / "curve.csv", encoding="ascii", newline="") as file:
        loads = [float(row["load"]) for row in csv.DictReader(file)]
    assert len(loads) == 10
    assert printed(environment, "python", "-c", SOLVE, cwd=scene) == f"{loads}\n"


def test_command(environment, scene):
    """Output, messages and exit status are those of the program."""
    version = tomllib.loads((ROOT / "fpm.toml").read_text(encoding="utf-8"))["version"]
    assert printed(environment, "asperity", "--version").startswith(f"asperity {version}\n")
    assert "asperity solve" in printed(environment, "asperity", "--help")
    done = run(environment, "asperity", "solve", "none.scene", cwd=scene)
    assert (done.returncode, done.stdout) == (2, "") and "none.scene" in done.stderr


def test_example(environment):
    """The example of the package's description, without another package."""
    page = (ROOT / "python/README.md").read_text(encoding="utf-8")
    lines = page.split("```python\n")[1].split("```")[0]
    said = printed(environment, "python", "-c", lines, cwd=ROOT)
    assert re.search(r"^total load +40$", said, re.M), said


# ---------------------------------------------------------------- what the files state

def test_metadata(wheel):
    """Every optional package and nothing required; the licences of all that is inside."""
    values = tomllib.loads((ROOT / "python/pyproject.toml").read_text(encoding="utf-8"))["project"]
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        info = next(name for name in names if name.endswith(".dist-info/METADATA"))
        stated = email.message_from_bytes(archive.read(info))
    extras = values["optional-dependencies"]
    assert stated.get_all("Provides-Extra") == list(extras)
    assert stated.get_all("Requires-Dist") == [
        f'{package}; extra == "{extra}"' for extra in extras for package in extras[extra]]
    assert set(extras["all"]) == {package for extra in extras for package in extras[extra]}
    for field, value in (("Name", "name"), ("Version", "version"), ("Summary", "description"),
                         ("Requires-Python", "requires-python")):
        assert stated[field] == values[value]
    assert stated.get_all("Classifier") == values["classifiers"]
    assert "GPL-2.0-or-later" in stated["License-Expression"].split(" AND ")
    page = (ROOT / "python/README.md").read_text(encoding="utf-8")
    assert stated.get_payload() == page
    texts = stated.get_all("License-File")
    assert {"LICENSE", "bundled/FFTW.txt", "bundled/GCC.txt", "bundled/GPL-3.txt"} <= set(texts)
    assert {info.replace("METADATA", f"licenses/{text}") for text in texts} <= set(names)


def test_package_files(wheel):
    """Every module, stub and mark of the package is in the wheel, and what a C program needs."""
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if name.startswith("asperity/")}
    tracked = subprocess.run(["git", "ls-files", "asperity"], cwd=ROOT / "python", check=True,
                             capture_output=True, text=True).stdout.split()
    assert {*tracked, "asperity/asperity.h", "asperity/asperity.pc"} == {
        name for name in names if name[-1] != "/" and ".so." not in name}


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    """The folder of the source distribution."""
    folder = tmp_path_factory.mktemp("sources")
    path = only("asperity-*.tar.gz")
    with tarfile.open(path) as archive:
        archive.extractall(folder)
    assert [entry.name for entry in folder.iterdir()] == [path.name.removesuffix(".tar.gz")]
    return folder / path.name.removesuffix(".tar.gz")


def test_sources_are_complete(unpacked):
    """All that a build compiles, byte for byte."""
    tracked = subprocess.run(["git", "ls-files", "app", "include", "src", "python/asperity"],
                             cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    for name in [*tracked, "python/build_backend.py", "python/pyproject.toml", "LICENSE"]:
        assert (unpacked / name).read_bytes() == (ROOT / name).read_bytes()
    assert (unpacked / "PKG-INFO").exists()


def test_sources_build(unpacked, tmp_path, scene):
    """pip builds them; objects of the same sources are taken over to save the compilation."""
    for objects in (ROOT / "build").glob("gfortran_*"):
        shutil.copytree(objects, unpacked / "build" / objects.name)
    folder = tmp_path / "environment"
    subprocess.run([sys.executable, "-m", "venv", folder], check=True, timeout=300)
    path = os.pathsep.join((str(ROOT / ".venv/bin"), os.environ["PATH"]))
    done = run(folder, "pip", "install", "--no-index", "--disable-pip-version-check", unpacked,
               PATH=path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert printed(folder, "python", "-c", SOLVE, cwd=scene).startswith("[")
    assert printed(folder, "asperity", "--version").startswith("asperity ")


def test_same_bytes_again(wheel):
    """A second build of the same sources has the same bytes."""
    paths = [wheel, only("asperity-*.tar.gz")]
    before = [path.read_bytes() for path in paths]
    subprocess.run(["bash", ".ci/wheel"], cwd=ROOT, check=True, timeout=900, capture_output=True)
    assert [path.read_bytes() for path in paths] == before
