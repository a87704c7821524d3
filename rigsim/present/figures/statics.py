"""How rigs hang, over the tension of their wires and the offset of their mass, with one wire set and two."""

import numpy as np

from .rig_parts import SETS
from .style import BLUE, GREY, RED, legend, outer_labels, style, subplots

_LOOK = {1: {"color": RED, "marker": "s", "linestyle": "--"}, 2: {"color": BLUE, "marker": "o", "linestyle": "-"}}


def statics_figure(equilibrium, *, ax=None, points=25):
    """Tilt under gravity, rocking and bounce over the wires' tension and the mass's offset, with one set and two.

    The lower and the higher of the two modes are drawn, not "rocking" and "bounce": with two sets they change
    places as the offset grows. One set's wires are twice as stiff, so that k1 and k3 are equal. Where there is no
    stable equilibrium, or the rig cannot be built, a cross on the lower edge says so. The `StaticEquilibrium` is of a
    rig with one set or two, and the other rig follows from it; there are ``points`` rigs a curve.

    Raises
    ------
    ValueError
        If ``points`` is not a whole number of at least 2.
    """
    p, table = equilibrium.parameters, equilibrium.sweep(points)
    told = "; with ".join(
        f"{SETS[row['sets']]} tilts by {row['tilt [deg]']:.2g} degrees and rocks and bounces at "
        f"{row['lower [Hz]']:.3g} and {row['upper [Hz]']:.4g} Hz"
        for _, row in table[table["over"].isna()].iterrows()
    )
    alt = (
        "Tilt at rest, and the two frequencies at which the mass rocks and bounces, over the stretch of the wires and "
        f"over the offset of the centre of mass. This rig with {told}."
    )
    with style():
        figure, grid = subplots(2, 2, alt=alt, ax=ax, width=9.5, height=6.6, sharex="col", sharey="row")
        for column, over, label, unit, now in (
            (grid[:, 0], "stretch", "stretch of the wires d - d0 [µm]", 1e6, p.d - p.d0),
            (grid[:, 1], "offset", "offset of the centre of mass LG [mm]", 1e3, p.LG),
        ):
            for n, rows in table[table["over"] == over].groupby("sets"):
                value = unit * rows["value [m]"].to_numpy()
                look = _LOOK[n] | {"marker": "", "linewidth": 0.8}
                column[1].plot(value, rows["upper [Hz]"], **look, label=f"{SETS[n]}, higher mode")
                for axes, name in zip(column, ("tilt [deg]", "lower [Hz]"), strict=True):
                    axes.plot(value, rows[name], **_LOOK[n], markersize=3.5, label=SETS[n])
                    _mark_failed(axes, value[rows[name].isna()], n)
            for axes, text in zip(column, ("tilt at rest [°]", "rocking and bounce [Hz]"), strict=True):
                axes.axvline(unit * now, color=GREY, linewidth=1.0, linestyle=":", label="this rig")
                axes.set(xlabel=label, ylabel=text, yscale="log")
        if not p.gap:  # else a stretch below zero is shown, too, and no tension
            for axes in grid[:, 0]:
                axes.set_xscale("log")
            tension = p.double_set().wire_stiffness.mean() * 1e-6
            above = grid[0, 0].secondary_xaxis("top", functions=(lambda s: tension * s, lambda T: T / tension))
            above.set_xlabel("tension of a wire, two sets [N]; twice that with one")
        outer_labels(grid, ax=ax)
        legend(grid, ax=ax, columns=3)
    return figure


def _mark_failed(axes, value, sets):
    """Crosses on the lower edge, a little higher for two sets."""
    if value.size:
        axes.plot(
            value, np.full(value.size, 0.02 + 0.05 * (sets - 1)), "x", color=_LOOK[sets]["color"], clip_on=False,
            transform=axes.get_xaxis_transform(), label=f"{SETS[sets]}: none found",
        )  # fmt: skip
