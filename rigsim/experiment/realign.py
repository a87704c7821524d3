"""Records whose channels are brought together: late or early ones, another clock, signs, order, single samples."""

import numpy as np
from scipy.interpolate import CubicSpline

from .. import checks


def realigned(record, delay=None, clock=None, reverse=(), swap=False, spikes=None):
    """See `Record.realigned`."""
    channels, kinds = {name: getattr(record, name) for name in record.kinds}, record.kinds
    if checks.flag("swap", swap):
        channels = dict(zip(channels, reversed(channels.values()), strict=True))
        kinds = dict(zip(kinds, reversed(kinds.values()), strict=True))
    channels = {name: -values if name in reverse else values for name, values in channels.items()}
    for name, places in (spikes or {}).items():
        channels[name] = _without(channels[name], np.asarray(places, dtype=int))
    n, rate = record.force.size, record.sample_rate
    at = {name: np.arange(n, dtype=float) for name in channels}
    for name, fast in (clock or {}).items():
        at[name] = at[name] / (1 + 1e-6 * checks.real(f"clock of {name}", fast, "ppm", low=-1e5, high=1e5))
    for name, late in (delay or {}).items():
        most = n / 4 / rate
        at[name] = at[name] + rate * checks.real(f"delay of {name}", late, "s", low=-most, high=most)
    first = int(np.ceil(max(0.0, *(-places[0] for places in at.values()))))
    lasts = [np.searchsorted(places, n - 1, side="right") for places in at.values()]
    kept = slice(first, min(n, *lasts))
    moved = {
        name: values[kept]
        if np.array_equal(at[name], np.arange(n))
        else CubicSpline(np.arange(n), values)(at[name][kept])
        for name, values in channels.items()
    }
    tilt = None if record.tilt is None else record.tilt[kept]
    start = record.start if first == 0 else None
    return record.replace(force=record.force[kept], tilt=tilt, start=start, kinds=kinds, **moved)


def _without(values, places):
    """The channel with some samples replaced by straight lines between their neighbours."""
    good = np.setdiff1d(np.arange(values.size), places)
    return np.interp(np.arange(values.size), good, values[good])
