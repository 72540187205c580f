"""Small scenes for tests: surfaces and scene files written, solved, and the results read."""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from csv_rows import records
from exact_contact import Scene, Surface
from programs import run_program


@dataclass
class Solved:
    """What a run of `asperity solve` left."""

    status: int
    stdout: str
    stderr: str
    positions: list
    contacts: list
    curve: list
    scene: Path | None = None


def text_of(value):
    """A number as the scene reads it; a pair with a comma; a word in quotes."""
    if isinstance(value, (tuple, list)):
        return ", ".join(map(text_of, value))
    if isinstance(value, Fraction):
        value = float(value)
    return f"'{value}'" if isinstance(value, str) else repr(value)


def write_surface(path, rows):
    """Rows (x, y, height, radius) of doubles."""
    path.write_text("x,y,height,radius\n"
                    + "".join(",".join(repr(float(c)) for c in row) + "\n" for row in rows))
    return path.name


def write_scene(path, by_default=False, **groups):
    """One group a keyword, each a dict. Effects that it does not name are off.

    With `by_default` they are as the program has them.
    """
    if not by_default:
        groups["effects"] = {**groups.get("effects", {}), **{
            name: "off" for name in ("interaction", "plasticity")
            if name not in groups.get("effects", {})}}
    path.write_text("".join(
        f"&{group} " + ", ".join(f"{name} = {text_of(value)}" for name, value in names.items())
        + " /\n" for group, names in groups.items()))
    return path


def write_csv_scene(folder, upper, lower, name="pair", modulus=(2.0e5, 1.0e5), ratio=(0.3, 0.25),
                    **groups):
    """Two surfaces and the scene that names them."""
    return write_scene(
        folder / f"{name}.scene",
        surfaces={"upper": write_surface(folder / f"{name}_upper.csv", upper),
                  "lower": write_surface(folder / f"{name}_lower.csv", lower)},
        material={"elastic_modulus": modulus, "poisson_ratio": ratio}, **groups)


def write_plane_scene(folder, caps, surfaces=None, modulus=(1e3, 1e3), ratio=(0.3, 0.3), **groups):
    """A plane over asperities in a folder; one number as modulus is the contact modulus."""
    folder.mkdir(exist_ok=True)
    lower = write_surface(folder / "caps.csv", caps)
    return write_scene(
        folder / "caps.scene", surfaces={"upper": "plane", "lower": lower, **(surfaces or {})},
        material={"contact_modulus": modulus} if isinstance(modulus, float) else
        {"elastic_modulus": modulus, "poisson_ratio": ratio}, **groups)


def exact_csv_scene(upper, lower, modulus=(2.0e5, 1.0e5), ratio=(0.3, 0.25), **groups):
    """The same scene for the exact evaluation. CSV cells are doubles, the rest is its text."""
    def decimals(values):
        return tuple(Fraction(repr(v)) for v in values)

    tilt, motion = groups.get("tilt", {}), groups.get("motion", {})
    loading, limit = groups.get("loading", {}), groups.get("limit", {})
    rotation = decimals(tilt.get("rotation", (0.0, 0.0)))
    surfaces = [
        Surface([tuple(map(Fraction, row)) for row in rows], Fraction(repr(modulus[i])),
                Fraction(repr(ratio[i])), decimals(tilt.get(side + "_slope", (0.0, 0.0))),
                rotation[i])
        for i, (side, rows) in enumerate((("upper", upper), ("lower", lower)))]
    criterion = limit.get("criterion", "load")
    number = {"greenwood_williamson": "hardness", "hardy": "yield_stress"}.get(criterion, "value")
    return Scene(
        *surfaces,
        first=decimals(motion.get(axis + "_first", 0.0) for axis in "xy"),
        step=decimals(motion.get(axis + "_step", 0.0) for axis in "xy"),
        positions=motion.get("positions", 1), control=loading.get("control", "limit"),
        value=Fraction(repr(loading["value"])) if "value" in loading else None,
        criterion=criterion, limit=Fraction(repr(limit[number])) if number in limit else None)


def solve(asperity, scene, *options, folder=None, contacts=True, curve=False, timeout=300):
    """Run the solver; the CSV files appear in the folder, else beside the scene, and are read."""
    folder = folder or scene.parent
    wanted = ["positions"] + ["contacts"] * contacts + ["curve"] * curve
    files = {name: folder / "-".join((scene.name, *options, name + ".csv")) for name in wanted}
    named = [part for name, path in files.items() for part in ("--" + name, path)]
    done = run_program(asperity, "solve", scene, *options, *named, status=None, timeout=timeout)
    return Solved(done.returncode, done.stdout, done.stderr,
                  *(records(files[name]) if name in files and files[name].exists() else []
                    for name in ("positions", "contacts", "curve")), scene)
