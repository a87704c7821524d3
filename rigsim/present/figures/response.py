"""Figures of what theory predicts: the paper's Fig. 6 and the ladder of force events."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from ...theory.detached import folds, force_scenario, interval_kind
from .style import BLUE, GREY, ORANGE, PURPLE, RIG, SKY, STABLE, UNSTABLE, style, subplots

_PANELS = (("shaker", "shaker $x_s$"), ("mass", "suspended mass $x$"), ("relative", "relative $z = x_s - x$"))
_SHADES = {"inner": ORANGE, "outer": PURPLE, "hysteresis": SKY}


def frequency_response_figure(
    result,
    *,
    label="single-term theory",
    beside=None,
    beside_label=None,
    circles=None,
    circles_label="multi-body rig",
    axes=None,
):
    """Amplitudes of shaker, mass and relative displacement over frequency, in the layout of the paper's Fig. 6.

    Stable solutions are solid and unstable ones dashed (Floquet multipliers about the single-term orbits, as in the
    paper), folds are diamonds and closed detached curves are shaded.

    Parameters
    ----------
    result : FrequencyResponse
    label : str
        Name of ``result`` in the legend.
    beside : FrequencyResponse, optional
        A second response, drawn thin and grey, with the name ``beside_label``.
    circles : tuple of four (k,) array_like, optional
        Frequency (Hz), shaker, mass and relative amplitudes (m, complex or real) drawn as circles, with the name
        ``circles_label``; NaN leaves a circle out.
    axes : sequence of three matplotlib.axes.Axes, optional
        Drawn into instead of a new figure; legend and text alternative are then the caller's.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If the shaker is undamped, since curves cannot then be joined.
    """
    with style():
        new = axes is None
        if new:
            figure, axes = subplots(3, 1, alt=_response_alt(result, circles is not None), height=8.2, sharex=True)
        else:
            figure = axes[0].figure
        for panel, ((name, title), ax) in enumerate(zip(_PANELS, axes, strict=True)):
            if beside is not None:
                _curves(ax, beside, name, GREY, beside_label, linewidth=1.0)
            _shade(ax, result, name)
            _curves(ax, result, name, BLUE, label)
            if circles is not None:
                ax.plot(
                    circles[0], 1e3 * np.abs(circles[1 + panel]), color="k", markersize=4, label=circles_label, **RIG
                )
            ax.set_yscale("log")
            ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            ax.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
            ax.yaxis.set_minor_formatter(NullFormatter())
            ax.set_ylabel("amplitude (mm)")
            ax.set_title(f"({'abc'[panel]}) {title}", loc="left")
        low, high = result.frequency.min(), result.frequency.max()
        if low < high:
            axes[-1].set_xlim(low, high)
        axes[-1].set_xlabel("frequency (Hz)")
        if new:
            figure.align_ylabels(axes)
            title = "stability: Floquet multipliers about the single-term orbit, as in the paper"
            handles, names = axes[-1].get_legend_handles_labels()
            figure.legend(handles, names, title=title, loc="outside lower center", ncols=2)
        return figure


def _curves(ax, response, name, color, label, **options):
    """Every piece as runs of equal stability, so that the line style changes where stability does."""
    named = set()
    for piece in response.pieces:
        amplitude = 1e3 * np.abs(getattr(piece, name))
        for run, solid in piece.runs:
            text = f"{label}, {'stable' if solid else 'unstable'}" if label and solid not in named else None
            named.add(solid)
            key = STABLE if solid else UNSTABLE
            ax.plot(piece.frequency[run], amplitude[run], color=color, label=text, **key, **options)
    points = [fold for piece in response.pieces for fold in piece.folds]
    text = f"{label}, folds" if label else None
    heights = [1e3 * abs(getattr(fold, name)) for fold in points]
    if points:
        ax.plot([fold.frequency for fold in points], heights, "D", color=color, markersize=4.5, label=text)


def _shade(ax, response, name):
    named = set()
    for piece in response.pieces:
        if piece.closed:
            text = None if piece.kind in named else f"{piece.kind} detached curve"
            named.add(piece.kind)
            amplitude = 1e3 * np.abs(getattr(piece, name))
            ax.fill(piece.frequency, amplitude, color=_SHADES[piece.kind], alpha=0.3, linewidth=0, label=text)


def _response_alt(result, circles):
    low, high = result.frequency.min(), result.frequency.max()
    parts = [
        f"{piece.kind} detached curve from {piece.frequency.min():.1f} to {piece.frequency.max():.1f} hertz"
        for piece in result.pieces
        if piece.closed
    ]
    text = (
        f"Three stacked plots of amplitude in millimetres, logarithmic, over frequency from {low:g} to {high:g} hertz "
        f"at {result.force:g} newtons: shaker, suspended mass and relative displacement. Stable solutions are solid "
        f"lines, unstable ones dashed. Closed detached curves: {'; '.join(parts) if parts else 'none in this band'}."
    )
    return text + (" Circles are the multi-body rig." if circles else "")


def force_scenario_figure(parameters, *, force=None, band=(5.0, 120.0)):
    """Where there are three solutions, over frequency and force: the ladder of births, mergers, splits and deaths.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float, optional
        Marked by a line (N).
    band : (float, float)
        Frequencies shown (Hz).

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If the shaker is undamped, or without cubic stiffness, when there is nothing to draw.
    """
    events = force_scenario(parameters)
    if not events:
        raise ValueError("k3 = 0 N/m^3 is not allowed here; expected cubic stiffness, for else nothing happens")
    listing = "; ".join(f"{event.kind} at {event.force:.3g} N and {event.frequency:.3g} Hz" for event in events)
    alt = f"Regions with three solutions over frequency (hertz) and force (newtons, logarithmic). Events: {listing}."
    with style():
        figure, ax = subplots(1, 1, alt=alt, height=5.5)
        edges = [0.5 * events[0].force, *(event.force for event in events), 3 * events[-1].force]
        # Denser at events, where regions end roundly; an event itself has no definite list of intervals.
        share = np.clip(np.sin(np.linspace(0, np.pi / 2, 40)) ** 2, 1e-9, 1 - 1e-9)
        named = set()
        for low, high in zip(edges, edges[1:], strict=False):
            _regions(ax, parameters, low * (high / low) ** share, named)
        for number, event in enumerate(events, 1):
            ax.plot(event.frequency, event.force, "o", color="k", markersize=5)
            ax.annotate(str(number), (event.frequency, event.force), xytext=(6, 4), textcoords="offset points")
        if force is not None:
            ax.axhline(force, color=BLUE, linestyle="-.", label=f"{force:g} N")
        ax.set(
            yscale="log", xlim=band, ylim=(edges[0], edges[-1]), xlabel="frequency (Hz)", ylabel="force amplitude (N)"
        )
        text = "\n".join(f"{i}  {event.force:.4g} N  {event.kind}" for i, event in enumerate(events, 1))
        figure.legend(loc="outside lower center", ncols=4)
        ax.set_title(text, loc="left", fontsize=9)
        return figure


def _regions(ax, parameters, forces, named):
    """Shade the intervals with three solutions at forces between two neighbouring events, where their list is one."""
    lists = [folds(parameters, force) for force in forces]
    for i in range(0, len(lists[0]), 2):
        kind = interval_kind(lists[0][i].kind, lists[0][i + 1].kind)
        label = (
            None
            if kind in named
            else {"hysteresis": "hysteresis of the main curve"}.get(kind, f"{kind} detached curve")
        )
        named.add(kind)
        ends = [[points[i + end].frequency for points in lists] for end in (0, 1)]
        ax.fill_betweenx(forces, *ends, color=_SHADES[kind], alpha=0.6, linewidth=0, label=label)
