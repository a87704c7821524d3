"""Detached curves of an identified rig, and how likely they are."""

from ... import checks
from ...design.count import KINDS
from ...design.probability import curve_probability
from .style import BLACK, ORANGE, PURPLE, legend, log_scale, style, subplots

_LOOKS = {"inner": {"color": ORANGE, "linestyle": "-"}, "outer": {"color": PURPLE, "linestyle": "--"}}


def curve_probability_figure(result, *, ax=None, force=None):
    """Probability of an inner and of an outer detached curve over force; at ``force`` (N), if given, in words too."""
    force = None if force is None else checks.positive("force", force, "N")
    with style():
        there = "" if force is None else "; at {:g} N {:.0f} and {:.0f} percent".format(force, *_percent(result, force))
        figure, axes = subplots(alt=f"Probability over force. {result.summary()}{there}.", ax=ax, height=3.4)
        for kind in KINDS:
            axes.plot(result.force, 100 * getattr(result, kind), label=f"{kind} detached curve", **_LOOKS[kind])
        if force is not None:
            axes.axvline(force, color=BLACK, linestyle=":", label=f"{force:g} N")
        log_scale(axes, (1, 2, 5), "x")
        axes.set(xlabel="force [N]", ylabel="probability [%]", ylim=(-3, 103), xlim=result.force[[0, -1]])
        legend(axes, ax=ax, columns=3)
        return figure


def detached_probability_figure(identification, *, ax=None, force=None):
    """The `curve_probability_figure` of an identified rig; ``force`` (N) is one to mark.

    Raises
    ------
    ValueError
        If the identification has no errors.
    """
    return curve_probability_figure(curve_probability(identification, force), ax=ax, force=force)


def _percent(result, force):
    return [100 * share for share in result.at(force)]
