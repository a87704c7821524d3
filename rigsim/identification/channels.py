"""What the channels of a record show by themselves, before any rig is thought of."""

import numpy as np
from scipy import signal
from scipy.constants import g as standard_gravity

from .layout import powers_of
from .troubles import Trouble

_HELD, _SLOWER = 0.3, 1.5  # of the samples repeat the one before; samples from one change to the next
_ENDS = 5  # samples in a row at the largest value
_RICH = 0.99  # of the force's power in the band
_SURVIVED = 100.0  # times gravity, rms
_NOTHING = 1e-4  # of an output's deviation


def channel_troubles(record, band, order):
    """Clipping, samples held from a slower recorder, a force of few lines, absurd units: `Trouble` each."""
    found = []
    for name in ("force", *record.kinds):
        values = getattr(record, name)
        found += [*_clipped(name, values), *_held(name, values)]
    return [*found, *poor_force(record, band, order), *_absurd(record, band), *_not_held(record)]


def _not_held(record):
    """Whether a force is told to be held that a coil's current makes: it follows the voltage."""
    if record.voltage is None or record.hold == "band-limited":
        return []
    message = (
        f'the force of a coil that was given a voltage is not held between samples, as hold = "{record.hold}" says: '
        'sample faster, shake by a current, or by a voltage without jumps, with hold = "band-limited"'
    )
    return [Trouble("hold", message)]


def _absurd(record, band):
    """Motions that no rig survives: those in a wrong unit."""
    found = []
    for (name, kind), power in zip(record.kinds.items(), powers_of(record), strict=True):
        if getattr(record, name).std() * (2 * np.pi * band[1]) ** (2 - power) < _SURVIVED * standard_gravity:
            continue  # even if all of it were at the band's end
        frequency, density = signal.periodogram(getattr(record, name), record.sample_rate, window="hann")
        inside = (frequency >= band[0]) & (frequency <= band[1])
        squares = density[inside] * (2 * np.pi * frequency[inside]) ** (4 - 2 * power)
        rms = np.sqrt(squares.sum() * frequency[1])
        if rms > _SURVIVED * standard_gravity:
            told = f"{name} would be accelerated by {rms / standard_gravity:.2g} times gravity (rms, in the band)"
            found.append(Trouble("unit", f"{told}: is its unit right, {record.units[name]} for a {kind}?"))
    return found


def _clipped(name, values):
    ends = 0
    for extreme in (values.max(), values.min()):
        at = np.isclose(values, extreme, rtol=0, atol=1e-9 * np.ptp(values))
        runs = np.diff(np.flatnonzero(np.diff(np.concatenate([[0], at, [0]]))))[::2]
        ends += int(runs[runs >= _ENDS].sum())
    if name == "force" or ends < 2 * _ENDS:
        return []
    share = 100 * ends / values.size
    return [
        Trouble("clipping", f"{name} stands at its largest value for {ends} samples ({share:.2g} %): it is clipped")
    ]


def _held(name, values):
    same = np.diff(values) == 0
    share = same.mean()
    if name == "force" or share < _HELD:
        return []
    moves = np.flatnonzero(~same)
    if moves.size < 3 or np.ptp(values) / np.abs(np.diff(values)[~same]).min() < 300:
        return []  # few digits rather than few samples
    every = np.median(np.diff(moves))
    if every < _SLOWER:
        return []  # it stood still for a while
    return [
        Trouble("rate", f"{name} repeats {100 * share:.2g} % of its samples: it was sampled {every:g} times slower")
    ]


def poor_force(record, band, order):
    """Whether the force has lines enough to tell the parameters apart."""
    force = record.force - record.force.mean()
    frequency, power = signal.periodogram(force, record.sample_rate, window="hann")
    inside = power[(frequency >= band[0]) & (frequency <= band[1])]
    if not inside.sum() > 1e-6 * power.sum():
        return [Trouble("force", f"the force has nothing in the band {band[0]:g} to {band[1]:g} Hz")]
    brightest = np.sort(inside)[::-1].cumsum() / inside.sum()
    lines = int(np.searchsorted(brightest, _RICH)) + 1
    needed = 3 * (order + 4)  # a Hann window makes three of each
    if lines >= needed:
        return []
    return [
        Trouble(
            "force", f"{100 * _RICH:g} % of the force in the band are {max(1, lines // 3)} lines, too few to tell the "
            "parameters apart: shake with a random force or a sweep",
        )
    ]  # fmt: skip


def breaks(left, size, sample_rate, most=8):
    """Where the motion begins anew: what is left of outputs (n, q) rises at once and dies away; samples, in order.

    ``size`` (q,) is the outputs' deviation: what is less than a ten-thousandth of it is nothing.
    """
    window = max(8, int(0.15 * sample_rate))
    left = left.copy()
    for rest, alone in zip(left.T, spikes(left, size), strict=True):
        rest[alone] = (rest[alone - 1] + rest[alone + 1]) / 2
    scale = np.maximum(np.median(np.abs(left), axis=0), _NOTHING * size)
    power = np.sum((left / scale) ** 2, axis=1)
    summed = np.concatenate([[0.0], np.cumsum(power)])
    n, found = power.size, []
    before, after = np.full(n, np.inf), np.zeros(n)
    at = np.arange(window, n - window)
    before[at] = (summed[at] - summed[at - window]) / window
    after[at] = (summed[at + window] - summed[at]) / window
    usual = max(np.median(power), 1.0)
    jump = np.where(after > 20 * usual, after / (before + usual), 0.0)
    while len(found) < most and jump.max() > 12:
        place = int(jump.argmax())
        first = place + int(np.argmax(power[place : place + window] > max(6 * before[place], 10 * usual)))
        found.append(first)
        jump[max(0, place - 4 * window) : place + 4 * window] = 0.0
    return sorted(found)


def spikes(left, size):
    """Samples of each output that stand out of both their neighbours: list of arrays; ``size`` as for `breaks`."""
    found = []
    for rest, usual in zip(left.T, size, strict=True):
        out = np.zeros(rest.size)
        out[1:-1] = rest[1:-1] - (rest[:-2] + rest[2:]) / 2
        scale = max(1.4826 * np.median(np.abs(out)), _NOTHING * usual)
        places = np.flatnonzero(np.abs(out) > 12 * scale)
        alone = [place for place in places if np.abs(out[place]) == np.abs(out[max(place - 2, 0) : place + 3]).max()]
        found.append(np.array(alone, dtype=int))
    return found
