"""The theory's response as artists that move, and what it shows in words."""

import numpy as np
from matplotlib.collections import PolyCollection

from ...theory.amplitude import frequency_response
from ...theory.detached import detached_curves, folds
from ..figures.style import BLUE, GREY, ORANGE, PURPLE, STABLE, UNSTABLE, log_scale

BAND = (5.0, 80.0)  # Hz
_FREQUENCIES = np.linspace(*BAND, 301)  # curves pass through their folds whatever the grid
_SHADES = {"inner": ORANGE, "outer": PURPLE}


class ResponseCurve:
    """The single-term response of one quantity on axes whose limits stay.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    """

    def __init__(self, axes):
        (self.before,) = axes.plot([], [], color=GREY, linewidth=0.8, animated=True, label="as at the start")
        self.shades = {
            kind: axes.add_collection(
                PolyCollection([], facecolor=color, alpha=0.3, animated=True, label=f"{kind} detached curve")
            )
            for kind, color in _SHADES.items()
        }
        (self.stable,) = axes.plot([], [], color=BLUE, animated=True, label="stable", **STABLE)
        (self.unstable,) = axes.plot([], [], color=BLUE, animated=True, label="unstable", **UNSTABLE)
        (self.folds,) = axes.plot([], [], "D", color=BLUE, markersize=4.5, animated=True, label="folds")
        log_scale(axes)
        axes.set(xlim=BAND, ylim=(0.003, 20.0), xlabel="frequency [Hz]", ylabel="amplitude [mm]")
        self._first = None

    def show(self, parameters, force, quantity="relative"):
        """Move to the response of ``parameters`` at ``force`` (N); ``quantity`` is "shaker", "mass" or "relative".

        Returns
        -------
        str
            What it shows, in words.
        """
        pieces = frequency_response(parameters, force, _FREQUENCIES).pieces
        words = response_in_words(parameters, force)
        self._first = pieces if self._first is None else self._first
        self.before.set_data(*_joined(self._first, quantity))
        self.stable.set_data(*_joined(pieces, quantity, True))
        self.unstable.set_data(*_joined(pieces, quantity, False))
        points = [fold for piece in pieces for fold in piece.folds]
        self.folds.set_data([p.frequency for p in points], [1e3 * abs(getattr(p, quantity)) for p in points])
        for kind, shade in self.shades.items():
            closed = [piece for piece in pieces if piece.closed and piece.kind == kind]
            shade.set_verts([np.column_stack([p.frequency, 1e3 * abs(getattr(p, quantity))]) for p in closed])
        return words


def _joined(pieces, quantity, stable=None):
    """Frequencies and amplitudes (mm) of the pieces, or of their stable or unstable runs, with NaN between them."""
    frequency, amplitude = [[np.nan]], [[np.nan]]
    for piece in pieces:
        height = 1e3 * np.abs(getattr(piece, quantity))
        for run in [run for run, kind in piece.runs if kind == stable] if stable is not None else [slice(None)]:
            frequency += [piece.frequency[run], [np.nan]]
            amplitude += [height[run], [np.nan]]
    return np.concatenate(frequency), np.concatenate(amplitude)


def response_in_words(parameters, force):
    """The detached curves and the jumps of the main curve at ``force`` (N), wherever they lie.

    Raises
    ------
    ValueError
        As `rigsim.theory.detached.folds`.
    """
    curves = detached_curves(parameters, force)
    ends = {end for curve in curves for end in (curve.low, curve.high)}
    jumps = [fold.frequency for fold in folds(parameters, force) if fold.frequency not in ends]
    listed = "; ".join(f"one {curve.kind} detached curve, {curve.low:.2f} to {curve.high:.2f} Hz" for curve in curves)
    met = " A sweep along the main curve never meets it." if len(curves) == 1 else ""
    jumping = f"jumps at {' and '.join(f'{f:.2f}' for f in jumps)} Hz" if jumps else "does not jump"
    return f"At {force:.4g} N: <b>{listed or 'no detached curve'}</b>.{met} The main curve {jumping}."
