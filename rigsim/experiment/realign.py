"""Records whose channels are brought together: late or early ones, another clock, signs, order, single samples."""

import numpy as np
from scipy.interpolate import CubicSpline

from .. import checks


def realigned(record, delay=None, clock=None, reverse=(), swap=False, spikes=None):
    """See `Record.realigned`."""
    n, rate = record.force.size, record.sample_rate
    most = min(test.force.size for test in record.tests) / 4 / rate
    delay = _by_channel("delay", delay, record, lambda name, late: checks.real(name, late, "s", low=-most, high=most))
    clock = _by_channel("clock", clock, record, lambda name, fast: checks.real(name, fast, "ppm", low=-1e5, high=1e5))
    spikes = _by_channel("spikes", spikes, record, lambda name, at: checks.integers(name, at, low=0, high=n - 1))
    reverse = () if _is_none(reverse) else checks.names("reverse", reverse, tuple(record.kinds))
    channels, kinds = {name: getattr(record, name) for name in record.kinds}, record.kinds
    if checks.flag("swap", swap):
        channels = dict(zip(channels, reversed(channels.values()), strict=True))
        kinds = dict(zip(kinds, reversed(kinds.values()), strict=True))
    channels = {name: -values if name in reverse else values for name, values in channels.items()}
    for name, places in spikes.items():
        channels[name] = _without(channels[name], places)
    record = record.replace(kinds=kinds, **channels)
    return type(record).joined([_moved(test, delay, clock) for test in record.tests]) if delay or clock else record


def _moved(record, delay, clock):
    """One test with its outputs earlier by a delay (s), and by another clock (ppm)."""
    n, rate = record.force.size, record.sample_rate
    channels = {name: getattr(record, name) for name in record.kinds}
    at = {name: np.arange(n, dtype=float) for name in channels}
    for name, ppm in clock.items():
        at[name] = at[name] / (1 + 1e-6 * ppm)
    for name, late in delay.items():
        at[name] = at[name] + rate * late
    first = int(np.ceil(max(0.0, *(-places[0] for places in at.values()))))
    kept = slice(first, min(n, *(np.searchsorted(places, n - 1, side="right") for places in at.values())))
    moved = {name: values[kept] for name, values in channels.items()}
    for name in {*clock, *delay}:
        moved[name] = CubicSpline(np.arange(n), channels[name])(at[name][kept])
    moved |= {name: record.channels[name][kept] for name in ("tilt", "voltage") if name in record.channels}
    start = record.start if first == 0 else None
    return record.replace(force=record.force[kept], start=start, **moved)


def _is_none(names):
    return isinstance(names, (tuple, list)) and not names


def _by_channel(what, given, record, check):
    """A dict with something of each channel, checked."""
    if given is None:
        return {}
    given = checks.instance(what, given, dict, "a dict by channel")
    return {
        checks.one_of(f"channel of {what}", name, tuple(record.kinds)): check(f"{what} of {name}", value)
        for name, value in given.items()
    }


def _without(values, places):
    """The channel with some samples replaced by straight lines between their neighbours."""
    good = np.setdiff1d(np.arange(values.size), places)
    if not good.size:
        raise ValueError(f"spikes are all {values.size} samples; expected fewer")
    return np.interp(np.arange(values.size), good, values[good])
