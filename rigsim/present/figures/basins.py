"""Figures of the motions that last and which is reached: basins on a plane, maps of taps, integrity along a branch."""

import itertools

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from ... import checks
from ...attraction.integrity import Integrity
from ...attraction.taps import SmallestTap
from .style import BLACK, MOTIONS, OTHERS, legend, style, subplots

_MARKERS = "osD^vP*X"


def motion_colors(attractors):
    """A colour for each of the `Attractors`, as in every figure: the first of a name has its own, others follow."""
    return _colors(one.name for one in attractors)


def _colors(names):
    own, others = dict(MOTIONS), itertools.cycle(OTHERS)
    return [own.pop(name.partition(" 1/")[0], None) or next(others) for name in names]


def _where(flow):
    return f"at {flow.frequency:g} hertz and {flow.force:g} newtons"


def attractors_figure(result, *, ax=None):
    """The motions of `Attractors` in the plane (z, z'): their paths, and where they are when the force peaks."""
    flow = result.flow
    told = "; ".join(f"{name} up to {1e3 * one.amplitude:.3g}" for name, one in zip(result.names, result, strict=True))
    alt = f"Paths of the lasting motions {_where(flow)}, velocity of z over its displacement in millimetres: {told}."
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=5.2)
        for one, name, color in zip(result, result.names, motion_colors(result), strict=True):
            z, speed = one.path
            axes.plot(1e3 * z, speed, color=color, label=name if one.period else "")
            look = {"markerfacecolor": color, "markeredgecolor": BLACK, "label": "" if one.period else name}
            axes.plot(1e3 * one.orbit[:, 1], one.orbit[:, 3], "o" if one.period else ".", linestyle="none", **look)
        axes.set(xlabel="relative displacement z [mm]", ylabel="relative velocity z' [m/s]")
        axes.set_title(f"{flow.frequency:g} Hz, {flow.force:g} N: dots when the force peaks", loc="left")
        legend(axes, ax=ax, columns=3)
        return figure


def basins_figure(result, *, ax=None):
    """The plane (z, z') of `Basins`, the shaker on a named motion and the force at its peak, by the motion reached.

    Markers are where the motions themselves are at the peaks of the force; hollow ones have their shaker elsewhere, so
    that they lie above or below the plane.
    """
    flow, names = result.attractors.flow, result.attractors.names
    shares = "; ".join(
        f"{name} {100 * share:.1f} per cent ({100 * low:.1f} to {100 * high:.1f})"
        for name, share, low, high in zip(names, result.share, result.share_low, result.share_high, strict=True)
    )
    alt = (
        f"Map of the relative displacement and its velocity {_where(flow)}, shaker as on the motion "
        f"{names[result.motion]}, coloured by the motion reached. Shares of the box in four dimensions: {shares}."
    )
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=5.6)
        colors = _image(axes, result.attractors, result.label, 1e3 * result.z, result.speed)
        handles = []
        for one, color, marker in zip(result.attractors, colors, itertools.cycle(_MARKERS), strict=False):
            handle = [Patch(facecolor=color, edgecolor=BLACK)]
            if one.period:
                points = 1e3 * one.orbit[:, 1], one.orbit[:, 3]
                face = "white" if one.motion == result.motion else "none"
                handle += axes.plot(*points, marker, color=BLACK, markerfacecolor=face, markersize=7)
            handles.append(tuple(handle))
        labels = [f"{name}: {share:.1%} of the box" for name, share in zip(names, result.share, strict=True)]
        axes.set(xlabel="relative displacement z [mm]", ylabel="relative velocity z' [m/s]")
        title = f"{flow.frequency:g} Hz, {flow.force:g} N: shaker as on '{names[result.motion]}' when the force peaks"
        axes.set_title(title, loc="left")
        place = {"loc": "outside lower center", "ncols": 3} if ax is None else {}
        (figure if ax is None else axes).legend(handles, labels, **place)
        return figure


def tap_map_figure(result, *, ax=None, smallest=()):
    """Size of the tap over its instant, of a `TapMap`, coloured by the motion it leads to.

    ``smallest``, a `SmallestTap` or a sequence of them, are marked.
    """
    flow, names = result.attractors.flow, result.attractors.names
    marked = checks.one_or_many("smallest", smallest, SmallestTap, "a SmallestTap")
    reached = "; ".join(f"{name} by {100 * result.reached(i).mean():.1f} per cent" for i, name in enumerate(names))
    alt = (
        f"Map of taps on the motion {names[result.motion]} {_where(flow)}: velocity of the tap in metres a second "
        f"over its instant in forcing periods. Motions reached: {reached} of the taps."
    )
    if marked:
        alt += " Marked: " + "; ".join(f"smallest to {names[tap.target]}, {tap.velocity:.3g} m/s" for tap in marked)
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=5.2)
        colors = _image(axes, result.attractors, result.label, result.instant, result.velocity)
        for name, color in zip(names, colors, strict=True):
            axes.fill([], [], facecolor=color, edgecolor=BLACK, label=name)
        for tap, marker in zip(marked, itertools.cycle(_MARKERS), strict=False):
            look = {"color": BLACK, "markerfacecolor": "white", "markersize": 7}
            label = f"smallest to {names[tap.target]}: {tap.velocity:.3g} m/s"
            axes.plot(tap.instant, tap.velocity, marker, label=label, **look)
        axes.set(xlabel="begin of the tap [forcing periods after a peak of the force]", ylabel="tap velocity [m/s]")
        axes.set_title(f"{flow.frequency:g} Hz, {flow.force:g} N: taps on '{names[result.motion]}'", loc="left")
        legend(axes, ax=ax, columns=3)
        return figure


def _image(ax, attractors, label, x, y):
    """Labels as coloured cells centred on x and y, white where undecided; returns the motions' colours."""
    colors = motion_colors(attractors)
    half = [(values[-1] - values[0]) / (2 * max(len(values) - 1, 1)) for values in (x, y)]
    extent = (x[0] - half[0], x[-1] + half[0], y[0] - half[1], y[-1] + half[1])
    look = {"cmap": ListedColormap(colors).with_extremes(under="white"), "vmin": -0.5, "vmax": len(colors) - 0.5}
    ax.imshow(label, origin="lower", extent=extent, aspect="auto", interpolation="nearest", **look)
    ax.grid(False)
    return colors


def integrity_figure(result, *, ax=None, beside=()):
    """Radius of the largest ball of disturbances that a motion survives, over frequency.

    ``beside``, an `Integrity` or a sequence of them, adds further motions.
    """
    results = [result, *checks.one_or_many("beside", beside, Integrity, "an Integrity")]
    told = "; ".join(
        f"{one.branch} from {1e3 * np.nanmin(one.radius):.3g} to {1e3 * np.nanmax(one.radius):.3g} millimetres"
        for one in results
        if np.isfinite(one.radius).any()
    )
    alt = f"Radius of the largest surviving disturbance over frequency in hertz at {result.force:g} newtons: {told}."
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=4.2)
        colors = _colors(one.branch for one in results)
        for one, color, marker in zip(results, colors, itertools.cycle(_MARKERS), strict=False):
            f, told = one.frequency, f"of '{one.branch}'"
            axes.plot(f, 1e3 * one.radius, color=color, marker=marker, label=f"integrity {told}")
            axes.plot(f, 1e3 * one.amplitude, ":", color=color, linewidth=1.2, label=f"amplitude {told}")
        axes.set(xlabel="frequency [Hz]", ylabel="radius, amplitude of z [mm]", yscale="log")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.set_title(f"Dynamical integrity at {result.force:g} N (velocities over omega)", loc="left")
        legend(axes, ax=ax)
        return figure
