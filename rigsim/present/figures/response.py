"""Figures of what theory predicts: the paper's Fig. 6 and the ladder of force events."""

import numpy as np

from ... import checks
from ...theory.amplitude import FrequencyResponse
from .style import BLUE, GREY, ORANGE, PURPLE, SKY, in_runs, legend, outer_labels, panels, style, subplots

_SHADES = {"inner": ORANGE, "outer": PURPLE, "hysteresis": SKY}


def frequency_response_figure(
    result, *, ax=None, label="single-term theory", beside=(), beside_label=None, key=True
):  # fmt: skip
    """Amplitudes of shaker, mass and relative displacement over frequency, in the layout of the paper's Fig. 6.

    Stable solutions are solid and unstable ones dashed (Floquet multipliers about the single-term orbits, as in the
    paper), folds are diamonds and closed detached curves are shaded.

    Parameters
    ----------
    result : FrequencyResponse
    ax : sequence of three axes, optional
    label : str
        Name of ``result`` in the legend.
    beside : FrequencyResponse or sequence of them, optional
        Other responses, drawn thin and grey, with the name ``beside_label``.
    beside_label : str, optional
    key : bool
        Whether to draw the legend.

    Raises
    ------
    ValueError
        If the shaker is undamped, since curves cannot then be joined.
    """
    beside = checks.one_or_many("beside", beside, FrequencyResponse, "a FrequencyResponse")
    label, key = checks.text("label", label), checks.flag("key", key)
    beside_label = None if beside_label is None else checks.text("beside_label", beside_label)
    with style():
        figure, axes = subplots(3, 1, alt=_response_alt(result), ax=ax, height=8.2, sharex=True)
        low, high = result.frequency.min(), result.frequency.max()
        for name, one in panels(axes):
            for other in beside:
                _curves(one, other, name, GREY, beside_label, linewidth=1.0)
            _shade(one, result, name)
            _curves(one, result, name, BLUE, label)
            one.set_xlabel("frequency [Hz]")
            if low < high:
                one.set_xlim(low, high)
        outer_labels(axes, ax=ax)
        if key:
            legend(axes, ax=ax, title="stability: Floquet multipliers about the single-term orbit, as in the paper")
        return figure


def detached_curves_figure(result, *, ax=None, **options):
    """The `frequency_response_figure`, with its options, of the response over all of `DetachedCurves` or `Folds`."""
    return frequency_response_figure(result.response, ax=ax, **options)


def _curves(axes, response, name, color, label, **options):
    """Every piece as runs of equal stability, so that the line style changes where stability does."""
    for piece in response.pieces:
        in_runs(axes, piece, 1e3 * np.abs(getattr(piece, name)), label, color=color, **options)
    points = [fold for piece in response.pieces for fold in piece.folds]
    text = f"{label}, folds" if label else None
    heights = [1e3 * abs(getattr(fold, name)) for fold in points]
    if points:
        axes.plot([fold.frequency for fold in points], heights, "D", color=color, markersize=4.5, label=text)


def _shade(axes, response, name):
    for piece in response.pieces:
        if piece.closed:
            text, amplitude = f"{piece.kind} detached curve", 1e3 * np.abs(getattr(piece, name))
            axes.fill(piece.frequency, amplitude, color=_SHADES[piece.kind], alpha=0.3, linewidth=0, label=text)


def _response_alt(result):
    low, high, closed = result.frequency.min(), result.frequency.max(), "; ".join(closed_curves(result))
    return (
        f"Three stacked plots of amplitude in millimetres, logarithmic, over frequency from {low:g} to {high:g} hertz "
        f"at {result.force:g} newtons: shaker, suspended mass and relative displacement. Stable solutions are solid "
        f"lines, unstable ones dashed. Closed detached curves: {closed or 'none in this band'}."
    )


def closed_curves(response):
    """Where closed detached curves lie, in words, a list."""
    return [
        f"{piece.kind} detached curve from {piece.frequency.min():.1f} to {piece.frequency.max():.1f} hertz"
        for piece in response.pieces
        if piece.closed
    ]


def force_scenario_figure(result, *, ax=None, force=None, band=(5.0, 120.0)):
    """Where there are three solutions, over frequency and force: the ladder of births, mergers, splits and deaths.

    Of a `ForceScenario`; a line marks ``force`` (N), and ``band`` is what is shown (Hz).

    Raises
    ------
    ValueError
        Without cubic stiffness, when there is nothing to draw.
    """
    if not result:
        raise ValueError("k3 = 0 N/m^3 is not allowed here; expected cubic stiffness, for else nothing happens")
    band = checks.pair("band", band, "Hz", low_open=False)
    force = None if force is None else checks.positive("force", force, "N")
    listing = "; ".join(f"{event.kind} at {event.force:.3g} N and {event.frequency:.3g} Hz" for event in result)
    alt = f"Regions with three solutions over frequency (hertz) and force (newtons, logarithmic). Events: {listing}."
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=5.5)
        for kind, forces, low, high in result.regions:
            text = "hysteresis of the main curve" if kind == "hysteresis" else f"{kind} detached curve"
            axes.fill_betweenx(forces, low, high, color=_SHADES[kind], alpha=0.6, linewidth=0, label=text)
        for number, event in enumerate(result, 1):
            axes.plot(event.frequency, event.force, "o", color="k", markersize=5)
            axes.annotate(str(number), (event.frequency, event.force), xytext=(6, 4), textcoords="offset points")
        if force is not None:
            axes.axhline(force, color=BLUE, linestyle="-.", label=f"{force:g} N")
        ylim = 0.5 * result[0].force, 3 * result[-1].force
        axes.set(yscale="log", xlim=band, ylim=ylim, xlabel="frequency [Hz]", ylabel="force amplitude [N]")
        text = "\n".join(f"{i}  {event.force:.4g} N  {event.kind}" for i, event in enumerate(result, 1))
        legend(axes, ax=ax, columns=4)
        axes.set_title(text, loc="left", fontsize=9)
        return figure
