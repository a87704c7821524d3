"""The rig's parts as points in its vertical plane, to be joined by lines: what every picture of it is drawn from."""

import numpy as np

from ... import checks
from ...model.planar import pack
from ...parameters import RigParameters

SETS = {1: "one wire set", 2: "two wire sets"}


def only_rigs(rigs):
    """The rigs as a tuple; `ValueError` if one is not a `RigParameters`."""
    rigs = tuple(rigs)
    for p in rigs:
        if not isinstance(p, RigParameters):
            raise ValueError(f"parameters = {checks.shown(p)} has no shape to draw; expected RigParameters")
    return rigs


def rig_parts(parameters, coordinates, exaggeration=1.0):
    """The parts of the rig in its vertical plane, as points to be joined by lines.

    Cylinder, wires and pins are to scale; frame, guide, shaker and damper are schematic, with
    sizes that follow from the wires' reach.

    Parameters
    ----------
    parameters : RigParameters
    coordinates : array_like, shape (..., 4)
        xs, X, Y (m) and tilt (rad), as in `rigsim.model.planar`.
    exaggeration : float
        The tilt about P is drawn this many times as large.

    Returns
    -------
    dict of str to ndarray, shape (..., n, 2)
        m. "frame" and "mass" are closed outlines; "wires", "shaker" and "damper" lines interrupted by NaN; "rollers",
        "pins" (frame and mass pin of each wire in the plane), "hidden" (where the wires across the plane
        are pinned), "P" and "G" points; "ground", shape (n, 2), stands still.
    """
    coordinates = np.asarray(coordinates, dtype=float)
    exaggeration = checks.real("exaggeration", exaggeration, low=0.0, high=1e6, low_open=True)
    xs, X, Y, tilt = np.moveaxis(coordinates, -1, 0)
    P = np.stack([X - parameters.LG * np.cos(tilt), Y - parameters.LG * np.sin(tilt)], axis=-1)[..., None, :]
    cos, sin = np.cos(exaggeration * tilt)[..., None], np.sin(exaggeration * tilt)[..., None]

    def on_mass(along, across):
        along, across = np.asarray(along), np.asarray(across)
        return P + np.stack([cos * along - sin * across, sin * along + cos * across], axis=-1)

    def on_frame(points):
        points = np.asarray(points, dtype=float)
        return points + np.stack([xs, np.zeros_like(xs)], axis=-1)[..., None, :]

    wires = pack([parameters])[1][0][: 3 * parameters.wire_sets]
    planar, across = wires[wires["hidden"] == 0], wires[wires["hidden"] > 0]
    frame_pins = on_frame(np.column_stack([planar["anchor_x"], planar["anchor_y"]]))
    mass_pins = on_mass(planar["along"] + parameters.LG, planar["across"])
    ends = parameters.LG + parameters.Lm / 2 * np.array([-1, 1, 1, -1])
    mass = on_mass(ends, parameters.Rm * np.array([-1, -1, 1, 1]))
    half, top, bar, wall = frame_sizes(parameters)
    frame = np.array(
        [[-half, top], [half, top], [half, top - bar], [bar - half, top - bar],
         [bar - half, bar - top], [half, bar - top], [half, -top], [-half, -top]]
    )  # fmt: skip
    left, level = on_frame([[-half, 0.0]]), 0.35 * top
    behind = (mass[..., :1, :] + mass[..., 3:, :]) / 2
    return {
        "ground": _ground(half, top, bar, wall),
        "frame": on_frame(frame),
        "rollers": on_frame([[-0.7 * half, -top - bar / 2], [0.7 * half, -top - bar / 2]]),
        "shaker": _joined(
            _spring(wall, left + [0, level], 0.06 * top), _dashpot(wall, left - [0, level], 0.06 * top)
        ),
        "damper": _dashpot(on_frame([[bar - half, 0.0]]), behind, 0.04 * top),
        "mass": mass,
        "wires": _joined(*(_joined(frame_pins[..., i : i + 1, :], mass_pins[..., i : i + 1, :], gap=False)
                           for i in range(len(planar)))),
        "pins": np.concatenate([frame_pins, mass_pins], axis=-2),
        "hidden": on_mass(across["along"] + parameters.LG, across["across"]),
        "P": P,
        "G": on_mass([parameters.LG], [0.0]),
    }  # fmt: skip


def frame_sizes(parameters):
    """Half length and half height of the frame, its bars' thickness, and where the shaker's wall stands (m)."""
    reach = parameters.Rm + parameters.d
    bar = 0.08 * reach
    half = parameters.Lm / 2 + abs(parameters.LG) + 0.35 * reach
    return half, reach + bar, bar, -half - 0.8 * max(reach, half)


def _joined(*lines, gap=True):
    """Lines one after the other, shape (..., n, 2), with a NaN between them if ``gap``."""
    shape = np.broadcast_shapes(*(line.shape[:-2] for line in lines))
    parts = []
    for line in lines:
        parts.append(np.broadcast_to(line, (*shape, *line.shape[-2:])))
        if gap:
            parts.append(np.full((*shape, 1, 2), np.nan))
    return np.concatenate(parts[:-1] if gap else parts, axis=-2)


def _between(begin, end, along, across):
    """Points at a share of the way from begin to end and at a distance (m) across it, which is upwards."""
    way = np.asarray(along)[:, None] * (end - begin)
    return begin + way + np.column_stack([np.zeros(len(across)), across])


def _spring(wall, end, width):
    along = np.concatenate([[0, 0.2], np.linspace(0.2, 0.8, 9)[:-1] + 0.0375, [0.8, 1]])
    across = np.concatenate([[0, 0], width * (-1.0) ** np.arange(8), [0, 0]])
    begin = np.stack([np.full(end.shape[:-1], wall), end[..., 1]], axis=-1)
    return _between(begin, end, along, across)


def _dashpot(begin, end, width):
    if np.isscalar(begin):
        begin = np.stack([np.full(end.shape[:-1], begin), end[..., 1]], axis=-1)
    cup = _between(begin, end, [0, 0.35, 0.35, 0.7, 0.35, 0.35, 0.7], width * np.array([0, 0, 1, 1, 1, -1, -1]))
    plunger = _between(begin, end, [0.55, 0.55, 0.55, 1], 0.7 * width * np.array([1, -1, 0, 0]))
    return _joined(cup, plunger)


def _ground(half, top, bar, wall):
    """Wall and guide with their hatching."""
    floor = -top - bar
    tick = 0.6 * bar
    lines = [np.array([[wall, 0.6 * top], [wall, -0.6 * top]]), np.array([[-1.1 * half, floor], [1.1 * half, floor]])]
    lines += [np.array([[wall, y], [wall - tick, y - tick]]) for y in np.linspace(-0.55, 0.6, 10) * top]
    lines += [np.array([[x, floor], [x - tick, floor - tick]]) for x in np.linspace(-1.05, 1.1, 16) * half]
    return _joined(*lines)
