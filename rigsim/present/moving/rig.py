"""The rig in motion: frame, wires and tilting mass of a record, played offline."""

import numpy as np

from ... import checks
from ...experiment.out_of_plane import planar_only
from ...experiment.record import Record
from ..figures.rig_parts import SETS, only_rigs, rig_parts
from ..figures.style import BLACK, BLUE, GREY, RED, as_tuple
from .plot import Curve, Panel
from .shapes import Shape, animate, drawing

# Part of the drawing, kind of line, name in the legend, colour; later ones on top.
_SHAPES = (
    ("ground", "line", "", GREY),
    ("frame", "outline", "frame", GREY),
    ("rollers", "point", "", BLACK),
    ("shaker", "line", "", BLACK),
    ("damper", "line", "", BLACK),
    ("mass", "outline", "suspended mass", BLUE),
    ("wires", "stable", "wires", RED),
    ("hidden", "point", "wires across the plane", RED),
    ("pins", "dot", "", BLACK),
    ("P", "point", "P", BLACK),
    ("G", "dot", "centre of mass", BLUE),
)

# What may be drawn over time beside the rig: label, title, and the label's unit over the record's.
_CHANNELS = {
    "tilt": ("tilt [°]", "Tilt as recorded", np.degrees(1.0)),
    "relative": ("z [mm]", "Relative displacement as recorded", 1e3),
}


def rig_animation(parameters, record, start=0.0, stop=None, frames=48, exaggeration=1.0, *, seconds=6.0, titles=None,
                  channel="tilt"):  # fmt: skip
    """`MovingPlot` of the rig as it moved between two instants of a record, with its tilt, or z, over time beside it.

    Frame and mass are drawn where the record has them, to scale. P's height is not recorded and is drawn as zero: in
    a sound rig it moves by micrometres. Several rigs stand side by side under one slider for time.

    Parameters
    ----------
    parameters : RigParameters or sequence of them
    record : Record or sequence of them
        One a rig, with its tilt; of `simulate`, or ``SineTest.record(i)``.
    start, stop : float
        Part of the records that is shown (s); by default all of it.
    frames : int
        Pictures, 2 to 5000; the record is interpolated between its samples.
    exaggeration : float
        The tilt is drawn this many times as large, and the caption says so.
    seconds : float
        How long one pass lasts on the screen.
    titles : str or sequence of str, optional
        One a rig.
    channel : {"tilt", "relative"}
        What is drawn over time.

    Raises
    ------
    ValueError
        If the parameters are not a rig's, a record has no tilt, the instants lie outside it, ``channel`` is
        neither, or there are not as many records or titles as rigs.
    """
    rigs, records = only_rigs(as_tuple(parameters)), checks.one_or_many("record", record, Record, "a Record")
    titles = [SETS[p.wire_sets].capitalize() for p in rigs] if titles is None else titles
    titles, seconds = checks.one_or_many("titles", titles, str, "text"), checks.positive("seconds", seconds, "s")
    for name, given in (("record", records), ("titles", titles)):
        if len(given) != len(rigs) or not rigs:
            raise ValueError(f"{name} has {len(given)} elements for {len(rigs)} rigs; expected one a rig, at least one")
    exaggeration = checks.real("exaggeration", exaggeration, low=0.0, high=1e6, low_open=True)
    channel = checks.one_of("channel", channel, tuple(_CHANNELS))
    motions = [rig_motion(p, each, start, stop, frames) for p, each in zip(rigs, records, strict=True)]
    time = motions[0][0]
    shapes = [
        [Shape(parts[name], *look) for name, *look in _SHAPES]
        for parts in (rig_parts(p, q, exaggeration) for p, (_, q) in zip(rigs, motions, strict=True))
    ]
    others = [drawing(each, time.size, title) for each, title in zip(shapes[1:], titles[1:], strict=True)]
    histories = _histories(time, records, channel)
    drawn = "drawn to scale" if exaggeration == 1 else f"drawn {exaggeration:g} times as large"
    words = [_words(p, q) for p, (_, q) in zip(rigs, motions, strict=True)]
    return animate(
        time, shapes[0], title=titles[0], panels=[*others, *histories], columns=max(2, len(rigs)), digits=4,
        width=9.5, height=5.2 if len(rigs) == 1 else 8.6, seconds=seconds,
        alt=f"From {1e3 * time[0]:.4g} to {1e3 * time[-1]:.4g} ms, tilt {drawn}. {' '.join(words)}",
        caption=f"Displacements to scale, tilt {drawn}. The height of P is not recorded and drawn as zero."
        + (f" Note: {told}." if (told := planar_only(rigs)) else ""),
        notes=["; ".join(_note(p, q[k]) for p, (_, q) in zip(rigs, motions, strict=True)) for k in range(time.size)],
    )  # fmt: skip


def _words(parameters, coordinates):
    xs, x, tilt = coordinates[:, 0], _position(parameters, coordinates), np.degrees(coordinates[:, 3])
    return (
        f"With {SETS[parameters.wire_sets]} the frame moves by {1e3 * np.ptp(xs):.3g} mm in all, the mass by "
        f"{1e3 * np.ptp(xs - x):.3g} mm against it; its tilt goes from {tilt.min():.3g} to {tilt.max():.3g} degrees."
    )


def _note(parameters, at):
    x = _position(parameters, at)
    text = f"xs {1e3 * at[0]:+.3f} mm, x {1e3 * x:+.3f} mm, tilt {np.degrees(at[3]):+.2g}°"
    return f"{SETS[parameters.wire_sets].capitalize()}: {text}"


def _position(parameters, coordinates):
    """x of P (m)."""
    return coordinates[..., 1] - parameters.LG * np.cos(coordinates[..., 3])


def _histories(time, records, channel):
    """A panel for each record, all on the same scale, with a dot that moves along."""
    label, title, scale = _CHANNELS[channel]
    shown = [(record.time >= time[0]) & (record.time <= time[-1]) for record in records]
    signals = [scale * getattr(record, channel) for record in records]
    low = min(signal[part].min() for signal, part in zip(signals, shown, strict=True))
    high = max(signal[part].max() for signal, part in zip(signals, shown, strict=True))
    margin = 0.05 * (high - low) or 1.0
    panels = []
    for record, signal, part in zip(records, signals, shown, strict=True):
        whole = Curve(1e3 * record.time[part], signal[part], "line", color=GREY)
        at = np.interp(time, record.time, signal)
        dots = [[Curve([1e3 * t], [value], "dot", color=BLUE)] for t, value in zip(time, at, strict=True)]
        panels.append(Panel(dots, "time [ms]", label, title, ylim=(low - margin, high + margin), fixed=(whole,)))
    return panels


def rig_motion(parameters, record, start=0.0, stop=None, frames=48):
    """Evenly spaced instants (frames,) of a record (s), and xs, X, Y (m) and tilt (rad) there, shape (frames, 4).

    P is at the height of zero. Arguments and errors are those of `rig_animation`.
    """
    (parameters,) = only_rigs([parameters])
    if record.tilt is None:
        raise ValueError("record has no tilt; expected one of the multi-body rig")
    last = record.time[-1]
    start = checks.real("start", start, "s", low=0.0, high=last)
    stop = checks.real("stop", last if stop is None else stop, "s", low=start, high=last, low_open=True)
    frames = checks.integer("frames", frames, low=2, high=5000)  # a page holds them all
    time = np.linspace(start, stop, frames)
    xs, x, tilt = (np.interp(time, record.time, channel) for channel in (record.shaker, record.mass, record.tilt))
    LG = parameters.LG
    return time, np.column_stack([xs, x + LG * np.cos(tilt), LG * np.sin(tilt), tilt])
