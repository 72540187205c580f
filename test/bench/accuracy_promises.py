"""`solve --accuracy E` on asperities and maps: is the error what was promised, and the method fast?

    python test/bench/accuracy_promises.py [--asperities 60] [--maps 40] [--save]

Asperities are dense scenes with the loads of test/truth/dense_truth.py, in turns at a separation
and at a load. Maps are balls, with the closed form of Hertz, and periodic random waves, egg crates
and grooves, with the same surface on pixels a quarter as wide and its top by Newton's method; in
turns at a pressure and at a compression. Each scene is solved with --accuracy 1e-2 and 1e-3 and by
all methods of the program. A scene counts as possible where one of them truly has the error. With
--save the table goes to reference_output/bench/accuracy_promises.csv.
"""

import argparse
import csv
import io
import resource
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from builds import build
from csv_rows import records
from dense_figures import truths
from dense_scenes import dense_scenes
from programs import run_program
from surfaces_csv import write_scene
from whole_runs import KEPT, heading

GOALS, E, FINER, SLOWER = (1e-2, 1e-3), 1000.0, 4, 3.0
METHODS = {"coupled": {"interaction": "coupled"},
           **{f"auto {share}": {"interaction": "auto", "tolerance": share}
              for share in (0.01, 0.003, 0.001, 0.0003)},
           **{f"boundary {share}": {"interaction": "boundary", "boundary_tolerance": share}
              for share in (0.01, 0.001, 0.0001)}}
STEPS = {"every fourth": 4, "every second": 2, "pixels": 1}


@dataclass
class Case:
    """A scene: its name, how each method writes it, the true value, its doubt, what it is over."""

    name: str
    write: dict
    column: str
    truth: float
    doubt: float
    over: float

    def error(self, row):
        return max(0.0, abs(float(row[self.column]) - self.truth) / self.over - self.doubt)


def asperities(number):
    """Dense scenes of all families, in turns at their separation and at their load."""
    scenes = dense_scenes()
    for turn, scene in enumerate(scenes[::max(1, len(scenes) // max(1, number))][:number]):
        truth = truths()[scene.name]
        loading = {"control": "load", "value": float(truth["normal_load"])} if turn % 2 else None
        # The closest to a separation or a load is that of --accuracy, written with the default.
        write = {name: partial(scene.write, loading=loading, **effects)
                 for name, effects in {"": {"interaction": "auto"}, **METHODS}.items()}
        closing = float(truth["closing"])
        yield Case(scene.name, write, "separation", scene.approach, float(truth["load_error"]),
                   closing) if turn % 2 else Case(
            scene.name, write, "vertical_load", float(truth["load"]), float(truth["load_error"]),
            float(truth["load"]))


def waves(random, pixels):
    """Amplitudes, wave numbers over the side and phases of a random surface."""
    shortest = random.uniform(6, 16)
    k = np.array([(i, j) for i in range(-pixels, pixels) for j in range(pixels)
                  if (j > 0 or i > 0) and 3 <= np.hypot(i, j) <= pixels / shortest])
    k = k[random.permutation(len(k))[:300]]
    return np.hypot(*k.T)**-random.uniform(1.3, 2.0), k, random.uniform(0, 2 * np.pi, len(k))


def crate(random, pixels):
    k = random.integers(2, 6, 2)
    return np.ones(2), np.array([(k[0], 0), (0, k[1])]), random.uniform(0, 2 * np.pi, 2)


def grooves(random, pixels):
    k = random.integers(2, 6)
    return (np.array([1.0, random.uniform(0.05, 0.3)]),
            np.array([(random.integers(0, 3), k), (2, 0)]), random.uniform(0, 2 * np.pi, 2))


def heights_of(surface, pixels, points=None):
    """Heights of waves at the pixels, or at points of the unit square."""
    amplitude, k, phase = surface
    if points is not None:
        return np.cos(2 * np.pi * points @ k.T + phase) @ amplitude
    spectrum = np.zeros((pixels, pixels), complex)
    np.add.at(spectrum, (k[:, 1] % pixels, k[:, 0] % pixels), amplitude * np.exp(1j * phase))
    return np.fft.ifft2(spectrum).real * pixels**2


def top_of(surface, fine):
    """Height of the top, by Newton's method from the highest fine pixel."""
    amplitude, k, phase = surface
    y, x = np.unravel_index(fine.argmax(), fine.shape)
    place = np.array([x, y]) / len(fine)
    for _ in range(20):
        angle, q = 2 * np.pi * k @ place + phase, 2 * np.pi * k
        slope = -(amplitude * np.sin(angle)) @ q
        place = place - np.linalg.lstsq(-(q.T * (amplitude * np.cos(angle))) @ q, slope,
                                        rcond=1e-9)[0]
    return heights_of(surface, 0, place[None])[0]


def map_scene(folder, heights, step, spacing, edge, control, value):
    np.save(folder / "m.npy", heights[::step, ::step])
    return write_scene(folder / "m.scene", by_default=True, material={"contact_modulus": E},
                       loading={"control": control, "value": float(value)},
                       surfaces={"upper": "plane", "lower": "m.npy", "map_edge": edge,
                                 "map_level": "none", "map_spacing": (step * spacing,) * 2})


def rows_of(exe, write, *options):
    """The last state, the standard output and the processor time of a solve; None: refused."""
    with tempfile.TemporaryDirectory() as name:
        scene = write(Path(name))
        least = np.inf
        for _ in range(3):
            begun = resource.getrusage(resource.RUSAGE_CHILDREN)
            done = run_program(exe, "solve", scene, "--threads", "1", "--positions", "p.csv",
                               *options, cwd=name, status=None)
            spent = resource.getrusage(resource.RUSAGE_CHILDREN)
            least = min(least, spent.ru_utime + spent.ru_stime - begun.ru_utime - begun.ru_stime)
            if least > 0.2:
                break
        row = records(Path(name) / "p.csv")[0] if done.returncode == 0 else None
        return row, done.stdout + done.stderr, least


def maps(exe, number, start=0):
    """Balls and periodic surfaces, in turns at a pressure and at a compression."""
    for turn in range(start, start + number):
        random = np.random.default_rng(turn)
        pixels = 4 * int(random.integers(16, 49))
        kind = ("waves", "ball", "crate", "grooves", "waves")[turn % 5]
        control = ("pressure", "compression")[turn // 5 % 2]
        if kind == "ball":
            # A ball of radius R on contact radius a: load 4 E a**3/(3 R), compression a**2/R.
            radius, a = 50 * pixels, random.uniform(0.1, 0.3) * pixels
            place = pixels / 2 + random.uniform(-2, 2, 2)
            x = np.arange(pixels)
            heights = -((x - place[0])**2 + (x[:, None] - place[1])**2) / (2 * radius)
            load, compression = 4 * E * a**3 / (3 * radius), a**2 / radius
            value = {"pressure": load / pixels**2, "compression": compression}[control]
            doubt, edge = 0.0, "free"
        else:
            surface = {"waves": waves, "crate": crate, "grooves": grooves}[kind](random, pixels)
            fine = heights_of(surface, FINER * pixels)
            scale = 0.02 / np.sqrt(np.mean((np.diff(fine, axis=0) * FINER)**2 +
                                           (np.diff(fine, axis=1) * FINER)[:, :-1].T.mean()**2))
            fine, surface = scale * fine, (scale * surface[0], *surface[1:])
            top, edge = top_of(surface, fine), "periodic"
            pressure = 10**random.uniform(-2, -0.7) * E * 0.02
            row, text, _ = rows_of(exe, partial(
                map_scene, heights=fine, step=1, spacing=1 / FINER, edge=edge, control="pressure",
                value=pressure))
            assert row, text
            # The separation is that of the mean planes; first contact that of the top.
            compression = top - float(row["separation"])
            load = float(row["load"])
            value = {"pressure": pressure, "compression": compression}[control]
            doubt = float(row["separation_error_estimate"]) / 6
            heights = fine[::FINER, ::FINER]
        write = {name: partial(map_scene, heights=heights, step=step, spacing=1.0, edge=edge,
                               control=control, value=value)
                 for name, step in {"": 1, **STEPS}.items()
                 if edge == "free" or pixels % step == 0}
        truth = {"pressure": ("compression", compression), "compression": ("load", load)}[control]
        yield Case(f"{kind} {turn} {control}", write, *truth, doubt, truth[1])


def judged(exe, case, goals=GOALS):
    """A row for each goal: what was accepted, its error, its time over that of the cheapest method
    that truly has the error."""
    methods = []
    for name, write in case.write.items():
        if name:
            row, _, seconds = rows_of(exe, write)
            if row:
                methods.append((seconds, case.error(row), name))
    for goal in goals:
        cheapest = min((one for one in methods if one[1] <= goal), default=(np.nan, np.nan, ""))
        row, text, seconds = rows_of(exe, case.write[""], "--accuracy", goal)
        found = next((line for line in text.splitlines() if "fastest method" in line
                      or "no method" in line), text.strip())
        yield {"scene": case.name, "accuracy": goal, "accepted": int(row is not None),
               "error": f"{case.error(row):.2g}" if row else "", "seconds": f"{seconds:.3f}",
               "cheapest": cheapest[2], "its_error": f"{cheapest[1]:.2g}",
               "its_seconds": f"{cheapest[0]:.3f}",
               "message": found.partition(": ")[2].replace(",", ";")}


def summary(rows):
    """The counts for a goal and a kind of surface."""
    for kind, is_map in (("asperities", False), ("maps", True)):
        for goal in GOALS:
            part = [row for row in rows if row["accuracy"] == goal and
                    (" " in row["scene"]) == is_map]
            accepted = [row for row in part if row["accepted"]]
            possible = [row for row in part if row["cheapest"]]
            fast = [row for row in possible if row["accepted"] and
                    float(row["seconds"]) <= SLOWER * float(row["its_seconds"])]
            held = [row for row in accepted if float(row["error"]) <= goal]
            yield (f"{kind}, {goal:g}: {len(held)} of {len(accepted)} accepted hold; of "
                   f"{len(possible)} possible {sum(row['accepted'] for row in possible)} accepted, "
                   f"{len(fast)} within {SLOWER:g} times the time of the cheapest")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--asperities", type=int, default=60)
    parser.add_argument("--maps", type=int, default=40)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--save", action="store_true")
    words = parser.parse_args()
    exe, rows = build("release"), []
    for case in (*asperities(words.asperities), *maps(exe, words.maps, words.start)):
        for row in judged(exe, case):
            rows.append(row)
            print(*row.values(), sep=", ", flush=True)
    print(*summary(rows), sep="\n")
    if words.save:
        text = io.StringIO()
        writer = csv.DictWriter(text, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        lines = "".join(f"# {line}\n" for line in summary(rows))
        (KEPT / "accuracy_promises.csv").write_text(
            f"{heading()}accuracy_promises.py\n{lines}{text.getvalue()}", encoding="ascii")


if __name__ == "__main__":
    main()
