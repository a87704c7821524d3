"""Figures that move without a kernel: a slider over precomputed curves, and shapes played over time.

Each object is one piece of HTML with an inline SVG, a range input and a few lines of JavaScript that swap the ``d``
attribute of paths. It works alike in JupyterLab and in an exported page opened from disk.
"""

import hashlib
import json
import math
from dataclasses import dataclass
from html import escape
from importlib.resources import files

import numpy as np
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from ... import checks
from ..figures.style import BLACK, BLUE, style, subplots
from ..figures.svg import unique_ids

# Line key of the house (`figures.style`); "outline" is a closed shape, filled lightly. Widths and dashes in points.
_KINDS = {
    "stable": {"width": 1.6},
    "unstable": {"width": 1.6, "dash": (5.9, 2.6)},
    "line": {"width": 1.2},
    "outline": {"width": 1.2, "fill": 0.15},
    "point": {"width": 1.2, "radius": 3.0},
    "dot": {"width": 0.0, "radius": 2.5, "fill": 1.0},
}


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
        checks.one_of("kind", self.kind, tuple(_KINDS))
        x, y = (np.asarray(values, dtype=float).ravel() for values in (self.x, self.y))
        if x.size != y.size:
            raise ValueError(f"a curve has {x.size} x and {y.size} y; expected the same number")
        object.__setattr__(self, "x", x)
        object.__setattr__(self, "y", y)
        if self.color is None:
            object.__setattr__(self, "color", BLACK if self.kind in ("point", "dot") else BLUE)


@dataclass(frozen=True)
class Panel:
    """One pair of axes of a `MovingPlot`.

    Parameters
    ----------
    curves : sequence of sequences of Curve
        One sequence for each value of the slider; they may differ in number, a curve may come and go.
    xlabel, ylabel, title : str
        Quantity and unit, as in "frequency (Hz)".
    xscale, yscale : {"linear", "log"}
    xlim, ylim : pair of float, optional
        By default what holds every curve at every value.
    fixed : sequence of Curve
        Drawn at every value, beneath the moving ones.
    equal : bool
        One unit has the same length on both axes, as in a drawing.
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

    Raises
    ------
    ValueError
        If lengths do not match, or there is nothing to show.

    Examples
    --------
    >>> panel = Panel([[Curve([1, 2], [force, 2 * force])] for force in (1, 2)], "frequency (Hz)", "x (mm)")
    >>> MovingPlot("Force", [1, 2], "N", panel, alt="The response doubles with the force.")
    MovingPlot(Force: 2 values from 1 N to 2 N)
    """

    def __init__(
        self, name, values, unit, panels, *, alt, notes=None, caption="", start=0, seconds=None, digits=3,
        width=7.5, height=None, columns=3,
    ):  # fmt: skip
        self.name, self.unit, self.alt, self.caption = name, unit, alt, caption
        self.values = checks.array(name, values, unit)
        self.panels = (panels,) if isinstance(panels, Panel) else tuple(panels)
        count = self.values.size
        if not self.panels:
            raise ValueError("panels is empty; expected at least one Panel")
        for panel in self.panels:
            if len(panel.curves) != count:
                raise ValueError(f"a panel has {len(panel.curves)} lists of curves; expected {count}, one a value")
        self.notes = tuple(notes) if notes is not None else ("",) * count
        if len(self.notes) != count:
            raise ValueError(f"notes has {len(self.notes)} sentences; expected {count}, one a value")
        self.start = checks.integer("start", start, low=0, high=count - 1)
        self.seconds = None if seconds is None else checks.positive("seconds", seconds, "s")
        self.digits = checks.integer("digits", digits, low=1)
        self._size = {"width": width, "height": height}
        self._columns = min(checks.integer("columns", columns, low=1), len(self.panels))

    def __repr__(self):
        first, last = (self._text(value) for value in self.values[[0, -1]])
        return f"MovingPlot({self.name}: {self.values.size} values from {first} to {last})"

    def _text(self, value):
        # '#' keeps trailing zeros, so that the text does not jump while the slider moves.
        return f"{value:#.{self.digits}g}".removesuffix(".") + (f" {self.unit}" if self.unit else "")

    def _repr_html_(self):
        svg, paths = self._draw()
        data = json.dumps(
            {
                "paths": paths,
                "texts": [self._text(value) for value in self.values],
                "notes": self.notes,
                "alt": self.alt,
                "name": self.name,
                "seconds": self.seconds,
            },
            separators=(",", ":"),
        ).replace("</", "<\\/")
        key = "m" + hashlib.sha256((svg + data).encode()).hexdigest()[:8] + "-"
        button = '<button type="button">Play</button>' if self.seconds else ""
        note = f'<p class="rigsim-note">{escape(self.notes[self.start])}</p>' if any(self.notes) else ""
        caption = f'<p class="rigsim-caption">{escape(self.caption)}</p>' if self.caption else ""
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
            handles = _handles(key for panel_slots in slots for key, _ in panel_slots)
            if handles:
                figure.legend(handles=handles, loc="outside upper center", ncols=min(4, len(handles)))
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
            texts = ["".join(_path(curve, axes, box, height) for curve in group) for group in curves]
            if len(texts) == 1 or len(set(texts)) == 1:
                elements.append(f'<path d="{texts[0]}" {_look(kind, color)}/>')
            else:
                elements.append(f'<path class="moves" d="{texts[self.start]}" {_look(kind, color)}/>')
                paths.append(texts)
        x, y, right, top = box
        clip = f'<rect x="{x:.1f}" y="{height - top:.1f}" width="{right - x:.1f}" height="{top - y:.1f}"/>'
        return (
            f'<clipPath id="panel{number}">{clip}</clipPath><g clip-path="url(#panel{number})">'
            f'<g transform="scale(.1)" stroke-linejoin="round">{"".join(elements)}</g></g>'
        )


@dataclass(frozen=True)
class Shape:
    """A part of a drawing that moves: a line, an outline or points.

    Parameters
    ----------
    points : array_like, shape (frames, n, 2) or (n, 2)
        x and y in metres; two dimensions if it stands still. NaN interrupts the line.
    kind, label, color
        As in `Curve`.
    """

    points: np.ndarray
    kind: str = "line"
    label: str = ""
    color: str | None = None


def drawing(shapes, frames, title="", xlim=None, ylim=None):
    """Shapes as a `Panel` to scale and in millimetres, for `animate` or beside its own drawing.

    Parameters
    ----------
    shapes : sequence of Shape
    frames : int
        Sets of points of those that move.
    title : str
    xlim, ylim : pair of float, optional
        Metres.

    Returns
    -------
    Panel

    Raises
    ------
    ValueError
        If a shape's array does not fit the number of frames.
    """
    fixed, moving = [], [[] for _ in range(frames)]
    for shape in shapes:
        points = 1e3 * np.asarray(shape.points, dtype=float)
        key = (shape.kind, shape.label, shape.color)
        if points.ndim == 2 and points.shape[1] == 2:
            fixed.append(Curve(points[:, 0], points[:, 1], *key))
        elif points.ndim == 3 and points.shape[::2] == (frames, 2):
            for group, at in zip(moving, points, strict=True):
                group.append(Curve(at[:, 0], at[:, 1], *key))
        else:
            raise ValueError(f"a shape has shape {points.shape}; expected ({frames}, n, 2) or (n, 2)")
    limits = {
        name: None if pair is None else tuple(1e3 * np.asarray(pair)) for name, pair in (("xlim", xlim), ("ylim", ylim))
    }
    return Panel(moving, "x (mm)", "y (mm)", title, fixed=tuple(fixed), equal=True, **limits)


def animate(
    time, shapes, *, alt, seconds=6.0, title="", caption="", notes=None, xlim=None, ylim=None, panels=(), **size
):
    """Play shapes over time, to scale and in millimetres, with a play button and a slider for time.

    Parameters
    ----------
    time : array_like, shape (frames,)
        Seconds.
    shapes : sequence of Shape
        Those that move have one set of points a frame; later ones are drawn on top.
    alt : str
        What a reader who cannot see the figure should know.
    seconds : float
        One pass takes this long on the screen; how much slower than the rig that is, is said below the figure.
    title, caption : str
        Name here anything drawn larger than it is, as in "tilt drawn 20 times as large".
    notes : sequence of str, optional
        A sentence for each frame.
    xlim, ylim : pair of float, optional
        Metres.
    panels : sequence of Panel
        Further panels beside the drawing, one list of curves a frame.
    **size
        ``width``, ``height``, ``columns``, ``start`` and ``digits`` of `MovingPlot`.

    Returns
    -------
    MovingPlot

    Raises
    ------
    ValueError
        If a shape's array does not fit the time vector.
    """
    time = checks.array("time", time, "s", min_size=2)
    first = drawing(shapes, time.size, title, xlim, ylim)
    slower = seconds / (time[-1] - time[0])
    caption = f"{caption} Played {float(f'{slower:.2g}'):g} times slower than real time.".strip()
    return MovingPlot(
        "Time", 1e3 * time, "ms", (first, *panels), alt=alt, notes=notes, caption=caption, seconds=seconds, **size
    )


def _file(name):
    return files(__package__).joinpath("templates", name).read_text(encoding="utf-8").strip()


def _set_axes(axes, panel):
    axes.set(xlabel=panel.xlabel, ylabel=panel.ylabel, title=panel.title, xscale=panel.xscale, yscale=panel.yscale)
    curves = [*panel.fixed, *(curve for group in panel.curves for curve in group)]
    for name, scale, wanted in (("x", panel.xscale, panel.xlim), ("y", panel.yscale, panel.ylim)):
        if wanted is None:
            values = np.concatenate([np.empty(0), *(getattr(curve, name) for curve in curves)])
            values = values[np.isfinite(values) & ((values > 0) | (scale == "linear"))]
            if values.size:
                axes.update_datalim([(v, v) for v in (values.min(), values.max())], name == "x", name == "y")
                axes.autoscale_view(scalex=name == "x", scaley=name == "y")
        else:
            axes.set(**{f"{name}lim": wanted})
        if scale == "log":
            axis = getattr(axes, f"{name}axis")
            axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axis.set_minor_formatter(NullFormatter())
    if panel.equal:
        axes.set_aspect("equal", adjustable="box" if panel.xlim and panel.ylim else "datalim")


def _slots(panel):
    """Curves gathered by look: ((kind, label, colour), lists of curves), one list if fixed, else one a value."""
    slots = {}
    for curve in panel.fixed:
        slots.setdefault((True, curve.kind, curve.label, curve.color), [[]])[0].append(curve)
    for index, group in enumerate(panel.curves):
        for curve in group:
            key = (False, curve.kind, curve.label, curve.color)
            slots.setdefault(key, [[] for _ in panel.curves])[index].append(curve)
    return [(key[1:], curves) for key, curves in slots.items()]


def _handles(keys):
    """Legend entries, one for each label and colour; where solid and dashed share both, the solid one."""
    entries = {}
    for kind, label, color in keys:
        if label and (kind != "unstable" or (label, color) not in entries):
            entries[label, color] = _handle(kind, label, color)
    return list(entries.values())


def _handle(kind, label, color):
    look = _KINDS[kind]
    if "radius" in look:
        fill = color if "fill" in look else "none"
        return Line2D([], [], linestyle="none", marker="o", color=color, markerfacecolor=fill, label=label)
    return Line2D([], [], linestyle="--" if "dash" in look else "-", color=color, label=label)


def _look(kind, color):
    """SVG attributes of a kind of line, in tenths of a point."""
    look = _KINDS[kind]
    color = to_hex(color)
    text = f'stroke="{color}" stroke-width="{10 * look["width"]:g}"'
    text += f' fill="{color}" fill-opacity="{look["fill"]:g}"' if "fill" in look else ' fill="none"'
    if "dash" in look:
        text += ' stroke-dasharray="{:g} {:g}"'.format(*(10 * length for length in look["dash"]))
    return text


def _path(curve, axes, box, height):
    """The curve as SVG path text in whole tenths of a point: absolute starts, relative steps."""
    points = np.column_stack([curve.x, curve.y])
    for column, scale in enumerate((axes.get_xscale(), axes.get_yscale())):
        if scale == "log":
            points[points[:, column] <= 0, column] = np.nan
    points = axes.transData.transform(points)
    look = _KINDS[curve.kind]
    if "radius" in look:
        points = points[np.isfinite(points).all(axis=1)]
        r = round(10 * look["radius"])
        circle = f"m{-r} 0a{r} {r} 0 1 0 {2 * r} 0a{r} {r} 0 1 0{-2 * r} 0"
        return "".join(f"M{x} {y}{circle}" for x, y in _tenths(points, height))
    if "fill" in look:
        return _line(_tenths(points, height)) + "z" if len(points) else ""
    if not len(points):
        return ""
    # Matplotlib's own clipping and merging of points that lie on a straight line within a ninth of a pixel.
    margin = np.array([-5, -5, 5, 5])
    cleaned = Path(points).cleaned(remove_nans=True, clip=tuple(box + margin), simplify=True)
    keep = cleaned.codes != Path.STOP
    starts = np.flatnonzero(cleaned.codes[keep] == Path.MOVETO)[1:]
    return "".join(_line(_tenths(part, height)) for part in np.split(cleaned.vertices[keep], starts) if len(part) > 1)


def _tenths(points, height):
    return np.rint(10 * np.column_stack([points[:, 0], height - points[:, 1]])).astype(int).tolist()


def _line(points):
    """One piece of a line; repeated points are dropped, a minus sign needs no space before it."""
    (x, y), *rest = points
    steps = []
    for next_x, next_y in rest:
        if (next_x, next_y) != (x, y):
            steps += [next_x - x, next_y - y]
            x, y = next_x, next_y
    return f"M{points[0][0]} {points[0][1]}" + ("l" + " ".join(map(str, steps)).replace(" -", "-") if steps else "")
