"""Shapes played over time: drawings to scale whose parts move."""

from dataclasses import dataclass

import numpy as np

from ... import checks
from .plot import Curve, MovingPlot, Panel


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


def drawing(shapes, frames, title="", xlim=None, ylim=None, above=False):
    """Shapes as a `Panel` to scale and in millimetres, for `animate` or beside its own drawing.

    ``frames`` counts the sets of points of those that move; ``xlim`` and ``ylim`` are pairs in metres. Seen from
    ``above``, y is the way out of the plane, towards the reader, and runs down the page.

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
    xlim, ylim = (None if pair is None else tuple(1e3 * np.asarray(pair)) for pair in (xlim, ylim))
    names = ("x [mm]", "out of the plane [mm]" if above else "y [mm]")
    return Panel(moving, *names, title, xlim=xlim, ylim=ylim, fixed=tuple(fixed), equal=True, downwards=above)


def animate(
    time, shapes, *, alt, seconds=6.0, title="", caption="", notes=None, xlim=None, ylim=None, panels=(), **size
):
    """`MovingPlot` of shapes over time, to scale and in millimetres, with a play button and a slider for time.

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
        ``width``, ``height``, ``columns``, ``start``, ``digits`` and ``key`` of `MovingPlot`.

    Raises
    ------
    ValueError
        If a shape's array does not fit the time vector.
    """
    time = checks.array("time", time, "s", min_size=2)
    first = drawing(shapes, time.size, title, xlim, ylim)
    seconds = checks.positive("seconds", seconds, "s")
    slower = seconds / (time[-1] - time[0])
    caption += f" Played {float(f'{slower:.2g}'):g} times slower than real time."
    caption = f"{caption} On the slider, space plays and pauses, arrow keys step.".strip()
    return MovingPlot(
        "Time", 1e3 * time, "ms", (first, *panels), alt=alt, notes=notes, caption=caption, seconds=seconds, **size
    )
