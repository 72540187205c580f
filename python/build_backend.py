"""Builds the wheel: the library with fpm, then the package around it (PEP 517).

`pip install ./python` in a checkout of the project comes here. gfortran and FFTW must be there;
fpm is taken from PyPI where none is found. The objects stay in `build/` of the project.
"""

import base64
import csv
import fcntl
import hashlib
import io
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    tomllib = None

PACKAGE = Path(__file__).resolve().parent
ROOT = PACKAGE.parent
FPM = "fpm==0.12.0"
# As .ci/common.sh has them for the release build: objects that a shared library can be made of.
FLAGS = "-fPIC -fno-semantic-interposition"
# What the library shows: the names of include/asperity.h.
SHOWN = "{ global: asperity_*; local: *; };\n"


def get_requires_for_build_wheel(config_settings=None):
    return [] if shutil.which("fpm") else [FPM]


def build_sdist(sdist_directory, config_settings=None):
    raise SystemExit("asperity: the package is built from a checkout of the project, "
                     "which holds the Fortran sources: pip install ./python")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    values = project()
    name, version = values["name"], values["version"]
    system = f"{platform.system()}_{platform.machine()}".lower()
    info = f"{name}-{version}.dist-info"
    files = {f"{name}/{path.name}": path.read_bytes()
             for path in sorted((PACKAGE / name).iterdir()) if path.suffix in (".py", ".typed")}
    with tempfile.TemporaryDirectory() as folder:
        library, program = build_library(Path(folder))
        files[f"{name}/{library.name}"] = library.read_bytes()
        files[f"{name}-{version}.data/scripts/{name}"] = program.read_bytes()
    files[f"{info}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
        f"Summary: {values['description']}\nRequires-Python: {values['requires-python']}\n"
        "License: MIT\n").encode()
    files[f"{info}/WHEEL"] = ("Wheel-Version: 1.0\nGenerator: asperity\nRoot-Is-Purelib: false\n"
                              f"Tag: py3-none-{system}\n").encode()
    wheel = f"{name}-{version}-py3-none-{system}.whl"
    with zipfile.ZipFile(Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if "/scripts/" in path else 0o100644) << 16
            archive.writestr(entry, data)
        archive.writestr(f"{info}/RECORD", record(files, f"{info}/RECORD"))
    return wheel


def project():
    """Group [project] of pyproject.toml; Python 3.10 has no reader for it."""
    text = (PACKAGE / "pyproject.toml").read_text(encoding="utf-8")
    if tomllib:
        return tomllib.loads(text)["project"]
    lines = [line.partition(" = ") for line in text.split("[project]")[1].splitlines()]
    return {name: value.strip('"') for name, _, value in lines}


def record(files, own):
    """The list of files that a wheel has, with their checksums."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    for path, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        rows.writerow((path, f"sha256={digest}", len(data)))
    rows.writerow((own, "", ""))
    return text.getvalue()


def build_library(folder):
    """The shared library in a folder, and the program beside it."""
    compiler = shutil.which(os.environ.get("FPM_FC", "gfortran"))
    if not compiler:
        stop("gfortran is not found; on Debian or Ubuntu: sudo apt-get install gfortran libc6-dev")
    if not (ROOT / "fpm.toml").exists():
        stop(f"no Fortran sources in {ROOT}: run pip install ./python in a checkout of the project")
    fpm = shutil.which("fpm")
    if not fpm:
        stop(f"fpm is not found; pip install {FPM}")
    check_fftw(compiler, folder)
    (ROOT / "build").mkdir(exist_ok=True)
    # Tests of the project build there, too.
    with open(ROOT / "build" / "lock", "w", encoding="ascii") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        run([fpm, "install", "--profile", "release", "--no-prune", "--flag", FLAGS,
             "--prefix", folder])
    (folder / "shown").write_text(SHOWN, encoding="ascii")
    library = folder / "libasperity.so"
    run([compiler, "-shared", "-fopenmp", "-o", library,
         "-Wl,--whole-archive", folder / "lib" / "libasperity.a", "-Wl,--no-whole-archive",
         f"-Wl,--version-script={folder / 'shown'}", "-lfftw3"])
    return library, folder / "bin" / "asperity"


def check_fftw(compiler, folder):
    """Refuse a missing FFTW before the compilation."""
    source = folder / "fftw.f90"
    source.write_text("call fftw_cleanup()\nend\n", encoding="ascii")
    done = subprocess.run([compiler, "-fno-underscoring", source, "-lfftw3", "-o", folder / "fftw"],
                          capture_output=True)
    if done.returncode != 0:
        stop("FFTW is not found; on Debian or Ubuntu: sudo apt-get install libfftw3-dev")


def run(command):
    """Runs a command in the project; its standard output."""
    done = subprocess.run(command, cwd=ROOT, stdin=subprocess.DEVNULL, capture_output=True,
                          text=True)
    if done.returncode != 0:
        stop(f"{Path(command[0]).name} failed:\n{(done.stdout + done.stderr)[-4000:]}")
    return done.stdout


def stop(why):
    raise SystemExit(f"asperity: {why}")
