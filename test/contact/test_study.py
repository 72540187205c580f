"""`asperity study`: contacts and sections against numpy, the integrals against numpy's own, kept
surfaces, and what the command says when it cannot do what is asked."""

import math
import os
import re
import shlex

import numpy as np
import pytest

from programs import run_program
from surfaces_csv import records
from test_kept_positions import kept_records

SPEC = """&surfaces density = 0.5, 0.4, length = 30., 32., width = 28., least_distance = {least} /
&heights mean = 0.127, 0.12, deviation = 0.03, 0.04, lowest_deviation = -1., \
highest_deviation = 2. /
&radii mean = 1.2, 0.9, deviation = 0.1, lowest_deviation = -2., highest_deviation = 1.5 /
&random seed = {seed}, ensemble = {ensemble} /
&material elastic_modulus = 275760., 1.e5, poisson_ratio = 0.42, 0.3 /
&study {study} /
"""
QUANTITIES = ["contacts", "area", "load", "vertical_load"]
MODULUS = 1 / ((1 - 0.42**2) / 275760 + (1 - 0.3**2) / 1e5)


@pytest.fixture
def study(asperity, tmp_path):
    def start(text, *options, status=0, command=None):
        (tmp_path / "a.spec").write_text(text, encoding="ascii")
        first = shlex.split(command) if command else [asperity]
        return run_program(*first, "study", "a.spec", *options, status=status, cwd=tmp_path)
    return start


def spec(study="separation = 0.2", least=0.5, seed=3, ensemble=4):
    return SPEC.format(study=study, least=least, seed=seed, ensemble=ensemble)


def surface(asperity, folder, text, member, side):
    """A surface as `asperity generate` writes it: x, y, height, radius."""
    (folder / "g.spec").write_text(text.split("&material")[0], encoding="ascii")
    run_program(asperity, "generate", "g.spec", "--surface", member, f"--{side}", "s.csv",
                cwd=folder)
    return np.loadtxt(folder / "s.csv", delimiter=",", skiprows=1).T


def contacts(upper, lower, separation):
    """Place and the four quantities of every contact; all pairs are looked at."""
    xu, yu, hu, ru = (values[:, None] for values in upper)
    xl, yl, hl, rl = (values[None, :] for values in lower)
    d2 = (xu - xl) ** 2 + (yu - yl) ** 2
    s = ru + rl
    z = s - hu - hl + separation
    distance = np.sqrt(d2 + z**2)
    overlap = s - distance
    i, j = np.nonzero(overlap >= 0)
    w, radius = overlap[i, j], (ru * rl / s)[i, j]
    load = 4 / 3 * MODULUS * np.sqrt(radius) * w**1.5
    share = (ru / s)[i, j]
    x = upper[0][i] + share * (lower[0][j] - upper[0][i])
    y = upper[1][i] + share * (lower[1][j] - upper[1][i])
    vertical = load * (z / distance)[i, j]
    return x, y, np.array([np.ones_like(w), math.pi * w * radius, load, vertical])


def section_values(found, corner, size, per_side):
    """Per area of each square of a grid: quantity, square."""
    x, y, values = found
    edges = [corner + size * np.arange(per_side + 1)] * 2
    return np.array([np.histogram2d(x, y, bins=edges, weights=q)[0].ravel() / size**2
                     for q in values])


def test_sections_are_those_of_numpy(asperity, study, tmp_path, tally):
    """Means, deviations, standard errors and shares of all sizes from contacts found in numpy."""
    text = spec("separation = 0.2, factor = 2., steps = 4, tolerance = 0.3")
    study(text, "--csv", "a.csv", "--quiet")
    table = records(tmp_path / "a.csv")
    found = [contacts(surface(asperity, tmp_path, text, member, "upper"),
                      surface(asperity, tmp_path, text, member, "lower"), 0.2)
             for member in range(1, 5)]
    # Highest summits 0.187 and 0.2, largest radii 1.35 and 1.05.
    depth = 0.187 + 0.2 - 0.2
    corner = 2 * 0.5 + math.sqrt(depth * (2 * 2.4 - depth))
    whole = 28 - 2 * corner
    compared = met = 0
    for step in range(4):
        values = np.array([section_values(one, corner, whole / 2**step, 2**step)
                           for one in found])
        reference = np.array([float(row["integral"]) for row in table[4 * step:4 * step + 4]])
        within = np.abs(values - reference[None, :, None]) <= 0.3 * reference[None, :, None]
        for k, name in enumerate(QUANTITIES):
            row = table[4 * step + k]
            of_surface = values[:, k, :].mean(axis=1)
            expected = {"size": whole / 2**step, "mean": values[:, k].mean(),
                        "deviation": values[:, k].std(ddof=1),
                        "standard_error": of_surface.std(ddof=1) / 2,
                        "within": within[:, k].mean(), "all_within": within.all(axis=1).mean()}
            assert row["quantity"] == name and int(row["sections"]) == 4 * 4**step
            for column, value in expected.items():
                compared += 1
                met += math.isclose(float(row[column]), value, rel_tol=1e-9)
    tally.add("study: sections against numpy", compared, met)
    assert met == compared


def law(mean, deviation, lowest, highest, points):
    """Gauss-Legendre places and weights of a cut Gaussian."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    x = (highest + lowest) / 2 + (highest - lowest) / 2 * nodes
    weights = weights * np.exp(-((x - mean) / deviation) ** 2 / 2)
    return x, weights / weights.sum()


def integrals(separation, densities):
    """The four integrals by plain sums over heights, radii and offset."""
    total = np.zeros(4)
    heights = law(0.127, 0.03, 0.097, 0.187, 60), law(0.12, 0.04, 0.08, 0.2, 60)
    t = (heights[0][0][:, None] + heights[1][0][None, :] - separation).ravel()
    weight_t = np.outer(heights[0][1], heights[1][1]).ravel()[t > 0]
    t = t[t > 0]
    nodes, weights = np.polynomial.legendre.leggauss(20)
    for r1, w1 in zip(*law(1.2, 0.1, 1.0, 1.35, 5)):
        for r2, w2 in zip(*law(0.9, 0.1, 0.7, 1.05, 5)):
            s, radius = r1 + r2, r1 * r2 / (r1 + r2)
            z = s - t
            reach = np.sqrt(s**2 - z**2)
            angle = math.pi / 4 * (nodes + 1)
            d = reach[:, None] * np.sin(angle)
            ring = 2 * math.pi * d * reach[:, None] * np.cos(angle) * weights * math.pi / 4
            distance = np.sqrt(d**2 + z[:, None] ** 2)
            w = np.maximum(s - distance, 0)
            load = 4 / 3 * MODULUS * math.sqrt(radius) * w**1.5
            for k, q in enumerate([np.ones_like(w), math.pi * w * radius, load,
                                   load * z[:, None] / distance]):
                total[k] += w1 * w2 * (weight_t * (ring * q).sum(axis=1)).sum()
    return total * densities[0] * densities[1]


def test_integrals_are_those_of_plain_sums(study, tmp_path, tally):
    """The columns of integrals; the edge t = 0 in the sum over heights costs digits."""
    study(spec("separation = 0.2, steps = 1", ensemble=2), "--csv", "a.csv", "--quiet")
    table = records(tmp_path / "a.csv")
    expected = integrals(0.2, [float(table[0]["upper_density"]), float(table[0]["lower_density"])])
    found = [float(row["integral"]) for row in table]
    tally.add("study: integrals", 4, int(np.isclose(found, expected, rtol=1e-3).sum()))
    assert found == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("places", ["places = 'grid'", "places = 'random', sections = 3"])
@pytest.mark.parametrize("least", [0, 0.7])
@pytest.mark.parametrize("loading", ["separation = 0.2", "separation = 0.13, against = 'plane'"])
def test_ensemble_meets_integral(study, tmp_path, tally, loading, least, places):
    """Means of 60 surfaces are within 4 standard errors of the integral, and these are small."""
    text = spec(f"{loading}, steps = 2, {places}", least=least, seed=7, ensemble=60)
    study(text, "--csv", "a.csv",
          "--quiet")
    table = records(tmp_path / "a.csv")
    near = [abs(float(row["mean"]) - float(row["integral"])) < 4 * float(row["standard_error"])
            and float(row["standard_error"]) < 0.04 * float(row["integral"]) for row in table]
    tally.add("study: means and integrals", len(near), sum(near))
    assert all(near)


def test_large_surfaces_bear_the_pressure_at_the_separation(study, tmp_path):
    """The separation is the one at which large surfaces of the design bear the pressure."""
    study(spec("pressure = 100., steps = 1", least=0, ensemble=2), "--csv", "a.csv", "--quiet")
    row = records(tmp_path / "a.csv")[3]
    design = round(0.5 * 30 * 28) / (30 * 28), round(0.4 * 32 * 28) / (32 * 28)
    ratio = design[0] * design[1] / (float(row["upper_density"]) * float(row["lower_density"]))
    assert float(row["integral"]) * ratio == pytest.approx(100, rel=1e-12)


def test_the_representative_size_is_the_least_that_is_within(study, tmp_path):
    """The representative size is the least from which on up enough sections are within."""
    done = study(spec("separation = 0.2, steps = 5, tolerance = 0.5, confidence = 0.8",
                      ensemble=20), "--csv", "a.csv")
    table = records(tmp_path / "a.csv")[::4]
    good = [float(row["all_within"]) >= 0.8 for row in table]
    expected = good.index(False) - 1
    assert 0 <= expected < 4
    assert [row["representative"] for row in table].index("1") == expected
    size = f"{float(table[expected]['size']):g}"
    assert f"representative size (80.00% of the sections): {size}"[:52] \
        in done.stdout


@pytest.mark.long
def test_kept_surfaces(study, tmp_path, tally):
    """A file cut anywhere is continued, to the same numbers; a damaged surface is done again."""
    text = spec(ensemble=5)
    study(text, "--csv", "whole.csv", "--keep", "whole.keep", "--quiet")
    study(text, "--csv", "none.csv", "--quiet")
    whole = (tmp_path / "whole.keep").read_bytes()
    csv_bytes = (tmp_path / "whole.csv").read_bytes()
    assert (tmp_path / "none.csv").read_bytes() == csv_bytes
    surfaces = [i for i in range(len(whole)) if whole.startswith(b"surface ", i)]
    cuts = [0, 5, surfaces[0], surfaces[0] + 3, surfaces[1] - 1, surfaces[1], surfaces[3] + 2000]
    versions = [whole[:cut] for cut in cuts]
    versions.append(whole[:surfaces[2] + 100] + b"A" * 8 + whole[surfaces[2] + 108:])
    for version in versions:
        (tmp_path / "part.keep").write_bytes(version)
        study(text, "--csv", "part.csv", "--keep", "part.keep", "--quiet")
        same = ((tmp_path / "part.csv").read_bytes() == csv_bytes) + \
            (kept_records(tmp_path / "part.keep") == kept_records(tmp_path / "whole.keep"))
        tally.add("study: continued runs", 2, same)
        assert same == 2
    assert len(surfaces) == 5


def test_other_specification_is_refused(study, tmp_path):
    study(spec(), "--keep", "a.keep", "--quiet")
    before = (tmp_path / "a.keep").read_bytes()
    done = study(spec(seed=4), "--keep", "a.keep", "--csv", "b.csv", status=1)
    assert "a.keep: holds no surfaces of this specification" in done.stderr
    assert (tmp_path / "a.keep").read_bytes() == before
    assert not (tmp_path / "b.csv").exists() and done.stdout == ""


@pytest.mark.skipif("ASPERITY_IMAGES" not in os.environ,
                    reason="ASPERITY_IMAGES is no command for several images")
def test_images_leave_the_bytes_of_one(study, tmp_path):
    """ASPERITY_IMAGES, for instance `cafrun -n 2 EXE`: the same bytes as one image."""
    text = spec(ensemble=11)
    study(text, "--csv", "one.csv", "--keep", "one.keep", "--quiet")
    done = study(text, "--csv", "two.csv", "--keep", "two.keep", "--quiet",
                 command=os.environ["ASPERITY_IMAGES"])
    assert done.stdout == ""
    assert (tmp_path / "two.csv").read_bytes() == (tmp_path / "one.csv").read_bytes()
    assert kept_records(tmp_path / "two.keep") == kept_records(tmp_path / "one.keep")


@pytest.mark.parametrize("text, messages", [
    (spec("steps = 3"), ["no separation and no pressure in &study"]),
    (spec("separation = 0.2, pressure = 3."), ["a.spec:6:8: separation: found beside pressure"]),
    (spec("separation = 0.2, sizes = 5., 6."), ["sizes: found sizes in another order"]),
    (spec("separation = 0.2, sizes = 20., 0.0001"), ["sizes: found 0.1", "expected at least"]),
    (spec("separation = 0.2, sizes = 29."), ["sizes: found 29.0000, expected at most 24.1"]),
    (spec("separation = 0.2, factor = 1."), ["factor: found '1.', expected a number more than 1"]),
    (spec("separation = 0.2, sizes = 3., steps = 2"), ["steps: found beside sizes"]),
    (spec("separation = 0.2, tolerance = 1."), ["tolerance: found '1.'", "less than 1"]),
    (spec("separation = 0.2, places = 'here'"), ["places: found", "'grid' or 'random'"]),
    (spec("separation = 0.388"), ["no asperities can touch at the separation", "0.387"]),
    (spec("separation = -1.4"), ["may come level at the separation"]),
    (spec("pressure = 1.e9"), ["the pressure is more than the surfaces carry"]),
    (spec("separation = 0.2", ensemble=1), ["a.spec:4:", "fewer than 2 surfaces"]),
    (spec().replace("28.", "1.5"), ["the surfaces are too small"]),
    (spec().replace("&material", "&deck /\n&material"), ["group &deck: found in a study"]),
    (spec().replace("poisson_ratio", "poisson"),
     ["unknown name in &material", "needs poisson_ratio"]),
])
def test_bad_specifications(study, tmp_path, text, messages):
    done = study(text, "--csv", "a.csv", status=2)
    for message in messages:
        assert message in done.stderr
    assert done.stdout == "" and not (tmp_path / "a.csv").exists()


@pytest.mark.long
def test_contact_area_above_the_nominal_area(study):
    """Caps that touch nearly everywhere: no number where the area per nominal area is above 1."""
    dense = (spec(least=0, ensemble=2).replace("0.5, 0.4", "1., 1.")
             .replace("1.2, 0.9", "20., 20.").replace("30., 32.", "20., 20.").replace("28.", "20."))
    areas = {}
    low, high = 0.2, 0.38
    for _ in range(12):
        middle = (low + high) / 2
        text = dense.replace("separation = 0.2", f"separation = {middle}")
        try:
            found = study(text, "--csv", "a.csv")
            areas[0] = area_per_area(found.stdout)
            high = middle
        except AssertionError as error:
            areas[1] = float(re.search(r"contact area is (\S+) times the nominal", str(error))[1])
            low = middle
    assert 0.99 < areas[0] <= 1 < areas[1] < 1.01


def area_per_area(summary):
    """The larger of the integral and of the mean over the largest sections."""
    section = summary.partition("contact area per area")[2].splitlines()
    integral = next(line for line in section if "Greenwood-Tripp" in line)
    return max(float(section[2].split()[2]), float(integral.split()[1]))
