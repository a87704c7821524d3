"""A rig as it was mounted, in space: how it hangs and rocks where wires differ, or sit where they should not.

The planar rig has neither a long wire nor a turned set; the referee of `spatial` takes any pins, so what is wrong with
a rig is put into its wires there. A wire that is cut longer by e counts as one whose pin on the frame is nearer by e:
its tension is the same, its length in the geometry is short by the ten-thousandth part that e is of d.
"""

from dataclasses import dataclass, fields

import numpy as np

from .. import checks
from . import spatial
from .modes import Modes, largest_to_one, modes_of
from .planar import largest_tilt, static_equilibrium

COORDINATES = ("frame", "axial", "bounce", "sway", "roll", "yaw", "rocking")
# m and rad, of the differences that give the stiffness: less than what keeps a wire taut, half a micrometre by weight.
_NUDGE = np.array([1e-7] * 4 + [1e-6] * 3)


@dataclass(frozen=True)
class Mounting:
    """What is wrong with the first wire set: lengths in m, angles in rad; all of it may be zero.

    Attributes
    ----------
    long_wire : float
        By how much its upper wire was cut too long, or, negative, too short; less than d.
    clocked_set : float
        Angle by which its pins on the frame are turned about the axis; up to a tenth of a turn.
    skewed_set : float
        Angle by which their plane is turned about the vertical; likewise.
    """

    long_wire: float = 0.0
    clocked_set: float = 0.0
    skewed_set: float = 0.0

    def __post_init__(self):
        for item in fields(self):
            unit, most = ("m", 0.01) if item.name == "long_wire" else ("rad", 0.628)
            value = checks.real(item.name.replace("_", " "), getattr(self, item.name), unit, low=-most, high=most)
            object.__setattr__(self, item.name, value)

    def __bool__(self):
        return any(getattr(self, item.name) for item in fields(self))


def mounted(parameters, mounting):
    """One rig and its wires (8, 7) as `spatial.march` reads them, with what is wrong with them."""
    rigs, wires = spatial.pack([parameters])
    pins, (cx, sx), (cy, sy) = wires[0, :4, :3], *((np.cos(a), np.sin(a)) for a in (mounting.clocked_set,
                                                                                    mounting.skewed_set))  # fmt: skip
    centre = np.array([parameters.set_positions[0], 0.0, 0.0])
    about_axis = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_vertical = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    pins[:] = centre + (pins - centre) @ (about_vertical @ about_axis).T
    wire = pins[0] - wires[0, 0, 3:6] - [parameters.LG, 0.0, 0.0]
    pins[0] -= mounting.long_wire * wire / np.linalg.norm(wire)
    return rigs[0], wires[0]


def hung(parameters, mounting):
    """State (15,) at rest under gravity, followed from the planar rig of equal wires as they become what they are.

    `ValueError` if the planar rig has no equilibrium, or the mass does not come to rest within its wires' reach.
    """
    equal = parameters.replace(k=float(parameters.wire_stiffness.mean()))
    state = spatial.planar_state(static_equilibrium(equal).coordinates)
    (rig, last), (_, first) = mounted(parameters, mounting), mounted(equal, Mounting())
    share, increment = 0.0, 1.0
    if np.array_equal(first, last):
        return state
    while share < 1.0:
        trial = min(share + increment, 1.0)
        found = _at_rest(state, rig, (1 - trial) * first + trial * last)
        if found is not None and np.abs(spatial.angles(found)).max() < largest_tilt(parameters):
            state, share, increment = found, trial, 2 * increment
        else:
            increment /= 2
        if increment < 1e-4:
            raise ValueError(
                f"{mounting} with k from {min(parameters.wire_stiffness):g} to {max(parameters.wire_stiffness):g} N/m "
                f"leaves the mass without a place of rest near its middle at {share:.0%} of that; expected less"
            )
    return state


def _pulls(state, rig, wires):
    """Forces (7,) at rest: on the frame along x, on the mass along x, y, z, moments about the axes of the body."""
    pull = np.array(spatial.pull_of_wires(state, rig, wires))
    pull[1] -= rig["m"] * rig["gravity"]
    return np.concatenate([[-rig["ks"] * state[0] - spatial.pull_of_wires(state, rig, wires)[0]], pull])


def moved(state, by):
    """A state moved by xs, x, y, z (m) and small turns about the axes of the body (rad), (7,)."""
    result = state.copy()
    result[:4] += by[:4]
    w, v = state[4], state[5:8]
    half = np.asarray(by[4:]) / 2
    size = np.linalg.norm(half)
    c, s = np.cos(size), half * np.sinc(size / np.pi)
    result[4], result[5:8] = w * c - v @ s, w * s + c * v + np.cross(v, s)
    return result


def _stiffness(state, rig, wires):
    """Of the forces of `_pulls`, (7, 7), by fourth-order differences; symmetric at rest."""
    columns = []
    for i, nudge in enumerate(_NUDGE):
        one, two = (
            _pulls(moved(state, h * np.eye(7)[i]), rig, wires) - _pulls(moved(state, -h * np.eye(7)[i]), rig, wires)
            for h in (nudge, 2 * nudge)
        )
        columns.append((two - 8 * one) / (12 * nudge))
    matrix = np.column_stack(columns)
    return (matrix + matrix.T) / 2


def _at_rest(state, rig, wires):
    """State near one where no force is left, stable; or None."""
    reach = np.sqrt(rig["across"] / rig["m"])
    scale = np.array([1.0] * 4 + [1 / reach] * 3)
    for _ in range(60):
        values, vectors = np.linalg.eigh(_stiffness(state, rig, wires) * np.outer(scale, scale))
        # Curvature by modulus, so that a step always goes downhill, and no further than the wires are linear.
        step = scale * (vectors @ ((vectors.T @ (_pulls(state, rig, wires) * scale)) / np.maximum(abs(values), 1e-3)))
        size = np.abs(step / scale).max()
        state = moved(state, step * min(1.0, 3e-4 / max(size, 1e-300)))
        if size < 1e-13:
            break
    return state if values[0] > 0 and size < 1e-9 else None


def modes_in_space(parameters, mounting, state):
    """`Modes` of the rig about a state at rest: those of the plane, and "sway", "roll" and "yaw" out of it.

    Coordinates are xs, the mass's x, y, z (m), and its turns about its own axes: roll, yaw, rocking (rad). Damping is
    left out. `ValueError` if the state is unstable.
    """
    rig, wires = mounted(parameters, mounting)
    mass = np.diag([rig["ms"], *[rig["m"]] * 3, rig["about"], rig["across"], rig["across"]])
    _, _, tilt = spatial.angles(state)
    # Named as seen from the sets' middle, as `planar.linear_modes` does.
    about, arm = np.eye(7), parameters.LG - parameters.set_centre
    about[1:4, 6], about[3, 5] = arm * np.array([-np.sin(tilt), np.cos(tilt), 0.0]), -arm
    matrices = (about.T @ m @ about for m in (mass, np.zeros((7, 7)), _stiffness(state, rig, wires)))
    modes = modes_of(*matrices, names=COORDINATES)
    return Modes(modes.frequency, modes.damping, largest_to_one(modes.shape @ about.T), modes.names)
