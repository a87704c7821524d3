"""Figures of the response sheet: over frequency and force, folded, and over frequency and amplitude, with contours."""

import numpy as np

from .style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, in_runs, legend, log_scale, style, subplots

_LOOKS = {
    "fold": (BLUE, "-"),
    "symmetry breaking": (GREEN, "-"),
    "period doubling": (PURPLE, "-"),
    "Neimark-Sacker": (RED, ":"),
}


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
            axes.plot(locus.frequency, locus.force, color=color, linestyle=line, linewidth=1.2, label=name)
        for number, event in enumerate(events, 1):
            axes.plot(event.frequency, event.force, "o", color="k", markersize=5)
            axes.annotate(str(number), (event.frequency, event.force), xytext=(6, 4), textcoords="offset points")
        if force is not None:
            axes.axhline(force, color=ORANGE, linestyle="-.", label=f"{force:g} N")
        axes.set(yscale="log", xlim=sheet.band, ylim=sheet.force, xlabel="frequency [Hz]", ylabel="force amplitude [N]")
        legend(axes, ax=ax, columns=3)
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
    forces = np.geomspace(low, high, 9)[1:-1] if forces is None else np.atleast_1d(forces)
    told = ", ".join(f"{force:.3g}" for force in forces)
    alt = (
        "Amplitude of the relative displacement in millimetres, logarithmic, over frequency in hertz: response curves "
        f"at {told} newtons, stable ones solid and unstable ones dashed, and the lines along which they fold."
    )
    colors = (SKY, BLUE, GREEN, ORANGE, RED, PURPLE, "k")
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=5.5)
        for number, force in enumerate(forces):
            for branch in result.at(float(force)):
                height = 1e3 * abs(branch.relative[:, branch.period])
                in_runs(axes, branch, height, f"{force:.3g} N", color=colors[number % len(colors)], linewidth=1.2)
        for name, locus in result.lines:
            if locus.kind == "fold":
                axes.plot(locus.frequency, 1e3 * locus.amplitude, color=GREY, linewidth=1, label=f"{name} line")
        axes.set(xlim=result.band, xlabel="frequency [Hz]", ylabel="amplitude of z [mm]")
        log_scale(axes, (1, 2, 5))
        legend(axes, ax=ax, columns=3)
        return figure
