"""Random scenes whose effects `auto` may leave out: maps of random spectra, of the generator and of
files; caps; a ball as a row of a table and as pixels. Each effect and each pair, over decades of
its influence, from 0.01 to 90 % contact."""

from itertools import combinations

import numpy as np
from made_maps import FOLDER, archived
from map_scenes import map_scene
from programs import run_program
from surfaces_csv import write_csv_scene, write_scene

KINDS = "random", "generated", "measured", "caps", "ball"
SETS = [names for number in (1, 2) for names in
        combinations(("friction", "plasticity", "adhesion", "creep"), number)]
EVERY = len(KINDS) * len(SETS)  # scenes with each set on each kind
MODULUS = 1e3  # combined, of two bodies with Poisson's ratio 0.3
MATERIAL = {"elastic_modulus": (2 * 0.91 * MODULUS,) * 2, "poisson_ratio": (0.3, 0.3)}
RANGE = 9 * 3**0.5 / 16  # of the exponential law over the equilibrium distance
BALL = 10.0  # its radius


class Body:
    """What lies under a plane or another body: how a scene of it is written, the standard deviation
    of its heights, the width of a pixel or the radius of a cap, and a pressure at which much of it
    is in contact."""

    def __init__(self, write, height, width, pressure, is_map=True, is_ball=False):
        self.write, self.height, self.width = write, float(height), float(width)
        self.pressure, self.is_map, self.is_ball = float(pressure), is_map, is_ball


def rms_slope(height, sides):
    """Of the pixels that are measured."""
    steps = [np.diff(height, axis=k) / side for k, side in enumerate(sides)]
    return float(np.sqrt(sum(np.nanmean(step**2) for step in steps)))


def of_map(height, sides, edge, name=None):
    """A map, from a file of this name or written."""
    def write(folder, **groups):
        if name:
            return write_scene(folder / "map.scene", by_default=True, material=MATERIAL,
                               surfaces={"upper": "plane", "lower": name}, **groups)
        return map_scene(folder, height, sides, surfaces={"map_edge": edge}, material=MATERIAL,
                         interaction="auto", by_default=True, **groups)

    return Body(write, np.nanstd(height), max(sides), MODULUS * rms_slope(height, sides))


def random_map(rng, *_):
    """Heights with a random spectrum and rms slope."""
    pixels = int(rng.choice([24, 32]))
    q = np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(pixels)]))
    q[0, 0] = 1
    keeps = (q <= 1 / rng.uniform(4, 8)) & (q >= 1 / rng.uniform(10, pixels))
    height = np.fft.ifft2(np.where(keeps, q**-(1 + rng.uniform(0.3, 1)), 0) *
                          np.fft.fft2(rng.standard_normal((pixels, pixels)))).real
    height *= rng.uniform(0.02, 0.2) / rms_slope(height, (1.0, 1.0))
    return of_map(height, (1.0, 1.0), str(rng.choice(["periodic", "free"])))


def generated_map(rng, asperity, folder):
    """A map of `asperity generate`."""
    (folder / "map.spec").write_text(
        f"&map pixels = 30, 24, spacing = 1., 1., hurst = {rng.uniform(0.3, 0.9):.3f}, "
        f"roll_off = {rng.uniform(12, 24):.2f}, cut_off = {rng.uniform(4, 8):.2f},\n"
        f" rms_slope = {rng.uniform(0.02, 0.2):.3f}, seed = {rng.integers(1000)} /\n")
    run_program(asperity, "generate", "map.spec", "--output", "map.npy", cwd=folder)
    return of_map(np.load(folder / "map.npy").T, (1.0, 1.0), "periodic")


def measured_map(rng, *_):
    """A map of a file, levelled by the program; one has missing pixels."""
    name = str(rng.choice(sorted(archived())))
    height, side = archived()[name]
    return of_map(height.T, (side, side), "free", str(FOLDER / name))


def caps(rng, *_):
    """Caps on both bodies, of which some meet, in a plan of 6 by 6."""
    def rows(number):
        return [tuple(map(float, row)) for row in np.column_stack([
            rng.uniform(0, 6, (number, 2)), 0.3 + spread * rng.uniform(-1, 1, number),
            rng.uniform(0.5, 2, number)])]

    def write(folder, **groups):
        return write_csv_scene(folder, upper, lower, name="caps", by_default=True,
                               modulus=MATERIAL["elastic_modulus"], ratio=(0.3, 0.3), **groups)

    spread = 10**rng.uniform(-3, -1.3)
    upper, lower = rows(int(rng.integers(4, 10))), rows(int(rng.integers(8, 20)))
    return Body(write, spread, 1.0, MODULUS * np.sqrt(spread) / 2, False)


def ball(as_pixels):
    """A ball of radius 10: as the row of a table, or as 64 by 64 pixels."""
    side, pixels = 0.05, 64

    def row(folder, **groups):
        (folder / "ball.csv").write_text(f"x,y,height,radius\n0,0,0.5,{BALL}\n")
        return write_scene(folder / "ball.scene", by_default=True, material=MATERIAL,
                           surfaces={"upper": "plane", "lower": "ball.csv"}, **groups)

    def map_of(folder, **groups):
        x = (np.arange(pixels) - pixels // 2) * side
        return map_scene(folder, -(x[:, None]**2 + x[None, :]**2) / (2 * BALL), (side, side),
                         surfaces={"map_level": "none"}, material=MATERIAL, interaction="auto",
                         by_default=True, **groups)

    return Body(map_of if as_pixels else row, 0.05, side if as_pixels else BALL, MODULUS / 20,
                as_pixels, True)


MAKERS = {"random": random_map, "generated": generated_map, "measured": measured_map, "caps": caps}


def loading_of(rng, body):
    """A pressure of a map, or a compression; a load of caps."""
    if not body.is_map and rng.random() < 0.5:
        return {"control": "load", "value": float(36 * body.pressure * 10**rng.uniform(-4, -0.5))}
    if body.is_map and rng.random() < 0.7:
        return {"control": "pressure", "value": float(body.pressure * 10**rng.uniform(-4, -0.1))}
    return {"control": "compression", "value": float(body.height * 10**rng.uniform(-1.5, 0.3))}


def with_shear(rng, body, loading, names):
    """Half of the maps with friction are displaced along the plane, where its theory is closed."""
    if "friction" in names and body.is_map and not {"adhesion", "creep"} & set(names) \
            and rng.random() < 0.5:
        loading["tangential_displacement"] = float(body.height * 10**rng.uniform(-3, 0))
    return loading


def numbers_of(rng, body, names):
    """The numbers of these effects, by effect. Pixels resolve the attraction: its steepness is at
    most 1. On pixels friction has a tangential load of its own, in &loading."""
    reach = body.height * 10**rng.uniform(-1.5, 0.7)
    yields = body.pressure * 10**rng.uniform(-0.5, 1)
    every = {
        "friction": {"friction_coefficient": float(10**rng.uniform(-3, 0))},
        "plasticity": {"plastic_hardness": float(yields * 3)} if body.is_map else
                      {"plastic_yield_stress": float(yields)},
        "adhesion": {"work_of_adhesion": float(10**rng.uniform(-5, -0.9) * reach**2 * MODULUS /
                                               body.width),
                     "equilibrium_distance": float(reach / RANGE),
                     "adhesion_law": str(rng.choice(["exponential", "van_der_waals"]))},
        "creep": {"hold_time": float(10**rng.uniform(-1, 1)), "relaxation_time": 1.0,
                  "relaxed_modulus_ratio": float(1 - 10**rng.uniform(-3, -0.1)),
                  "hold": str(rng.choice(["load", "separation"]))}}
    return {name: every[name] for name in names}


def scene_of(seed):
    """Kind, effects and random numbers of a scene."""
    return (KINDS[seed % len(KINDS)], SETS[seed // len(KINDS) % len(SETS)],
            np.random.default_rng(seed))
