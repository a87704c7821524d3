"""How sure the parameters of an identification are."""

import numpy as np

from .residuals import checked
from .style import BLACK, BLUE, GREY, ORANGE, PURPLE, style, subplots

_BEYOND = 30.0  # half-widths: what is further off stands on the edge


def parameter_figure(identification, *, ax=None):
    """95 % intervals of the parameters, least possible ones beside; and how far H_E's reading and what is nominal are.

    On the left the half-width of each interval, relative to the value, over the least that any unbiased reading could
    have (Cramer-Rao). On the right, in half-widths, where the parameters that H_E alone gives lie, and the nominal ones
    where they are known. The second way is not the surer one: under noise it may lie outside the interval.

    Raises
    ------
    ValueError
        If the identification is by one of the paper's readings, which have no errors.
    """
    errors = checked(identification).errors
    size = np.where(errors.value == 0, np.nan, np.abs(errors.value))
    wide, least = 100 * errors.half_width / size, 100 * 1.96 * errors.bound / size
    rows = np.arange(len(errors.names))
    told = ", ".join(f"{name} {share:.2g} percent" for name, share in zip(errors.names, wide, strict=True))
    with style():
        alt = f"Half-widths of the 95 percent intervals: {told}; and how far other readings of the parameters are off."
        figure, (left, right) = subplots(
            1, 2, alt=alt, ax=ax, width=9.5, height=1.8 + 0.4 * rows.size, width_ratios=(1, 1)
        )
        left.barh(rows, wide, height=0.5, color=BLUE, alpha=0.7, label="95 % interval, ±")
        left.plot(least, rows, "|", color=BLACK, markersize=14, markeredgewidth=2, label="least possible")
        for row, share in enumerate(wide):
            left.text(share, row, f" {share:.2g} %" if share > 0 else "", va="center", fontsize=8)
        known = np.concatenate([wide, least])
        known = known[np.isfinite(known) & (known > 0)]
        low, high = (known.min(), known.max()) if known.size else (1.0, 1.0)
        left.set(xscale="log", xlim=(low / 3, 10 * high), xlabel="of the value [%]")
        right.axvspan(-1, 1, color=GREY, alpha=0.35, linewidth=0, label="95 % interval")
        right.axvline(0, color=BLUE)
        for parameters, look, label in (
            (identification.read, {"marker": "s", "color": PURPLE}, "read from H_E alone"),
            (identification.nominal, {"marker": "D", "color": ORANGE}, "nominal"),
        ):
            if parameters is not None:
                off = _offsets(errors, parameters)
                right.plot(off, rows[: off.size], linestyle="none", label=label, markerfacecolor="none", **look)
        right.set_xscale("symlog", linthresh=1, linscale=0.8)
        right.set(xlim=(-1.2 * _BEYOND, 1.2 * _BEYOND), xlabel="off by [half-widths]")
        right.set_xticks([-30, -10, -3, -1, 0, 1, 3, 10, 30], ["≤−30", "−10", "−3", "−1", "0", "1", "3", "10", "≥30"])
        right.set_xticks([], minor=True)
        for axis in (left, right):
            axis.set_yticks(rows, errors.names)
            axis.set_ylim(rows.size - 0.4, -0.6)
            axis.grid(False, axis="y")
            handles = axis.get_legend_handles_labels()
            axis.legend(*handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, fontsize=8)
        return figure


def _offsets(errors, parameters):
    """Of other parameters from the values, in half-widths, those far off at the edge."""
    others = np.array([getattr(parameters, name) for name in errors.names if hasattr(parameters, name)])
    width = np.where(errors.half_width > 0, errors.half_width, np.nan)[: others.size]  # on a base the first mass is 1
    return np.clip((others - errors.value[: others.size]) / width, -_BEYOND, _BEYOND)
