"""What `auto` leaves out: in random scenes the result by default is that with the effects on,
within the tolerance, or the effect is named; a number below the tolerance changes no digit."""

import re
import shutil

import numpy as np
import pytest

from left_out_scenes import (EVERY, MAKERS, ball, loading_of, numbers_of, random_map,
                             scene_of, with_shear)
from map_scenes import numbers
from programs import run_program
from surfaces_csv import solve

TOLERANCE = 1e-2  # of `auto` by default
# Refusals of what cannot be solved with the effects on.
NO_PAIR = "do not go together"
REFUSED = ("too wide for the range of adhesion", "plastic_hardness times the measured area",
           "the pull is larger than the contacts carry", "pixels of a map yield at a pressure",
           NO_PAIR)

# Warnings of the size of pixels and of their edge, of the theory of spheres that adhere, and of the
# size of plastic flow, which pixels without a hardness cannot estimate.
OF_MODEL = ("contact patches are not resolved", "the estimated error is above", "an edge of the",
            "the map ends within", "a contact adheres by the law for small", "plasticity is ")


def run(asperity, folder, body, loading, effects):
    """Messages of a run, and its position; None: refused."""
    done = solve(asperity, body.write(folder, loading=loading, effects=effects))
    assert not done.status or any(text in done.stderr for text in REFUSED), done.stderr
    return done, None if done.status else numbers(done.positions[0])


def judge_on(solve_with, words, silent, default, body):
    """Compares a result without silent effects with that with them on. What has no common theory
    with an effect that is on is left out of both."""
    reference, on = solve_with(**words)
    apart = re.findall(r"\((\w+) beside", reference.stderr)
    if on is None:
        return
    if apart or default is None:
        default = solve_with(**{**words, **dict.fromkeys((*silent, *apart), "off")})[1]
    for column in ("area", "compression", "load"):
        change = abs(default[column] / on[column] - 1) if on[column] else abs(default[column])
        # The area of pixels is that of whole ones and their rims: two more may close or open, of a
        # ball 8 at once. With other laws than Hertz' caps are not resolved, to a printed error.
        error = on["area_error_estimate"] if not body.is_map else \
            (8 if body.is_ball else 2) / max(1, on["samples_in_contact"])
        bound = TOLERANCE + (error if column == "area" else 0)
        assert change <= bound, (silent, column, change, bound)


def judge_body(asperity, folder, body, loading, effects):
    """Solves a scene by default, and with the effects on that it leaves out without a word.
    Messages, and effects left out."""
    given = {key: value for group in effects.values() for key, value in group.items()}

    def solve_with(**words):
        return run(asperity, folder, body, loading, {**given, **words})

    done, default = solve_with()
    if default is None:
        return done, []
    left = [name for name in effects if default.get(name, "off") == "off"]
    named = [name for name in left
             if re.search(rf"\b{name} (beside|is left out|is off)", done.stderr)]
    for name in effects:
        assert f"\n{name} " in done.stdout or name in named, (name, done.stdout, done.stderr)
    silent = [name for name in left if name not in named]
    words = {name: "on" for name in effects if name not in named}
    if silent and NO_PAIR in solve_with(**words)[0].stderr:
        for name in silent:
            judge_on(solve_with, {**dict.fromkeys(effects, "off"), name: "on"}, [name], None,
                     body)
    elif silent:
        judge_on(solve_with, words, silent, default, body)
    return done, left


def warnings_of(done):
    """The words of each warning, without its numbers, except those of one model."""
    lines = (line.split(": ", 3)[3] for line in done.stderr.splitlines() if "warning:" in line)
    return sorted(re.sub(r"[\d.E+-]+", "N", line) for line in lines
                  if not line.startswith(OF_MODEL))


def judge_ball(asperity, folder, rng, names):
    """Where both models simulate the same effects of a ball they print the same warnings. A yield
    stress has a warning alone."""
    row, pixels = ball(False), ball(True)
    loading, effects = loading_of(rng, row), numbers_of(rng, row, names)
    if "plasticity" in effects:
        effects["plasticity"]["plasticity"] = "off"
    (of_row, left), (of_pixels, also_left) = (judge_body(asperity, folder, body, loading, effects)
                                              for body in (row, pixels))
    if left == also_left:
        assert warnings_of(of_row) == warnings_of(of_pixels), (loading, effects)
    return len(left) + len(also_left)


def judge(asperity, folder, seed):
    """Judges a scene. The number of effects left out."""
    kind, names, rng = scene_of(seed)
    if kind == "ball":
        return judge_ball(asperity, folder, rng, names)
    body = MAKERS[kind](rng, asperity, folder)
    loading = with_shear(rng, body, loading_of(rng, body), names)
    return len(judge_body(asperity, folder, body, loading, numbers_of(rng, body, names))[1])


def judge_all(asperity, folder, seeds):
    left = sum(judge(asperity, folder, seed) for seed in seeds)
    assert 0.3 * len(seeds) < left < 1.5 * len(seeds), left


def test_default_is_on_or_named(asperity, tmp_path):
    """Each effect and each pair on each kind of body."""
    judge_all(asperity, tmp_path, range(EVERY))


@pytest.mark.long
def test_default_is_on_or_named_often(asperity, tmp_path):
    judge_all(asperity, tmp_path, range(EVERY, EVERY + 300))


@pytest.mark.parametrize("seed, was", [
    (127, "beside adhesion, friction had other contact patches, whose values left the table"),
    (973, "the area of circles without a correction had the printed error of corrected ones"),
    (2198, "of two effects beside a third one only the larger had a warning")])
def test_found_scene(seed, was, asperity, tmp_path):
    judge(asperity, tmp_path, seed)


def test_left_out_changes_no_digit(asperity, tmp_path):
    """Adhesion and creep far below the tolerance: the solution is the one without their numbers,
    also the number of its iterations."""
    body = random_map(np.random.default_rng(3))
    rows = []
    for effects in ({}, {"work_of_adhesion": 1e-9, "equilibrium_distance": 0.1},
                    {"hold_time": 1.0, "relaxation_time": 1.0, "relaxed_modulus_ratio": 1 - 1e-6}):
        row = run(asperity, tmp_path, body, {"control": "pressure",
                                             "value": 0.05 * body.pressure}, effects)[1]
        rows.append([row[key] for key in ("load", "area", "separation", "mean_gap",
                                          "area_error_estimate", "interaction_iterations")])
    assert rows[0] == rows[1] == rows[2]


@pytest.mark.once
@pytest.mark.skipif(shutil.which("valgrind") is None, reason="no valgrind here")
def test_left_out_solves_no_more(asperity, tmp_path):
    """The elastic solves of a map in the program itself, counted by callgrind: as many with the
    numbers of an effect that is left out as without them; with adhesion on most are others."""
    body = random_map(np.random.default_rng(3))
    counts = []
    for effects in ({}, {"work_of_adhesion": 1e-9, "equilibrium_distance": 0.1},
                    {"work_of_adhesion": 1e-9, "equilibrium_distance": 0.1, "adhesion": "on"}):
        scene = body.write(tmp_path, effects=effects, loading={
            "control": "pressure", "value": 0.05 * body.pressure})
        run_program("valgrind", "--tool=callgrind", f"--callgrind-out-file={tmp_path}/calls",
                    asperity, "solve", scene, "--threads", "1")
        calls, called, names = 0, "", {}
        for line in (tmp_path / "calls").read_text().splitlines():
            # A name stands where its number is used first.
            if (found := re.match(r"c?fn=(\(\d+\))(?: (.*))?", line)):
                name = names.setdefault(found[1], found[2])
                called = name if line.startswith("c") else called
            elif line.startswith("calls=") and "MOD_press_map" in called:
                calls += int(line[6:].split()[0])
        counts.append(calls)
    assert counts[0] == counts[1] > counts[2] > 0, counts
