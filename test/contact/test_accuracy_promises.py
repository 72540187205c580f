"""`solve --accuracy E` on some surfaces of test/bench/accuracy_promises.py: the promise holds."""

import re
from functools import partial

import numpy as np
import pytest
from accuracy_promises import asperities, heights_of, judged, map_scene, maps, rows_of, waves
from programs import run_program
from surfaces_csv import write_plane_scene


@pytest.mark.parametrize("kind, goal, least", [("asperities", 1e-2, 6), ("asperities", 1e-3, 6),
                                               ("maps", 1e-2, 4), ("maps", 1e-3, 4),
                                               ("grooves", 1e-3, 1)])
def test_accepted_accuracies_hold(kind, goal, least, asperity):
    """Against independent loads, closed forms and finer pixels; other pixels are methods. On the
    grooves the load changes by more than the estimate of every second pixel."""
    cases = list(asperities(6) if kind == "asperities" else maps(
        asperity, least, start=8 if kind == "grooves" else 1))
    rows = []
    for case in cases:
        case.write = {"": case.write[""]}
        rows += judged(asperity, case, (goal,))
    accepted = [row for row in rows if row["accepted"]]
    assert len(accepted) >= least, rows
    assert all(float(row["error"]) <= goal for row in accepted), accepted
    if kind == "maps" and goal == 1e-2:
        assert any("every fourth" in row["message"] for row in accepted)


@pytest.mark.parametrize("surface", ["waves", "noise", "free"])
def test_more_pixels_need_known_waves(surface, asperity):
    """A periodic map without waves below 3 pixels has the accuracy on more pixels of the same
    waves, with all columns. Noise of a thousandth of the heights, or a free edge, leaves it on its
    own pixels."""
    n = 96
    random = np.random.default_rng(5)
    heights = heights_of(waves(random, n), n)
    fine = heights_of(waves(np.random.default_rng(5), n), 2 * n)
    heights, fine = heights / np.ptp(heights), fine / np.ptp(heights)
    if surface == "noise":
        heights = heights + 1e-3 * random.standard_normal((n, n))
    scene = partial(map_scene, step=1, edge="free" if surface == "free" else "periodic",
                    control="pressure", value=0.3)
    row, text, _ = rows_of(asperity, partial(scene, heights=heights, spacing=1.0), "--accuracy",
                           1e-3)
    found = re.search(r"fastest method (\d+) x \1 pixels", text)
    if surface != "waves":
        assert not found and (row or "or take a map of finer pixels" in text), text
        return
    assert n < int(found[1]) < 2 * n and float(row["error_estimate"]) <= 1e-3
    want, _, _ = rows_of(asperity, partial(scene, heights=fine, spacing=0.5))
    for name, bound in (("compression", 1e-3), ("contact_stiffness", 0.05)):
        assert float(row[name]) == pytest.approx(float(want[name]), rel=bound)


def refused_scene(folder, kind):
    """Caps of many sizes, or a random map."""
    if kind == "map":
        n = 96
        height = heights_of(waves(np.random.default_rng(4), n), n)
        return map_scene(folder, height / np.ptp(height), 1, 1.0, "free", "pressure", 0.3)
    random = np.random.default_rng(kind)
    n = random.integers(100, 300)
    radii = 10 ** random.uniform(-2, -1, n)
    caps = np.column_stack([random.uniform(0, 1, (n, 2)),
                            0.02 * radii.mean() * random.standard_normal(n), radii])
    return write_plane_scene(folder / "caps", caps.tolist(), modulus=1e3, by_default=True, loading={
        "control": "compression", "value": float(radii.mean() * 10 ** random.uniform(-2.5, -1))})


@pytest.mark.parametrize("kind", [3, 24, "map"])
@pytest.mark.parametrize("of", [(), ("--of", "area")])
def test_a_refusal_proposes_what_is_met(kind, of, asperity, tmp_path):
    """The option of a refusal, as it is typed, is accepted, and its printed error is within it."""
    scene = refused_scene(tmp_path, kind)
    shown = run_program(asperity, "solve", scene, *of, "--accuracy", "1e-6", status=1).stderr
    option = re.search(r"set --accuracy (\S+?)(?: |,|\n)", shown)[1]
    met = run_program(asperity, "solve", scene, *of, "--accuracy", option).stdout
    printed = re.search(r"^accuracy .* error (\S+)$", met, re.M)
    assert printed and float(printed[1]) <= float(option), met


def test_the_residual_is_a_part_of_the_accuracy(asperity):
    """Pixels solved to an accuracy have the totals of pixels solved to rounding, to a part of it;
    the steps to them less work."""
    x = np.arange(64) - 31.3
    heights = -(x**2 + x[:, None]**2) / 4000
    scene = partial(map_scene, heights=heights, step=1, spacing=1.0, edge="free",
                    control="compression", value=0.08)
    rough, text, _ = rows_of(asperity, scene, "--accuracy", 2e-3)
    exact, _, _ = rows_of(asperity, scene)
    assert "the pixels of the map" in text
    change = abs(float(rough["load"]) / float(exact["load"]) - 1)
    assert 1e-9 < change < 0.02 * 2e-3
