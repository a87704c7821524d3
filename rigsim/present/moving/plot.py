"""Figures that move without a kernel: a slider over precomputed curves.

Each object is one piece of HTML with an inline SVG, a range input and a few lines of JavaScript that swap the ``d``
attribute of paths. It works alike in JupyterLab and in an exported page opened from disk.
"""

import hashlib
import json
import math
from dataclasses import dataclass
from functools import cached_property
from html import escape
from importlib.resources import files

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap

from ... import checks
from ..figures.style import BLACK, BLUE, log_scale, style, subplots
from ..figures.svg import unique_ids
from .paths import KINDS, handles, look, path_of


@dataclass(frozen=True)
class Curve:
    """One curve of a panel at one value of the slider.

    Parameters
    ----------
    x, y : array_like, shape (n,)
        In the units of the axes; NaN interrupts the line. May be empty.
    kind : {"stable", "unstable", "line", "outline", "point", "dot"}
        Solid, dashed, thin solid, closed and lightly filled, open circles, filled circles.
    label : str
        Shown in the legend, once for all curves with the same label and colour.
    color : str, optional
        A Matplotlib colour; blue by default, black for points.

    Raises
    ------
    ValueError
        If the kind is unknown or x and y differ in length.
    """

    x: np.ndarray
    y: np.ndarray
    kind: str = "stable"
    label: str = ""
    color: str | None = None

    def __post_init__(self):
        kind = checks.one_of("kind", self.kind, tuple(KINDS))
        x, y = (np.asarray(values, dtype=float).ravel() for values in (self.x, self.y))
        if x.size != y.size:
            raise ValueError(f"a curve has {x.size} x and {y.size} y; expected the same number")
        color = self.color or (BLACK if self.kind in ("point", "dot") else BLUE)
        for name, value in (("kind", kind), ("x", x), ("y", y), ("color", color)):
            object.__setattr__(self, name, value)


@dataclass(frozen=True)
class Panel:
    """One pair of axes of a `MovingPlot`.

    Parameters
    ----------
    curves : sequence of sequences of Curve
        One sequence for each value of the slider; they may differ in number, a curve may come and go.
    xlabel, ylabel, title : str
        Quantity and unit, as in "frequency [Hz]".
    xscale, yscale : {"linear", "log"}
    xlim, ylim : pair of float, optional
        By default what holds every curve at every value.
    fixed : sequence of Curve
        Drawn at every value, beneath the moving ones.
    equal : bool
        One unit has the same length on both axes, as in a drawing.
    downwards : bool
        y runs down the page.
    """

    curves: tuple
    xlabel: str
    ylabel: str
    title: str = ""
    xscale: str = "linear"
    yscale: str = "linear"
    xlim: tuple | None = None
    ylim: tuple | None = None
    fixed: tuple = ()
    equal: bool = False
    downwards: bool = False


@dataclass(frozen=True)
class Key:
    """Classes of a quantity, ``label`` with its unit, between n + 1 ``limits``, each in one of n ``colors``."""

    label: str
    limits: np.ndarray
    colors: tuple


class MovingPlot:
    """Curves that follow a slider, drawn beforehand for each of its values.

    Parameters
    ----------
    name : str
        The quantity the slider sets, as in "Force".
    values : array_like, shape (n,)
        Its values, in slider order.
    unit : str
    panels : Panel or sequence of Panel
        Each with n lists of curves.
    alt : str
        What a reader who cannot see the figure should know.
    notes : sequence of str, optional
        n sentences, shown with their value: what is to be seen there.
    caption : str
        A sentence below the slider that holds for every value.
    start : int
        Index of the value shown first.
    seconds : float, optional
        Adds a play button; one pass over the values takes this long. Nothing plays by itself.
    digits : int
        Significant digits of the value shown.
    width, height : float
        Inches, of the whole figure.
    columns : int
        Panels side by side before a new row begins.
    key : Key, optional
        A bar of colours beside the panels.

    Raises
    ------
    ValueError
        If lengths do not match, or there is nothing to show.

    Examples
    --------
    >>> panel = Panel([[Curve([1, 2], [force, 2 * force])] for force in (1, 2)], "frequency [Hz]", "x [mm]")
    >>> MovingPlot("Force", [1, 2], "N", panel, alt="The response doubles with the force.")
    MovingPlot(Force: 2 values from 1 N to 2 N)
    """

    def __init__(
        self, name, values, unit, panels, *, alt, notes=None, caption="", start=0, seconds=None, digits=3,
        width=7.5, height=None, columns=3, key=None,
    ):  # fmt: skip
        given = {"name": name, "unit": unit, "alt": alt, "caption": caption}
        self.name, self.unit, self.alt, self.caption = (checks.text(*one) for one in given.items())
        self.values = checks.array(name, values, unit)
        self.panels = tuple(checks.one_or_many("panels", panels, Panel, "a Panel"))
        count = self.values.size
        if not self.panels:
            raise ValueError("panels is empty; expected at least one Panel")
        for panel in self.panels:
            if len(panel.curves) != count:
                raise ValueError(
                    f"a panel has {len(panel.curves)} lists of curves; expected {count}, one for each of values"
                )
        self.notes = ("",) * count if notes is None else tuple(checks.one_or_many("notes", notes, str, "text"))
        if len(self.notes) != count:
            raise ValueError(f"notes has {len(self.notes)} sentences; expected {count}, one a value")
        self.start = checks.integer("start", start, low=0, high=count - 1)
        self.seconds = None if seconds is None else checks.positive("seconds", seconds, "s")
        self.digits = checks.integer("digits", digits, low=1, high=15)
        width = checks.real("width", width, "inches", low=1.0, high=100.0)
        height = None if height is None else checks.real("height", height, "inches", low=1.0, high=100.0)
        self._size = {"width": width, "height": height}
        self.key = None if key is None else checks.instance("key", key, Key, "a Key")
        self._columns = min(checks.integer("columns", columns, low=1), len(self.panels))

    def __repr__(self):
        first, last = (self._text(value) for value in self.values[[0, -1]])
        return f"MovingPlot({self.name}: {self.values.size} values from {first} to {last})"

    def _text(self, value):
        # '#' keeps trailing zeros, so that the text does not jump while the slider moves.
        return f"{value:#.{self.digits}g}".removesuffix(".") + (f" {self.unit}" if self.unit else "")

    @property
    def megabytes(self):
        """What the picture takes of a page."""
        return len(self._html.encode()) / 1e6

    def _repr_html_(self):
        return self._html

    @cached_property
    def _html(self):
        svg, paths = self._draw()
        data = {"paths": paths, "texts": [self._text(value) for value in self.values]}
        data |= {name: getattr(self, name) for name in ("notes", "alt", "name", "seconds")}
        data = json.dumps(data, separators=(",", ":")).replace("</", "<\\/")
        key = "m" + hashlib.sha256((svg + data).encode()).hexdigest()[:8] + "-"
        button = '<button type="button">Play</button>' if self.seconds else ""
        note = f'<p class="rigsim-note">{escape(self.notes[self.start])}</p>' if any(self.notes) else ""
        takes = f" {max((len(svg) + len(data)) / 1e6, 0.01):.2f} MB of this page." if self.seconds else ""
        caption = self.caption + takes
        caption = f'<p class="rigsim-caption">{escape(caption)}</p>' if caption else ""
        text = escape(self._text(self.values[self.start]))
        return (
            f'<div class="rigsim-moving" data-key="{key}"><style>{_file("moving.css")}</style>'
            f'<div class="rigsim-drawing">{unique_ids(svg, key)}</div>'
            f'<div class="rigsim-controls">{button}<label>{escape(self.name)} '
            f'<input type="range" min="0" max="{self.values.size - 1}" step="1" value="{self.start}" '
            f'aria-valuetext="{text}"></label><output aria-live="off">{text}</output></div>{note}{caption}'
            f'<script type="application/json">{data}</script><script>{_file("moving.js")}</script></div>'
        )

    def _draw(self):
        """The SVG with the first value's curves, and for each path that moves its n ``d`` attributes."""
        rows = math.ceil(len(self.panels) / self._columns)
        with style():
            figure, grid = subplots(rows, self._columns, alt=self.alt, squeeze=False, **self._size)
            figure.set_dpi(72)  # that of an SVG file, so that the layout found here is the layout there
            for axes, panel in zip(grid.flat, self.panels, strict=False):
                _set_axes(axes, panel)
            for axes in grid.flat[len(self.panels) :]:
                axes.set_axis_off()
            slots = [_slots(panel) for panel in self.panels]
            if self.key:
                colors = ListedColormap(self.key.colors)
                bar = ScalarMappable(BoundaryNorm(self.key.limits, colors.N), colors)
                look = {"label": self.key.label, "ticks": self.key.limits, "format": "{x:g}", "aspect": 30}
                figure.colorbar(bar, ax=grid[0].tolist(), location="right", **look)
            entries = handles(key for panel_slots in slots for key, _ in panel_slots)
            if entries:
                figure.legend(handles=entries, loc="outside upper center", ncols=min(4, len(entries)))
            figure.draw_without_rendering()
            figure.set_layout_engine("none")
            layers, paths = [], []
            for number, (axes, panel_slots) in enumerate(zip(grid.flat, slots, strict=False)):
                layers.append(self._layer(number, axes, panel_slots, figure.bbox.height, paths))
            return figure.svg().rstrip().removesuffix("</svg>") + "".join(layers) + "</svg>", paths

    def _layer(self, number, axes, slots, height, paths):
        box = axes.bbox.extents
        elements = []
        for (kind, _, color), curves in slots:
            texts = ["".join(path_of(curve, axes, box, height) for curve in group) for group in curves]
            if len(set(texts)) == 1:
                elements.append(f'<path d="{texts[0]}" {look(kind, color)}/>')
            else:
                elements.append(f'<path class="moves" d="{texts[self.start]}" {look(kind, color)}/>')
                paths.append(texts)
        x, y, right, top = box
        clip = f'<rect x="{x:.1f}" y="{height - top:.1f}" width="{right - x:.1f}" height="{top - y:.1f}"/>'
        return (
            f'<clipPath id="panel{number}">{clip}</clipPath><g clip-path="url(#panel{number})">'
            f'<g transform="scale(.1)" stroke-linejoin="round">{"".join(elements)}</g></g>'
        )


def _file(name):
    return files(__package__).joinpath("templates", name).read_text(encoding="utf-8").strip()


def _set_axes(axes, panel):
    axes.set(xlabel=panel.xlabel, ylabel=panel.ylabel, title=panel.title)
    curves = [*panel.fixed, *(curve for group in panel.curves for curve in group)]
    for name, scale, wanted in (("x", panel.xscale, panel.xlim), ("y", panel.yscale, panel.ylim)):
        if scale == "log":
            log_scale(axes, (1, 2, 5), name)
        if wanted is None:
            values = np.concatenate([np.empty(0), *(getattr(curve, name) for curve in curves)])
            values = values[np.isfinite(values) & ((values > 0) | (scale == "linear"))]
            if values.size:
                axes.update_datalim([(v, v) for v in (values.min(), values.max())], name == "x", name == "y")
                axes.autoscale_view(scalex=name == "x", scaley=name == "y")
        else:
            axes.set(**{f"{name}lim": wanted})
    if panel.equal:
        axes.set_aspect("equal", adjustable="box" if panel.xlim and panel.ylim else "datalim")
    if panel.downwards:
        axes.invert_yaxis()


def _slots(panel):
    """Curves gathered by look: ((kind, label, colour), lists of curves), one list if fixed, else one a value."""
    slots = {}
    for curve in panel.fixed:
        slots.setdefault((True, curve.kind, curve.label, curve.color), [[]])[0].append(curve)
    for index, group in enumerate(panel.curves):
        for curve in group:
            key = (False, curve.kind, curve.label, curve.color)
            if key not in slots:
                slots[key] = [[] for _ in panel.curves]
            slots[key][index].append(curve)
    return [(key[1:], curves) for key, curves in slots.items()]
