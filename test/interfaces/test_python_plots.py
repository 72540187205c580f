"""Figures in Python: limits and kind of the colours, states of slip, sections of stress, bands of
errors, and pictures for notebooks. The values are those of the arrays."""

import copy
import re

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import LogNorm, Normalize, to_hex

pytestmark = [pytest.mark.once, pytest.mark.filterwarnings("ignore::UserWarning")]


@pytest.fixture(scope="module")
def surface(package):
    return package.generate_map(pixels=48, spacing=0.5, unit="um", hurst=0.8, rms_slope=0.05)


@pytest.fixture(scope="module")
def results(package, surface):
    """A map with slip."""
    return package.solve({
        "surfaces": {"upper": "plane", "lower": surface, "units": ("um", "uN")},
        "material": {"elastic_modulus": (2e5, 2e5), "poisson_ratio": (0.3, 0.3)},
        "effects": {"friction": "on", "friction_coefficient": 0.3},
        "loading": {"control": "pressure", "value": 400, "points": 5, "tangential_load": 2e4}},
        fields="all")


def with_pressure(fields, ratio):
    """The fields with pressures of 1 in contact, but for two of this ratio."""
    found = copy.copy(fields)
    values = np.where(fields.contact, 1.0, 0.0)
    values[tuple(np.argwhere(fields.contact)[:2].T)] = ratio
    found.pressure = values
    return found


def test_scale(results):
    """Logarithmic where the greatest pressure exceeds 20 medians, or where asked for."""
    fields = results.fields()
    for ratio, kind in ((19.9, Normalize), (20.1, LogNorm)):
        assert type(with_pressure(fields, ratio).plot().images[0].norm) is kind
    assert type(with_pressure(fields, 20.1).plot(scale="linear").images[0].norm) is Normalize
    assert type(with_pressure(fields, 2.0).plot(scale="log").images[0].norm) is LogNorm
    with pytest.raises(ValueError, match="scale: found 'square', expected 'auto', 'linear', 'log'"):
        fields.plot(scale="square")


def test_outliers(results):
    """Few values far beyond the rest do not widen a linear scale; the greatest is stated."""
    fields = results.fields()
    far = with_pressure(fields, 15.0).plot(percentile=99.0)
    assert far.images[0].norm.vmax == 1.0 and far.images[0].colorbar.extend == "max"
    assert far.images[0].colorbar.ax.get_title() == "max 15"
    near = with_pressure(fields, 1.2).plot(percentile=99.0)
    assert near.images[0].norm.vmax == 1.2 and near.images[0].colorbar.extend == "neither"
    assert near.images[0].norm.vmin == 0.0


def test_states_of_slip(results):
    """Three colours, and the shares of the area."""
    fields = results.fields()
    axes = fields.plot("stick")
    shown = axes.images[0].get_array()
    assert np.array_equal(shown, np.where(~fields.contact, 0, np.where(fields.stick, 2, 1)))
    colours = [to_hex(axes.images[0].cmap(axes.images[0].norm(number))) for number in range(3)]
    assert colours == ["#ffffff", "#e69f00", "#0072b2"]
    shares = [float(re.search(r"([\d.]+)%", text.get_text())[1])
              for text in axes.get_legend().get_texts()]
    slip = fields.contact & ~fields.stick
    counts = [(~fields.contact).mean(), slip.mean(), fields.stick.mean()]
    assert np.allclose(shares, 100 * np.array(counts), atol=0.051) and min(counts) > 0
    assert np.array_equal(np.isnan(fields.plot("traction_x").images[0].get_array().filled(np.nan)),
                          ~fields.contact)


def test_hills(package, surface, results):
    """Light from the upper left on the heights below the pressure: a ridge along y is bright on its
    left side."""
    fields = results.fields()
    axes = fields.plot(on=surface)
    assert len(axes.images) == 2 and axes.images[0].get_extent() == axes.images[1].get_extent()
    ridge = np.tile(np.where(np.arange(48) < 24, np.arange(48), 48 - np.arange(48)), (48, 1))
    hills = fields.plot(on=package.HeightMap(ridge.astype(float), 0.5)).images[0].get_array()
    assert hills[24, 10] > hills[24, 40] and np.ptp(hills[1:-1, 10]) < 1e-12
    slope = np.tile(np.arange(48.0)[:, None], (1, 48))  # falls towards the light in front
    assert fields.plot(on=slope).images[0].get_array()[24, 24] < \
        fields.plot(on=-slope).images[0].get_array()[24, 24]
    with pytest.raises(ValueError, match=r"on: found an array of shape \(3, 3\), expected"):
        fields.plot(on=np.zeros((3, 3)))


def test_stress(results):
    """In plan at a depth, by default that of the largest value; in a section at a row of pixels."""
    stress = results.stress([0.5, 2.0, 1.0])
    assert np.array_equal(stress.plot("zz", depth=1.2).images[0].get_array(), stress.zz[2])
    _, depth, _, _ = stress.largest("von_mises")
    level = [0.5, 2.0, 1.0].index(depth)
    axes = stress.plot()
    assert np.array_equal(axes.images[0].get_array(), stress.von_mises[level])
    assert axes.get_title() == f"depth {depth:g} um" and axes.get_xlabel() == "x (um)"
    assert axes.images[0].colorbar.ax.get_ylabel() == "von mises (MPa)"
    axes = stress.plot("xz", y=5.1)
    section = axes.collections[0]
    assert np.array_equal(np.asarray(section.get_array()), stress.xz[[0, 2, 1], 10])
    assert section.norm.vmin == -section.norm.vmax and section.cmap.name == "RdBu_r"
    assert axes.yaxis_inverted() and axes.get_ylabel() == "depth (um)"
    with pytest.raises(ValueError, match="name: found 'tresca', expected 'xx'"):
        stress.plot("tresca")
    with pytest.raises(ValueError, match="y: found stresses at one depth"):
        results.stress(1.0).plot(y=0)


def test_named_theories(package, results, surface):
    """A theory by its name has the area of its function at the pressures of the states, with the
    contact modulus of the scene; where the scene has none, a surface is refused."""
    names = ["persson", "bush_gibson_thomas", "greenwood_williamson"]
    _, right = results.plot(theory={**dict.fromkeys(names, surface), "root": np.sqrt})
    drawn = {line.get_label(): line.get_xydata().T for line in right.lines[-4:]}
    modulus, pressure = 2e5 / (2 * 0.91), results.states["nominal_pressure"]
    theory = package.theory
    for name, area in (
            ("persson", theory.persson(surface, modulus, pressure)),
            ("bush_gibson_thomas", theory.bush_gibson_thomas(surface, modulus, pressure)),
            ("greenwood_williamson", [0.0, *theory.greenwood_williamson(
                surface, modulus, pressure=pressure[1:])["area_fraction"]])):
        assert np.array_equal(drawn[name][0], pressure[1:])
        assert np.allclose(drawn[name][1], area[1:], rtol=1e-12)
    assert np.array_equal(drawn["root"][1], np.sqrt(pressure))
    with pytest.raises(ValueError, match="'person', expected persson, bush"):
        results.plot(theory={"person": surface})
    _, right = results.plot(theory={"persson": ([1.0, 2.0], [0.1, 0.2])})
    assert right.lines[-1].get_ydata().tolist() == [0.1, 0.2]
    cap = {"x": [0.0], "y": [0.0], "height": [1.0], "radius": [10.0]}
    found = package.solve({"surfaces": {"upper": cap, "lower": "plane"},
                           "material": {"contact_modulus": 1e3},
                           "loading": {"control": "compression", "value": 0.01}})
    with pytest.raises(ValueError, match="theory: found 'persson' for a scene without a nominal"):
        found.plot(theory={"persson": surface})
    stated = copy.copy(results)
    for text, modulus in (("&material contact_modulus = 1.5d3 /", 1.5e3),
                          ("! contact_modulus = 1\n&material elastic_modulus = 2*200e3,\n"
                           "  poisson_ratio = 0.3, 0.5 /", 2e5 / (0.91 + 0.75))):
        stated.scene = {"text": text}
        line = stated.plot(theory={"persson": surface})[1].lines[-1]
        assert np.allclose(line.get_ydata(), theory.persson(surface, modulus, pressure[1:]))
    stated.scene = {"text": "! contact_modulus = 1\n"}
    with pytest.raises(ValueError, match="theory: found 'persson' for a scene that states no mod"):
        stated.plot(theory={"persson": surface})


def test_curves(package, results):
    """Bands of the estimated errors, other theories, logarithmic axes; bars on a path back."""
    states = results.states
    pressure, fraction = states["nominal_pressure"], states["area_fraction"]
    left, right = results.plot(log=True, theory={"linear": (pressure, 2 * fraction),
                                                        "root": np.sqrt})
    assert (left.get_yscale(), right.get_xscale(), right.get_yscale()) == ("log",) * 3
    assert left.get_xscale() == "linear" and left.get_ylabel() == "nominal pressure (MPa)"
    assert np.array_equal(right.lines[-2].get_ydata(), 2 * fraction)
    assert np.array_equal(right.lines[-1].get_ydata(), np.sqrt(pressure))
    assert [text.get_text() for text in right.get_legend().get_texts()] == ["linear", "root"]
    corners = results.plot()[0].collections[0].get_paths()[0].vertices
    half = np.nan_to_num(states["separation_error_estimate"] * states["compression"])
    assert np.isclose(corners[:, 0].min(), (states["separation"] - half).min())
    assert half[-1] > 0 and not results.plot(errors=False)[0].collections
    caps = {"upper": {"x": [0.0, 3.0], "y": [0.0, 0.0], "height": [1.0, 1.0], "radius": [10.0] * 2},
            "lower": "plane"}
    for path in ([0.02, 0.03, 0.05], [0.02, 0.05, 0.03]):
        found = package.solve({"surfaces": caps, "material": {"contact_modulus": 1e3},
                               "effects": {"interaction": "off"},
                               "loading": {"control": "compression", "value": path}})
        error = found.states["error_estimate"] * found.states["load"]
        assert error[-1] > 0
        [drawn] = found.plot()[0].collections
        places = np.concatenate([one.vertices for one in drawn.get_paths()])
        assert type(drawn).__name__ == ("FillBetweenPolyCollection" if path[2] > path[1]
                                        else "LineCollection")
        assert np.isclose(places[:, 1].max(), (found.states["load"] + error).max())


def test_pictures_of_notebooks(results):
    """A picture in the text, and no figure that stays open."""
    plt.close("all")
    for one in (results.fields(), results.stress(1.0)):
        assert re.fullmatch(r"<p>asperity\.\w+ .*</p><img src='data:image/png;base64,[\w+/=]+'>",
                            one._repr_html_())
    assert not plt.get_fignums()
