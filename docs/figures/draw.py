"""Draws docs/figures/*.svg by public functions of the Python package: `solve`, `report`,
`accuracy`, and `plot` of their results; `Table.plot_columns` for curves.

    python docs/figures/draw.py EXE [NAME ...]     # all figures, or some, as fig10 fig11

EXE makes input in build/figures. `work_precision` and `time-and-error` have times of the machine
that draws them.
"""

import csv
import functools
import re
import subprocess
import sys
import warnings
from math import erf, exp, pi, sqrt
from pathlib import Path

import matplotlib
import numpy as np

import asperity

matplotlib.use("svg")
import matplotlib.pyplot as plt
from matplotlib.patches import Circle, PathPatch, Rectangle
from matplotlib.transforms import Affine2D

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parents[1]
DATA = ROOT / "build/figures"
SCENES = ROOT / "docs/figures/scenes"
EFFECTS = ROOT / "data/examples/effects"
KEPT = ROOT / "reference_output"
MAP = ROOT / "data/examples/summits/smooth.sdf"
# Paul Tol's high-contrast colours, safe for the colour-blind and in grey.
BLUE, YELLOW, RED, INK, GREY = "#004488", "#DDAA33", "#BB5566", "#222222", "#888888"
INCH = 2.54
STYLE = {"font.size": 10.5, "axes.spines.top": False, "axes.spines.right": False,
         "axes.edgecolor": "#666666", "axes.grid": True, "grid.color": "#DDDDDD",
         "grid.linewidth": 0.6, "axes.axisbelow": True, "lines.linewidth": 1.8,
         "legend.edgecolor": "none", "legend.framealpha": 0.9, "svg.hashsalt": "asperity",
         "figure.constrained_layout.use": True, "xtick.color": "#333333",
         "ytick.color": "#333333", "lines.markersize": 4}
PRINTED = {"marker": "o", "fillstyle": "none", "color": INK, "linestyle": "none",
           "markersize": 6, "markeredgewidth": 0.9}
FIGURES = {}


def figure(height, rows=1, columns=1, **options):
    """Registers a drawing procedure of a figure of a height in units of 1/100 of 8 inches."""
    def register(draw):
        def make():
            canvas, axes = plt.subplots(rows, columns, figsize=(8, height / 100), **options)
            draw(canvas, *np.atleast_1d(axes).flat)
            return canvas
        FIGURES[draw.__name__] = make
        return draw
    return register


def table(path, **chosen):
    """A kept CSV file as a table; an empty field is not a number. `chosen`: words of rows."""
    with open(path, newline="", encoding="ascii") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    rows = [row for row in rows if all(row[name] == word for name, word in chosen.items())]

    def column(name):
        try:
            return np.array([float(row[name] or "nan") for row in rows])
        except ValueError:
            return np.array([row[name] for row in rows])
    return asperity.Table({name: column(name) for name in rows[0]})


@functools.cache
def solved(path, **options):
    """Results of a scene file."""
    return asperity.solve(path, **options)


def part(states, rows, **more):
    """Some rows of a table, with further columns."""
    return asperity.Table({name: values[rows] for name, values in {**states, **more}.items()},
                          states.units)


def run(executable, *words, folder=ROOT):
    done = subprocess.run([executable, *map(str, words)], cwd=folder, capture_output=True,
                          text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return done.stdout


def make_input(executable, wanted):
    """Files that scenes of the figures name."""
    DATA.mkdir(parents=True, exist_ok=True)
    run(executable, "summits", MAP, "--unit", "um", "--rule", "contact", "--quiet", "--output",
        DATA / "summits.csv")
    run(executable, "generate", "data/examples/generate/surface.spec", "--output",
        DATA / "surface.sdf")
    for name in ("rough-ball", "measured-surface"):
        page = (ROOT / f"docs/tutorial/{name}.md").read_text(encoding="utf-8")
        for name, text in re.findall(r"`(ball[.]spec|\w+[.]scene)`.*?```\n(.*?)```", page,
                                     re.DOTALL):
            (DATA / name).write_text(text, encoding="ascii")
    run(executable, "generate", "ball.spec", "--output", "ball.sdf", folder=DATA)
    (DATA / "surface.scene").write_text((SCENES / "surface.scene").read_text(), encoding="ascii")
    if "stability" in wanted:
        subprocess.run([sys.executable, ROOT / "test/support/stability.py", executable,
                        DATA / "stability.csv"], cwd=ROOT, check=True)


# ------------------------------------------------------------------ the thesis

def three_curves(axes, name):
    """A quantity against load at three displacements, with the totals that the thesis prints."""
    for position, letter, colour, width in ((13, "a", YELLOW, 3), (55, "b", RED, 2.2),
                                            (56, "c", BLUE, 1.4)):
        curve = solved(SCENES / f"position_{position}.scene").states
        curve.plot_columns("load", name, axes, color=colour, linewidth=width,
                           label=f"x = {position / 10} cm",
                           drawstyle="steps-post" if name == "contacts" else "default")
        printed = table(KEPT / f"thesis/table_vii{letter}.csv")
        number, last, touch = 0, 0.0, None
        points = []
        for kind, separation, area, load, label in zip(*(printed[key] for key in (
                "kind", "approach", "area", "load", "area_no"))):
            separation = float(separation) if separation not in ("", "?") else np.nan
            if kind == "contact":
                number, last = float(label), separation
                touch = separation if touch is None else touch
            elif kind == "total" and float(str(load).strip("?") or 0) > 0:
                area = str(area)
                points.append((float(load), {"contacts": number, "compression": touch - last,
                                             "area": np.nan if "?" in area else float(area)}[name]))
        axes.plot(*np.array(points).T, **PRINTED,
                  label="printed in the thesis" if position == 56 else None)


@figure(460)
def fig10(_, axes):
    three_curves(axes, "contacts")
    axes.set(xlim=(0, 1500), ylim=(0, 9), yticks=range(10))
    axes.legend(loc="lower right")


def logarithmic(axes, low, high, ticks):
    axes.set(xscale="log", yscale="log", xlim=(1, 2000), ylim=(low, high), xticks=(
        1, 10, 100, 1000), xticklabels=("1", "10", "100", "1000"))
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.legend(loc="upper left")


@figure(520)
def fig11(_, axes):
    three_curves(axes, "compression")
    logarithmic(axes, 2e-4, 2e-2, (2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2))


@figure(520)
def fig12(_, axes):
    three_curves(axes, "area")
    logarithmic(axes, 5e-4, 0.2, (5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 0.1, 0.2))


def models(deck):
    """Upper and lower summits of a deck, x and y in inches: NU in columns 1-5 of card 2."""
    lines = Path(deck).read_text(encoding="ascii").splitlines()
    upper = int(lines[1][:5])
    rows = np.array([[float(line[k:k + 6]) for k in (0, 6)] for line in lines[4:]
                     if line[:6].strip()])
    return rows[:upper], rows[upper:]


@figure(760, 2, 3, gridspec_kw={"height_ratios": [1.25, 1], "width_ratios": [1, 1, 0.35]})
def fig28(canvas, *panels):
    """The thesis gives surfaces of 3 in x 8 in and 3 in x 4 in on models 3.455 in wide. The margin
    at their ends is taken to be that at their sides."""
    for panel in (panels[0], panels[1], panels[2], panels[5]):
        panel.remove()
    width = 3.455 * INCH
    margin = (width - 3 * INCH) / 2
    shift = 5.6
    upper, lower = models(ROOT / "data/thesis.deck")
    results = solved(SCENES / "position_56.scene")
    places = ((7.52, 7.55, "a"), (9.92, 2.17, "b"))
    whole = canvas.add_subplot(panels[0].get_gridspec()[0, :])
    for axes in (whole, panels[3], panels[4]):
        axes.grid(False)
        axes.set_aspect("equal")
        axes.spines[:].set_visible(True)
        axes.add_patch(Rectangle((0, 0), 8 * INCH + 2 * margin, width, facecolor="#F3F3F3",
                                 edgecolor="#777777"))
        axes.add_patch(Rectangle((shift, 0), 4 * INCH + 2 * margin, width, facecolor="#DCE6F2",
                                 edgecolor=BLUE))
        large = 1 if axes is whole else 3
        results.plot_contacts(ax=axes)
        if axes is not panels[4]:
            axes.collections[-1].colorbar.remove()
        axes.plot(lower[:, 0] * INCH, width - lower[:, 1] * INCH, ".", color="#777777",
                  markersize=3 * large, label="lower summits")
        axes.plot(upper[:, 0] * INCH + shift, upper[:, 1] * INCH, "+", color=BLUE,
                  markersize=4 * large, markeredgewidth=0.8, label="upper summits")
    whole.plot([], [], "o", color="#35B779", label="contacts, to scale")
    whole.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=3)
    whole.text(0.3, 0.4, "lower model", color="#555555")
    whole.text(shift + 0.3, 0.4, "upper model, moved by 5.6 cm", color=BLUE)
    whole.set(xlim=(-0.3, 21.8), ylim=(-0.3, 9.1), xlabel="x (cm)", ylabel="y (cm)")
    for axes, (x, y, name) in zip(panels[3:5], places):
        whole.add_patch(Rectangle((x - 0.35, y - 0.35), 0.7, 0.7, fill=False, edgecolor=INK))
        whole.text(x + 0.45, y, name)
        axes.set(xlim=(x - 0.35, x + 0.35), ylim=(y - 0.35, y + 0.35), title=name, xlabel="x (cm)")


@figure(300, columns=3)
def fig28_loads(canvas, *panels):
    """The contacts of position 56 at three loads, with five times their radii."""
    width = 3.455 * INCH
    upper, _ = models(ROOT / "data/thesis.deck")
    results = solved(SCENES / "position_56.scene")
    curve = results.states
    for axes, share in zip(panels, (0.05, 0.3, 1.0)):
        state = int(np.argmin(np.abs(curve["load"] - share * curve["load"][-1])))
        results.plot_contacts(ax=axes, step=1 + state)
        drawn = axes.collections[-1]
        drawn.set_clim(0, 16000)
        centres = [path.get_extents().get_points().mean(axis=0) for path in drawn.get_paths()]
        drawn.set_paths([
            PathPatch(path.transformed(Affine2D().translate(-x, -y).scale(5).translate(x, y)))
            for path, (x, y) in zip(drawn.get_paths(), centres)])
        if axes is not panels[2]:
            axes.collections[-1].colorbar.remove()
        axes.plot(upper[:, 0] * INCH + 5.6, upper[:, 1] * INCH, "+", color=GREY, markersize=4,
                  markeredgewidth=0.6)
        axes.grid(False)
        axes.set(title=f"{curve['load'][state]:.0f} N, {curve['contacts'][state]} contacts",
                 xlim=(6.4, 16.9), ylim=(1, width))


@figure(760)
def report_head(canvas, axes):
    """The first page of Table VIIA, on the paper of a line printer: pale bars of two lines, the
    holes of the edges every half inch of three lines."""
    page = next(page for page in asperity.report(ROOT / "data/thesis.deck").split("\f")
                if any(line.endswith(" TABLE VIIA") for line in map(str.rstrip, page.split("\n"))))
    lines = [line.rstrip()[7:] for line in page.strip("\n").split("\n")]
    while not lines[-1]:
        lines.pop()
    pitch, strip, wide = 17, 36, 800
    tall = pitch * (len(lines) + 4)
    canvas.set_size_inches(8, tall / 100)
    canvas.set_layout_engine("none")
    axes.set_position((0, 0, 1, 1))
    axes.set(xlim=(0, wide), ylim=(tall, 0))
    axes.axis("off")
    for first in range(0, len(lines), 4):
        axes.add_patch(Rectangle((strip, (2 + first) * pitch), wide - 2 * strip, 2 * pitch,
                                 color="#E6F2E8", linewidth=0))
    for x in (strip / 2, wide - strip / 2):
        for y in np.arange(1.5 * pitch, tall, 3 * pitch):
            axes.add_patch(Circle((x, y), 5, facecolor="#E4E4E4", edgecolor="#BBBBBB"))
    for x in (strip, wide - strip):
        axes.axvline(x, color="#CCCCCC", linewidth=0.6, linestyle=":")
    for number, line in enumerate(lines):
        axes.text(strip + 6, (2.5 + number) * pitch, line, family="monospace", fontsize=8.1,
                  va="center", color=INK)


@figure(460)
def interaction(_, axes):
    """Load of the contacts together over that of isolated contacts. Positions with overlapping
    contact circles are named."""
    truth = table(KEPT / "boundary/factors.csv")
    axes.axhline(1, color="#999999", linestyle=":", label="isolated contacts")
    for name, label, style in (
            ("coupled", "coupled", {"color": YELLOW}),
            ("boundary", "boundary elements", {"color": RED, "fillstyle": "none", "ms": 7})):
        solved(SCENES / f"{name}.scene").positions.plot_columns(
            "x_displacement", "factor", axes, marker="o", ls="", label=label, **style)
    axes.plot(truth["position"] / 10, truth["factor"], "x", color=INK,
              label="independent evaluation")
    for position, factor, circles in zip(truth["position"], truth["factor"],
                                         truth["overlapping_circles"]):
        if circles > 0:
            axes.annotate(f"{position:.0f}", (position / 10, factor), (7, -3),
                          textcoords="offset points")
    axes.set(xlim=(0, 10.1), ylim=(0.74, 1.02),
             ylabel="load with interaction / load of isolated contacts")
    axes.legend(loc="center", bbox_to_anchor=(0.4, 0.42))


@figure(460)
def friction(_, axes):
    found = solved(SCENES / "friction.scene").positions
    lateral = np.hypot(found["rig_force_x"], found["rig_force_y"]) / found["vertical_load"]
    rows = part(found, slice(None), lateral=100 * lateral, added=100 * found["friction_influence"])
    rows.plot_columns("x_displacement", "lateral", axes, marker="o", ls="", color=RED,
                      fillstyle="none", markersize=6, label="lateral force on the fixture")
    rows.plot_columns("x_displacement", "added", axes, marker="o", ls="", color=BLUE,
                      label="vertical load added by friction, coefficient 0.1")
    axes.set(ylabel="share of the vertical load (%)", xlim=(0, 10.1), ylim=(0, 11))
    axes.legend(loc="upper right")


@figure(440)
def gallery_sweep(_, axes):
    rows = solved(ROOT / "data/examples/thesis.scene").positions
    rows.plot_columns("x_displacement", "load", axes, color=BLUE, label="load")
    axes.plot([], [], color=YELLOW, label="contacts")
    axes.set(xlim=(0, 10.1), ylim=(0, 1500))
    other = axes.twinx()
    other.grid(False)
    other.spines.right.set_visible(True)
    rows.plot_columns("x_displacement", "contacts", other, color=YELLOW, drawstyle="steps-post")
    other.set(ylim=(0, 42), yticks=range(0, 9, 2))
    other.set_ylabel("contacts", y=0.1)
    axes.legend(loc="upper left")


# ------------------------------------------------------------------ effects

@figure(480)
def adhesion(_, axes):
    """The models of the thesis in gelatine."""
    curve = solved(EFFECTS / "gelatine.scene").states
    for first, style in ((0, {"color": BLUE, "label": "loading"}),
                         (100, {"color": RED, "label": "unloading"}),
                         (200, {**PRINTED, "markersize": 3, "label": "reloading"})):
        rows = (curve["step"] > first) & (curve["step"] <= first + 101)
        part(curve, rows).plot_columns("separation", "load", axes, **style)
    axes.axhline(0, color="#666666", linewidth=0.8)
    axes.set(xlim=(0.302, 0.259), ylim=(-0.0125, 0.0075))
    axes.legend(loc="upper left")


@figure(440)
def creep(_, axes):
    """Polymethyl methacrylate held for ten minutes: share r of the load that relaxes, time tau."""
    share, tau = 0.8, 100.0
    for name, column, colour, label in (
            ("ten_minutes", "area", YELLOW, "load held: contact area"),
            ("ten_minutes", "compression", RED, "load held: compression"),
            ("ten_minutes_approach", "load", BLUE, "separation held: load")):
        held = solved(EFFECTS / f"{name}.scene").states
        held = part(held, slice(None), ratio=held[column] / held[column][0])
        held.plot_columns("time", "ratio", axes, color=colour, label=label)
    time = np.linspace(0, 610, 300)
    single = [(1 / share - (1 / share - 1) * exp(-share * t / tau))**(2 / 3) for t in time]
    axes.plot(time, single, ":", color=INK, linewidth=1, label="load held: a single contact")
    axes.set(xlabel="time since loading (s)", ylabel="value over that at the end of loading",
             xlim=(0, 610), ylim=(0.78, 1.2))
    axes.legend(loc="center right")


@figure(480)
def hysteresis(_, axes):
    """Steps 2 to 41 go up, 42 to 81 down, and so on; at `limit` the first contact is at its."""
    cycle, elastic = (solved(EFFECTS / f"{name}.scene").states
                      for name in ("cycle", "cycle_elastic"))
    limit = 1372
    axes.plot([0, 0.0295], [limit, limit], ":", color="#999999")
    axes.text(0.03, limit, "first contact at its limit", color="#555555", va="center")
    elastic.plot_columns("compression", "load", axes, ls="--", color="#999999",
                         label="elastic: loading and unloading")
    for k in range(6):
        rows = (cycle["step"] > 40 * k) & (cycle["step"] <= 40 * k + 41)
        part(cycle, rows).plot_columns(
            "compression", "load", axes, color=(BLUE, RED)[k % 2],
            label=("plastic: loading", "unloading")[k] if k < 2 else None)
    axes.set(xlim=(0, 0.052), ylim=(0, 12600))
    axes.legend(loc="upper left")


@figure(460)
def plasticity(_, axes):
    """A ball past its elastic limit: load and area over those of Hertz at the same overlap."""
    overlap, force, area = 1.1090941284170878e-4, 3.470072092352658e-4, 3.484321965974697e-4
    curve = solved(EFFECTS / "steel.scene").states
    first = curve["compression"] > np.r_[-1, np.maximum.accumulate(curve["compression"])[:-1]]
    first &= curve["compression"] > 0
    x = curve["compression"][first] / overlap
    axes.axvspan(1.9, 6, color="#F0F0F0")
    axes.text(3.38, 0.29, "joined", color="#666666", ha="center")
    axes.axhline(1, color="#999999", linestyle=":", label="Hertz")
    rows = asperity.Table({"overlap": x, "area": curve["area"][first] / area / x,
                           "load": curve["load"][first] / force / x**1.5})
    rows.plot_columns("overlap", "area", axes, color=YELLOW, label="area")
    rows.plot_columns("overlap", "load", axes, color=BLUE, label="load")
    fit = np.geomspace(6, 110, 50)
    axes.plot(fit, 1.40 * fit**1.263 / fit**1.5, "--", color=RED, label="load, Kogut and Etsion")
    axes.set(xscale="log", xlim=(1, 130), ylim=(0.25, 2.2), ylabel="Load, area / those of Hertz",
             xlabel="Overlap / overlap at first yield")
    ticks = (1, 1.9, 3, 6, 10, 20, 50, 100)
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_xticks([], minor=True)
    axes.legend(loc="upper left")


@figure(420)
def gallery_index(_, axes):
    """The surface of Greenwood and Williamson at a plasticity index of 0.92."""
    curve = solved(EFFECTS / "index_092.scene").states
    part(curve, slice(None), load=curve["load"] / 400).plot_columns("load", "contacts", axes,
                                                                    marker="o", color=BLUE)
    axes.set(xlabel="load per summit (N)", ylabel="summits in contact, of 400", ylim=(0, 400))
    axes.set_xlim(left=0)


@figure(420)
def gallery_limit(_, axes):
    """One pair of summits past its limit."""
    for name, colour, label in (
            ("beyond_limit", BLUE, "auto: plastic from 1.5 times the limit load on"),
            ("beyond_limit_hertz", YELLOW, "Hertz")):
        solved(EFFECTS / f"{name}.scene").states.plot_columns(
            "load", "area", axes, marker="o", color=colour, label=label)
    axes.set_xlim(0, 2950)
    axes.set_ylim(bottom=0)
    axes.legend(loc="upper left")


@figure(420)
def gallery_pair(_, axes):
    """Radii 5 and 10, one modulus of 200e3 and Poisson's ratio 0.3 for both, and Hertz by hand."""
    radius, modulus = 1 / (1 / 5 + 1 / 10), 200e3 / (2 * (1 - 0.3**2))
    x = np.linspace(0, 0.0105, 100)
    axes.plot(x, 4 / 3 * modulus * sqrt(radius) * x**1.5, color=YELLOW, linewidth=5, label="Hertz")
    solved(SCENES / "pair.scene").states.plot_columns("compression", "load", axes, marker="o",
                                                      color=BLUE, label="asperity")
    axes.set_xlim(0, 0.0105)
    axes.set_ylim(bottom=0)
    axes.legend(loc="upper left")


@figure(420)
def gallery_surfaces(_, axes):
    """Two surfaces of five asperities each under one load, with the number of contacts."""
    slide = solved(ROOT / "data/examples/csv_surfaces.scene").positions
    slide.plot_columns("x_displacement", "separation", axes, marker="o", color=BLUE)
    for x, y, number in zip(slide["x_displacement"], slide["separation"], slide["contacts"]):
        axes.annotate(f"{number:.0f}", (x, y), (0, 6), textcoords="offset points", ha="center",
                      color="#555555")
    axes.margins(y=0.15)
    axes.set(xlabel=f"{axes.get_xlabel()} (mm)", ylabel=f"{axes.get_ylabel()} (mm)")


# ------------------------------------------------------------------ maps and statistics

@figure(370)
def gallery_generated(_, axes):
    """A random pair of models: the summits of both in plan."""
    for rows, marker, colour, label in zip(
            asperity.generate(ROOT / "data/examples/generate/thesis.spec"), "+o", (BLUE, RED),
            ("upper model", "lower model")):
        rows.plot_columns("x", "y", axes, ls="", marker=marker, ms=6, color=colour, label=label)
    axes.set(xlabel="x (in)", ylabel="y (in)", xlim=(-0.1, 8.1), ylim=(-0.1, 3.1), aspect="equal")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=2)


@figure(460, 1, 2)
def how_good(_, left, right):
    """Summits and theories against the pixels of fifteen maps: medians."""
    for number, (name, label) in enumerate((
            ("contact", "summits, coupled"), ("plain", "plain summits"),
            ("alone", "isolated summits"), ("half", "half resolution"),
            ("greenwood_williamson", "Greenwood, Williamson"),
            ("bush_gibson_thomas", "Bush, Gibson, Thomas"), ("persson", "Persson"))):
        rows = table(KEPT / "bench/maps.csv", way=name)
        style = {"color": (BLUE, RED, YELLOW, INK, GREY, GREY, GREY)[number],
                 "marker": "oooo*sx"[number],
                 "linestyle": ("-", "--", ":", "-.")[max(0, number - 3)]}
        rows = part(rows, slice(None), percent=100 * rows["share"])
        rows.plot_columns("percent", "error_median", left, **style)
        rows.plot_columns("percent", "area_median", right, **style, label=label)
    for axes in (left, right):
        axes.set(xlabel="area fraction (%)", xscale="log", xlim=(0.2, 30))
        axes.set_xticks((0.3, 1, 3, 10, 20), ("0.3", "1", "3", "10", "20"))
        axes.set_xticks([], minor=True)
    left.set(yscale="log", ylim=(0.01, 10), ylabel="Error of separation (rms heights)")
    right.set(ylim=(0.6, 2), ylabel="Area over that of the pixels")
    right.legend(loc="upper right", fontsize=9)


@figure(420)
def map_area(_, axes):
    """Contact area over pressure of random height maps, in units of modulus and rms slope."""
    x = np.geomspace(9e-4, 0.35, 200)
    axes.axhline(sqrt(2 * pi), color=GREY, linestyle="--")
    axes.plot(x, [erf(sqrt(2) * p) / p for p in x], ":", color=INK)
    for name, colour in (("pixels_periodic", BLUE), ("pixels_free", "#66AADD"),
                         ("summits_coupled", RED), ("summits_off", YELLOW)):
        rows = table(KEPT / "bench/map_area.csv", method=name)
        part(rows, slice(None), ratio=rows["area_fraction"] / rows["pressure"]).plot_columns(
            "pressure", "ratio", axes, marker="o", color=colour)
    for x, y, text, colour in (
            (0.0011, 2.54, "Bush, Gibson and Thomas, small pressures", "#666666"),
            (0.0011, 1.53, "Persson", INK), (0.012, 2.03, "summits, interacting", RED),
            (0.07, 1.86, "pixels, periodic", BLUE), (0.0135, 1.70, "pixels, free edge", "#4488BB"),
            (0.0035, 1.5, "summits, isolated", "#AA7711")):
        axes.text(x, y, text, color=colour)
    axes.set(xscale="log", xlim=(9e-4, 0.35), ylim=(1.2, 2.7),
             xlabel="Nominal pressure / (contact modulus × rms slope)",
             ylabel="Area fraction / (pressure / (modulus × slope))")


@figure(400, 1, 2)
def map_curves(_, left, right):
    """A map under a flat: its summits and its pixels."""
    pixels = solved(ROOT / "data/examples/summits/press_samples.scene").states
    spheres = solved(DATA / "summits.scene").states
    for axes, name in ((left, "area_fraction"), (right, "separation")):
        pixels.plot_columns("nominal_pressure", name, axes, **PRINTED, label="pixels")
        spheres.plot_columns("nominal_pressure", name, axes, color=BLUE, label="summits")
        axes.set_xlim(0, 205)
        axes.legend(loc="upper left" if axes is left else "upper right")
    left.set_ylim(0, 0.13)
    right.set_ylim(-0.15, 0.35)


@figure(460)
def pressure_map(_, axes):
    solved(DATA / "surface.scene", fields=True).fields().plot("pressure", axes)
    axes.grid(False)


@figure(420)
def summits(_, axes):
    """A map and its summits."""
    asperity.summits(asperity.read_map(MAP, unit="um"), rule="contact").plot(axes)
    axes.grid(False)


@figure(330, columns=3)
def rough_ball(_, pressures, slips, hold):
    fields = solved(DATA / "slip.scene", fields=True).fields()
    fields.plot("pressure", pressures)
    fields.plot("stick", slips)
    for axes in (pressures, slips):
        axes.grid(False)
        axes.set(xlim=(6, 58), ylim=(6, 58))
    rows = solved(DATA / "creep.scene").states
    for name, colour in (("area", BLUE), ("compression", RED)):
        part(rows, slice(None), ratio=rows[name] / rows[name][0]).plot_columns(
            "time", "ratio", hold, color=colour, label=name)
    hold.set(xlabel="time (s)", ylabel="over the value at loading")
    hold.legend()


@figure(360)
def scan_size(_, axes):
    """A map with a free edge against the size of the scan."""
    rows = table(KEPT / "bench/scan_size.csv")
    rows.plot_columns("side", "mean_gap", axes, marker="o", color=BLUE, label="mean gap")
    rows.plot_columns("side", "separation", axes, marker="o", color=RED,
                      label="separation of the reference planes")
    axes.set(xscale="log", xlim=(0.9, 17.5), ylim=(-7.5, 1.5), ylabel="Length / rms height",
             xlabel="Side of the scan / roll-off wavelength")
    axes.set_xticks((1, 2, 4, 8, 16), ("1", "2", "4", "8", "16"))
    axes.set_xticks([], minor=True)
    axes.legend(loc="lower left")


@figure(640, 2, 1, sharex=True)
def representative_area(_, above, below):
    """Sections of the thesis' design: means and spread against their size."""
    sizes = (4.4, 8.8, 17.6, 28, 44, 70, 112)
    for name, label, shift, colour in (("load", "load", 1.05, YELLOW),
                                       ("area", "contact area", 1, RED),
                                       ("contacts", "contacts", 0.952, BLUE)):
        rows = table(KEPT / "bench/representative_area.csv", quantity=name)
        above.errorbar(shift * rows["size"], rows["mean"] / rows["integral"],
                       rows["standard_error"] / rows["integral"], fmt="o", color=colour,
                       elinewidth=1.2, capsize=3)
        part(rows, slice(None), spread=100 * rows["deviation"] / rows["integral"]).plot_columns(
            "size", "spread", below, marker="o", ls="", color=colour, label=label)
    above.axhline(1, color=INK, linestyle="--", linewidth=1)
    above.text(0.02, 0.92, "bars: standard error", color="#666666", transform=above.transAxes)
    above.set(xscale="log", ylim=(0.95, 1.07), ylabel="mean / integral")
    x = np.array([3.6, 140])
    below.plot(x, 932 / x, "--", color=INK, linewidth=1, label="1/side")
    below.axvline(8.8, color="#999999", linewidth=1)
    below.text(9.2, 3.6, "thesis, upper plate", color="#666666")
    below.set(xlabel="Side of a section (cm)", yscale="log", xlim=(3.6, 140), ylim=(3, 300),
              ylabel="standard deviation of a section\n(% of the integral)")
    below.set_xticks(sizes, [f"{size:g}" for size in sizes])
    below.set_xticks([], minor=True)
    below.set_yticks((3, 10, 30, 100, 300), ("3", "10", "30", "100", "300"))
    below.legend(loc="upper right")


@figure(480)
def stability(_, axes):
    """Condition number against error over the hard cases. An operation loses half a unit of the
    last place at most."""
    edge, least = 1e19, 2e-18
    condition = np.geomspace(0.5, 1e20, 100)
    axes.plot(condition, 2.0**-53 * condition, color="#999999", linewidth=1.5,
              label="condition times roundoff")
    for formula, style in (("original", {"fillstyle": "none", "markersize": 6}),
                           ("stable", {"markersize": 4})):
        rows = table(DATA / "stability.csv", formula=formula, arithmetic="real64")
        rows = asperity.Table({
            "condition": np.where(rows["condition"] < 1e18, rows["condition"], edge),
            "error": np.maximum(rows["error"], least)})
        rows.plot_columns("condition", "error", axes, marker="o", ls="", color=BLUE,
                          label=f"{formula} overlap", **style)
    ticks = [10.0**k for k in range(0, 17, 4)]
    axes.set(xscale="log", yscale="log", xlim=(0.5, 1e20), ylim=(1e-18, 1e3),
             xlabel="Condition number", ylabel="Largest relative error of a total")
    axes.set_xticks([*ticks, edge], [f"$10^{{{k}}}$" for k in range(0, 17, 4)] + ["more"])
    axes.set_xticks([], minor=True)
    axes.legend(loc="upper left")


# ------------------------------------------------------------------ what accuracy costs

@functools.cache
def costs(name):
    """Run times and errors of one of four kinds of surfaces: heights with four digits."""
    if name == "thesis":
        return asperity.accuracy(ROOT / "data/thesis.deck")
    if name == "map":
        rough = asperity.generate_map(ROOT / "data/examples/generate/surface.spec")
        return asperity.accuracy({
            "surfaces": {"upper": "plane", "units": ("um", "uN"), "lower": asperity.HeightMap(
                rough.heights.round(4), rough.spacing, rough.unit, rough.periodic)},
            "material": {"contact_modulus": 1e5},
            "loading": {"control": "pressure", "value": 100}}, finer=True)
    number, side, deviation, load = {"rough": (10000, 19.6, 0.03, 1e5),
                                     "dense": (100, 2.0, 0.005, 3e3)}[name]
    _, lower = asperity.generate({
        "surfaces": {"number": number, "length": side, "width": side},
        "heights": {"mean": 0.127, "deviation": deviation, "lowest": 0.01},
        "radii": {"mean": 1.27}})
    return asperity.accuracy({
        "surfaces": {"upper": "plane", "lower": {**lower, "height": lower["height"].round(4)}},
        "material": {"elastic_modulus": (275760.0,) * 2, "poisson_ratio": (0.42,) * 2},
        "loading": {"control": "load", "value": load}})


@figure(560)
def work_precision(_, axes):
    """All methods of the sweep of the thesis, arithmetics and steps too."""
    costs("thesis").plot(axes)


@figure(1000, 2, 2)
def time_and_error(_, *panels):
    """Four kinds of surfaces."""
    for axes, name, title in zip(panels, ("thesis", "rough", "dense", "map"), (
            "the thesis' deck", "10,000 caps", "100 dense caps", "map, 160 x 160 pixels")):
        costs(name).plot(axes).set_title(title)


# ------------------------------------------------------------------ drawings without a run

def arrow(axes, begin, end, style="<->", colour=INK):
    axes.annotate("", end, begin, arrowprops={"arrowstyle": style, "color": colour,
                                              "shrinkA": 0, "shrinkB": 0})


@figure(400)
def quantities(_, axes):
    """Lengths between a map and a flat under load, not to scale."""
    x = np.linspace(0.15, 9.9, 600)
    free = 0.8 * np.cos(2.1 * x) + 0.5 * np.cos(x + 1.3)
    flat, touch = 0.55, free.max()
    loaded = np.minimum(free, flat)
    for height, label, colour, dashes in ((touch, "flat at first contact", GREY, "--"),
                                          (flat, "flat under load", RED, "-"),
                                          (0, "mean plane of the map", GREY, "--")):
        axes.plot([0.15, 9.9], [height, height], dashes, color=colour,
                  linewidth=1 if dashes == "--" else 1.8)
        axes.text(10, height, label, color=colour, va="center")
    axes.plot(x, free, "--", color=GREY, linewidth=1)
    axes.plot(x, loaded, color=BLUE, linewidth=2.2)
    axes.text(10, -1.0, "dashed: without load", color=GREY, va="center")
    axes.text(10, -1.4, "map under load", color=BLUE, va="center")
    for place, low, high, label in ((4.0, flat, touch, "compression"), (7.0, 0, flat, "separation"),
                                    (1.55, loaded[np.argmin(abs(x - 1.55))], flat, "gap")):
        arrow(axes, (place, low), (place, high))
        axes.text(place + 0.1, (low + high) / 2, label, va="center")
    axes.text(2.4, 2.1, "projected area: the contacts seen from above")
    arrow(axes, (2.9, 2.0), (3.1, flat + 0.06), "->")
    arrow(axes, (6.0, 2.0), (6.0, flat + 0.06), "->")
    arrow(axes, (0.15, -1.7), (9.9, -1.7))
    axes.text(3.6, -2.0, "nominal area: all of the map", va="center")
    axes.set(xlim=(0, 13.4), ylim=(-2.2, 2.5))
    axes.axis("off")


@figure(400, columns=3)
def pair_geometry(_, first, loaded, loads):
    """Two spheres in contact beside their summits: Appendix 5 of the thesis, drawn by us."""
    angle, depth, half = pi / 6, 0.3, 0.42
    s, c = np.sin(angle), np.cos(angle)
    d, z = 2 * s, 2 * c
    for axes, title, spheres in (
            (first, "first contact", (((0, 0), BLUE, "-"), ((d, z), RED, "-"))),
            (loaded, "under load", (((0, 0), BLUE, "-"), ((d, z), GREY, "--"),
                                    ((d, z - depth), RED, "-"))),
            (loads, "loads and areas", (((0, 0), GREY, "--"), ((d, z), GREY, "--")))):
        for centre, colour, dashes in spheres:
            axes.add_patch(Circle(centre, 1, fill=False, edgecolor=colour, linestyle=dashes,
                                  linewidth=1 if dashes == "--" else 1.8))
        axes.set(title=title, xlim=(-1.6, 2.2), ylim=(-1.7, 2.9), aspect="equal")
        axes.axis("off")
    first.plot([0, d], [0, z], color=INK, linewidth=1)
    first.plot([0, 0], [0, z], "--", color=GREY, linewidth=1)
    arrow(first, (0, z), (d, z))
    arrow(first, (-1.2, 0), (-1.2, z))
    for x, y, text in ((0.4, z + 0.1, "d"), (-1.5, z / 2, "z"), (0.06, 0.65, "M"),
                       (1.0, 0.3, "R1 + R2")):
        first.text(x, y, text)
    loaded.plot([0, d], [0, z - depth], color=INK, linewidth=1)
    arrow(loaded, (d, z), (d, z - depth))
    loaded.text(d + 0.1, z - depth / 2, "p", va="center")
    loaded.text(1.0, 0.2, "W along\nthis line")
    ends = np.array([(s - half * c, c + half * s), (s + half * c, c - half * s)])
    loads.plot(*ends.T, color=INK, linewidth=4)
    loads.plot(ends[:, 0], [-1.25, -1.25], color=INK, linewidth=4)
    for x, y in ends:
        loads.plot([x, x], [y, -1.25], "--", color=GREY, linewidth=1)
    arrow(loads, (s + 1.4 * s, c + 1.4 * c), (s, c), "->", RED)
    arrow(loads, (s, c + 1.4 * c * c), (s, c), "->", RED)
    arrow(loads, (s, c), (s + 0.8 * c, c - 0.8 * s), "->", BLUE)
    for x, y, text in ((s + 1.5 * s, c + 1.45 * c, "N"), (s - 0.25, c + 1.0, "L"),
                       (s + 0.85 * c, c - 0.75 * s, "T"), (s - 0.35, -1.6, "A cos M")):
        loads.text(x, y, text)


def main(executable, *names):
    drawn = {name.replace("_", "-") if name.split("_")[0] in (
        "gallery", "how", "map", "time", "scan", "representative", "pair", "pressure", "rough")
        else name: make
        for name, make in FIGURES.items()}
    names = names or drawn
    unknown = set(names) - set(drawn)
    if unknown:
        sys.exit(f"no figure {', '.join(sorted(unknown))}; there are {', '.join(drawn)}")
    warnings.simplefilter("ignore")
    make_input(executable, names)
    plt.rcParams.update(STYLE)
    for name in names:
        canvas = drawn[name]()
        canvas.savefig(FOLDER / f"{name}.svg", metadata={"Date": None})
        if "--png" in sys.argv:
            canvas.savefig(DATA / f"{name}.png", dpi=80)
        plt.close(canvas)


if __name__ == "__main__":
    main(*(word for word in sys.argv[1:] if not word.startswith("--")))
