"""From S-curves, force over amplitude at fixed frequencies, to the response at one force with its folds."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from ...results import Result, ResultSequence, frame
from .gains import multipliers, transitions

_SAME = 2e-3  # of the largest amplitude, within which a motion was held twice
_FEWEST = 4  # motions a spline is put through
_FLOQUET = 128  # steps a period


@dataclass(frozen=True, eq=False)
class MeasuredMotion:
    """Where an S-curve passes the force.

    Attributes
    ----------
    frequency : float
        Hz.
    shaker, mass, relative : complex
        First lines of xs, x and z (m), phase against the force.
    multiplier : float
        Largest modulus of the multipliers about it, estimated as `HeldMotion.multipliers` are.
    stable : bool
        Whether that is below 1.
    motion : {"low", "middle", "high", "only"}
        Which of the frequency's motions it is.
    """

    frequency: float
    shaker: complex
    mass: complex
    relative: complex
    multiplier: float
    stable: bool
    motion: str


@dataclass(frozen=True, eq=False)
class MeasuredFold:
    """A fold of the response at the force.

    Attributes
    ----------
    frequency, amplitude : float
        Hz; of z, m.
    kind : str
        Which motions meet in it, "low and middle" or "middle and high".
    between : (float, float)
        Neighbouring frequencies of the test (Hz), between which a spline placed it: no closer than they tell.
    """

    frequency: float
    amplitude: float
    kind: str
    between: tuple


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredResponse(ResultSequence):
    """What `FeedbackTest.at` returns: `MeasuredMotion` after `MeasuredMotion`, by frequency and amplitude.

    Attributes
    ----------
    members : tuple of MeasuredMotion
    folds : tuple of MeasuredFold
        Ascending in frequency.
    force : float
        N.
    test : FeedbackTest
    """

    members: tuple
    folds: tuple
    force: float
    test: Result

    plots = {"response": "measured_response_figure"}

    @property
    def frequency(self):
        """Hz, shape (n,)."""
        return np.array([one.frequency for one in self])

    @property
    def relative(self):
        """First line of z (m), complex, shape (n,)."""
        return np.array([one.relative for one in self], dtype=complex)

    @property
    def stable(self):
        """Shape (n,)."""
        return np.array([one.stable for one in self], dtype=bool)

    def summary(self):
        """One line: motions, and folds."""
        folds = ", ".join(f"{fold.frequency:.2f} Hz ({fold.kind})" for fold in self.folds) or "none"
        unstable = int((~self.stable).sum())
        short = ", ".join(f"{frequency:g}" for frequency in self.unfinished)
        return (
            f"MeasuredResponse at {self.force:g} N: {len(self)} motions at {np.unique(self.frequency).size} "
            f"frequencies, {unstable} of them unstable; folds: {folds}"
            + (
                f"; at {short} Hz there may be more, since motions there were not held, or none that takes the force"
                if short
                else ""
            )
        )

    @property
    def unfinished(self):
        """Tuple of frequencies (Hz) at which motions were not held, or none that takes more than the force."""
        found = []
        for frequency in self.test.frequency.tolist():
            own = [one for one in self.test if one.frequency == frequency]
            held = [abs(one.force[1]) for one in self.test.held(frequency)]
            if len(held) < len(own) or max(held, default=0.0) < self.force:
                found.append(frequency)
        return tuple(found)

    def to_dataframe(self):
        """`pandas.DataFrame` with a row per motion."""
        rows = [
            {
                "frequency [Hz]": one.frequency,
                "motion": one.motion,
                "|xs| [mm]": 1e3 * abs(one.shaker),
                "|x| [mm]": 1e3 * abs(one.mass),
                "|z| [mm]": 1e3 * abs(one.relative),
                "open multiplier": one.multiplier,
                "stable": one.stable,
            }
            for one in self
        ]
        return frame(rows)

    table = to_dataframe


def contour(model, curves, force):
    """Tuples of `MeasuredMotion` and `MeasuredFold` at a force (N).

    ``curves`` is a dict of frequency (Hz) to the motions held there, ascending, and the amplitudes of those that were
    not.
    """
    motions = []
    for frequency, (held, gaps) in curves.items():
        held, amplitude, squared = _s_curve(held)
        if len(held) < _FEWEST:
            continue
        amplitude, squared = np.append(0.0, amplitude), np.append(0.0, squared)  # no motion takes no force
        over = CubicSpline(amplitude, squared - force**2)
        passed = over.roots(extrapolate=False)
        lines = [np.column_stack([one.shaker, one.mass]) for one in held]
        lines = CubicSpline(amplitude, [np.zeros_like(lines[0]), *lines])
        phase = CubicSpline(amplitude, [0.0, *(one.force[1] for one in held)])
        fitted = model.replace(**dict(zip(("c", "k1", "k3"), held[0].suspension.tolist(), strict=True)))
        names = _names(over(passed, 1) < 0)
        for root, name in zip(passed, names, strict=True):
            if not _apart(amplitude, root, gaps):
                xs, x = lines(root).T
                largest = float(abs(multipliers(transitions(fitted, xs - x, frequency, _FLOQUET)[0])).max())
                turn = np.conj(phase(root)) / abs(phase(root))
                first = complex(xs[1] * turn), complex(x[1] * turn), complex((xs[1] - x[1]) * turn)
                motions.append(MeasuredMotion(frequency, *first, largest, largest < 1, name))
    return tuple(motions), _folds(curves, force)


def _names(falling):
    """Names of an S-curve's motions at a force, by whether it falls through each."""
    if len(falling) == 1:
        return ["only"]
    before = np.cumsum(falling) > 0
    return ["middle" if down else "high" if late else "low" for down, late in zip(falling, before, strict=True)]


def _folds(curves, force):
    folds = []
    for kind, (frequency, amplitude, level) in fold_levels(curves).items():
        words = "low and middle" if kind == "largest" else "middle and high"
        known = np.isfinite(level)
        for run in np.split(np.arange(len(level)), np.flatnonzero(np.diff(known)) + 1):
            if known[run[0]] and len(run) > 1:
                over = CubicSpline(frequency[run], np.column_stack([level[run] - force, amplitude[run]]))
                roots = CubicSpline(frequency[run], level[run] - force).roots(extrapolate=False)
                for root in roots.tolist():
                    i = np.clip(np.searchsorted(frequency, root), 1, len(frequency) - 1)
                    between = float(frequency[i - 1]), float(frequency[i])
                    folds.append(MeasuredFold(root, float(over(root)[1]), words, between))
    return tuple(sorted(folds, key=lambda fold: fold.frequency))


def fold_levels(curves):
    """Where the force of each S-curve is largest and least between its ends: see `FeedbackTest.fold_levels`."""
    found = {"largest": [], "least": []}
    for held, gaps in curves.values():
        places = dict.fromkeys(found, (np.nan, np.nan))
        held, amplitude, squared = _s_curve(held)
        if len(held) >= _FEWEST:
            spline = CubicSpline(amplitude, squared)
            turns = [a for a in spline.derivative().roots(extrapolate=False) if not _apart(amplitude, a, gaps)]
            tops = [a for a in turns if spline(a, 2) < 0]
            if tops:
                top = max(tops, key=spline)
                places["largest"] = top, spline(top)
                low = [a for a in turns if a > top and spline(a, 2) > 0]
                if low:
                    place = min(low, key=spline)
                    places["least"] = place, max(spline(place), 0.0)
        for kind, place in places.items():
            found[kind].append(place)
    frequency = np.array(list(curves))
    result = {}
    for kind, places in found.items():
        amplitude, squared = np.array(places).T
        result[kind] = frequency, amplitude, np.sqrt(squared)
    return result


def _s_curve(held):
    """Motions apart in amplitude, their amplitude of z (m) and square of the force (N^2).

    Unlike the force its square is smooth where it is least.
    """
    amplitude = np.array([abs(one.relative[1]) for one in held])
    apart = np.flatnonzero(np.diff(amplitude, prepend=-np.inf) > _SAME * amplitude.max(initial=0.0))
    return [held[i] for i in apart], amplitude[apart], np.array([abs(held[i].force[1]) ** 2 for i in apart])


def _apart(amplitude, root, gaps):
    """Whether a motion that was not held lies between the two held ones beside an amplitude."""
    i = np.clip(np.searchsorted(amplitude, root), 1, len(amplitude) - 1)
    return any(amplitude[i - 1] < gap < amplitude[i] for gap in gaps)
