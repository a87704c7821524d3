"""What kind of motion a window of a sine test shows: its lines, whether they last, and a verdict."""

import enum

import numpy as np

from .lines import fit_sines, strongest_line

HARMONICS = 10
DRIFT = 1e-3  # largest change of z between the window's halves that counts as settled
STRAY = 0.02  # largest line of z, off the harmonics, that counts as none
_LOWEST = 1.0  # Hz; slower lines are no better than the mean over a window of a second


class Status(enum.StrEnum):
    """How a sine test ended."""

    SETTLED = "settled"
    SUBHARMONIC = "subharmonic"
    DRIFTING = "still drifting"
    IRREGULAR = "not periodic"
    PARTED = "flew apart"


def read_window(time, displacements, f):
    """Lines of one window of a sine test, over as many whole periods as it holds.

    Parameters
    ----------
    time : ndarray, shape (samples,)
        s, evenly spaced.
    displacements : ndarray, shape (samples, 2)
        xs and x (m).
    f : float
        Frequency of the force (Hz); at least two periods in the window.

    Returns
    -------
    fundamental : ndarray, complex, shape (3,)
        Lines of xs, x and z at f (m).
    distortion : ndarray, shape (3,)
        Largest harmonic 2-10 over the fundamental.
    below : tuple of float
        Strongest line of z below f over its fundamental, and its order f/f_line.
    drift : float
        Change of z's fundamental from the first half window to the second, over their mean.
    verdict : tuple of (Status, str)
        And the reason in words and figures.
    """
    whole = np.floor((time[-1] - time[0]) * f * (1 + 1e-9))  # periods
    inside = time > time[-1] - (1 - 1e-9) * whole / f
    time = time[inside]
    signals = np.column_stack([displacements[inside], displacements[inside, 0] - displacements[inside, 1]])
    harmonics = f * np.arange(1, HARMONICS + 1)
    lines, residual = fit_sines(time, signals, harmonics)
    fundamental = lines[0]
    distortion = np.abs(lines[1:]).max(axis=0) / np.abs(fundamental)
    z, left = abs(fundamental[2]), residual[:, 2]
    below, stray = (strongest_line(time, left, (_LOWEST, top)) for top in (f, harmonics[-1]))
    parts = _subharmonic_parts(time, signals[:, 2], f, below[0]) if below[1] > STRAY * z else 1
    drift = _drift(time, signals[:, 2:], f, whole, harmonics, parts)
    told = f"z drifts by {drift:.2g} between half windows"
    steady = drift < DRIFT
    if parts > 1 and steady:
        verdict = Status.SUBHARMONIC, f"period {parts}/f: line at {below[0]:.3f} Hz of {below[1] / z:.1%} of z; {told}"
    elif parts == 1 and stray[1] > STRAY * z and not _decays(time, left, stray[0]):
        verdict = (
            Status.IRREGULAR,
            f"lasting line at {stray[0]:.3f} Hz of {stray[1] / z:.1%} of z, no period up to 5/f; {told}",
        )
    elif not steady or stray[1] > STRAY * z:
        line = f"line at {stray[0]:.3f} Hz of {stray[1] / z:.1%} of z"
        verdict = Status.DRIFTING, f"{told} (settled: below {DRIFT:g}), {line}: shake for longer"
    else:
        verdict = Status.SETTLED, f"{told}, largest other line {stray[1] / z:.2%}"
    return fundamental, distortion, (below[1] / z, f / below[0]), drift, verdict


def _subharmonic_parts(time, z, f, below):
    """Smallest n whose lines at multiples of f/n, one of them near ``below``, leave next to nothing of z, or 1."""
    for n in (2, 3, 4, 5):
        # The dear fit is spared where the line lies further from every multiple than the window can tell.
        off = below * n / f - round(below * n / f)
        if abs(off) * f / n > 1 / (time[-1] - time[0]):
            continue
        # Over whole periods of the motion, and together: the part line can be the larger one.
        inside = time > time[-1] - (1 - 1e-9) * np.floor((time[-1] - time[0]) * f / n * (1 + 1e-9)) * n / f
        if not inside.any():
            continue
        lines, left = fit_sines(time[inside], z[inside, None], f / n * np.arange(1, HARMONICS * n + 1))
        if strongest_line(time[inside], left[:, 0], (_LOWEST, HARMONICS * f))[1] <= STRAY * np.abs(lines).max():
            return n
    return 1


def _decays(time, left, frequency):
    """Whether a line is dying away: a transient, then, and no motion of its own."""
    half = len(time) // 2
    first, last = (
        abs(fit_sines(time[part], left[part, None], [frequency])[0][0, 0]) for part in (slice(half), slice(half, None))
    )
    return last < 0.9 * first


def _drift(time, signal, f, whole, harmonics, parts):
    """Change of the line at f between the first and the last whole periods of half the window, over their mean."""
    half = np.floor(whole / 2) / f
    between = [f / parts * k for k in range(1, 3 * parts) if k % parts]
    lines = np.concatenate([harmonics, between])
    first, _ = fit_sines(*_part(time, signal, time[0], half), lines)
    last, _ = fit_sines(*_part(time, signal, time[-1] - half, half), lines)
    return float(abs(last[0, 0] - first[0, 0]) / abs(first[0, 0] + last[0, 0]) * 2)


def _part(time, signal, begin, length):
    inside = (time >= begin - 1e-9) & (time <= begin + length + 1e-9)
    return time[inside], signal[inside]
