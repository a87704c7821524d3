"""The rig in three dimensions: the referee of the planar one, and what tells whether its motion stays in the plane.

A rigid cylinder hangs on springs from pins on the frame to pins on its surface: up and down along +-y, left and right
along -+z. Forces, and moments r x F about the centre of mass, are summed as vectors; the frame slides along x.
Nothing here knows the planar law and its hidden length, and nothing of it is imported.

State (15): xs, centre of mass (3), attitude as a quaternion (4, real part first), then the rates: of xs, of the centre
of mass (3), and the angular velocity (3) in axes of the body, whose first is the cylinder's. P lies LG behind the
centre of mass on that axis; at rest P is at the origin. In a planar state the lateral shift, two parts of the
quaternion, and the rates of all three are zero.

Rocking damping resists the turning of the axis, in whatever direction, and not the spin about it, in which nothing
rocks: a moment -c (omega - (omega . a) a), in the plane the planar rig's own. Dampers of wires pull along the wires,
and the axial damper pulls P along x.
"""

import itertools

import numpy as np
from scipy.integrate._ivp import dop853_coefficients
from scipy.spatial.transform import Rotation

from ..compiled import compiled
from ..parameters import rig_of

RIG = np.dtype([(name, float) for name in (
    "ms", "ks", "cs", "m", "about", "across", "c", "LG", "d0", "gravity", "wire_damping", "rocking_damping", "slack",
)], align=True)  # fmt: skip
SIZE = 15
OUT = 6  # numbers of a deviation out of the plane, see `_lateral_rates`
_BISECTIONS = 45  # of half a wire, down to a femtometre
_STAGES = dop853_coefficients.N_STAGES
_A = np.ascontiguousarray(dop853_coefficients.A[:_STAGES, :_STAGES])
_B = np.ascontiguousarray(dop853_coefficients.B)
_C = np.ascontiguousarray(dop853_coefficients.C[:_STAGES])


def pack(parameters):
    """Rigs (n,) and wires (n, 8, 7) as compiled loops read them: pin on the frame, pin from the centre of mass, k.

    Rigs of one set have four wires of no stiffness. `ValueError` if one is no rig.
    """
    rigs, wires = np.zeros(len(parameters), dtype=RIG), np.zeros((len(parameters), 8, 7))
    outward = np.array([[0, 1, 0], [0, -1, 0], [0, 0, -1], [0, 0, 1]], dtype=float)
    for i, p in enumerate(parameters):
        p = rig_of(p)
        about = p.m * p.Rm**2 / 2
        rigs[i] = (p.ms, p.ks, p.cs, p.m, about, p.inertia, p.c, p.LG, p.d0, p.gravity, p.wire_damping,
                   p.rocking_damping, p.tension_only)  # fmt: skip
        sections = np.repeat([[a, 0.0, 0.0] for a in p.set_positions], 4, axis=0)
        radial = np.tile(outward, (len(p.set_positions), 1))
        wires[i, :, :3] = 10 * (p.d + p.d0)  # of the absent wires, whose length must not vanish
        wires[i, : len(radial), :3] = sections + (p.Rm + p.d) * radial
        wires[i, : len(radial), 3:6] = sections + p.Rm * radial - [p.LG, 0.0, 0.0]
        wires[i, : len(radial), 6] = p.wire_stiffness
    return rigs, wires


def planar_state(q, v=(0.0, 0.0, 0.0, 0.0)):
    """State (15,) of planar coordinates xs, X, Y, tilt and their rates, (4,) each."""
    state = np.zeros(SIZE)
    state[[0, 1, 2, 8, 9, 10, 14]] = *q[:3], *v
    state[4], state[7] = np.cos(q[3] / 2), np.sin(q[3] / 2)
    return state


def planar_numbers(state):
    """Coordinates xs, X, Y, tilt and their rates (8,) of a planar state."""
    return np.array([*state[:3], 2 * np.arctan2(state[7], state[4]), *state[8:11], state[14]])


def drive(force, frequency, tap=None, mass=0.0):
    """What `march` takes as its drive: a cosine on the frame (N, Hz), and the pulse of a `Tap` on the mass (kg)."""
    pulse = (0.0, 0.0, 1.0)
    if tap is not None:
        pulse = mass * tap.velocity * np.pi / (2 * tap.duration), tap.time, tap.duration
    return np.array([force, 2 * np.pi * frequency, 0.0, 0.0, 0.0, *pulse])


def stretches(force, frequency, tap, mass, *cuts):
    """(begin, end, drive) of a test between instants (s), of which the begin and the end of a `Tap` are two more."""
    plain, cuts = drive(force, frequency), set(cuts) | (set() if tap is None else {tap.time, tap.time + tap.duration})
    for low, high in itertools.pairwise(sorted(cuts)):
        tapped = tap is not None and tap.time <= low < tap.time + tap.duration
        yield low, high, drive(force, frequency, tap, mass) if tapped else plain


def rates(state, rig, wires, forces=(0.0,) * 7 + (1.0,), planar=True):
    """Time derivative of a state at t = 0 with deviations behind it or none, see `march`; of the same shape."""
    out = np.empty(len(state))
    _rates(0.0, np.asarray(state, dtype=float), rig, wires, np.asarray(forces), planar, out)
    return out


def turned(state, roll, yaw):
    """A planar state (15,), rolled and yawed by small angles (rad) about the cylinder's own axes."""
    w, x, y, z = state[4], roll / 2, yaw / 2, state[7]
    result = state.copy()
    # the product of (w, 0, 0, z) and (1, x, y, 0)
    result[4:8] = np.array([w, w * x - z * y, w * y + z * x, z]) / np.sqrt(1 + x * x + y * y)
    return result


def angles(states):
    """Roll, yaw and tilt (rad), each (...,), of states (..., 15): about the axis, of it out of the plane, and in it."""
    w, x, y, z = np.moveaxis(states[..., 4:8] / np.linalg.norm(states[..., 4:8], axis=-1)[..., None], -1, 0)
    yaw = np.arcsin(np.clip(2 * (w * y - x * z), -1, 1))
    tilt = np.arctan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z))
    return np.arctan2(2 * (y * z + w * x), 1 - 2 * (x * x + y * y)), yaw, tilt


def axial_position(parameters, states):
    """x of P (m), shape (...,), of states (..., 15)."""
    w, x, y, z = np.moveaxis(states[..., 4:8], -1, 0)
    return states[..., 1] - parameters.LG * (1 - 2 * (y * y + z * z) / (w * w + x * x + y * y + z * z))


def wire_pull(parameters, states):
    """Tension of each wire (N), shape (..., 4 wire_sets), and the way from its pin on the body to that on the frame.

    The way (m) has shape (..., 4 wire_sets, 3), wires the rig's order. A tension below zero pushes; one that lets go
    pulls with nothing. Dampers of wires are left out.
    """
    rigs, wires = pack([parameters])
    wires = wires[0, : 4 * parameters.wire_sets]
    shape = states.shape[:-1]
    turn = Rotation.from_quat(states.reshape(-1, SIZE)[:, 4:8], scalar_first=True).as_matrix().reshape(*shape, 3, 3)
    shaken = states[..., None, :1] * [1.0, 0.0, 0.0]
    way = wires[:, :3] + shaken - states[..., None, 1:4] - np.einsum("...ij,wj->...wi", turn, wires[:, 3:6])
    tension = wires[:, 6] * (np.linalg.norm(way, axis=-1) - parameters.d0)
    return np.where(tension < 0, 0.0, tension) if rigs["slack"][0] else tension, way


def hung(parameters, shaker, mass, tilt, lift=0.0):
    """Planar states (n, 15), rates left zero, of xs, x of P (m) and tilt (rad), each (n,), where no height is known.

    The height is the one at which the wires carry the mass while it is accelerated upwards by ``lift`` (n,) (m/s^2),
    found by bisection: the higher it hangs, the less they hold.
    """
    states = np.zeros((shaker.size, SIZE))
    states[:, 0], states[:, 1] = shaker, mass + parameters.LG * np.cos(tilt)
    states[:, 4], states[:, 7] = np.cos(tilt / 2), np.sin(tilt / 2)
    middle, half = parameters.LG * np.sin(tilt), parameters.d / 2
    load = parameters.m * (parameters.gravity + lift)
    for _ in range(_BISECTIONS):
        states[:, 2], half = middle, half / 2
        tension, way = wire_pull(parameters, states)
        held = (tension * way[..., 1] / np.linalg.norm(way, axis=-1)).sum(axis=-1)
        middle = middle + np.where(held > load, half, -half)
    states[:, 2] = middle
    return states


@compiled
def _turn(y):
    """Rotation matrix of a state's quaternion, whatever its length, row by row."""
    w, i, j, k = y[4], y[5], y[6], y[7]
    s = 2.0 / (w * w + i * i + j * j + k * k)
    return (
        1.0 - s * (j * j + k * k), s * (i * j - k * w), s * (i * k + j * w),
        s * (i * j + k * w), 1.0 - s * (i * i + k * k), s * (j * k - i * w),
        s * (i * k - j * w), s * (j * k + i * w), 1.0 - s * (i * i + j * j),
    )  # fmt: skip


@compiled
def pull_of_wires(y, rig, wires):
    """Resultant of the wires: force in space, then moment about the centre of mass in axes of the body."""
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = _turn(y)
    ox, oy, oz = y[12], y[13], y[14]
    fx = fy = fz = mx = my = mz = 0.0
    for n in range(wires.shape[0]):
        bx, by, bz, k = wires[n, 3], wires[n, 4], wires[n, 5], wires[n, 6]
        # arm, and wire from the frame's pin to the body's
        ax, ay, az = r11 * bx + r12 * by + r13 * bz, r21 * bx + r22 * by + r23 * bz, r31 * bx + r32 * by + r33 * bz
        lx, ly, lz = y[1] + ax - wires[n, 0] - y[0], y[2] + ay - wires[n, 1], y[3] + az - wires[n, 2]
        length = np.sqrt(lx * lx + ly * ly + lz * lz)
        if k == 0.0 or (rig.slack != 0.0 and length < rig.d0):
            continue
        pull = -k * (length - rig.d0)
        if rig.wire_damping != 0.0:
            # the pin's velocity against the centre of mass is omega x b
            ux, uy, uz = oy * bz - oz * by, oz * bx - ox * bz, ox * by - oy * bx
            rate = lx * (y[9] + r11 * ux + r12 * uy + r13 * uz - y[8])
            rate += ly * (y[10] + r21 * ux + r22 * uy + r23 * uz)
            rate += lz * (y[11] + r31 * ux + r32 * uy + r33 * uz)
            pull -= rig.wire_damping * rate / length
        pull /= length
        lx, ly, lz = pull * lx, pull * ly, pull * lz
        fx += lx
        fy += ly
        fz += lz
        mx += ay * lz - az * ly
        my += az * lx - ax * lz
        mz += ax * ly - ay * lx
    return (
        fx, fy, fz,
        r11 * mx + r21 * my + r31 * mz, r12 * mx + r22 * my + r32 * mz, r13 * mx + r23 * my + r33 * mz,
    )  # fmt: skip


@compiled
def _rates(t, y, rig, wires, drive, planar, out):
    """Time derivative of a state, and of the deviations behind it if there are any, into ``out``.

    ``drive`` holds what `march` says; ``planar`` guides the body in the plane.
    """
    fx, fy, fz, mx, my, mz = pull_of_wires(y, rig, wires)
    turn = _turn(y)
    r12, r13 = turn[1], turn[2]
    ox, oy, oz = y[12], y[13], y[14]
    # The damper's force on P, whose velocity against the centre of mass is LG (0, -oz, oy) in axes of the body.
    damper = rig.c * (y[8] - y[9] - rig.LG * (r13 * oy - r12 * oz))
    my += rig.LG * r13 * damper
    mz -= rig.LG * r12 * damper
    push = drive[0] * np.cos(drive[1] * t) + drive[2] + drive[3] * (t - drive[4])
    pulse = drive[5] * np.sin(np.pi * (t - drive[6]) / drive[7]) if drive[5] != 0.0 else 0.0
    for j in range(4):
        out[j] = y[8 + j]
    out[4] = (-y[5] * ox - y[6] * oy - y[7] * oz) / 2
    out[5] = (y[4] * ox + y[6] * oz - y[7] * oy) / 2
    out[6] = (y[4] * oy + y[7] * ox - y[5] * oz) / 2
    out[7] = (y[4] * oz + y[5] * oy - y[6] * ox) / 2
    out[8] = (push - rig.ks * y[0] - rig.cs * y[8] - fx - damper) / rig.ms
    out[9] = (fx + damper + pulse) / rig.m
    out[10] = fy / rig.m - rig.gravity
    out[11] = fz / rig.m
    out[12] = mx / rig.about
    out[13] = (my - rig.rocking_damping * oy + (rig.across - rig.about) * oz * ox) / rig.across
    out[14] = (mz - rig.rocking_damping * oz - (rig.across - rig.about) * ox * oy) / rig.across
    if planar:
        out[3] = out[5] = out[6] = out[11] = out[12] = out[13] = 0.0
    for column in range((y.size - 15) // 6):
        _lateral_rates(y, rig, wires, damper, y[15 + 6 * column :], out[15 + 6 * column :])


@compiled
def _lateral_rates(y, rig, wires, damper, u, out):
    """The equations out of the plane, linear about a planar state ``y``, with the axial ``damper``'s force (N) there.

    A deviation u (6) is lateral shift, roll and yaw about the body's axes, then the shift's rate and the angular
    velocity about these axes. It is R = Rz(tilt) (1 + [e]x) with e = (roll, yaw, 0), hence omega = e' + tilt' ez x e.
    """
    cos, sin = y[4] * y[4] - y[7] * y[7], 2.0 * y[4] * y[7]
    spin, shift, roll, yaw, ox, oy = y[14], u[0], u[1], u[2], u[4], u[5]
    fz = mx = my = 0.0
    for n in range(wires.shape[0]):
        k = wires[n, 6]
        if k == 0.0:
            continue
        bx, by, bz = wires[n, 3], wires[n, 4], wires[n, 5]
        # The wire, and its change, in axes that tilt with the body.
        ax, ay = y[1] - wires[n, 0] - y[0], y[2] - wires[n, 1]
        lx, ly, lz = cos * ax + sin * ay + bx, -sin * ax + cos * ay + by, bz - wires[n, 2]
        dx, dy, dz = yaw * bz, -roll * bz, shift + roll * by - yaw * bx
        square = lx * lx + ly * ly + lz * lz
        length = np.sqrt(square)
        if rig.slack != 0.0 and length < rig.d0:
            continue
        along = (lx * dx + ly * dy + lz * dz) / square
        # Force g = -T l/|l|, so that its change is -(dT l/|l| + T (d - along l)/|l|).
        tension, more = k * (length - rig.d0), k * along * length
        if rig.wire_damping != 0.0:
            ax, ay = y[9] - y[8], y[10]
            vx, vy = cos * ax + sin * ay - spin * by, -sin * ax + cos * ay + spin * bx
            # e x (omega0 x b) + omega x b, omega0 = spin ez, and the shift's rate
            wx, wy = oy * bz, -ox * bz
            wz = u[3] + roll * spin * bx + yaw * spin * by + ox * by - oy * bx
            rate = (lx * vx + ly * vy) / length
            tension += rig.wire_damping * rate
            more += rig.wire_damping * ((dx * vx + dy * vy + lx * wx + ly * wy + lz * wz) / length - rate * along)
        tension, more = tension / length, more / length - tension * along / length
        gx, gy, gz = -tension * lx, -tension * ly, -tension * lz
        cx, cy, cz = -more * lx - tension * dx, -more * ly - tension * dy, -more * lz - tension * dz
        fz += cz
        # The body sees the force turned back by e.
        cx, cy, cz = cx - yaw * gz, cy + roll * gz, cz - roll * gy + yaw * gx
        mx += by * cz - bz * cy
        my += bz * cx - bx * cz
    my += rig.LG * damper * (roll * sin + yaw * cos)
    out[0] = u[3]
    out[1] = ox + spin * yaw
    out[2] = oy - spin * roll
    out[3] = fz / rig.m
    out[4] = mx / rig.about
    out[5] = (my - rig.rocking_damping * oy + (rig.across - rig.about) * spin * ox) / rig.across


@compiled(nogil=True)
def march(state, start, step, steps, rig, wires, drive, planar, trace):
    """DOP853's eighth-order formula with a fixed step: move a state, in place, from the time ``start`` (s).

    Parameters
    ----------
    state : ndarray, shape (15 + 6 c,)
        With c deviations out of the plane behind it, which linear equations move; then it has to be planar.
    start, step : float
        s.
    steps : int
    rig, wires
        Of `pack`, one rig's.
    drive : ndarray, shape (8,)
        Force on the frame d[0] cos(d[1] t) + d[2] + d[3] (t - d[4]), and on the centre of mass along x a pulse
        d[5] sin(pi (t - d[6])/d[7]); N, rad/s and s.
    planar : bool
        Whether the body is guided in the plane.
    trace : ndarray, shape (samples, 15 + 6 c)
        Takes the state after every so many steps that they fill it; ``samples`` divides ``steps``, or is zero.
    """
    size = state.size
    stages = np.empty((_STAGES, size))
    inner = np.empty(size)
    every = steps // trace.shape[0] if trace.shape[0] else steps + 1
    for n in range(steps):
        t = start + n * step
        for s in range(_STAGES):
            inner[:] = state
            for r in range(s):
                weight = step * _A[s, r]
                if weight != 0.0:
                    for j in range(size):
                        inner[j] += weight * stages[r, j]
            _rates(t + _C[s] * step, inner, rig, wires, drive, planar, stages[s])
        for s in range(_STAGES):
            weight = step * _B[s]
            for j in range(size):
                state[j] += weight * stages[s, j]
        if (n + 1) % every == 0:
            trace[(n + 1) // every - 1] = state
