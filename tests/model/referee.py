"""Referee of the multi-body rig: its equations of motion written a second time, in three dimensions.

A rigid cylinder hangs on four or eight real three-dimensional springs, each from a pin on the frame to
a pin on the cylinder's surface: up and down along +-y, left and right along +-z. Forces and moments are
summed as vectors, F and r x F about the centre of mass. The motion is then restricted to the vertical
plane, which symmetry allows: the resultants out of it vanish (a test shows so). Nothing here knows the
planar law with a hidden length, and nothing is imported from the rig's own model.

State: xs, X, Y (centre of mass), tilt (counter-clockwise), then their rates. P lies LG behind the centre
of mass along the axis; at rest P is at the origin.
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp
from scipy.integrate._ivp import dop853_coefficients
from scipy.linalg import eigh
from scipy.optimize import minimize, root

STAGES = dop853_coefficients.N_STAGES
A = np.ascontiguousarray(dop853_coefficients.A[:STAGES, :STAGES])
B = np.ascontiguousarray(dop853_coefficients.B)
C = np.ascontiguousarray(dop853_coefficients.C[:STAGES])


class Tap(NamedTuple):
    """A half-sine force pulse along +x through the centre of mass, of impulse m x velocity."""

    velocity: float = 0.5
    duration: float = 2e-3
    time: float = 1.0


class Spatial(NamedTuple):
    """The rig in three dimensions; pins in metres, from P on the frame and from the centre of mass on the cylinder."""

    frame_pins: np.ndarray  # (wires, 3)
    mass_pins: np.ndarray  # (wires, 3)
    stiffness: np.ndarray  # (wires,)
    d0: float
    LG: float
    ms: float
    ks: float
    cs: float
    m: float
    inertia: float
    c: float
    gravity: float
    wire_damping: float
    rocking_damping: float
    tension_only: bool


class Drive(NamedTuple):
    """Force on the frame, amplitude cos(omega t) + level + slope (t - since), and a half-sine pulse on the mass."""

    amplitude: float = 0.0
    omega: float = 0.0
    level: float = 0.0
    slope: float = 0.0
    since: float = 0.0
    peak: float = 0.0
    pulse_start: float = 0.0
    pulse_duration: float = 1.0


def spatial(parameters):
    """The three-dimensional rig of a `RigParameters`."""
    p = parameters
    outward = np.array([[0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
    sections = np.repeat([[a, 0.0, 0.0] for a in p.set_positions], 4, axis=0)
    radial = np.tile(outward, (len(p.set_positions), 1))
    return Spatial(
        sections + (p.Rm + p.d) * radial,
        sections + p.Rm * radial - [p.LG, 0.0, 0.0],
        np.array(p.wire_stiffness, dtype=float),
        *(float(v) for v in (p.d0, p.LG, p.ms, p.ks, p.cs, p.m, p.inertia, p.c, p.gravity)),
        float(p.wire_damping),
        float(p.rocking_damping),
        bool(p.tension_only),
    )


def energy(rig, q):
    """Potential energy (J) of wires, shaker spring and weight at q = (xs, X, Y, tilt)."""
    xs, X, Y, tilt = q
    turn = np.array([[np.cos(tilt), -np.sin(tilt), 0], [np.sin(tilt), np.cos(tilt), 0], [0, 0, 1]])
    wires = np.array([X, Y, 0]) + rig.mass_pins @ turn.T - rig.frame_pins - np.array([xs, 0, 0])
    stretch = np.linalg.norm(wires, axis=1) - rig.d0
    if rig.tension_only:
        stretch = np.maximum(stretch, 0.0)
    return np.sum(rig.stiffness * stretch**2) / 2 + rig.ks * xs**2 / 2 + rig.m * rig.gravity * Y


@njit(cache=True)
def _wrench(rig, state):
    frame_pins, mass_pins, stiffness, d0, _, _, _, _, _, _, _, _, wire_damping, _, tension_only = rig
    xs, X, Y, tilt, vs, vX, vY, spin = state
    cos, sin = np.cos(tilt), np.sin(tilt)
    fx = fy = fz = mx = my = mz = 0.0
    for i in range(stiffness.size):
        rx = cos * mass_pins[i, 0] - sin * mass_pins[i, 1]
        ry = sin * mass_pins[i, 0] + cos * mass_pins[i, 1]
        rz = mass_pins[i, 2]
        lx = X + rx - frame_pins[i, 0] - xs
        ly = Y + ry - frame_pins[i, 1]
        lz = rz - frame_pins[i, 2]
        length = np.sqrt(lx * lx + ly * ly + lz * lz)
        if tension_only and length < d0:
            continue
        # velocity of the pin is v + spin e_z x r
        rate = (lx * (vX - spin * ry - vs) + ly * (vY + spin * rx)) / length
        pull = -(stiffness[i] * (length - d0) + wire_damping * rate) / length
        gx, gy, gz = pull * lx, pull * ly, pull * lz
        fx += gx
        fy += gy
        fz += gz
        mx += ry * gz - rz * gy
        my += rz * gx - rx * gz
        mz += rx * gy - ry * gx
    return fx, fy, fz, mx, my, mz


@njit(cache=True)
def _rates(t, state, rig, drive, out):
    _, _, _, _, LG, ms, ks, cs, m, inertia, c, gravity, _, rocking_damping, _ = rig
    amplitude, omega, level, slope, since, peak, pulse_start, pulse_duration = drive
    xs, X, Y, tilt, vs, vX, vY, spin = state
    fx, fy, _, _, _, mz = _wrench(rig, state)
    # height of P from the centre of mass
    py = -LG * np.sin(tilt)
    damper = c * (vs - (vX - spin * py))
    push = amplitude * np.cos(omega * t) + level + slope * (t - since)
    pulse = 0.0
    if peak != 0.0:
        pulse = peak * np.sin(np.pi * (t - pulse_start) / pulse_duration)
    out[0], out[1], out[2], out[3] = vs, vX, vY, spin
    out[4] = (push - ks * xs - cs * vs - fx - damper) / ms
    out[5] = (fx + damper + pulse) / m
    out[6] = fy / m - gravity
    out[7] = (mz - py * damper - rocking_damping * spin) / inertia


@njit(cache=True)
def _march(state, start, step, steps, rig, drive, trace):
    """DOP853's eighth-order formula with a fixed step; ``trace`` (steps, 8) takes every state, or is empty."""
    stages = np.empty((STAGES, 8))
    inner = np.empty(8)
    for n in range(steps):
        t = start + n * step
        for s in range(STAGES):
            for j in range(8):
                increment = 0.0
                for r in range(s):
                    increment += A[s, r] * stages[r, j]
                inner[j] = state[j] + step * increment
            _rates(t + C[s] * step, inner, rig, drive, stages[s])
        for j in range(8):
            increment = 0.0
            for s in range(STAGES):
                increment += B[s] * stages[s, j]
            state[j] += step * increment
        if trace.shape[0]:
            trace[n] = state


@njit(cache=True)
def _march_held(state, interval, substeps, levels, slopes, rig, trace):
    """One interval a sample, the force constant or linear in it; ``trace`` (samples, 8), each before its force acts."""
    nothing = np.empty((0, 8))
    for k in range(levels.size):
        trace[k] = state
        since = k * interval
        drive = (0.0, 0.0, levels[k], slopes[k], since, 0.0, 0.0, 1.0)
        _march(state, since, interval / substeps, substeps, rig, drive, nothing)


def wrench(rig, state):
    """Resultant of the wires on the cylinder (6): force, then moment about the centre of mass, in space."""
    return _wrench(tuple(rig), state)


def rates(rig, drive, t, state):
    """Time derivative of the state (8)."""
    out = np.empty(8)
    _rates(t, state, tuple(rig), tuple(drive), out)
    return out


def static_equilibrium(parameters):
    """(xs, X, Y, tilt) of least potential energy near the installed position."""
    rig = spatial(parameters)
    # metres and radians of the size of sag and tilt, and joules of the weight's work, so that the search is well scaled
    size = np.array([1e-4, 1e-4, 1e-6, 1e-2])
    installed = np.array([0.0, rig.LG, 0.0, 0.0])
    base, work = energy(rig, installed), rig.m * 9.81 * 1e-5
    found = minimize(lambda u: (energy(rig, installed + size * u) - base) / work, np.zeros(4), method="BFGS")
    polished = root(lambda u: residual(rig, installed + size * u) / rig.m, found.x, method="hybr", tol=1e-14)
    return installed + size * polished.x


def residual(rig, q):
    """Generalised static forces (4): minus the gradient of `energy`, by forces and moments."""
    accelerations = rates(rig, Drive(), 0.0, np.concatenate([q, np.zeros(4)]))[4:]
    return accelerations * [rig.ms, rig.m, rig.m, rig.inertia]


def linear_modes(parameters, q=None):
    """Undamped natural frequencies (Hz) and shapes (4, 4; columns) about ``q``, or the static equilibrium."""
    rig = spatial(parameters)
    q = static_equilibrium(parameters) if q is None else np.asarray(q, dtype=float)
    columns = []
    for nudge in np.diag([1e-6, 1e-6, 1e-6, 1e-5]):
        # fourth-order central difference
        near = residual(rig, q + nudge) - residual(rig, q - nudge)
        far = residual(rig, q + 2 * nudge) - residual(rig, q - 2 * nudge)
        columns.append((far - 8 * near) / (12 * nudge.max()))
    hessian = np.column_stack(columns)
    squared, shapes = eigh((hessian + hessian.T) / 2, np.diag([rig.ms, rig.m, rig.m, rig.inertia]))
    return np.sign(squared) * np.sqrt(np.abs(squared)) / (2 * np.pi), shapes


def simulate_sine(parameters, force, frequency, duration=3.0, tap=None, start="rest", step=5e-5, method="compiled"):
    """Drive the frame with F cos(omega t) and return t, xs, x, z, tilt of the last second, a sample every ``step``.

    ``method`` "compiled" is DOP853's formula with a fixed step; "scipy" is `scipy.integrate.solve_ivp` with DOP853.
    """
    rig, state = spatial(parameters), starting_state(parameters, start)
    sine = Drive(float(force), 2 * np.pi * frequency)
    cuts = {0.0, duration - 1.0, duration}
    if tap is not None:
        cuts |= {tap.time, tap.time + tap.duration}
    cuts = sorted(cut for cut in cuts if 0 <= cut <= duration)
    times, states = [np.array([cuts[0]])], [state[None, :].copy()]
    for low, high in zip(cuts[:-1], cuts[1:], strict=True):
        drive = sine
        if tap is not None and tap.time <= low < tap.time + tap.duration:
            peak = rig.m * tap.velocity * np.pi / (2 * tap.duration)
            drive = sine._replace(peak=peak, pulse_start=tap.time, pulse_duration=tap.duration)
        steps = max(1, round((high - low) / step))
        t = low + (high - low) / steps * np.arange(1, steps + 1)
        if method == "compiled":
            trace = np.empty((steps, 8))
            _march(state, low, (high - low) / steps, steps, tuple(rig), tuple(drive), trace)
        else:
            trace = scipy_march(state, low, t, rig, drive)
            state = trace[-1].copy()
        times.append(t)
        states.append(trace)
    t, states = np.concatenate(times), np.concatenate(states)
    last = t >= duration - 1.0 - step / 2
    return t[last], *_outputs(rig, states[last])


def simulate_held(parameters, force, sample_rate, hold="zero", start="equilibrium", step=5e-5):
    """Response xs, x, z, tilt to a sampled force held "zero" or "linear"; sample k is before force[k] acts."""
    rig, state = spatial(parameters), starting_state(parameters, start)
    force = np.asarray(force, dtype=float)
    slopes = np.zeros(force.size)
    if hold == "linear":
        slopes[:-1] = np.diff(force) * sample_rate
    trace = np.empty((force.size, 8))
    substeps = int(np.ceil(1 / sample_rate / step - 1e-9))
    _march_held(state, 1 / sample_rate, substeps, force, slopes, tuple(rig), trace)
    return _outputs(rig, trace)


def fourier(t, u, frequency):
    """Complex amplitude U of u = Re(U exp(i omega t)), least squares with a mean over the last whole periods."""
    periods = np.floor((t[-1] - t[0]) * frequency + 1e-9)
    # half open, so that no sample of the periods is counted twice
    window = t > t[-1] - periods / frequency + 1e-9
    phase = 2 * np.pi * frequency * t[window]
    columns = np.column_stack([np.ones(phase.size), np.cos(phase), np.sin(phase)])
    _, real, minus_imaginary = np.linalg.lstsq(columns, u[window], rcond=None)[0]
    return complex(real, -minus_imaginary)


def starting_state(parameters, start):
    """State (8) of the start "rest" or "equilibrium"."""
    state = np.zeros(8)
    state[1] = parameters.LG
    if start == "equilibrium":
        state[:4] = static_equilibrium(parameters)
    return state


def scipy_march(state, low, times, rig, drive):
    """States (n, 8) at ``times`` by SciPy's DOP853, which chooses its own steps."""
    # absolute tolerances far below the micrometres, milliradians and their rates that matter
    scale = np.array([1e-6, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4, 1e-4, 1e-2])
    solution = solve_ivp(
        partial(rates, rig, drive),
        (low, times[-1]),
        state,
        method="DOP853",
        t_eval=times,
        rtol=1e-10,
        atol=1e-7 * scale,
    )
    if not solution.success:
        raise RuntimeError(solution.message)
    return solution.y.T


def _outputs(rig, states):
    xs, tilt = states[:, 0], states[:, 3]
    x = states[:, 1] - rig.LG * np.cos(tilt)
    return xs, x, xs - x, tilt
