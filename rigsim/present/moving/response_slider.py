"""The frequency response as it follows one parameter: a slider over curves computed beforehand."""

import numpy as np

from ... import checks
from ...orbits.branches import PeriodicOrbits
from ...theory.amplitude import FrequencyResponse
from ..figures.style import BLACK, BLUE, GREY, ORANGE, PANELS, PURPLE, circles_of
from .plot import Curve, MovingPlot, Panel

_COLORS = {"main": BLUE, "inner": ORANGE, "outer": PURPLE, "detached": ORANGE, "asymmetric": PURPLE}


def response_slider(name, values, unit, responses, *, alt=None, beside=None, circles=None, **options):
    """`MovingPlot` of the amplitudes of shaker, mass and relative displacement over frequency, as a parameter changes.

    Stable solutions are solid, unstable ones dashed (Floquet multipliers about their orbits); a detached curve has a
    colour of its own, and the sentence below the figure says where it lies.

    Parameters
    ----------
    name : str
        The parameter, as in "Force".
    values : array_like, shape (n,)
        Its values, in slider order.
    unit : str
    responses : sequence of FrequencyResponse or PeriodicOrbits
        n responses over the same band, one for each value.
    alt : str, optional
        What a reader who cannot see the figure should know; by default the band and where curves are detached.
    beside : FrequencyResponse, optional
        Drawn in grey at every value, for comparison.
    circles : tuple of four (k,) array_like, optional
        Frequency (Hz), shaker, mass and relative amplitudes (m, complex or real), drawn at every value; NaN leaves a
        circle out.
    **options
        ``start``, ``caption``, ``digits``, ``width``, ``height`` and ``seconds`` of `MovingPlot`.

    Raises
    ------
    ValueError
        If the numbers of values and responses differ.

    Examples
    --------
    >>> forces = np.linspace(1, 8, 29)
    >>> responses = [frequency_response(parameters, force, frequency) for force in forces]  # doctest: +SKIP
    >>> response_slider("Force", forces, "N", responses)  # doctest: +SKIP
    MovingPlot(Force: 29 values from 1.00 N to 8.00 N)
    """
    kinds = FrequencyResponse, PeriodicOrbits
    responses = tuple(checks.one_or_many("responses", responses, kinds, "FrequencyResponse or PeriodicOrbits"))
    if not responses:
        raise ValueError("responses is empty; expected one for each value")
    name, unit = checks.text("name", name), checks.text("unit", unit)
    values = checks.array(name, values, unit)
    beside = None if beside is None else checks.instance("beside", beside, kinds, "FrequencyResponse or PeriodicOrbits")
    circles = None if circles is None else circles_of(circles)
    reach = np.concatenate([piece.frequency for response in responses for _, piece in _pieces(response)])
    low, high = float(reach.min()), float(reach.max())
    notes = [_note(response) for response in responses]
    panels = []
    for number, (channel, title) in enumerate(PANELS):
        fixed = []
        if beside is not None:
            fixed += [Curve(curve.x, curve.y, curve.kind, "for comparison", GREY) for curve in _curves(beside, channel)]
        if circles is not None:
            fixed.append(Curve(circles[0], 1e3 * np.abs(circles[1 + number]), "point", "multi-body rig", BLACK))
        panels.append(
            Panel(
                [_curves(response, channel) for response in responses], "frequency [Hz]", "amplitude [mm]",
                title.capitalize(), yscale="log", xlim=(low, high), fixed=tuple(fixed),
            )
        )  # fmt: skip
    if alt is None:
        alt = (
            f"Three plots of amplitude in millimetres, logarithmic, over frequency from {low:g} to {high:g} hertz: "
            "shaker, suspended mass and relative displacement. Stable solutions are solid lines, unstable ones dashed; "
            "detached curves have a colour of their own."
        )
    options = {"width": 9.5, "height": 3.8} | options
    return MovingPlot(name, values, unit, panels, alt=alt, notes=notes, **options)


def _pieces(response):
    """(name, piece) of single-term theory, or (name, branch) of converged orbits; only the first may be "main"."""
    if hasattr(response, "pieces"):
        return [(piece.kind if piece.kind == "main" else f"{piece.kind} detached", piece) for piece in response.pieces]
    kinds = [("detached" if b.closed else "main") if b.symmetric else "asymmetric" for b in response]
    return list(zip(kinds, response, strict=True))


def _curves(response, channel):
    """Every piece as runs of equal stability, each reaching to where the next begins."""
    curves = []
    for name, piece in _pieces(response):
        lines = getattr(piece, channel)
        amplitude = 1e3 * np.abs(lines if lines.ndim == 1 else lines[:, piece.period])
        for run, stable in piece.runs:
            kind = "stable" if stable else "unstable"
            text = kind if name == "main" else f"{name} curve"
            curves.append(Curve(piece.frequency[run], amplitude[run], kind, text, _COLORS[name.split()[0]]))
    return curves


def _note(response):
    found = [
        f"{name} curve from {piece.frequency.min():.1f} to {piece.frequency.max():.1f} Hz"
        for name, piece in _pieces(response)
        if name != "main"
    ]
    who = "Single-term theory" if hasattr(response, "pieces") else "Converged orbits"
    return f"{who}: {', '.join(found) or 'no detached curve in this band'}."
