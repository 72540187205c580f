"""A page of results for a browser, by Bokeh: one file that uses no network.

Images, contacts and points of curves have a column `key`, POSITION.STEP. A filter of this column
shows one state, and the slider sets the key of all filters.
"""

from __future__ import annotations

import html
import math
from typing import TYPE_CHECKING, Any

from ._columns import Lazy, Table, label_of
from ._fields import FLAGS
from ._plots import STATES, colour_limits, error_of, is_monotonic, quantities

if TYPE_CHECKING:
    from ._results import Results

numpy, embed, layouts, models, plotting, resources = (Lazy(name, "page", "a page") for name in (
    "numpy", "bokeh.embed", "bokeh.layouts", "bokeh.models", "bokeh.plotting", "bokeh.resources"))
# Chosen: bytes of images, as single precision, from which on states are left out; contacts listed.
MOST_BYTES, MOST_CONTACTS = 32_000_000, 20_000
# Two figures are side by side on a desk, one fits a width of 400 pixels with the margins.
WIDTH, HEIGHT = 376, 350
COLUMNS = ("area_no", "x", "y", "area", "load", "average_pressure", "maximum_pressure",
           "penetration")
DIGITS = 6
TOOLS = "pan,wheel_zoom,box_zoom,reset,save"
WRAPPED: dict[str, Any] = {"sizing_mode": "stretch_width", "styles": {"flex-wrap": "wrap"}}
MOVE = """for (const one of filters) one.group = keys[cb_obj.value]
cb_obj.title = names[cb_obj.value]"""
CHOOSE = """const place = keys.indexOf(source.data.key[cb_obj.indices[0]]);
if (place >= 0) slider.value = place"""


class Page:
    """A page under construction: its filters and figures."""

    def __init__(self, results: Results, position: int | None):
        self.results, self.states = results, results.states
        self.notes: list[str] = []
        self.filters: list[Any] = []
        self.ranges: dict[str, Any] = {}
        places = self.states["position"]
        self.rows = numpy.flatnonzero(places == (places if position is None else position))
        self.keys = keys_of(self.states, self.rows)
        self.fields = {key: one for one in results._all_fields()
                       if (key := f"{one.position}.{one.step}") in self.keys}
        self.shown = self.thinned()
        self.has_positions = len(set(self.states["position"][self.rows].tolist())) > 1

    def thinned(self) -> list[str]:
        """The keys that the slider visits: fewer where the images would be too large."""
        if not self.fields:
            return self.keys
        one = next(iter(self.fields.values()))
        images = sum(name not in ("contact", "displacement") for name in one)
        most = max(1, MOST_BYTES // (4 * images * one.shape[0] * one.shape[1]))
        if len(self.fields) > most:
            ends = numpy.linspace(len(self.keys) - 1, 0, most).round().astype(int)
            self.notes.append(f"{most} of {len(self.keys)} states are shown: "
                              "images of all would be too large for a page.")
            return [self.keys[place] for place in sorted(ends.tolist())]
        if len(self.fields) < len(self.keys):
            self.notes.append("Fields of the last state only were kept: fields='all' keeps all.")
        return self.keys

    def view(self) -> Any:
        """A view of the state of the slider."""
        self.filters.append(models.GroupFilter(column_name="key", group=self.shown[-1]))
        return models.CDSView(filter=self.filters[-1])

    def hover(self, renderer: Any, values: dict[str, str]) -> Any:
        return models.HoverTool(renderers=[renderer], tooltips=[
            (name, at + f"{{%.{DIGITS}g}}" * (at != "@key")) for name, at in values.items()],
            formatters={place: "printf" for place in values.values() if place != "@key"})

    def plan(self, title: str, unit: str) -> Any:
        """A figure in plan; all of them have the same ranges."""
        made = plotting.figure(title=title, width=WIDTH, height=HEIGHT, match_aspect=True,
                           x_axis_label=label_of("x", unit), y_axis_label=label_of("y", unit),
                           toolbar_location="above", active_scroll="wheel_zoom", tools=TOOLS,
                           **self.ranges)
        self.ranges = {"x_range": made.x_range, "y_range": made.y_range}
        made.grid.visible = False
        return made

    def colours(self, values: Any, figure: Any) -> Any:
        """Colours of values, with their bar."""
        is_log, low, high = colour_limits(values)
        kind = models.LogColorMapper if is_log else models.LinearColorMapper
        mapper = kind("Viridis256", low=low, high=high, nan_color="rgba(255, 255, 255, 0)")
        figure.add_layout(models.ColorBar(color_mapper=mapper, width=12), "right")
        return mapper

    def images(self) -> list[Any]:
        """Maps of the fields."""
        kept = {key: one for key, one in self.fields.items() if key in self.shown}
        if not kept:
            return []
        found, one = [], list(kept.values())[-1]
        (rows, columns), (dx, dy) = one.shape, one.spacing
        place = {"x": one.origin[0] - dx / 2, "y": one.origin[1] - dy / 2,
                 "dw": columns * dx, "dh": rows * dy}
        for name in ("pressure", "gap", "traction_x", "traction_y", "stick"):
            having = {key: each for key, each in kept.items() if name in list(each)}
            if not having:
                continue
            images = [each._drawn(name).astype("f4") for each in having.values()]
            if name == "stick":
                figure = self.plan("Stick (blue), slip (orange)", one.unit or "")
                mapper = models.LinearColorMapper(list(STATES.values()), low=-0.5, high=2.5)
            else:
                label = label_of(name, one.units[name])
                figure = self.plan(label[0].upper() + label[1:], one.unit or "")
                mapper = self.colours(numpy.concatenate(images, axis=None), figure)
            source = models.ColumnDataSource({"image": images, "key": list(having)})
            drawn = figure.image("image", source=source, view=self.view(), color_mapper=mapper,
                                 **place)
            if name not in FLAGS:
                figure.add_tools(self.hover(drawn, {"x": "$x", "y": "$y", name: "@image"}))
            found.append(figure)
        return found

    def contacts(self) -> tuple[list[Any], Any]:
        """The loaded contacts in plan, where no fields are, and as a table that sorts."""
        table = self.results.contacts
        rows = numpy.flatnonzero((table["load"] != 0) & numpy.isin(
            numpy.array(keys_of(table, numpy.arange(len(table))), dtype="U"), self.shown))
        if len(rows) > MOST_CONTACTS:
            largest = table["load"][rows].argsort()[::-1][:MOST_CONTACTS]
            self.notes.append(f"The {MOST_CONTACTS:,} contacts with the largest loads of "
                              f"{len(rows):,} are listed.")
            rows = numpy.sort(rows[largest])
        names = [name for name in COLUMNS if name in table]
        data = {name: table[name][rows] for name in names}
        data |= {"key": keys_of(table, rows), "radius": numpy.sqrt(table["area"][rows] / math.pi)}
        source = models.ColumnDataSource(data)
        listed = models.DataTable(
            source=source, view=self.view(), height=260, index_position=None, reorderable=False,
            sizing_mode="stretch_width", autosize_mode="none", columns=[models.TableColumn(
                field=name, title=table.label(name), width=145, formatter=self.format(data[name]))
                for name in names])
        if self.fields or not len(rows):
            return [], listed
        figure = self.plan("Contacts to scale", table.units["x"])
        mapper = self.colours(data["maximum_pressure"], figure)
        figure.right[-1].title = table.label("maximum_pressure")
        # The ranges are those of all states.
        figure.scatter("x", "y", source=source, alpha=0, nonselection_alpha=0)
        drawn = figure.circle("x", "y", radius="radius", source=source, view=self.view(),
                              fill_color={"field": "maximum_pressure", "transform": mapper},
                              line_color=None, nonselection_alpha=1)
        figure.add_tools(self.hover(drawn, {table.label(name): f"@{name}" for name in names}))
        return [figure], listed

    def format(self, values: Any) -> Any:
        """Numbers of a column with six digits of the greatest."""
        if values.dtype.kind == "i":
            return models.NumberFormatter(format="0")
        greatest = float(numpy.abs(values).max(initial=0.0))
        decimals = DIGITS - 1 - (math.floor(math.log10(greatest)) if greatest > 0 else 0)
        if decimals > 9 or decimals < -DIGITS:
            return models.ScientificFormatter(precision=DIGITS - 1, power_limit_low=0,
                                                   power_limit_high=0)
        return models.NumberFormatter(format="0." + "0" * decimals if decimals > 0 else "0")

    def curves(self, slider: Any) -> list[Any]:
        """Curves of the states, with their errors; a click on a point moves the slider."""
        force, size = quantities(self.states)
        pairs = [("position", force), ("position", "separation")] if self.has_positions \
            else [("separation", force), (force, size)]
        return [self.curve(across, up, slider) for across, up in pairs]

    def curve(self, across: str, up: str, slider: Any) -> Any:
        states = self.states
        figure = plotting.figure(width=WIDTH, height=HEIGHT, x_axis_label=states.label(across),
                             y_axis_label=states.label(up), toolbar_location="above", tools=TOOLS)
        x, y = states[across][self.rows], states[up][self.rows]
        data = {"x": x, "y": y, "key": self.keys}
        along, error = error_of(states, across, up, self.results._control())
        source = models.ColumnDataSource(data)
        if error is not None:
            source.data["low"], source.data["high"] = (
                data[along] - error[self.rows], data[along] + error[self.rows])
            style = {"base": "x" if along == "y" else "y", "lower": "low", "upper": "high",
                     "dimension": "height" if along == "y" else "width", "source": source}
            figure.add_layout(models.Band(fill_color="#1f77b4", fill_alpha=0.25, **style)
                              if is_monotonic(x) and not self.has_positions
                              else models.Whisker(line_color="#1f77b4", **style))
        ends = numpy.flatnonzero(numpy.append(numpy.diff(x) != 0, True)) if self.has_positions \
            else slice(None)
        figure.line(x[ends], y[ends])
        points = figure.scatter("x", "y", source=source, size=5, nonselection_alpha=1)
        figure.scatter("x", "y", source=source, view=self.view(), size=12, color="#d62728",
                       nonselection_alpha=1)
        figure.add_tools(self.hover(points, {"state": "@key", across: "@x", up: "@y"}),
                         models.TapTool(renderers=[points]))
        source.selected.js_on_change("indices", models.CustomJS(args={
            "slider": slider, "keys": self.shown, "source": source}, code=CHOOSE))
        return figure

    def name_of(self, key: str) -> str:
        position, step = key.split(".")
        return f"position {position}, state {step}" if self.has_positions else f"state {step}"


def keys_of(table: Table, rows: Any) -> list[str]:
    return [f"{position}.{step}" for position, step in zip(table["position"][rows].tolist(),
                                                           table["step"][rows].tolist())]


def page_of(results: Results, position: int | None, title: str | None) -> str:
    """The text of the page."""
    page = Page(results, position)
    slider = models.Slider(start=0, end=max(1, len(page.shown) - 1), step=1, width=WIDTH,
                                value=len(page.shown) - 1, show_value=False,
                                title=page.name_of(page.shown[-1]), visible=len(page.shown) > 1)
    maps = page.images()
    circles, listed = page.contacts()
    figures = [*maps, *circles, *page.curves(slider)]
    slider.js_on_change("value", models.CustomJS(args={
        "filters": page.filters, "keys": page.shown,
        "names": [page.name_of(key) for key in page.shown]}, code=MOVE))
    about = results.scene.get("provenance", {})
    name = title or results.scene.get("file", "asperity")
    lines = "".join(f"<li style='color:{colour}'>{html.escape(line)}</li>" for colour, texts in (
        ("#a00", results.warnings), ("#555", page.notes)) for line in texts)
    inputs = "; ".join([f"asperity {about.get('version', '')}", *(
        f"{one['file']}, checksum {one['checksum']}" for one in about.get("inputs", []))])
    style: dict[str, Any] = {"sizing_mode": "stretch_width", "styles": {"overflow-x": "auto"}}
    head, foot = (models.Div(text=text, **style) for text in (
        f"<h2>{html.escape(name)}</h2><ul>{lines}</ul>",
        f"<h3>Summary</h3><pre>{html.escape(results.summary)}</pre><h3>Input</h3>"
        f"<p>{html.escape(inputs)}</p><pre>{html.escape(results.scene.get('text', ''))}</pre>"))
    layout = layouts.column(head, slider, layouts.row(*figures, **WRAPPED), listed, foot,
                            sizing_mode="stretch_width", styles={"max-width": "1180px"})
    return str(embed.file_html(layout, resources.INLINE, name))
