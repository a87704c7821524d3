"""What a rig leaves of a record and no rig does: a drift below the band, and steady tones such as the mains' hum."""

import numpy as np
from scipy.ndimage import median_filter

from .troubles import Trouble

_AROUND = 41  # lines that one is compared with
_MEDIAN = np.log(2)  # of the power of a line of noise, over its mean
_LOUD = 40.0  # times the mean power around: among a million lines of noise none is so loud
_SLOW = 10.0  # times the power in the band
_SEEN = 1e-3  # of an output
_MAINS, _NEAR = (50.0, 60.0), 0.3  # Hz


def leftovers(record, left, band):
    """`Trouble` of each output that drifts or holds a tone, from what a rig leaves of it, (n, q).

    They move no parameter: a drift is below the band, and a line that is loud in it has little weight.
    """
    n, rate = record.force.size, record.sample_rate
    frequency, window = np.fft.rfftfreq(n, 1 / rate), np.hanning(n)
    amplitude = lambda channel: 2 * np.abs(np.fft.rfft(window * (channel - channel.mean()))) / window.sum()  # noqa: E731
    slow, inside = (frequency > 0) & (frequency < band[0] / 2), (frequency >= band[0]) & (frequency <= band[1])
    steady = (frequency >= band[0] / 2) & ~_loud(
        amplitude(record.force)
    )  # a line of the force is no tone of the sensors
    found = []
    for name, rest in zip(record.kinds, left.T, strict=True):
        lines, size, unit = amplitude(rest), getattr(record, name).std(), record.units[name]
        drift = np.sqrt(np.sum(lines[slow] ** 2) / 3)  # rms: the window spreads a line's power over three halves
        if drift > _SEEN * size and np.mean(lines[slow] ** 2) > _SLOW * np.median(lines[inside] ** 2) / _MEDIAN:
            found.append(
                Trouble("drift", f"{name} drifts, by {drift:.2g} {unit} rms below {band[0] / 2:g} Hz", size=drift)
            )
        tones = np.where(steady & _loud(lines), lines, 0.0)
        loudest = int(tones.argmax())
        if tones[loudest] > _SEEN * size:
            mains = min(abs((frequency[loudest] + each / 2) % each - each / 2) for each in _MAINS)
            word = "hum" if mains < _NEAR and frequency[loudest] > min(_MAINS) - _NEAR else "a tone"
            message = f"{name} holds {word} of {tones[loudest]:.2g} {unit} at {frequency[loudest]:.4g} Hz"
            found.append(Trouble("tone", message, size=float(tones[loudest])))
    return found


def _loud(lines):
    """Which lines stand out of those around them."""
    return lines**2 > _LOUD * median_filter(lines**2, _AROUND) / _MEDIAN
