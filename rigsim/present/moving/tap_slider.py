"""What follows a tap, as its size grows: a slider over paths computed beforehand."""

import numpy as np

from ... import checks
from ...attraction.taps import TapMap
from ..figures.basins import motion_colors
from ..figures.style import BLACK
from .plot import Curve, MovingPlot, Panel

_SAMPLES = 16  # a period


def tap_slider(taps, instant=0.0, *, velocity=None, periods=24, **options):
    """The motion after taps of growing size at one instant, each in the colour of where it leads.

    On the left z over time from the first peak of the force after the tap; on the right the same path seen once a
    period, in the plane (z, z'), among the motions that last.

    Parameters
    ----------
    taps : TapMap
        Says what is tapped, and how long a tap lasts.
    instant : float
        When the pulse begins, in forcing periods after a peak of the force.
    velocity : (n,) array_like, optional
        Sizes (m/s); by default 33 from zero to the map's largest.
    periods : int
        Shown after the tap, 1 to 1000.
    **options
        ``start``, ``caption``, ``digits``, ``width`` and ``height`` of `MovingPlot`.

    Returns
    -------
    MovingPlot

    Raises
    ------
    ValueError
        If an argument is not allowed.
    """
    taps = checks.instance("taps", taps, TapMap, "a TapMap")
    periods = checks.integer("periods", periods, low=1, high=1000)  # a page holds them all
    found, names = taps.attractors, taps.attractors.names
    velocity = np.linspace(0, taps.velocity.max(), 33) if velocity is None else velocity
    velocity = checks.array("velocity", velocity, "m/s")
    label, paths = taps.paths(instant, velocity, periods, _SAMPLES)
    colors = motion_colors(found)
    time = np.arange(periods * _SAMPLES) / _SAMPLES
    over_time, once_a_period = [], []
    for path, reached in zip(paths, label, strict=True):
        color = colors[reached] if reached >= 0 else BLACK
        told = f"leads to '{names[reached]}'" if reached >= 0 else "leads nowhere"
        z, speed = 1e3 * path[:, 1], path[:, 3]
        over_time.append([Curve(time, z, "line", told, color)])
        seen = z[::_SAMPLES], speed[::_SAMPLES]
        once_a_period.append([Curve(*seen, "line", told, color), Curve(*seen, "dot", "", color)])
    lasting = tuple(
        Curve(1e3 * one.orbit[:, 1], one.orbit[:, 3], "point", f"motion '{name}'", color)
        for one, name, color in zip(found, names, colors, strict=True)
        if one.period
    )
    panels = (
        Panel(over_time, "forcing periods after the tap", "relative displacement z [mm]"),
        Panel(once_a_period, "z [mm]", "z' [m/s]", "seen at peaks of the force", fixed=lasting),
    )
    reached = [names[i] if i >= 0 else "nothing that lasts" for i in label]
    alt = (
        f"Two plots that follow the size of a tap on the motion {names[taps.motion]} at {found.flow.frequency:g} "
        f"hertz: relative displacement in millimetres over {periods} forcing periods, and the same path once a period "
        "in the plane of displacement and velocity. " + "; ".join(_runs(velocity, reached)) + "."
    )
    notes = [f"This tap leads to '{name}'." for name in reached]
    options = {"width": 9.5, "height": 4.2} | options
    return MovingPlot("Tap", velocity, "m/s", panels, alt=alt, notes=notes, **options)


def _runs(velocity, names):
    """Where taps lead, in words, one phrase for each run of sizes that lead to the same motion."""
    cuts = [0, *(i for i in range(1, len(names)) if names[i] != names[i - 1]), len(names)]
    return [
        f"{velocity[low]:.3g} to {velocity[high - 1]:.3g} metres a second lead to {names[low]}"
        for low, high in zip(cuts, cuts[1:], strict=False)
    ]
