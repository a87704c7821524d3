"""Figures of periodic orbits: the frequency response with every piece, its stability and its special points."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from ...orbits.periodic_orbits import OrbitBranch
from .style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, RIG, SKY, STABLE, UNSTABLE, style, subplots

_PANELS = (("shaker", "shaker $x_s$"), ("mass", "suspended mass $x$"), ("relative", "relative $z = x_s - x$"))
_COLORS = (BLUE, GREEN, PURPLE, SKY)
_MARKS = {
    "fold": ("D", "k"),
    "Neimark-Sacker": ("s", RED),
    "period doubling": ("^", RED),
    "symmetry breaking": ("v", RED),
}


def orbits_figure(branches, *, beside=None, circles=None, circles_label="multi-body rig", axes=None):
    """Amplitudes at the forcing frequency over frequency, every piece in its colour.

    Stable orbits are solid, unstable ones dashed, by the Floquet multipliers of the converged orbits. Folds and changes
    of stability are marked and named, closed curves shaded.

    Parameters
    ----------
    branches : OrbitBranch or sequence of OrbitBranch
    beside : FrequencyResponse, optional
        Single-term theory, drawn thin and grey.
    circles : tuple of four (k,) array_like, optional
        Frequency (Hz), shaker, mass and relative amplitudes (m, complex or real) drawn as circles.
    circles_label : str
    axes : sequence of three matplotlib.axes.Axes, optional
        Drawn into instead of a new figure; legend and text alternative are then the caller's.

    Returns
    -------
    matplotlib.figure.Figure
    """
    branches = (branches,) if isinstance(branches, OrbitBranch) else tuple(branches)
    if not branches:
        raise ValueError("branches = () is not allowed; expected at least one OrbitBranch")
    with style():
        new = axes is None
        if new:
            figure, axes = subplots(3, 1, alt=_alt(branches), height=8.6, sharex=True)
        else:
            figure = axes[0].figure
        for panel, ((name, title), ax) in enumerate(zip(_PANELS, axes, strict=True)):
            if beside is not None:
                for piece in beside.pieces:
                    label = None if piece is not beside.pieces[0] else "single-term theory"
                    ax.plot(piece.frequency, 1e3 * abs(getattr(piece, name)), color=GREY, linewidth=0.9, label=label)
            named = set()
            for number, branch in enumerate(branches):
                _curve(ax, branch, name, _COLORS[number % len(_COLORS)], named)
            if circles is not None:
                height = 1e3 * np.abs(circles[1 + panel])
                ax.plot(circles[0], height, color="k", markersize=4, label=circles_label, **RIG)
            ax.set_yscale("log")
            ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            ax.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
            ax.yaxis.set_minor_formatter(NullFormatter())
            ax.set_ylabel("amplitude (mm)")
            ax.set_title(f"({'abc'[panel]}) {title}", loc="left")
        axes[-1].set_xlabel("frequency (Hz)")
        _frequencies(axes[-1], [point for branch in branches for point in branch.special_points])
        if new:
            figure.align_ylabels(axes)
            handles, names = axes[-1].get_legend_handles_labels()
            unique = dict(zip(names, handles, strict=True))
            title = "stability: Floquet multipliers of the converged orbits"
            figure.legend(unique.values(), unique, title=title, loc="outside lower center", ncols=3)
        return figure


def _curve(ax, branch, name, color, named):
    """A curve in runs of equal stability, its special points, and its inside if it is closed."""
    amplitude, stable = 1e3 * abs(getattr(branch, name)[:, branch.period]), branch.stable
    what = _title(branch)
    if branch.closed:
        ax.fill(branch.frequency, amplitude, color=ORANGE, alpha=0.25, linewidth=0, label="detached curve")
    for run in np.split(np.arange(stable.size), np.flatnonzero(np.diff(stable)) + 1):
        solid = bool(stable[run[0]])
        label = f"{what}, {'stable' if solid else 'unstable'}"
        reach = np.append(run, run[-1] + 1) if run[-1] + 1 < stable.size else run  # no gap to the next run
        key = STABLE if solid else UNSTABLE
        ax.plot(branch.frequency[reach], amplitude[reach], color=color, label=None if label in named else label, **key)
        named.add(label)
    for point in branch.special_points:
        marker, edge = _MARKS[point.kind]
        label = None if point.kind in named else point.kind
        named.add(point.kind)
        height = 1e3 * abs(getattr(point, name))
        ax.plot(
            point.frequency,
            height,
            marker,
            color=edge,
            markerfacecolor="w",
            markersize=5,
            label=label,
            linestyle="none",
        )


def _frequencies(ax, points):
    """Write the frequency (Hz) beside every point; those of close neighbours go to different sides."""
    sides = ((4, 5), (6, -11), (-30, 7), (-30, -11))
    last, side = -np.inf, 0
    for point in sorted(points, key=lambda point: point.frequency):
        side = (side + 1) % len(sides) if point.frequency < 1.06 * last else 0
        last = point.frequency
        place = point.frequency, 1e3 * abs(point.relative)
        ax.annotate(f"{last:.1f}", place, xytext=sides[side], textcoords="offset points", fontsize=8)


def _title(branch):
    if branch.period > 1:
        return f"period {branch.period}"
    if not branch.symmetric:
        return "asymmetric"
    return "closed" if branch.closed else "open"


def _alt(branches):
    first = branches[0]
    pieces = "; ".join(
        f"{_title(b)} curve of period {b.period} from {b.frequency.min():.1f} to {b.frequency.max():.1f} hertz"
        + "".join(f", {p.kind} at {p.frequency:.2f} hertz" for p in b.special_points)
        for b in branches
    )
    return (
        "Three stacked plots of amplitude in millimetres, logarithmic, over frequency in hertz at "
        f"{first.force:g} newtons: shaker, suspended mass and relative displacement of converged periodic orbits with "
        f"{first.harmonics} harmonics. Stable orbits are solid lines, unstable ones dashed. {pieces}."
    )


def harmonics_figure(result):
    """Error of the orbits, and shift of the special points, over the number of harmonics.

    Parameters
    ----------
    result : HarmonicsWorth

    Returns
    -------
    matplotlib.figure.Figure
    """
    alt = (
        "Two plots over the number of harmonics, logarithmic: the largest relative error of shaker, mass and relative "
        f"displacement along all curves, which falls from {result.error[0].max():.1e} to {result.error[-1].max():.1e}, "
        f"and the largest shift of a special point in hertz, from {result.shift[0]:.1e} to {result.shift[-1]:.1e}."
    )
    with style():
        figure, axes = subplots(1, 2, alt=alt, height=3.4)
        for column, (label, marker, color) in enumerate((("$x_s$", "o", BLUE), ("$x$", "s", GREEN), ("$z$", "^", RED))):
            axes[0].semilogy(result.harmonics, result.error[:, column], marker=marker, color=color, label=label)
        axes[0].set(xlabel="harmonics", ylabel="largest relative error")
        axes[0].legend()
        axes[1].semilogy(result.harmonics, result.shift, "o-", color="k")
        axes[1].set(xlabel="harmonics", ylabel="largest shift of a special point (Hz)")
        return figure
