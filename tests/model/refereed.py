"""What tests ask of the referee `rigsim.model.spatial`: tests run on it, its statics by energy, and SciPy's integrator.

The body is guided in the vertical plane where nothing else is said, which symmetry allows where left and right wires
are alike. Nothing is imported from the planar rig.
"""

from functools import partial

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import minimize, root

from rigsim.model import spatial

NO_TRACE = np.empty((0, spatial.SIZE))
FREE = np.zeros(8)
FREE[7] = 1.0


def rig_and_wires(parameters):
    """One rig as the compiled referee reads it."""
    rigs, wires = spatial.pack([parameters])
    return rigs.view(np.recarray)[0], wires[0]


def rates(rig, wires, drive, planar, t, state):
    """Time derivative of a state (15,)."""
    out = np.empty(np.size(state))
    spatial._rates(t, np.asarray(state, dtype=float), rig, wires, drive, planar, out)
    return out


def accelerations(parameters, q, v=(0.0, 0.0, 0.0, 0.0)):
    """Second derivative (4,) of planar coordinates xs, X, Y, tilt, free of forces."""
    return rates(*rig_and_wires(parameters), FREE, True, 0.0, spatial.planar_state(q, v))[[8, 9, 10, 14]]


def energy(parameters, state):
    """Potential energy (J) of wires, shaker spring and weight in a state (15,), by rotating pins as vectors."""
    p, (_, wires) = parameters, rig_and_wires(parameters)
    w, *vector = state[4:8] / np.linalg.norm(state[4:8])
    pins, vector = wires[:, 3:6], np.array(vector)
    once = 2 * np.cross(vector, pins)  # Rodrigues
    lines = state[1:4] + pins + w * once + np.cross(vector, once) - wires[:, :3] - [state[0], 0, 0]
    stretch = np.linalg.norm(lines, axis=1) - p.d0
    if p.tension_only:
        stretch = np.maximum(stretch, 0.0)
    return np.sum(wires[:, 6] * stretch**2) / 2 + p.ks * state[0] ** 2 / 2 + p.m * p.gravity * state[2]


def masses(parameters):
    """Of xs, X, Y and tilt (4,)."""
    return np.array([parameters.ms, parameters.m, parameters.m, parameters.inertia])


def residual(parameters, q):
    """Generalised static forces (4,) at planar coordinates: minus the gradient of `energy`, by forces and moments."""
    return accelerations(parameters, q) * masses(parameters)


def static_equilibrium(parameters):
    """(xs, X, Y, tilt) of least potential energy near the installed position."""
    p = parameters
    # metres and radians of the size of sag and tilt, and joules of the weight's work, so that the search is well scaled
    size = np.array([1e-4, 1e-4, 1e-6, 1e-2])
    installed, work = np.array([0.0, p.LG, 0.0, 0.0]), p.m * 9.81 * 1e-5
    height = lambda u: energy(p, spatial.planar_state(installed + size * u))  # noqa: E731
    base = height(np.zeros(4))
    found = minimize(lambda u: (height(u) - base) / work, np.zeros(4), method="BFGS")
    polished = root(lambda u: residual(p, installed + size * u) / p.m, found.x, method="hybr", tol=1e-14)
    return installed + size * polished.x


def linear_modes(parameters, q=None):
    """Undamped natural frequencies (Hz) and shapes (4, 4; columns) about ``q``, or the static equilibrium."""
    q = static_equilibrium(parameters) if q is None else np.asarray(q, dtype=float)
    columns = []
    for nudge in np.diag([1e-6, 1e-6, 1e-6, 1e-5]):
        # fourth-order central difference
        near = residual(parameters, q + nudge) - residual(parameters, q - nudge)
        far = residual(parameters, q + 2 * nudge) - residual(parameters, q - 2 * nudge)
        columns.append((far - 8 * near) / (12 * nudge.max()))
    hessian = np.column_stack(columns)
    squared, shapes = eigh((hessian + hessian.T) / 2, np.diag(masses(parameters)))
    return np.sign(squared) * np.sqrt(np.abs(squared)) / (2 * np.pi), shapes


def simulate_sine(
    parameters, force, frequency, duration=3.0, tap=None, start="rest", step=5e-5, method="compiled", turned=None
):
    """Drive the frame with F cos(omega t) and return t, xs, x, z, tilt of the last second, a sample every ``step``.

    ``method`` "compiled" is DOP853's formula with a fixed step; "scipy" is `scipy.integrate.solve_ivp` with DOP853.
    With ``turned``, roll and yaw (rad) at the start, the body is free, and roll and yaw are returned, too.
    """
    (rig, wires), state, planar = rig_and_wires(parameters), starting_state(parameters, start), turned is None
    if not planar:
        state = spatial.turned(state, *turned)
    cuts = {0.0, duration - 1.0, duration}
    if tap is not None:
        cuts |= {tap.time, tap.time + tap.duration}
    cuts = sorted(cut for cut in cuts if 0 <= cut <= duration)
    times, states = [np.array([cuts[0]])], [state[None, :].copy()]
    for low, high in zip(cuts[:-1], cuts[1:], strict=True):
        drive = np.array([force, 2 * np.pi * frequency, 0, 0, 0, 0, 0, 1.0])
        if tap is not None and tap.time <= low < tap.time + tap.duration:
            drive[5:] = parameters.m * tap.velocity * np.pi / (2 * tap.duration), tap.time, tap.duration
        steps = max(1, round((high - low) / step))
        t = low + (high - low) / steps * np.arange(1, steps + 1)
        if method == "compiled":
            trace = np.empty((steps, spatial.SIZE))
            spatial.march(state, low, (high - low) / steps, steps, rig, wires, drive, planar, trace)
        else:
            trace = scipy_march(state, low, t, rig, wires, drive, planar)
            state = trace[-1].copy()
        times.append(t)
        states.append(trace)
    t, states = np.concatenate(times), np.concatenate(states)
    last = t >= duration - 1.0 - step / 2
    return t[last], *outputs(parameters, states[last], planar)


def simulate_held(parameters, force, sample_rate, hold="zero", start="equilibrium", step=5e-5):
    """Response xs, x, z, tilt to a sampled force held "zero" or "linear"; sample k is before force[k] acts."""
    (rig, wires), state = rig_and_wires(parameters), starting_state(parameters, start)
    force = np.asarray(force, dtype=float)
    slopes = np.zeros(force.size)
    if hold == "linear":
        slopes[:-1] = np.diff(force) * sample_rate
    trace = np.empty((force.size, spatial.SIZE))
    substeps = int(np.ceil(1 / sample_rate / step - 1e-9))
    for k, (level, slope) in enumerate(zip(force, slopes, strict=True)):
        trace[k] = state
        drive = np.array([0, 0, level, slope, k / sample_rate, 0, 0, 1.0])
        spatial.march(state, k / sample_rate, 1 / sample_rate / substeps, substeps, rig, wires, drive, True, NO_TRACE)
    return outputs(parameters, trace, True)


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
    """State (15,) of the start "rest" or "equilibrium"."""
    at_rest = [0.0, parameters.LG, 0.0, 0.0]
    return spatial.planar_state(static_equilibrium(parameters) if start == "equilibrium" else at_rest)


def scipy_march(state, low, times, rig, wires, drive, planar=True):
    """States (n, 15) at ``times`` by SciPy's DOP853, which chooses its own steps."""
    # absolute tolerances far below the micrometres, milliradians and their rates that matter
    scale = np.array([1e-6] * 4 + [5e-5] * 4 + [1e-4] * 4 + [1e-2] * 3)
    solution = solve_ivp(
        partial(rates, rig, wires, drive, planar),
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


def outputs(parameters, states, planar):
    """xs, x and z (m) of states (n, 15), and their tilt where they are ``planar``, else roll, yaw and tilt (rad)."""
    xs, x = states[:, 0], spatial.axial_position(parameters, states)
    turned = spatial.angles(states)
    return xs, x, xs - x, *(turned[2:] if planar else turned)
