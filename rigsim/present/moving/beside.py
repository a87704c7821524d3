"""What stands beside the moving rig, of the same window: histories and phase portrait with a dot, and the spectrum."""

import numpy as np

from ...experiment.out_of_plane import SpaceRecord
from ...experiment.record import Record
from ...model import spatial
from ..figures.style import BLUE, GREY
from .plot import Curve, Panel

# Over time: label, title, and the label's unit over the record's.
_OVER_TIME = {
    "tilt": ("tilt [°]", "Tilt as recorded", np.degrees(1.0)),
    "relative": ("z [mm]", "Relative displacement as recorded", 1e3),
    "yaw": ("yaw [°]", "Yaw, out of the plane", np.degrees(1.0)),
    "roll": ("roll [°]", "Roll about the axis", np.degrees(1.0)),
}
CHANNELS = (*_OVER_TIME, "phase portrait", "spectrum")
_FEWEST = 16  # samples of a window that has a spectrum
_HIGHEST, _LOWEST = 6.0, 1e-4  # where a spectrum ends, over its strongest line's frequency and amplitude


def beside(time, records, channels):
    """Panels, channel by channel one for each record, on one scale; dots stand at ``time``, shape (frames,) (s).

    Raises
    ------
    ValueError
        If the window has too few samples for a spectrum.
    """
    panels = []
    for channel in channels:
        make = {"phase portrait": _phase_portrait, "spectrum": _spectrum}.get(channel, _history)
        made = [make(time, record, channel) for record in records]
        for (dots, whole, labels), limits in zip(made, _limits(channel, [whole for _, whole, _ in made]), strict=True):
            moving = [[Curve([x], [y], "dot", color=BLUE)] for x, y in dots] or [[]] * time.size
            panels.append(Panel(moving, *labels, **limits, fixed=(Curve(*whole, "line", color=GREY),)))
    return panels


def _window(time, record):
    return (record.time >= time[0]) & (record.time <= time[-1])


def _history(time, record, channel):
    """Dots (frames, 2), the whole curve, and labels."""
    ylabel, title, scale = _OVER_TIME[channel]
    if channel in ("roll", "yaw"):
        angles = spatial.angles(record.states) if isinstance(record, SpaceRecord) else np.zeros((2, record.force.size))
        signal = scale * angles[("roll", "yaw").index(channel)]
    else:
        signal = scale * getattr(record, channel)
    shown = _window(time, record)
    dots = np.column_stack([1e3 * time, np.interp(time, record.time, signal)])
    return dots, (1e3 * record.time[shown], signal[shown]), ("time [ms]", ylabel, title)


def _phase_portrait(time, record, _):
    z = record.relative
    speed, shown = np.gradient(z) * record.sample_rate, _window(time, record)
    dots = np.column_stack([1e3 * np.interp(time, record.time, z), np.interp(time, record.time, speed)])
    return dots, (1e3 * z[shown], speed[shown]), ("z [mm]", "z' [m/s]", "Phase portrait of this window")


def _spectrum(time, record, _):
    shown = _window(time, record)
    if shown.sum() < _FEWEST:
        told = f"stop = {time[-1]:g} s leaves {shown.sum()} samples from {time[0]:g} s on"
        raise ValueError(f"{told}; expected {_FEWEST} or more for a spectrum")
    part = Record(record.force[shown], record.shaker[shown], record.mass[shown], record.sample_rate, record.hold)
    frequency, amplitude = part.spectrum("relative", 1 / part.duration)
    return np.empty((0, 2)), (frequency, 1e3 * amplitude), ("frequency [Hz]", "z [mm]", "Spectrum of this window")


def _limits(channel, wholes):
    """Scales and limits of each panel, which all records share."""
    if channel == "spectrum":
        strongest = [(frequency[amplitude.argmax()], amplitude.max()) for frequency, amplitude in wholes]
        highest, top = np.max(strongest, axis=0)
        end = wholes[0][0][-1]
        look = {"yscale": "log", "xlim": (0.0, min(end, _HIGHEST * highest) or end)}
        return [look | {"ylim": (_LOWEST * (top or 1.0), 3 * (top or 1.0))}] * len(wholes)
    x, y = (_around([whole[axis] for whole in wholes]) for axis in (0, 1))
    return [{"xlim": x, "ylim": y} if channel == "phase portrait" else {"ylim": y}] * len(wholes)


def _around(values):
    low, high = min(map(np.min, values)), max(map(np.max, values))
    margin = 0.05 * (high - low) or 1.0
    return low - margin, high + margin
