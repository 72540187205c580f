"""The blocks of the pages that are neither lines of `asperity` nor programs: fpm, make, pip, Slurm.

Each block of a page is run by `test_documents.py` (commands of asperity, scenes, tables),
`test_page_programs.py` (C, Fortran), `test_python_docs.py` (Python), or by a test of this file; the
few that cannot run are listed in `NOT_RUN`, each with its reason.
"""

import os
import re
import shutil

import pytest
from builds import ROOT, build
from programs import run_program
from test_documents import PAGES, command_lines, name_of

pytestmark = pytest.mark.pages

# First line of each block that a test of this file runs: its page.
RUN = {
    "make report      # the report of the thesis, 2 minutes": "README.md",
    ".venv/bin/fpm build": "README.md docs/how-to/ci.md",
    "steps:": "docs/how-to/ci.md",
    ".venv/bin/fpm install --profile release --no-prune --prefix FOLDER": "docs/how-to/c.md",
    ".venv/bin/fpm run --example read_a_scene -- data/examples/thesis.scene":
        "docs/reference/fortran.md",
    "#!/bin/bash": "docs/how-to/many-machines.md",
    "asperity solve SCENE --positions positions.csv $(printf -- '--keep part.%s ' {1..16})":
        "docs/how-to/many-machines.md",
    "#SBATCH --ntasks=64": "docs/how-to/many-machines.md",
    "FILE:LINE:COLUMN: what is wrong, what was found, what is expected": "docs/reference/scene.md",
    "FILE: warning: position 8 and 3 more: what, how much, what to do":
        "docs/reference/warnings.md",
    "Summits against boundary elements on all pixels at the same load":
        "docs/theory/summits-or-pixels.md"}
# Blocks, or lines of blocks above, that no test of this kind runs, and why.
NOT_RUN = {
    "make test        # the tests, 4 minutes": "this test is a part of it",
    "[dependencies]": "test_library.py builds a project with this dependency",
    "apt-get install libcoarrays-openmpi-dev libopenmpi-dev":
        "installs as root; `make images` builds with these flags and runs the images over MPI",
    "  - run: sudo apt-get install -y gfortran libfftw3-dev && pip install fpm==0.12.0":
        "installs as root, over a network; .ci/setup is tested by every fresh clone",
    "pip install asperity-VERSION-py3-none-manylinux_2_35_x86_64.whl":
        "`make wheel-test` builds and installs this file",
    "pip install ./python": "the fixture `venv` of conftest.py runs it, without a network"}


# First line of each block of numbers that a program beside it prints: the test that compares them.
PRINTED = {
    "contact area (um2)            407.574": "test_readme.py::test_python",
    "0.1089453125 3692.2981079 0.0304626227": "test_other_pages.py::test_the_same_map",
    "0.1089453125 3692.2981083 0.0304626227": "test_other_pages.py::test_the_same_map",
    "0.1089453125 3692.2981067 0.0304626228": "test_other_pages.py::test_the_same_map"}


def all_blocks():
    """Page, number of the first line, language and text of every block."""
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for found in re.finditer(r"^```(\w*)\n(.*?)^```$", text, re.M | re.S):
            yield page, text.count("\n", 0, found.start()) + 2, found[1], found[2]


def runs_elsewhere(page, first, language, text):
    """Whether another file of tests runs a block: all lines are commands of asperity, or text that
    one of them prints; a scene, a table of asperities, a program."""
    # Programs in `py` are those of tamaas and ContactMechanics, which test_other_pages.py runs.
    if language in ("c", "fortran", "python", "py"):
        return True
    if text.startswith("x,y,height") or re.match(r"(?:!.*\n|\s*)*&\w+", text):
        return True
    seen = {number for number, _, _ in command_lines(page)}
    lines = list(enumerate(text.splitlines(), first))
    shown = lines[0][1].startswith("$ ")
    return all(number in seen or shown and line[:2] != "$ " for number, line in lines)


def test_every_block_is_run():
    """What no other file of tests runs stands in one of the two lists, which have nothing else."""
    there = {text.splitlines()[0]: name_of(page) for page, *block in all_blocks()
             if not runs_elsewhere(page, *block) for text in (block[2],)}
    lines = {line for *_, text in all_blocks() for line in text.splitlines()}
    assert not set(there) - set(RUN) - set(NOT_RUN) - set(PRINTED) and not set(PRINTED) - set(there)
    for test in PRINTED.values():
        file, name = test.split("::")
        assert f"def {name}" in (ROOT / "test/regression" / file).read_text(encoding="utf-8")
    assert not set(RUN) - set(there) and not set(NOT_RUN) - lines
    assert all(page in RUN[line] for line, page in there.items() if line in RUN)
    assert len(NOT_RUN) <= 6


def block_of(page, first):
    """The block of a page that begins with a line."""
    (text,) = {text for at, *_, text in all_blocks()
               if name_of(at) == page and text.splitlines()[0] == first}
    return text


def block_named(part):
    """The block of `RUN` whose first line has this part, on its first page."""
    ((first, pages),) = [(line, pages) for line, pages in RUN.items() if part in line]
    return block_of(pages.split()[0], first)


FPM = f"""#!/bin/bash
# fpm in the checkout, with the flags of the release build in place of its own.
. {ROOT}/.ci/common.sh
options_of release
exec {{lock}}>build/lock
flock "$lock"
verb=$1
shift
[ "$verb" != install ] || shift 3
exec {ROOT}/.venv/bin/fpm "$verb" "${{fpm_options[@]}}" "$@"
"""


@pytest.fixture
def shell(asperity, tmp_path):
    """Runs commands in a folder that looks like the checkout. fpm is the real one, with the flags
    of the release build; srun runs its command in this process."""
    for path in ROOT.iterdir():
        if not path.name.startswith(".") and path.name != "build":
            (tmp_path / path.name).symlink_to(path)
    programs = tmp_path / ".venv/bin"
    programs.mkdir(parents=True)
    (programs / "asperity").symlink_to(asperity)
    for name, text in (("fpm", FPM), ("srun", '#!/bin/sh\nshift\nexec "$@"\n')):
        (programs / name).write_text(text)
        (programs / name).chmod(0o755)

    # Under make a second make would print the folders that it enters.
    plain = {name: value for name, value in os.environ.items()
             if not name.startswith(("MAKE", "MFLAGS"))}

    def shell(commands, folder=tmp_path, status=0, **variables):
        done = run_program("bash", "-ec", commands, status=status, cwd=folder,
                           env={**plain, **variables, "PATH": f"{programs}:{os.environ['PATH']}"},
                           timeout=500)
        return done.stdout + done.stderr if status else done.stdout
    return shell


def test_make_report(shell):
    """The report of the thesis, to the last byte, as the last lines of what is printed."""
    line = block_named("make report").splitlines()[0]
    assert shell(line, folder=ROOT).endswith(
        (ROOT / "reference_output/thesis.ibm370.txt").read_text(encoding="utf-8"))


@pytest.mark.parametrize("page", RUN[".venv/bin/fpm build"].split())
def test_fpm_against_the_report(shell, page):
    build("release")
    shell(block_of(page, ".venv/bin/fpm build"))


def test_steps_of_a_job(shell):
    """The steps of the job, without the one that installs."""
    steps = re.findall(r"^  - (run: .*)", block_named("steps:"), re.M)
    assert f"  - {steps[0]}" in NOT_RUN and len(steps) == 3
    build("release")
    for step in steps[1:]:
        shell(step.removeprefix("run: "))


def test_examples(shell):
    build("release")
    lines = block_named("read_a_scene").splitlines()
    names = sorted(path.stem for path in (ROOT / "example").glob("*.f90"))
    assert sorted(line.split()[3] for line in lines) == names
    for line in lines:
        assert len(shell(line).split()) > 10


def test_install_and_c(shell, tmp_path):
    """The library in a folder of its own, and a C program that is linked to it."""
    build("release")
    shutil.copy(ROOT / "example/press_two_surfaces.c", tmp_path / "press.c")
    shell(block_named(".venv/bin/fpm install").replace("FOLDER", str(tmp_path / "own")))
    assert (tmp_path / "own/bin/asperity").exists() and len(shell("./a.out").split()) > 10


def test_array_of_jobs(shell, tmp_path):
    """Sixteen jobs of an array, and the run that takes all parts: the bytes of one run."""
    scene = "data/examples/thesis.scene"
    (tmp_path / "job.sh").write_text(block_named("#!/bin/bash").replace("SCENE", scene))
    assert "--array=1-16\n" in (tmp_path / "job.sh").read_text()
    for job in range(1, 17):
        shell("bash -e job.sh", SLURM_ARRAY_TASK_ID=str(job))
    assert not (tmp_path / "positions.csv").exists()
    shell(block_named("part.%s").replace("SCENE", scene))
    together = (tmp_path / "positions.csv").read_bytes()
    shell(f"asperity solve {scene} --positions positions.csv")
    assert together == (tmp_path / "positions.csv").read_bytes() and together.count(b"\n") == 101


def test_job_of_images(shell, asperity, tmp_path):
    """The job of the study, with one image in place of those of srun."""
    folder = tmp_path / "build/gfortran_0/app"
    folder.mkdir(parents=True)
    (folder / "asperity").symlink_to(asperity)
    shell(block_named("--ntasks").replace("SPEC", "data/examples/study/thesis.spec"))
    assert (tmp_path / "area.csv").read_text().count("\n") > 1
    assert (tmp_path / "area.keep").stat().st_size > 0


def test_form_of_a_problem(shell, tmp_path):
    assert block_named("FILE:LINE:COLUMN").count(":") == 3
    (tmp_path / "bad.scene").write_text("&surfaces deck = 'data/thesis.deck' /\n&motion x = 1 /\n")
    text = shell("asperity solve bad.scene", status=2)
    assert re.fullmatch(r"bad[.]scene:2:9: [^:]+: found 'x', expected .*\n", text)


def test_form_of_a_warning(shell):
    form = block_named("FILE: warning").strip()
    pattern = re.sub(r"\d+", r"\\d+", form).replace("FILE", r"\S+").replace(
        "what, how much, what to do", ".+, .+")
    text = shell("asperity solve data/examples/thesis.scene 2>&1 >/dev/null")
    assert any(re.fullmatch(pattern, line) for line in text.splitlines()), text


def test_form_of_a_comparison():
    """The lines of the page on theory are those that the tutorial shows, which are compared with
    what is printed."""
    form = re.escape(block_named("Summits against").strip()).replace(r"\.\.\.", ".+")
    tutorial = (ROOT / "docs/tutorial/measured-surface.md").read_text(encoding="utf-8")
    assert re.search(f"^{form}$", tutorial, re.M)
