"""What `asperity solve` refuses in &effects and beside it, word by word."""

import os
import subprocess

import pytest

from effect_runs import DECK
from surfaces_csv import write_scene

REFUSED = {
    "interaction = 'on'": (":2:24: interaction: found the text 'on', "
                           "expected 'off', 'auto', 'coupled' or 'boundary'"),
    "interaction = ''": ":2:24: interaction: found the text ''",
    "interaction = 'auto', tolerance = 0": "tolerance: found '0', "
                                           "expected a number more than 0 and less than 1",
    "interaction = 'auto', tolerance = 1": "tolerance: found '1'",
    "interaction = 'auto', tolerance = -0.1": "tolerance: found '-0.1'",
    "interaction = 'auto', tolerance = nan": "tolerance: found 'nan'",
    "tolerance = 2": "tolerance: found '2'",
    "interaction = 'boundary', boundary_tolerance = 0": "boundary_tolerance: found '0'",
    "interaction = 'boundary', boundary_tolerance = 1.": "boundary_tolerance: found '1.'",
    "interaction = 'boundary', boundary_tolerance = 'x'": "boundary_tolerance: found the text 'x'",
    "friction = 'on'":
        "friction_coefficient is missing in &effects: found none, expected one with "
        "friction = 'on'",
    "friction = 'coupled', friction_coefficient = 1": ("friction: found the text 'coupled', "
                                                       "expected 'off', 'on' or 'auto'"),
    "friction = 'on', friction_coefficient = -0.1": ("friction_coefficient: found '-0.1', "
                                                     "expected a number of 0 or more"),
    "friction = 'on', friction_coefficient = inf": "friction_coefficient: found 'inf'",
    "friction = 'on', friction_coefficient = 1e999": "friction_coefficient: found '1e999'",
    "friction_coefficient = -1": "friction_coefficient: found '-1'",
    "interactions = 'off'": "unknown name in &effects: found 'interactions', expected interaction,",
}


@pytest.mark.parametrize("names", REFUSED, ids=range(len(REFUSED)))
def test_bad_effects(names, asperity, tmp_path):
    scene = tmp_path / "bad.scene"
    scene.write_text(f"&surfaces deck = '{DECK}' /\n&effects {names} /\n")
    out = tmp_path / "positions.csv"
    done = subprocess.run([asperity, "solve", scene, "--positions", out], capture_output=True,
                          text=True)
    assert done.returncode == 2
    assert done.stdout == "" and not out.exists()
    assert f"{scene}:2:" in done.stderr and REFUSED[names] in done.stderr, done.stderr


def test_all_bad_effects_are_told(asperity, tmp_path):
    scene = tmp_path / "bad.scene"
    scene.write_text(f"&surfaces deck = '{DECK}' /\n&effects interaction = 'x', friction = 'on',\n"
                     "  tolerance = 5, boundary_tolerance = -1 /\n")
    done = subprocess.run([asperity, "solve", scene], capture_output=True, text=True)
    assert done.returncode == 2
    told = [line for line in done.stderr.splitlines() if f"{scene}:" in line]
    assert len(told) == 4, done.stderr


@pytest.mark.parametrize("option", (("--arithmetic", "ibm370"), ("--arithmetic", "real32")),
                         ids="_".join)
def test_options_that_effects_do_not_know(option, asperity, tmp_path):
    """Effects are computed in doubles: another arithmetic is refused, not ignored."""
    scene = write_scene(tmp_path / "one.scene", surfaces={"deck": str(DECK)},
                        motion={"x_first": 0.1, "positions": 1},
                        effects={"interaction": "coupled"})
    done = subprocess.run([asperity, "solve", scene, *option], capture_output=True, text=True,
                          env={**os.environ, "OMP_NUM_THREADS": "1"})
    assert done.returncode == 2, done.stdout
