"""The blocks of the pages that are neither lines of `asperity` nor programs: fpm, make, jobs.

Commands of asperity are run by `test_documents.py`, C and Fortran by `test_page_programs.py`,
Python by `test_python_docs.py`.
"""

import os
import re
import shutil

import pytest
from builds import ROOT, build
from programs import run_program

pytestmark = pytest.mark.pages


def block_of(page, part):
    """The block of a page whose first line has this part."""
    text = (ROOT / page).read_text(encoding="utf-8")
    (block,) = {block for block in re.findall(r"^```\w*\n(.*?)^```$", text, re.M | re.S)
                if part in block.splitlines()[0]}
    return block


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
def shell(asperity, checkout):
    """Runs commands in a folder that looks like the checkout. fpm is the real one, with the flags
    of the release build; srun runs its command in this process."""
    build("release")
    programs = checkout / ".venv/bin"
    programs.mkdir(parents=True)
    (programs / "asperity").symlink_to(asperity)
    for name, text in (("fpm", FPM), ("srun", '#!/bin/sh\nshift\nexec "$@"\n')):
        (programs / name).write_text(text)
        (programs / name).chmod(0o755)

    # Under make a second make would print the folders that it enters.
    plain = {name: value for name, value in os.environ.items()
             if not name.startswith(("MAKE", "MFLAGS"))}

    def shell(commands, folder=checkout, **variables):
        return run_program("bash", "-ec", commands, cwd=folder, timeout=500, env={
            **plain, **variables, "PATH": f"{programs}:{os.environ['PATH']}"}).stdout
    return shell


def test_make_report(shell):
    """The report of the thesis, to the last byte, as the last lines of what is printed."""
    line = block_of("README.md", "make report").splitlines()[0]
    assert shell(line, folder=ROOT).endswith(
        (ROOT / "reference_output/thesis.ibm370.txt").read_text(encoding="utf-8"))


def test_make_compare(shell):
    """The count of README as the last lines."""
    block = block_of("README.md", "make compare")
    assert shell("make compare", folder=ROOT).endswith(block.split("...\n")[-1])


def test_fpm_against_the_report(shell):
    shell(block_of("docs/how-to/ci.md", ".venv/bin/fpm build"))


def test_steps_of_a_job(shell):
    """The steps of the job, without the one that installs."""
    _, *steps = re.findall(r"^  - run: (.*)", block_of("docs/how-to/ci.md", "steps:"), re.M)
    assert len(steps) == 2
    for step in steps:
        shell(step)


def test_examples(shell):
    lines = block_of("docs/reference/fortran.md", "read_a_scene").splitlines()
    names = sorted(path.stem for path in (ROOT / "example").glob("*.f90"))
    assert sorted(line.split()[3] for line in lines) == names
    for line in lines:
        assert len(shell(line).split()) > 10


def test_install_and_c(shell, checkout):
    """The library in a folder of its own, and a C program that is linked to it."""
    shutil.copy(ROOT / "example/press_two_surfaces.c", checkout / "press.c")
    shell(block_of("docs/how-to/c.md", "fpm install").replace("FOLDER", str(checkout / "own")))
    assert (checkout / "own/bin/asperity").exists() and len(shell("./a.out").split()) > 10


MACHINES = "docs/how-to/many-machines.md"


def test_array_of_jobs(shell, checkout):
    """Sixteen jobs of an array, and the run that takes all parts: the bytes of one run."""
    scene = "data/examples/thesis.scene"
    (checkout / "job.sh").write_text(block_of(MACHINES, "#!/bin/bash").replace("SCENE", scene))
    assert "--array=1-16\n" in (checkout / "job.sh").read_text()
    for job in range(1, 17):
        shell("bash -e job.sh", SLURM_ARRAY_TASK_ID=str(job))
    assert not (checkout / "positions.csv").exists()
    shell(block_of(MACHINES, "part.%s").replace("SCENE", scene))
    together = (checkout / "positions.csv").read_bytes()
    shell(f"asperity solve {scene} --positions positions.csv")
    assert together == (checkout / "positions.csv").read_bytes() and together.count(b"\n") == 101


def test_job_of_images(shell, asperity, checkout):
    """The job, with one image in place of those of srun."""
    folder = checkout / "build/gfortran_0/app"
    folder.mkdir(parents=True)
    (folder / "asperity").symlink_to(asperity)
    shell(block_of(MACHINES, "--ntasks").replace("SCENE", "data/examples/thesis.scene"))
    assert (checkout / "p.csv").read_text().count("\n") == 101
    assert (checkout / "p.keep").stat().st_size > 0
