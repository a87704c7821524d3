"""Figure of subharmonic motions over the response to which they do not belong."""

import numpy as np

from .style import BLACK, BLUE, GREEN, GREY, ORANGE, in_runs, legend, style, subplots

_COLORS = {2: ORANGE, 3: GREEN}
_MARKERS = {2: "s", 3: "^"}


def subharmonics_figure(result, *, ax=None):
    """`Subharmonics`: curves of period 2 and 3 with the single-term response, line at f above, tell-tale line below.

    Stable motions are solid and unstable ones dashed (converged orbits); folds are diamonds, markers are motions that
    the search met. The single-term response is grey. At f alone a subharmonic motion passes for a point of the low
    branch; below, the strongest line at f/2 or f/3 gives it away.
    """
    low, high = result.band
    told = "; ".join(
        f"period {one.period} from {one.branch.frequency.min():.1f} to {one.branch.frequency.max():.1f} hertz"
        for one in result.families
    )
    alt = (
        f"Two stacked plots of the amplitude of z in millimetres, logarithmic, over frequency from {low:.0f} to "
        f"{high:.0f} hertz at {result.force:g} newtons: the line at the force's frequency beside the single-term "
        f"response, and the strongest line below it. Curves of subharmonic motions: {told or 'none'}."
    )
    with style():
        figure, (top, bottom) = subplots(2, 1, alt=alt, ax=ax, height=7.2, sharex=True)
        for piece in result.response.pieces:
            look = {"color": GREY, "linewidth": 1.0, "label": "single-term response"}
            top.plot(piece.frequency, 1e3 * np.abs(piece.relative), **look)
        for family in result.families:
            _curve(top, bottom, family)
        for period in sorted({one.period for one in result.motions}):
            met = [one for one in result.motions if one.period == period]
            f = [one.frequency for one in met]
            edge = BLACK if period in _COLORS else BLUE
            look = {"linestyle": "none", "marker": _MARKERS.get(period, "x"), "markersize": 5, "markeredgecolor": edge}
            look["color"] = _COLORS.get(period, BLUE)
            top.plot(f, [1e3 * abs(one.relative[one.period]) for one in met], label=f"met, period {period}", **look)
            bottom.plot(f, [1e3 * one.giveaway[1] for one in met], **look)
        top.set_title("(a) line of z at the force's frequency", loc="left")
        bottom.set_title("(b) strongest line of z off its multiples", loc="left")
        for axes in (top, bottom):
            axes.set(ylabel="amplitude [mm]", yscale="log")
            axes.yaxis.set_major_formatter("{x:g}")
        bottom.set(xlabel="frequency of the force [Hz]", xlim=(low, high))
        legend((top, bottom), ax=ax, columns=3)
        return figure


def _curve(top, bottom, family):
    """A family in both panels, as runs of equal stability."""
    branch, period, color = family.branch, family.period, _COLORS[family.period]
    below = np.abs(branch.relative)
    below[:, ::period] = 0.0
    at = list(branch.folds)
    for axes, height in (top, 1e3 * np.abs(branch.relative[:, period])), (bottom, 1e3 * below.max(axis=1)):
        in_runs(axes, branch, height, f"period {period}", color=color)
        axes.plot(branch.frequency[at], height[at], "D", color=color, markersize=4.5)
