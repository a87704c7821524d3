"""Figures of which motion is reached: basins on a plane, maps of taps, and integrity along a branch."""

import itertools

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from .style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, YELLOW, style, subplots

_KNOWN = {"low": SKY, "high": BLUE, "only": BLUE, "middle": RED, "aperiodic": GREY}
_OTHERS = (ORANGE, YELLOW, PURPLE, GREEN, RED)
_MARKERS = "osD^vP*X"


def motion_colors(attractors):
    """A colour for each motion, the same in every figure: those of the branches are fixed, others follow in turn.

    Parameters
    ----------
    attractors : sequence of Attractor

    Returns
    -------
    list of str
    """
    others = iter(_OTHERS * len(attractors))
    return [_KNOWN.get(one.name) or next(others) for one in attractors]


def basins_figure(result):
    """The plane (z, z') with the shaker on a named motion and the force at its peak, coloured by the motion reached.

    Markers are where the motions themselves are at the peaks of the force; hollow ones have their shaker elsewhere, so
    that they lie above or below the plane.

    Parameters
    ----------
    result : Basins

    Returns
    -------
    matplotlib.figure.Figure
    """
    flow = result.landscape.flow
    shares = "; ".join(
        f"{one.name} {100 * share:.1f} per cent ({100 * low:.1f} to {100 * high:.1f})"
        for one, share, low, high in zip(
            result.attractors, result.share, result.share_low, result.share_high, strict=True
        )
    )
    alt = (
        f"Map of the relative displacement and its velocity at {flow.frequency:g} hertz and {flow.force:g} newtons, "
        f"shaker as on the motion {result.around}, coloured by the motion reached. Shares of the box in four "
        f"dimensions: {shares}."
    )
    with style():
        figure, ax = subplots(1, 1, alt=alt, height=5.6)
        colors = _image(ax, result.attractors, result.label, 1e3 * result.z, result.speed)
        handles = []
        labels = []
        for one, color, marker, share in zip(
            result.attractors, colors, itertools.cycle(_MARKERS), result.share, strict=False
        ):
            handle = [Patch(facecolor=color, edgecolor=BLACK)]
            if one.period:
                points = 1e3 * one.orbit[:, 1], one.orbit[:, 3]
                face = "white" if one.name == result.around else "none"
                handle += ax.plot(*points, marker, color=BLACK, markerfacecolor=face, markersize=7)
            handles.append(tuple(handle))
            labels.append(f"{one.name}: {share:.1%} of the box")
        ax.set(xlabel="relative displacement z (mm)", ylabel="relative velocity z' (m/s)")
        ax.set_title(
            f"{flow.frequency:g} Hz, {flow.force:g} N: shaker as on '{result.around}' when the force peaks", loc="left"
        )
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
        return figure


def tap_map_figure(result, *, smallest=()):
    """Size of the tap over its instant, coloured by the motion it leads to.

    Parameters
    ----------
    result : TapMap
    smallest : SmallestTap or sequence of them
        Marked.

    Returns
    -------
    matplotlib.figure.Figure
    """
    flow = result.landscape.flow
    marked = smallest if isinstance(smallest, (tuple, list)) else (smallest,)
    reached = "; ".join(
        f"{one.name} by {100 * result.reached(one.name).mean():.1f} per cent" for one in result.attractors
    )
    alt = (
        f"Map of taps on the motion {result.start} at {flow.frequency:g} hertz and {flow.force:g} newtons: velocity of "
        f"the tap in metres a second over its instant in forcing periods. Motions reached: {reached} of the taps."
    )
    if marked:
        alt += " Marked: " + "; ".join(f"smallest to {tap.name}, {tap.velocity:.3g} m/s" for tap in marked) + "."
    with style():
        figure, ax = subplots(1, 1, alt=alt, height=5.2)
        colors = _image(ax, result.attractors, result.label, result.instant, result.velocity)
        handles = [
            Patch(facecolor=color, edgecolor=BLACK, label=one.name)
            for one, color in zip(result.attractors, colors, strict=True)
        ]
        for tap, marker in zip(marked, _MARKERS, strict=False):
            label = f"smallest to {tap.name}: {tap.velocity:.3g} m/s"
            handles += ax.plot(
                tap.instant, tap.velocity, marker, color=BLACK, markerfacecolor="white", markersize=7, label=label
            )
        ax.set(xlabel="begin of the tap (forcing periods after a peak of the force)", ylabel="tap velocity (m/s)")
        ax.set_title(f"{flow.frequency:g} Hz, {flow.force:g} N: taps on '{result.start}'", loc="left")
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
        return figure


def _image(ax, attractors, label, x, y):
    """Labels as coloured cells centred on x and y; returns the motions' colours."""
    colors = motion_colors(attractors)
    half = [(values[-1] - values[0]) / (2 * max(len(values) - 1, 1)) for values in (x, y)]
    extent = (x[0] - half[0], x[-1] + half[0], y[0] - half[1], y[-1] + half[1])
    ax.imshow(
        label, origin="lower", extent=extent, aspect="auto", interpolation="nearest", cmap=ListedColormap(colors),
        vmin=-0.5, vmax=len(colors) - 0.5,
    )  # fmt: skip
    ax.grid(False)
    return colors


def integrity_figure(result, *, beside=()):
    """Radius of the largest ball of disturbances that a motion survives, over frequency.

    Parameters
    ----------
    result : Integrity
    beside : Integrity or sequence of them
        Further motions in the same axes.

    Returns
    -------
    matplotlib.figure.Figure
    """
    results = [result, *(beside if isinstance(beside, (tuple, list)) else (beside,))]
    told = "; ".join(
        f"{one.name} from {1e3 * np.nanmin(one.radius):.3g} to {1e3 * np.nanmax(one.radius):.3g} millimetres"
        for one in results
        if np.isfinite(one.radius).any()
    )
    alt = f"Radius of the largest surviving disturbance over frequency in hertz at {result.force:g} newtons: {told}."
    with style():
        figure, ax = subplots(1, 1, alt=alt, height=4.2)
        for number, one in enumerate(results):
            color = (BLUE, ORANGE, GREEN, PURPLE)[number % 4]
            marker = _MARKERS[number % len(_MARKERS)]
            ax.plot(one.frequency, 1e3 * one.radius, color=color, marker=marker, label=f"integrity of '{one.name}'")
            ax.plot(
                one.frequency, 1e3 * one.amplitude, color=color, linestyle=":", linewidth=1.2,
                label=f"amplitude of '{one.name}'",
            )  # fmt: skip
        ax.set(xlabel="frequency (Hz)", ylabel="radius, amplitude of z (mm)", yscale="log")
        ax.yaxis.set_major_formatter("{x:g}")
        ax.set_title(f"Dynamical integrity at {result.force:g} N (velocities over omega)", loc="left")
        figure.legend(loc="outside lower center", ncols=2)
        return figure
