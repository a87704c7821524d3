"""Figures of the response sheet: over frequency and force, folded, and over frequency and amplitude, with contours."""

import numpy as np

from ... import checks
from ...design.variation import quantity
from .style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, in_runs, legend, log_scale, style, subplots

_LOOKS = {
    "fold": (BLUE, "-"),
    "symmetry breaking": (GREEN, "-"),
    "period doubling": (PURPLE, "-"),
    "Neimark-Sacker": (RED, ":"),
}

_LISTED = 16  # events that are named above the picture; of more the table tells


def sheet_figure(result, *, ax=None, force=None):
    """Fold lines and lines where stability is lost over frequency and force, events marked and numbered.

    Parameters
    ----------
    result : ResponseSheet or ConvergedScenario
        Of the latter single-term theory's regions with three solutions are drawn in grey behind.
    ax : axes, optional
    force : float, optional
        A force (N) to be marked, as of a test.
    """
    force = None if force is None else checks.positive("force", force, "N")
    sheet = getattr(result, "sheet", result)
    events = tuple(result) if sheet is not result else sheet.events
    listing = "; ".join(f"{event.kind} at {event.force:.4g} N and {event.frequency:.4g} Hz" for event in events)
    names = ", ".join(sorted({name for name, _ in sheet.lines}))
    alt = f"Lines over frequency (hertz) and force (newtons, logarithmic): {names}. Events: {listing}."
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=5.5)
        if sheet is not result:
            for _, forces, low, high in result.single_term.regions:
                text = "three solutions of single-term theory"
                axes.fill_betweenx(forces, low, high, color=GREY, alpha=0.2, linewidth=0, label=text)
        for name, locus in sheet.lines:
            color, line = _LOOKS[locus.kind]
            line = line if name == locus.kind else "--"
            force_there = _shown(sheet, locus, locus.force)
            if np.isfinite(force_there).any():
                axes.plot(locus.frequency, force_there, color=color, linestyle=line, linewidth=1.2, label=name)
        for number, event in enumerate(events, 1):
            axes.plot(event.frequency, event.force, "o", color="k", markersize=5)
            axes.annotate(str(number), (event.frequency, event.force), xytext=(6, 4), textcoords="offset points")
        if force is not None:
            axes.axhline(force, color=ORANGE, linestyle="-.", label=f"{force:g} N")
        axes.set(yscale="log", xlim=sheet.band, ylim=sheet.force, xlabel="frequency [Hz]", ylabel="force amplitude [N]")
        legend(axes, ax=ax, columns=3)
        if len(events) <= _LISTED:
            text = "\n".join(f"{i}  {event.force:.5g} N  {event.kind}" for i, event in enumerate(events, 1))
            axes.set_title(text, loc="left", fontsize=8)
        return figure


def sheet_amplitude_figure(result, *, ax=None, forces=None):
    """The sheet from above: contours at some forces over frequency and amplitude of z, fold lines and events on it.

    Parameters
    ----------
    result : ResponseSheet
    ax : axes, optional
    forces : sequence of float, optional
        N; by default seven over the sheet's range.
    """
    low, high = result.force
    if forces is None:
        forces = np.geomspace(low, high, 9)[1:-1]
    forces = checks.array("forces", forces, "N", low=low, high=high)
    told = ", ".join(f"{force:.3g}" for force in forces)
    alt = (
        "Amplitude of the relative displacement in millimetres, logarithmic, over frequency in hertz: response curves "
        f"at {told} newtons, stable ones solid and unstable ones dashed, and the lines along which they fold."
    )
    colors = (SKY, BLUE, GREEN, ORANGE, RED, PURPLE, "k")
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=5.5)
        for number, force in enumerate(forces):
            color = colors[number % len(colors)]
            axes.plot([], [], color=color, label=f"{force:.3g} N")
            for branch in result.at(float(force)):
                in_runs(axes, branch, 1e3 * abs(branch.relative[:, branch.period]), None, color=color, linewidth=1.2)
        for name, locus in result.lines:
            height = _shown(result, locus, 1e3 * locus.amplitude)
            if locus.kind == "fold" and np.isfinite(height).any():
                axes.plot(locus.frequency, height, color=GREY, linewidth=1, label=f"{name} line")
                points = np.array([y for y, _, _ in locus.stationary]).reshape(-1, locus.points.shape[1])
                frequency, force, amplitude = locus.sheet.shown(points)
                inside = (force >= low) & (force <= high)
                look = {"color": "k", "markersize": 5, "linestyle": "none", "label": "pieces come, join or go"}
                axes.plot(frequency[inside], 1e3 * amplitude[inside], "o", **look)
        axes.set(xlim=result.band, xlabel="frequency [Hz]", ylabel="amplitude of z [mm]")
        log_scale(axes, (1, 2, 5))
        legend(axes, ax=ax, columns=4, title="stable orbits solid, unstable ones dashed")
        return figure


def _shown(sheet, locus, values):
    """Values along a line, NaN outside the sheet's band and forces."""
    (low, high), (least, most) = sheet.band, sheet.force
    inside = (low <= locus.frequency) & (locus.frequency <= high) & (least <= locus.force) & (locus.force <= most)
    return np.where(inside, values, np.nan)


def event_curves_figure(result, *, ax=None, force=None):
    """Forces of converged events over one number of the rig: curves between which its pieces come and go.

    Parameters
    ----------
    result : EventCurves
    ax : axes, optional
    force : float, optional
        A force (N) to be marked.
    """
    force = None if force is None else checks.positive("force", force, "N")
    names = ", ".join(event.kind for event in result.events)
    alt = f"Forces in newtons, logarithmic, over {result.name}, at which these events happen: {names}."
    colors = (SKY, BLUE, GREEN, ORANGE, RED, PURPLE, "k")
    item = quantity(result.parameters, 1.0, result.name)
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=4.5)
        for number, (event, forces) in enumerate(zip(result.events, result.force.T, strict=True)):
            look = {"color": colors[number % len(colors)], "label": f"{number + 1} {event.kind}"}
            axes.plot(item.factor * result.values, forces, **look)
        axes.axvline(item.factor * result.own, color=GREY, linewidth=0.9, label="this rig")
        if force is not None:
            axes.axhline(force, color=ORANGE, linestyle="-.", label=f"{force:g} N")
        log_scale(axes, (1, 2, 5))
        axes.ticklabel_format(axis="x", useOffset=False)
        axes.set(xlabel=f"{result.name} [{item.shown_unit}]", ylabel="force amplitude [N]")
        legend(axes, ax=ax, columns=3)
        return figure
