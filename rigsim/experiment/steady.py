"""What kind of motion a window of a sine test shows: its lines, whether they last, and a verdict."""

import numpy as np

from ..results import Status
from .lines import fit_sines, strongest_lines

HARMONICS = 10
DRIFT = 1e-3  # largest change of z between the window's halves that counts as settled
STRAY = 0.02  # largest line of z, off the harmonics, that counts as none
WINDOW = 1.0  # s, of a reading
LOWEST = 2 / WINDOW  # Hz; two whole periods, so that the window's halves can be compared
_NONE = 1e-300  # m: where a coarse sensor shows no motion
_LOWEST = 1.0  # Hz; slower lines are no better than the mean over a window of a second
_USUAL = 1 / 4000  # s between samples, up to 160 Hz


def highest(step):
    """Hz, of a force, at an integration step (s): forty steps a period."""
    return 1 / (4 * HARMONICS * step)


def sampling(frequency, step):
    """Steps (s) of the leapfrog between two samples of a motion at a frequency (Hz), its tenth harmonic below a half.

    They divide those of low frequencies, so that instants of all frequencies fall on each other.
    """
    usual = max(1, int(_USUAL / step))
    wanted = int(1 / (2.5 * HARMONICS * frequency) / step)
    return max(every for every in range(1, usual + 1) if usual % every == 0 and every <= max(wanted, 1))


def read_window(time, displacements, f):
    """Lines of one window of a sine test, over as many whole periods as it holds.

    ``time`` (samples,) is evenly spaced (s), ``displacements`` (samples, 2) are xs and x (m), and ``f`` is the force's
    frequency (Hz), at least two periods of which are in the window.

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
    window, lines, left = _fit_period(time, displacements, f, 1)
    below, stray = strongest_lines(window, left, (_LOWEST, f), (_LOWEST, HARMONICS * f))
    parts = 1
    if below[1] > STRAY * abs(lines[0, 2]):
        parts = _subharmonic_parts(time, displacements, f, below[0])
    if parts > 1:
        _, lines, _ = _fit_period(time, displacements, f, parts)
        strongest = np.abs(lines[: parts - 1, 2]).argmax()
        below = (strongest + 1) * f / parts, abs(lines[strongest, 2])
    harmonics = np.maximum(np.abs(lines[parts - 1 :: parts]), _NONE)
    fundamental, distortion = lines[parts - 1], harmonics[1:].max(axis=0) / harmonics[0]
    z = harmonics[0, 2]
    drift = _drift(window, -np.diff(displacements[-len(window) :]), f, parts)
    told = f"z drifts by {drift:.2g} between half windows"
    line, steady = f"line at {stray[0]:.3f} Hz of {stray[1] / z:.1%} of z", drift < DRIFT
    if parts > 1 and steady:
        verdict = Status.SUBHARMONIC, f"period {parts}/f: line at {below[0]:.3f} Hz of {below[1] / z:.1%} of z; {told}"
    elif parts == 1 and stray[1] > STRAY * z and not _decays(time, left, stray[0]):
        verdict = Status.NOT_PERIODIC, f"lasting {line}, no period up to 5/f; {told}"
    elif not steady or stray[1] > STRAY * z:
        verdict = Status.STILL_DRIFTING, f"{told} (settled: below {DRIFT:g}), {line}: shake for longer"
    else:
        verdict = Status.SETTLED, f"{told}, largest other line {stray[1] / z:.2%}"
    return fundamental, distortion, (below[1] / z, f / below[0]), drift, verdict


def read_or_parted(time, displacements, f, parted):
    """What `read_window` tells, the status by its name; nothing but that of a rig that flew apart at ``parted`` (s)."""
    if np.isnan(parted):
        *numbers, (status, message) = read_window(time, displacements, f)
        return *numbers, status.name, message
    message = f"past its wires' reach at t = {parted:.4g} s"
    return np.full(3, np.nan + 0j), np.full(3, np.nan), (np.nan, np.nan), np.nan, Status.FLEW_APART.name, message


def _fit_period(time, displacements, f, parts):
    """Lines of xs, x and z at multiples of f/parts over the last whole periods of parts/f, and what they leave of z.

    Returned are time, lines and remainder. A fit is linear, so those of z follow from the others.
    """
    whole = np.floor((time[-1] - time[0]) * f / parts * (1 + 1e-9)) * parts / f
    inside = time > time[-1] - (1 - 1e-9) * whole
    lines, left = fit_sines(time[inside], displacements[inside], f / parts * np.arange(1, HARMONICS * parts + 1))
    return time[inside], np.column_stack([lines, -np.diff(lines)]), left[:, 0] - left[:, 1]


def _subharmonic_parts(time, displacements, f, below):
    """Smallest n whose lines at multiples of f/n, one of them near ``below``, leave next to nothing of z, or 1."""
    length = time[-1] - time[0]
    for n in (2, 3, 4, 5):
        # The dear fit is spared where the line lies further from every multiple than the window can tell.
        off = below * n / f - round(below * n / f)
        if abs(off) * f / n > 1 / length or length * f < n:
            continue
        # Fitted together with the line at f, since the part line can be the larger one.
        window, lines, left = _fit_period(time, displacements, f, n)
        if strongest_lines(window, left, (_LOWEST, HARMONICS * f))[0][1] <= STRAY * np.abs(lines[:, 2]).max():
            return n
    return 1


def _decays(time, left, frequency):
    """Whether a line is dying away: a transient, then, and no motion of its own."""
    half = len(time) // 2
    parts = slice(half), slice(half, None)
    first, last = (abs(fit_sines(time[part], left[part, None], [frequency])[0][0, 0]) for part in parts)
    return last < 0.9 * first


def _drift(time, z, f, parts):
    """Change of the line at f between the first and the last whole periods of half the window, over their mean."""
    half = np.floor(np.floor((time[-1] - time[0]) * f * (1 + 1e-3)) / 2) / f
    multiples = f / parts * np.arange(1, HARMONICS * parts + 1)
    lines = [k for k in multiples if k < 3 * f or round(k / f * parts) % parts == 0]
    at = lines.index(multiples[parts - 1])
    parts = [(time >= begin - 1e-9) & (time <= begin + half + 1e-9) for begin in (time[0], time[-1] - half)]
    first, last = (fit_sines(time[part], z[part], lines)[0][at, 0] for part in parts)
    return float(abs(last - first) / max(abs(first + last), _NONE) * 2)
