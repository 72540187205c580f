"""Builds the wheel and the source distribution (PEP 517): the library with fpm, then the package.

`pip install ./python` in a checkout of the project comes here, and so does `pip install` of the
source distribution. gfortran and FFTW must be there; fpm is taken from PyPI where none is found.
The objects stay in `build/` of the project.

`make wheel` sets `bundled`: auditwheel then completes the wheel with the libraries of
the library for C. The program has no fixed place relative to these and contains its libraries.
"""

import ast
import base64
import csv
import fcntl
import gzip
import hashlib
import io
import os
import platform
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent
ROOT = PACKAGE.parent
FPM = "fpm==0.12.0"
# As .ci/common.sh has them for the release build: objects that a shared library can be made of.
FLAGS = "-fPIC -fno-semantic-interposition -ffp-contract=off"
# What the library shows: the names of include/asperity.h.
SHOWN = "{ global: asperity_*; local: *; };\n"
# Its name; the number grows when a function or structure of the header changes or goes, so that no
# program takes a library for one that it was linked with.
LIBRARY = "libasperity.so.1"

# For pkg-config: library and header are in the folder of this file, or in the other two.
PKG_CONFIG = """Name: asperity
Description: {description}
Version: {version}
Libs: -L${{pcfiledir}}{lib} -l:{library}
Cflags: -I${{pcfiledir}}{include}
"""

# Libraries of the program of a bundled wheel, in the order of their use of each other.
STATIC = ["-l:libfftw3.a", "-l:libgfortran.a", "-l:libquadmath.a", "-l:libgomp.a"]
# FFTW; libgfortran and libgomp; libquadmath; libbacktrace, a part of libgfortran.
BUNDLED_LICENCE = ("MIT AND GPL-2.0-or-later AND GPL-3.0-or-later WITH GCC-exception-3.1"
                   " AND LGPL-2.1-or-later AND BSD-3-Clause")
BUNDLED_TEXTS = {
    "FFTW.txt": "/usr/share/doc/libfftw3-double3/copyright",
    "GCC.txt": "/usr/share/doc/libgfortran5/copyright",
    "GPL-2.txt": "/usr/share/common-licenses/GPL-2",
    "GPL-3.txt": "/usr/share/common-licenses/GPL-3",
    "LGPL-2.1.txt": "/usr/share/common-licenses/LGPL-2.1",
}
# The project without its tests and examples, which the source distribution does not have.
SOURCES = ("app", "include", "src", "python")
PAGES = ("CHANGELOG.md", "CITATION.cff", "LICENSE", "README.md")
PARTS = (".F90", ".f90", ".h", ".inc", ".md", ".py", ".pyi", ".toml", ".typed")
UNDISTRIBUTED = re.compile(r"^\[\[(?:test|example)\]\]\n(?:[^\[\n].*\n)*\n*", re.MULTILINE)


def get_requires_for_build_wheel(config_settings=None):
    return [] if shutil.which("fpm") else [FPM]


def build_sdist(sdist_directory, config_settings=None):
    """The Fortran sources and `python/`, as they lie in a checkout; `pyproject.toml` at the root
    leads to this file."""
    values = project()
    base = f"{values['name']}-{values['version']}"
    files = {path.relative_to(ROOT).as_posix(): path.read_bytes()
             for folder in SOURCES for path in (ROOT / folder).rglob("*")
             if path.suffix in PARTS}
    files |= {name: (ROOT / name).read_bytes() for name in PAGES}
    files["fpm.toml"] = UNDISTRIBUTED.sub("", text_of(ROOT / "fpm.toml")).encode()
    files["pyproject.toml"] = text_of(PACKAGE / "pyproject.toml").replace(
        'backend-path = ["."]', 'backend-path = ["python"]').encode()
    files["PKG-INFO"] = metadata(values, values["license"], ["LICENSE"])
    time = int(os.environ.get("SOURCE_DATE_EPOCH", "315532800"))
    with open(Path(sdist_directory) / f"{base}.tar.gz", "wb") as raw, \
            gzip.GzipFile("", "wb", fileobj=raw, mtime=time) as packed, \
            tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for path, data in sorted(files.items()):
            entry = tarfile.TarInfo(f"{base}/{path}")
            entry.size, entry.mtime = len(data), time
            archive.addfile(entry, io.BytesIO(data))
    return f"{base}.tar.gz"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    values = project()
    bundled = "bundled" in (config_settings or {})
    name, version = values["name"], values["version"]
    system = f"{platform.system()}_{platform.machine()}".lower()
    info = f"{name}-{version}.dist-info"
    files = {path.relative_to(PACKAGE).as_posix(): path.read_bytes()
             for path in (PACKAGE / name).rglob("*") if path.suffix in (".py", ".pyi", ".typed")}
    with tempfile.TemporaryDirectory() as folder:
        library, program = build_library(Path(folder), bundled)
        files[f"{name}/{library.name}"] = library.read_bytes()
        files[f"{name}-{version}.data/scripts/{name}"] = program.read_bytes()
        files |= {f"{name}-{version}.data/data/{path}": text
                  for path, text in shared_files(program).items()}
    files[f"{name}/{name}.h"] = (ROOT / f"include/{name}.h").read_bytes()
    files[f"{name}/{name}.pc"] = pkg_config()
    texts = licence_texts(bundled)
    files |= {f"{info}/licenses/{path}": text for path, text in texts.items()}
    files[f"{info}/METADATA"] = metadata(
        values, BUNDLED_LICENCE if bundled else values["license"], texts)
    files[f"{info}/WHEEL"] = ("Wheel-Version: 1.0\nGenerator: asperity\nRoot-Is-Purelib: false\n"
                              f"Tag: py3-none-{system}\n").encode()
    wheel = f"{name}-{version}-py3-none-{system}.whl"
    with zipfile.ZipFile(Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in sorted(files.items()):
            entry = zipfile.ZipInfo(path)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if "/scripts/" in path else 0o100644) << 16
            archive.writestr(entry, data)
        archive.writestr(f"{info}/RECORD", record(files, f"{info}/RECORD"))
    return wheel


def install(prefix):
    """Program, libraries, modules, header, file for pkg-config, completion and manual page under
    a prefix."""
    prefix = Path(prefix).resolve()
    prefix.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        library, program = build_library(Path(folder), False)
        shutil.copytree(Path(folder) / "include", prefix / "include", dirs_exist_ok=True)
        files = {f"bin/{program.name}": program.read_bytes(),
                 f"lib/{library.name}": library.read_bytes(),
                 "lib/libasperity.a": (library.parent / "lib/libasperity.a").read_bytes(),
                 "include/asperity.h": (ROOT / "include/asperity.h").read_bytes(),
                 "lib/pkgconfig/asperity.pc": pkg_config("/..", "/../../include"),
                 **shared_files(program)}
    for name, content in files.items():
        path = prefix / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        path.chmod(0o755 if name.startswith("bin/") else 0o644)


def pkg_config(lib="", include=""):
    values = project()
    return PKG_CONFIG.format(lib=lib, include=include, library=LIBRARY, **values).encode()


def shared_files(program):
    """Completion and manual page, which the program writes."""
    return {"share/bash-completion/completions/asperity": run([program, "--completion"]).encode(),
            "share/man/man1/asperity.1": run([program, "--man"]).encode()}


def text_of(path):
    return path.read_text(encoding="utf-8")


def project():
    """Group [project] of pyproject.toml and, as "extras", the optional dependencies. Python 3.10
    has no reader for TOML: each value there is one line that is Python, too."""
    groups, group = {}, None
    for line in text_of(PACKAGE / "pyproject.toml").splitlines():
        if line.startswith("["):
            group = groups.setdefault(line.strip("[]"), {})
        elif " = " in line:
            key, _, value = line.partition(" = ")
            group[key] = ast.literal_eval(value)
    return {**groups["project"], "extras": groups["project.optional-dependencies"]}


def metadata(values, licence, licence_files):
    """The file METADATA of a wheel, PKG-INFO of a source distribution (version 2.4)."""
    lines = ["Metadata-Version: 2.4", f"Name: {values['name']}", f"Version: {values['version']}",
             f"Summary: {values['description']}", f"License-Expression: {licence}",
             *(f"License-File: {path}" for path in licence_files),
             f"Requires-Python: {values['requires-python']}",
             f"Keywords: {','.join(values['keywords'])}",
             *(f"Classifier: {words}" for words in values["classifiers"])]
    for extra, packages in values["extras"].items():
        lines += [f"Provides-Extra: {extra}",
                  *(f'Requires-Dist: {package}; extra == "{extra}"' for package in packages)]
    lines += ["Description-Content-Type: text/markdown", "", text_of(PACKAGE / values["readme"])]
    return "\n".join(lines).encode()


def licence_texts(bundled):
    """The licence of the project and, bundled, of the libraries in the wheel: file and text."""
    texts = {"LICENSE": (ROOT / "LICENSE").read_bytes()}
    for name, source in (BUNDLED_TEXTS if bundled else {}).items():
        if not Path(source).exists():
            stop(f"{source} is not found: the wheel needs the licences of its libraries")
        texts[f"bundled/{name}"] = Path(source).read_bytes()
    return texts


def record(files, own):
    """The list of files that a wheel has, with their checksums."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    for path, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        rows.writerow((path, f"sha256={digest}", len(data)))
    rows.writerow((own, "", ""))
    return text.getvalue()


def build_library(folder, bundled):
    """The shared library in a folder, and the program beside it."""
    compiler = shutil.which(os.environ.get("FPM_FC", "gfortran"))
    if not compiler:
        stop("gfortran is not found; on Debian or Ubuntu: sudo apt-get install gfortran libc6-dev")
    if not (ROOT / "fpm.toml").exists():
        stop(f"no Fortran sources in {ROOT}: run pip install ./python in a checkout of the project")
    fpm = shutil.which("fpm")
    if not fpm:
        stop(f"fpm is not found; pip install {FPM}")
    place_fftw()
    check_fftw(compiler, folder)
    (ROOT / "build").mkdir(exist_ok=True)
    # Tests of the project build there, too.
    with open(ROOT / "build" / "lock", "w", encoding="ascii") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        # fpm adds to an archive: objects of sources that were removed would stay in it. One without
        # such objects stays, as its programs would be linked anew while they run.
        members = {"_".join(path.relative_to(ROOT).parts) + ".o"
                   for path in (ROOT / "src").rglob("*") if path.is_file()}
        for archive in (ROOT / "build").glob("*/asperity/libasperity.a"):
            if not members.issuperset(run(["ar", "t", archive]).split()):
                archive.unlink()
        output = run([fpm, "install", "--profile", "release", "--no-prune", "--flag", FLAGS,
                      "--prefix", folder])
        if bundled:
            link_program(compiler, folder, output)
    (folder / "shown").write_text(SHOWN, encoding="ascii")
    library = folder / LIBRARY
    run([compiler, "-shared", "-fopenmp", *(["-s"] if bundled else []), "-o", library,
         f"-Wl,-soname,{LIBRARY}",
         "-Wl,--whole-archive", folder / "lib" / "libasperity.a", "-Wl,--no-whole-archive",
         f"-Wl,--version-script={folder / 'shown'}", "-lfftw3"])
    return library, folder / "bin" / "asperity"


def link_program(compiler, folder, output):
    """Links the program again, with all libraries inside but the C library. fpm itself links only
    after a change of a source. Its objects are in the folder of the modules, which is in `output`,
    what `fpm install` has printed."""
    found = re.search(r"(build/\w+)/\w+\.mod -> ", output)
    if not found:
        stop("fpm install does not print the folder of the modules")
    objects = [f"{found[1]}/asperity/app_{path.name}.o"
               for path in sorted((ROOT / "app").glob("*.f90"))]
    # The order of fpm's archive differs from build to build, and so would the bytes of the wheel.
    library = folder / "lib" / "libasperity.a"
    members = sorted(run(["ar", "t", library]).split())
    library.unlink()
    run(["ar", "rcsD", library, *(f"{found[1]}/asperity/{member}" for member in members)])
    run([compiler, "-fopenmp", "-static-libgcc", "-s", "-o", folder / "bin" / "asperity", *objects,
         library, "-Wl,--as-needed", *STATIC])


def place_fftw():
    """Give linker and loader the folder of FFTW where pkg-config has one, as of conda."""
    try:
        found = subprocess.run(["pkg-config", "--variable=libdir", "fftw3"], capture_output=True,
                               text=True).stdout.strip()
    except OSError:
        return
    if found and not found.startswith(("/usr/lib", "/lib")):
        for name in ("LIBRARY_PATH", "LD_RUN_PATH"):
            os.environ[name] = ":".join(filter(None, (found, os.environ.get(name))))


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


if __name__ == "__main__":
    install(sys.argv[1])
