"""Figure of subharmonic motions over the response to which they do not belong."""

import numpy as np

from ...parameters import oscillator_of
from ...theory.amplitude import frequency_response
from .style import BLACK, BLUE, GREEN, GREY, ORANGE, STABLE, UNSTABLE, style, subplots

_COLORS = {2: ORANGE, 3: GREEN}
_MARKERS = {2: "s", 3: "^"}


def subharmonics_figure(result):
    """Curves of period 2 and 3 with the single-term response: their line at f above, their tell-tale line below.

    Stable motions are solid and unstable ones dashed (converged orbits); folds are diamonds, markers are motions that
    the search met. The single-term response is grey. At f alone a subharmonic motion passes for a point of the low
    branch; below, the strongest line at f/2 or f/3 gives it away.

    Parameters
    ----------
    result : Subharmonics

    Returns
    -------
    matplotlib.figure.Figure
    """
    reach = [result.frequency.min(), result.frequency.max()]
    for family in result.families:
        reach += [family.branch.frequency.min(), family.branch.frequency.max()]
    low, high = min(reach) - 2, max(reach) + 2
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
        figure, (top, bottom) = subplots(2, 1, alt=alt, height=7.2, sharex=True)
        response = frequency_response(oscillator_of(result.parameters), result.force, np.linspace(low, high, 400))
        for number, piece in enumerate(response.pieces):
            text = None if number else "single-term response"
            top.plot(piece.frequency, 1e3 * np.abs(piece.relative), color=GREY, linewidth=1.0, label=text)
        named = set()
        for family in result.families:
            _curve(top, bottom, family, named)
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
        for ax in (top, bottom):
            ax.set(ylabel="amplitude (mm)", yscale="log")
            ax.yaxis.set_major_formatter("{x:g}")
        bottom.set(xlabel="frequency of the force (Hz)", xlim=(low, high))
        figure.legend(loc="outside lower center", ncols=3)
        return figure


def _curve(top, bottom, family, named):
    """A family in both panels, as runs of equal stability; ``named`` are the labels in the legend so far."""
    branch, period = family.branch, family.period
    below = np.abs(branch.relative)
    below[:, ::period] = 0.0
    heights = 1e3 * np.abs(branch.relative[:, period]), 1e3 * below.max(axis=1)
    color = _COLORS[period]
    for run in np.split(np.arange(branch.stable.size), np.flatnonzero(np.diff(branch.stable)) + 1):
        solid = bool(branch.stable[run[0]])
        end = slice(run[0], run[-1] + 2)
        text = f"period {period}, {'stable' if solid else 'unstable'}"
        label = None if text in named else text
        named.add(text)
        for ax, height in zip((top, bottom), heights, strict=True):
            ax.plot(branch.frequency[end], height[end], color=color, label=label, **(STABLE if solid else UNSTABLE))
            label = None
    at = list(branch.folds)
    for ax, height in zip((top, bottom), heights, strict=True):
        ax.plot(branch.frequency[at], height[at], "D", color=color, markersize=4.5)
