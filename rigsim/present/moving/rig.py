"""The rig in motion: frame, wires and tilting mass of a record, played offline."""

import numpy as np

from ... import checks
from ...experiment.out_of_plane import SpaceRecord, planar_only
from ...experiment.record import Record
from ...model import spatial
from ..figures.rig_parts import SETS, only_rigs
from ..figures.style import as_tuple
from .beside import CHANNELS, beside
from .shapes import animate, drawing
from .views import tension_key, view

_MEGABYTES = 4.0  # of the page that one animation may take; a page may have 5
_SERIES = [step * 10.0**power for power in (0, 1) for step in (1, 2, 5)] + [100.0]
_DRAWN = 0.15, 0.3  # where "auto" ends: a displacement over the wires' reach, an angle (rad)


def rig_animation(parameters, record, start=0.0, stop=None, frames=48, exaggeration="auto", *, displacement="auto",
                  seconds=6.0, titles=None, channel="tilt"):  # fmt: skip
    """`MovingPlot` of the rig as it moved between two instants of a record, and what its record says beside it.

    Wires have the colour of their tension, with a key in newtons that all rigs share; those that are slack are dashed.
    P's height is no part of a planar record, and is where the wires carry the mass. A record in three dimensions is
    seen from the side and from above. Several rigs stand side by side under one slider for time.

    Parameters
    ----------
    parameters : RigParameters or sequence of them
    record : Record or sequence of them
        One a rig, with its tilt; of `simulate`, ``SineTest.record(i)`` or ``SineTest.in_space(i)``.
    start, stop : float
        Part of the records that is shown (s); by default what all of them hold.
    frames : int
        Pictures, 2 to 5000; the record is interpolated between its samples.
    exaggeration, displacement : float or "auto"
        Angles, and displacements, are drawn this many times as large, and the caption says so: 1 is to scale. "auto"
        takes 1, 2, 5 ... 100, as large as shows well.
    seconds : float
        How long one pass lasts on the screen.
    titles : str or sequence of str, optional
        One a rig.
    channel : str or sequence of str
        What stands beside the rig: "tilt", "relative", "yaw", "roll" over time, "phase portrait" of z, "spectrum" of
        z under a Hann window; all of the part that is shown.

    Raises
    ------
    ValueError
        If the parameters are not a rig's, a record has no tilt or no displacements, the instants lie outside it, a
        ``channel`` is unknown, there are not as many records or titles as rigs, or the animation takes more than 4 MB
        of a page.
    """
    rigs, records = only_rigs(as_tuple(parameters)), checks.one_or_many("record", record, Record, "a Record")
    titles = [SETS[p.wire_sets].capitalize() for p in rigs] if titles is None else titles
    titles, seconds = checks.one_or_many("titles", titles, str, "text"), checks.positive("seconds", seconds, "s")
    for name, given in (("record", records), ("titles", titles)):
        if len(given) != len(rigs) or not rigs:
            raise ValueError(f"{name} has {len(given)} elements for {len(rigs)} rigs; expected one a rig, at least one")
    channels = checks.names("channel", [channel] if isinstance(channel, str) else channel, CHANNELS)
    factors = _factor("displacement", displacement), _factor("exaggeration", exaggeration)
    if stop is None:
        stop = min(each.time[-1] for each in records)
    motions = [rig_motion(p, each, start, stop, frames) for p, each in zip(rigs, records, strict=True)]
    time, states = motions[0][0], [each for _, each in motions]
    factors = [_shown(*each) for each in zip(factors, _largest(rigs, states), _DRAWN, strict=True)]
    key = tension_key([spatial.wire_pull(p, each)[0] for p, each in zip(rigs, states, strict=True)])
    space = [isinstance(each, SpaceRecord) for each in records]
    drawings = [
        (view(p, each, key, *factors, above), f"{title}, from above" if above else title)
        for above in (False, True)[: 1 + any(space)]
        for p, each, title in zip(rigs, states, titles, strict=True)
    ]
    (first, title), *others = drawings
    panels = [drawing(shapes, time.size, name, above=i + 1 >= len(rigs)) for i, (shapes, name) in enumerate(others)]
    panels += beside(time, records, channels)
    columns = max(2, len(rigs))
    drawn = f"displacements {_times(factors[0])}, angles {_times(factors[1])}"
    words = [_words(*each) for each in zip(rigs, states, titles, strict=True)]
    told = [[_note(p, each, title) for each in at] for p, at, title in zip(rigs, states, titles, strict=True)]
    alone = planar_only([p for p, free in zip(rigs, space, strict=True) if not free])
    moving = animate(
        time, first, title=title, panels=panels, columns=columns, digits=4, width=9.5, key=key,
        height=0.8 + 3.9 * -(-(1 + len(panels)) // columns), seconds=seconds,
        alt=f"From {1e3 * time[0]:.4g} to {1e3 * time[-1]:.4g} ms in {time.size} pictures, {drawn}. {' '.join(words)} "
        f"Beside, of the same window: {', '.join(channels)}.",
        caption=f"{drawn.capitalize()}. Wires have the colour of their tension, circles are wires seen end on."
        + ("" if all(space) else " The height of P is not recorded, and is where the wires carry the mass.")
        + (f" Note: {alone}." if alone else ""),
        notes=["; ".join(each) for each in zip(*told, strict=True)],
    )  # fmt: skip
    if moving.megabytes > _MEGABYTES:
        told = f"frames = {frames} makes {moving.megabytes:.1f} MB of a page"
        raise ValueError(f"{told}; expected at most {_MEGABYTES:g} MB: fewer frames, rigs or channels")
    return moving


def _factor(name, value):
    if isinstance(value, str):
        return checks.one_of(name, value, ("auto",))
    return checks.real(name, value, low=0.0, high=1e6, low_open=True)


def _largest(rigs, states):
    """Largest displacement of all rigs over their wires' reach, and largest angle (rad)."""
    places = [
        np.abs([at[:, 0], x := spatial.axial_position(p, at), at[:, 0] - x, at[:, 3]]).max() / (p.Rm + p.d)
        for p, at in zip(rigs, states, strict=True)
    ]
    return max(places), max(np.abs(spatial.angles(at)).max() for at in states)


def _shown(factor, largest, drawn):
    if factor != "auto":
        return factor
    return max([1.0, *(each for each in _SERIES if each * largest <= drawn)])


def _times(factor):
    return "to scale" if factor == 1 else f"drawn {factor:g} times as large"


def _words(parameters, states, title):
    xs, x = states[:, 0], spatial.axial_position(parameters, states)
    tension, (roll, yaw, tilt) = spatial.wire_pull(parameters, states)[0], np.degrees(spatial.angles(states))
    space = f", its yaw reaches {abs(yaw).max():.2g}, its roll {abs(roll).max():.2g} degrees" if yaw.any() else ""
    return (
        f"{title}: the frame moves by {1e3 * np.ptp(xs):.3g} mm in all, the mass by {1e3 * np.ptp(xs - x):.3g} mm "
        f"against it; its tilt goes from {tilt.min():.3g} to {tilt.max():.3g} degrees{space}. Wires carry "
        f"{tension.min():.2g} to {tension.max():.2g} N."
    )


def _note(parameters, at, title):
    x, (_, yaw, tilt) = spatial.axial_position(parameters, at), np.degrees(spatial.angles(at))
    yaw = f", yaw {yaw:+.2g}°" if yaw else ""
    pulls = spatial.wire_pull(parameters, at)[0]
    text = f"xs {1e3 * at[0]:+.3f} mm, x {1e3 * x:+.3f} mm, tilt {tilt:+.2g}°{yaw}"
    return f"{title}: {text}, wires {pulls.min():.2g} to {pulls.max():.2g} N"


def rig_motion(parameters, record, start=0.0, stop=None, frames=48):
    """Evenly spaced instants (frames,) of a record (s), and the rig's states there, (frames, 15); see `model.spatial`.

    Arguments and errors are those of `rig_animation`.
    """
    (parameters,) = only_rigs([parameters])
    if record.tilt is None:
        raise ValueError("record has no tilt; expected one of the multi-body rig")
    if set(record.kinds.values()) != {"displacement"} or record.mass is None or record.base:
        raise ValueError(
            f"record has {', '.join(record.units)} in {', '.join(record.units.values())}; expected the force, "
            "and displacements of shaker and mass"
        )
    last = record.time[-1]
    start = checks.real("start", start, "s", low=0.0, high=last)
    stop = checks.real("stop", last if stop is None else stop, "s", low=start, high=last, low_open=True)
    frames = checks.integer("frames", frames, low=2, high=5000)  # a page holds them all
    time = np.linspace(start, stop, frames)
    if isinstance(record, SpaceRecord):
        return time, np.column_stack([np.interp(time, record.time, column) for column in record.states.T])
    lift = parameters.LG * np.gradient(np.gradient(np.sin(record.tilt))) * record.sample_rate**2
    channels = (record.shaker, record.mass, record.tilt, lift)
    return time, spatial.hung(parameters, *(np.interp(time, record.time, channel) for channel in channels))
