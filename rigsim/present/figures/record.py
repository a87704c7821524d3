"""Figures of records."""

import numpy as np

from ... import checks
from .style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, outer_labels, style, subplots

_COLOURS = {
    "force": GREY,
    "shaker": BLUE,
    "mass": ORANGE,
    "relative": GREEN,
    "tilt": RED,
    "voltage": PURPLE,
}  # from top to bottom
_SHOWN = {"m": (1e3, "mm"), "rad": (1e3, "mrad")}  # other units as they are


def record_figure(record, *, ax=None, interval=None):
    """Time histories of a `Record`'s channels and of z, one above the other.

    ``interval`` is the first and the last instant shown (s); all of it by default.

    Raises
    ------
    ValueError
        If the interval holds fewer than two samples.
    """
    time = record.time
    low, high = (time[0], time[-1]) if interval is None else checks.pair("interval", interval, "s", low_open=False)
    shown = (time >= low) & (time <= high)
    if shown.sum() < 2:
        expected = f"two samples of 0 to {time[-1]:g} s"
        raise ValueError(f"interval = {low:g} to {high:g} s is not allowed; expected {expected}")
    channels = {name: record.signals[name] for name in _COLOURS if name in record.signals}
    units = {"relative": record.units["shaker"]} | record.units
    names = ", ".join(map(record.called, channels))
    alt = f"Time histories of {names} from {low:.3g} to {high:.3g} s; {record.summary()}."
    with style():
        figure, axes = subplots(len(channels), 1, alt=alt, ax=ax, height=1.4 * len(channels) + 0.4, sharex=True)
        for axis, (name, values) in zip(axes, channels.items(), strict=True):
            scale, unit = _SHOWN.get(units[name], (1.0, units[name]))
            _draw(axis, time[shown], scale * values[shown], _COLOURS[name])
            axis.set(xlabel="time [s]", ylabel=f"{record.called(name)} [{unit}]", xlim=(low, high))
        outer_labels(axes, ax=ax)
        return figure


def _draw(axis, time, values, colour, columns=2000):
    """A line, or the band between smallest and largest where a line would be denser than the page."""
    if values.size <= 2 * columns:
        axis.plot(time, values, color=colour, linewidth=0.9)
        return
    starts = np.linspace(0, values.size, columns, endpoint=False).astype(int)
    low, high = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
    axis.fill_between(time[starts], low, high, color=colour, linewidth=0.5)
