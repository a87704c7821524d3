"""Figures of periodic orbits: the frequency response with every piece, its stability and its special points."""

import itertools

import numpy as np

from ... import checks
from ...orbits.branches import OrbitBranch
from ...theory.amplitude import FrequencyResponse
from .style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    RED,
    RIG,
    SKY,
    circles_of,
    in_runs,
    legend,
    panels,
    style,
    subplots,
)  # fmt: skip

_COLORS = (BLUE, GREEN, PURPLE, SKY)
_MARKS = {
    "fold": ("D", "k"), "Neimark-Sacker": ("s", RED), "period doubling": ("^", RED), "symmetry breaking": ("v", RED),
}  # fmt: skip


def orbits_figure(result, *, ax=None, beside=(), circles=None, circles_label="multi-body rig"):
    """Amplitudes at the forcing frequency over frequency, every piece in its colour.

    Stable orbits are solid, unstable ones dashed, by the Floquet multipliers of the converged orbits. Folds and changes
    of stability are marked and named, closed curves shaded.

    Parameters
    ----------
    result : PeriodicOrbits or OrbitBranch
    ax : sequence of three axes, optional
    beside : FrequencyResponse or sequence of them, optional
        Single-term theory, drawn thin and grey.
    circles : tuple of four (k,) array_like, optional
        Frequency (Hz), shaker, mass and relative amplitudes (m, complex or real) drawn as circles.
    circles_label : str
    """
    beside = checks.one_or_many("beside", beside, FrequencyResponse, "a FrequencyResponse")
    circles = None if circles is None else circles_of(circles)
    circles_label = checks.text("circles_label", circles_label)
    branches = (result,) if isinstance(result, OrbitBranch) else tuple(result)
    if not branches:
        raise ValueError("result holds no branches; expected at least one")
    with style():
        figure, axes = subplots(3, 1, alt=_alt(branches), ax=ax, height=8.6, sharex=True)
        for number, (name, one) in enumerate(panels(axes)):
            for theory in beside:
                for piece in theory.pieces:
                    height = 1e3 * abs(getattr(piece, name))
                    one.plot(piece.frequency, height, color=GREY, linewidth=0.9, label="single-term theory")
            for branch, color in zip(branches, itertools.cycle(_COLORS), strict=False):
                _curve(one, branch, name, color)
            if circles is not None:
                height = 1e3 * np.abs(circles[1 + number])
                one.plot(circles[0], height, color="k", markersize=4, label=circles_label, **RIG)
        axes[-1].set_xlabel("frequency [Hz]")
        _frequencies(axes[-1], [point for branch in branches for point in branch.special_points])
        figure.align_ylabels(axes)
        legend(axes, ax=ax, title="stability: Floquet multipliers of the converged orbits", columns=3)
        return figure


def _curve(axes, branch, name, color):
    """A curve in runs of equal stability, its special points, and its inside if it is closed."""
    amplitude = 1e3 * abs(getattr(branch, name)[:, branch.period])
    if branch.closed:
        axes.fill(branch.frequency, amplitude, color=ORANGE, alpha=0.25, linewidth=0, label="detached curve")
    in_runs(axes, branch, amplitude, _title(branch), color=color)
    for point in branch.special_points:
        marker, edge = _MARKS[point.kind]
        look = {"color": edge, "markerfacecolor": "w", "markersize": 5, "linestyle": "none"}
        axes.plot(point.frequency, 1e3 * abs(getattr(point, name)), marker, label=point.kind, **look)


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


def harmonics_figure(result, *, ax=None):
    """Error of the orbits, and shift of the special points, over the number of harmonics: `HarmonicsWorth`."""
    alt = (
        "Two plots over the number of harmonics, logarithmic: the largest relative error of shaker, mass and relative "
        f"displacement along all curves, which falls from {result.error[0].max():.1e} to {result.error[-1].max():.1e}, "
        f"and the largest shift of a special point in hertz, from {result.shift[0]:.1e} to {result.shift[-1]:.1e}."
    )
    with style():
        figure, axes = subplots(1, 2, alt=alt, ax=ax, height=3.4)
        for column, (label, marker, color) in enumerate((("$x_s$", "o", BLUE), ("$x$", "s", GREEN), ("$z$", "^", RED))):
            axes[0].semilogy(result.harmonics, result.error[:, column], marker=marker, color=color, label=label)
        axes[0].set(xlabel="harmonics", ylabel="largest relative error")
        axes[0].legend()
        axes[1].semilogy(result.harmonics, result.shift, "o-", color="k")
        axes[1].set(xlabel="harmonics", ylabel="largest shift of a special point [Hz]")
        return figure
