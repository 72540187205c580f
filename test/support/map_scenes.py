"""Height maps in scenes, indexed [x, y], and what a run makes of them as numbers."""

import numpy as np
from image_data import read_vti
from map_truth import levelled as level
from programs import run_program
from surfaces_csv import records, write_scene

E = 3.0


def write_map(path, height):
    """A matrix, one profile a line; x runs along it."""
    path.write_text("".join(" ".join("BAD" if np.isnan(z) else repr(float(z)) for z in row) + "\n"
                            for row in height.T))
    return path.name


def map_scene(folder, height, sides, name="map", upper="plane", interaction="boundary",
              surfaces=None, effects=None, material=None, **groups):
    """The scene of a map below a plane; a number as material is the contact modulus."""
    if not isinstance(material, dict):
        material = {"contact_modulus": material or E}
    return write_scene(
        folder / f"{name}.scene",
        surfaces={"upper": upper, "lower": write_map(folder / f"{name}.txt", height),
                  "map_spacing": sides, **(surfaces or {})},
        material=material, effects={"interaction": interaction, **(effects or {})}, **groups)


def numbers(row):
    """The cells of a row as numbers, empty ones as NaN, words as they are."""
    def number(cell):
        try:
            return float(cell or "nan")
        except ValueError:
            return cell
    return {name: number(cell) for name, cell in row.items()}


def solve_map(asperity, scene, *options, status=0):
    """States and position as numbers, fields of the last state, messages; of a refusal these."""
    at = {name: scene.with_suffix(f".{name}") for name in ("curve", "positions", "vti")}
    done = run_program(asperity, "solve", scene, "--quiet", "--curve", at["curve"], "--positions",
                       at["positions"], "--fields", at["vti"], *options, status=status)
    if status:
        return done.stderr
    return ([numbers(row) for row in records(at["curve"])], numbers(records(at["positions"])[0]),
            read_vti(at["vti"])[2] if at["vti"].exists() else None, done.stderr)


def load_for(height, sides, share):
    """What presses about a share of the area: half the rms slope times E, over the area."""
    slope = np.gradient(height, *sides)
    rms = np.sqrt(np.mean(slope[0] ** 2 + slope[1] ** 2))
    return float(share * E * rms / 2 * height.size * np.prod(sides))


def patch_areas(pressure, sides, periodic, hardness=np.inf):
    """Areas of the patches: of a pixel 1 less .118 for each side to a measured one out of contact
    (Yastrebov et al. 2017), at least its pressure over the hardness. A free map has no rim at its
    edge; nan is a missing pixel."""
    around = np.pad(pressure, 1, mode="wrap" if periodic else "edge")
    rim = sum(np.roll(around, shift, axis)[1:-1, 1:-1] == 0 for shift in (1, -1) for axis in (0, 1))
    of_pixel = np.maximum(1 - rim * (np.pi - 1 + np.log(2)) / 24, pressure / hardness)
    todo, areas = set(zip(*np.nonzero(pressure > 0))), []
    while todo:
        patch = [todo.pop()]
        for i, j in patch:
            for near in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
                if periodic:
                    near = near[0] % len(pressure), near[1] % len(pressure[0])
                if near in todo:
                    todo.remove(near)
                    patch.append(near)
        areas.append(of_pixel[tuple(zip(*patch))].sum())
    return np.array(areas) * np.prod(sides)
