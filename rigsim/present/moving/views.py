"""The rig from the side and from above, moved as much larger as is said, its wires coloured by their tension."""

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex
from scipy.spatial.transform import Rotation

from ...model import spatial
from ..figures.rig_parts import frame_sizes, rig_parts
from ..figures.style import BLACK, BLUE, GREY
from .plot import Key
from .shapes import Shape

# Part of the drawing, kind of line, name in the legend, colour: below the mass and its wires, and on top of them.
_BELOW = (
    ("ground", "line", "", GREY),
    ("frame", "outline", "frame", GREY),
    ("rollers", "point", "", BLACK),
    ("shaker", "line", "", BLACK),
    ("damper", "line", "", BLACK),
    ("mass", "outline", "suspended mass", BLUE),
)
_ABOVE = (("pins", "dot", "", BLACK), ("P", "point", "P", BLACK), ("G", "dot", "centre of mass", BLUE))
_CLASSES = 7  # of tension, at most
_STEPS = ((1, 1.5, 2, 3, 5, 7), (1, 2, 5))  # of a decade of them, the finest that has no more classes
_CORNERS = 40  # of a cylinder's outline in space


def tension_key(tensions):
    """`Key` of the tensions (N) in arrays: classes on a scale of round numbers, the more taut the darker."""
    taut = np.concatenate([each[each > 0] for each in tensions])
    least, largest = (taut.min(), taut.max()) if taut.size else (1.0, 1.0)
    for steps in _STEPS:
        series = np.outer(10.0 ** (np.floor(np.log10(largest)) + np.arange(-8, 3)), steps).ravel()
        low = np.searchsorted(series, least * (1 + 1e-9)) - 1
        high = np.searchsorted(series, largest * (1 - 1e-9))
        if high - low <= _CLASSES:
            break
    limits = series[max(low, high - _CLASSES) : high + 1]
    if least < limits[0]:
        limits[0] = 0.0
    shades = colormaps["plasma_r"](np.linspace(0.2, 0.95, len(limits) - 1))
    return Key("tension of a wire [N]", limits, tuple(map(to_hex, shades)))


def view(parameters, states, key, displacement, angles, above=False):
    """Shapes of a rig from the side (x, y) or, if ``above``, from there (x, z).

    Parameters
    ----------
    parameters : RigParameters
    states : ndarray, shape (frames, 15)
        As in `rigsim.model.spatial`.
    key : Key
    displacement, angles : float
        Displacements, and tilt, yaw and roll, are drawn this many times as large.
    """
    second = 2 if above else 1
    roll, yaw, tilt = spatial.angles(states)
    tension, _ = spatial.wire_pull(parameters, states)
    axis = np.stack([np.cos(tilt) * np.cos(yaw), np.sin(tilt) * np.cos(yaw), -np.sin(yaw)], axis=-1)
    xs, P = displacement * states[:, 0], displacement * (states[:, 1:4] - parameters.LG * axis)
    turn = Rotation.from_euler("ZYX", angles * np.stack([tilt, yaw, roll], axis=-1)).as_matrix()
    wires = spatial.pack([parameters])[1][0, : tension.shape[1]]
    begin = wires[:, :3] + xs[:, None, None] * [1.0, 0.0, 0.0]
    on_mass = wires[:, 3:6] + [parameters.LG, 0.0, 0.0]
    end = P[:, None] + np.einsum("fij,wj->fwi", turn, on_mass)
    begin, end = begin[..., [0, second]], end[..., [0, second]]

    seen = angles * (-yaw if above else tilt)  # seen from above, a yaw turns the other way
    centre = P[:, [0, second]] + parameters.LG * np.stack([np.cos(seen), np.sin(seen)], axis=-1)
    parts = rig_parts(parameters, np.column_stack([xs, centre, seen]))
    if roll.any() or yaw.any():
        middle = P + parameters.LG * turn[:, :, 0]
        parts |= {"G": middle[:, None, [0, second]], "mass": _outline(parameters, middle, turn[:, :, 0], second)}
    # Of each set, up and down are seen from the side, left and right from above, and of the others the nearer one.
    place, nearer = np.arange(tension.shape[1]) % 4, 0 if above else 3
    across = (place < 2) == above
    parts["pins"] = np.concatenate([begin[:, ~across], end[:, ~across]], axis=1)
    if above:
        _, top, _, wall = frame_sizes(parameters)
        parts |= {"ground": np.array([[wall, -0.6 * top], [wall, 0.6 * top]]), "rollers": np.empty((0, 2))}
    gap = np.full_like(begin, np.nan)
    lines = np.stack([begin, end, gap], axis=2)
    return [
        *(Shape(parts[name], *look) for name, *look in _BELOW),
        *_by_tension(lines[:, ~across], tension[:, ~across], key, "wire", "slack", parameters),
        *_by_tension(end[:, place == nearer, None], tension[:, place == nearer], key, "point", "point", parameters),
        *(Shape(parts[name], *look) for name, *look in _ABOVE),
    ]


def _by_tension(points, tension, key, kind, slack, parameters):
    """A shape for each class of tension: of the points (frames, wires, n, 2) those whose wire is of that class."""
    frames = len(points)
    number = np.searchsorted(key.limits[1:-1], tension)
    number[tension <= 0] = -1
    word = "slack wire" if parameters.tension_only else "wire that pushes"
    looks = {-1: (slack, word if kind == "wire" else "", GREY)}
    looks |= {n: (kind, "", color) for n, color in enumerate(key.colors)}
    shapes = []
    for n, look in looks.items():
        these = number == n
        if these.any():
            shapes.append(Shape(np.where(these[..., None, None], points, np.nan).reshape(frames, -1, 2), *look))
    return shapes


def _outline(parameters, centre, axis, second):
    """Outline of the cylinder, shape (frames, n, 2): the points that lie farthest out in each direction."""
    angle = 2 * np.pi * (np.arange(_CORNERS) + 0.3) / _CORNERS
    outward = np.zeros((_CORNERS, 3))
    outward[:, 0], outward[:, second] = np.cos(angle), np.sin(angle)
    along = axis @ outward.T
    radial = outward - along[..., None] * axis[:, None]
    radial *= parameters.Rm / np.linalg.norm(radial, axis=-1)[..., None]
    ends = np.sign(along)[..., None] * axis[:, None] * parameters.Lm / 2
    return (centre[:, None] + ends + radial)[..., [0, second]]
