"""What a test under feedback gives: the motions that were held, one by one, and the response curve among them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ... import checks
from ...parameters import OscillatorParameters, RigParameters
from ...results import Result, ResultSequence, Status, counted, frame
from ..kept import Kept
from ..record import Record
from .contour import MeasuredResponse, contour, fold_levels


@dataclass(frozen=True, eq=False, repr=False)
class HeldMotion(Result):
    """A motion that a loop was to hold at a frequency, and what was read of it.

    Attributes
    ----------
    frequency, amplitude : float
        Of the force (Hz), and of z as asked for (m).
    shaker, mass : ndarray, complex, shape (11,)
        Mean and lines of xs and x at the multiples of the frequency (m), as the sensors told them, by least squares
        over whole periods; phases against z's target. NaN where nothing was tried.
    force, feedback : ndarray, complex, shape (11,)
        Mean and lines of the whole force that acted, held from sample to sample, and of the feedback's part (N).
    invasive : float
        Largest line of the feedback other than that at the frequency, over the force's there.
    drift : float
        Change of z's line from the window's first half to its second, over their mean.
    gains : ndarray, shape (4,)
        P and D of xs, then of x (N/m, N s/m).
    loop : float
        Largest multiplier of the loop as designed, for the target's amplitude and a tenth more or less.
    multipliers : ndarray, complex, shape (4,)
        Floquet multipliers of the rig without feedback, largest first, estimated: of the design's model with the
        `suspension`, linearised about the motion as it was read. NaN for what was not held.
    suspension : ndarray, shape (3,)
        c, k1 and k3 (N s/m, N/m, N/m^3) as the motions held at this frequency tell them, by least squares on the
        mass's equation; the design's, where none was.
    misfit : float
        What the design's own suspension leaves of the mass's inertia force at the frequency, over that force.
    segments : int
        Targets it took.
    status : Status
        Held; or invasive, still drifting, lost, flew apart, untried.
    message : str
    begin : float
        When the window began (s).
    trace : ndarray or None, shape (3, samples)
        Force (N), xs and x (m) in the window.
    sample_rate : float
        Hz.
    parameters : RigParameters
    """

    frequency: float
    amplitude: float
    shaker: np.ndarray
    mass: np.ndarray
    force: np.ndarray
    feedback: np.ndarray
    invasive: float
    drift: float
    gains: np.ndarray
    loop: float
    multipliers: np.ndarray
    suspension: np.ndarray
    misfit: float
    segments: int
    status: Status
    message: str
    begin: float
    trace: np.ndarray | None
    sample_rate: float
    parameters: RigParameters

    plots = {"record": "held_motion_figure"}

    @property
    def relative(self):
        """Mean and lines of z (11,), complex (m)."""
        return self.shaker - self.mass

    @property
    def stable(self):
        """Whether all `multipliers` are inside the unit circle."""
        return bool(abs(self.multipliers[0]) < 1)

    def to_record(self):
        """The last window as a `Record` with its force as it was held. `ValueError` if nothing was tried."""
        if self.trace is None:
            raise ValueError(f"status = {self.status} has no window; expected a motion that was tried")
        known = {"parameters": self.parameters}
        return Record(*self.trace, self.sample_rate, "zero", **known)

    def summary(self):
        """One line: where, what was found, and how it ended."""
        return (
            f"HeldMotion at {self.frequency:g} Hz: z {1e3 * abs(self.relative[1]):.4g} mm at "
            f"{abs(self.force[1]):.4g} N, {self.status}: {self.message}"
        )


@dataclass(frozen=True, eq=False, repr=False)
class FeedbackTest(Kept, ResultSequence):
    """What `feedback_test` returns: `HeldMotion` after `HeldMotion`, in order of frequency and amplitude asked for.

    Attributes
    ----------
    members : tuple of HeldMotion
    parameters : RigParameters
    model : OscillatorParameters
        What the gains were designed from, and targets stepped by.
    force : float
        N, up to which the sweeps were to reach.
    feedback : {"both", "mass", "relative"}
    sample_rate : float
        Hz.
    delay : int
        Samples.
    noise : tuple of float
        Of the sensors: share of each signal's rms, and m.
    segment_time : float
        How long a target and its reading take (s).
    """

    members: tuple
    parameters: RigParameters
    model: OscillatorParameters
    force: float
    feedback: str
    sample_rate: float
    delay: int
    noise: tuple
    segment_time: float

    plots = {"s-curves": "s_curves_figure", "sheet": "measured_sheet_figure", "invasiveness": "invasiveness_figure"}

    @cached_property
    def frequency(self):
        """Frequencies (Hz), each once, ascending."""
        return np.unique([one.frequency for one in self])

    @property
    def bench_time(self):
        """What one bench would need for it, shaking at one frequency after the other (s)."""
        return self.segment_time * sum(one.segments for one in self)

    def held(self, frequency):
        """Tuple of the motions held at a frequency (Hz), ascending in amplitude."""
        frequency = checks.one_of("frequency", float(checks.positive("frequency", frequency, "Hz")), self._known)
        held = [one for one in self if one.frequency == frequency and one.status is Status.HELD]
        return tuple(sorted(held, key=lambda one: abs(one.relative[1])))

    @property
    def _known(self):
        return tuple(self.frequency.tolist())

    def at(self, force):
        """`MeasuredResponse`: the response curve at a force (N), where the held motions pass it.

        At each frequency a spline through what was held over the amplitude of z tells it, unless a motion in between
        was not held; folds are where a spline over frequency through the largest, or least, force of each S-curve
        passes the force. No model is in this, but for the stability (`HeldMotion.multipliers`).
        """
        force = checks.positive("force", force, "N")
        most = max((abs(one.force[1]) for one in self if one.status is Status.HELD), default=0.0)
        if force > most:
            raise ValueError(f"force = {force:g} N is not allowed; expected at most {most:.4g} N, that motions took")
        curves = {f: (self.held(f), self._gaps(f)) for f in self._known}
        motions, folds = contour(self.model, curves, force)
        return MeasuredResponse(motions, folds, force, self)

    @cached_property
    def fold_levels(self):
        """Dict of "largest" and "least" to (frequency, amplitude, force) arrays, NaN where an S-curve has no fold."""
        return fold_levels({f: (self.held(f), self._gaps(f)) for f in self._known})

    def _gaps(self, frequency):
        """Amplitudes asked for that were not held."""
        return [one.amplitude for one in self if one.frequency == frequency and one.status is not Status.HELD]

    def summary(self):
        """One line: how many motions, how many of each status, and the bench's time."""
        told = counted(one.status for one in self)
        low, high = self.frequency[0], self.frequency[-1]
        return (
            f"FeedbackTest of {len(self)} motions at {len(self.frequency)} frequencies, {low:g} to {high:g} Hz, up to "
            f"{self.force:g} N: {told}; {self.bench_time / 60:.3g} min of a bench"
        )

    def to_dataframe(self):
        """`pandas.DataFrame` with a row per motion."""
        return frame([_row(one) for one in self])

    table = to_dataframe


def _row(one):
    return {
        "frequency [Hz]": one.frequency,
        "asked z [mm]": 1e3 * one.amplitude,
        "|z| [mm]": 1e3 * abs(one.relative[1]),
        "|x| [mm]": 1e3 * abs(one.mass[1]),
        "force [N]": abs(one.force[1]),
        "feedback off f [%]": 100 * one.invasive,
        "loop multiplier": one.loop,
        "open multiplier": abs(one.multipliers[0]),
        "targets": one.segments,
        "status": one.status,
    }
