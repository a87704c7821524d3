"""One basin trajectory: ten periods at 30 Hz and 3.18 N from 1024 states, exact law of the wires.

Unit: one of the same trajectories by SciPy's DOP853 driven by the same compiled right-hand side, at matched accuracy.
"""

import math

import numpy as np
from numba import njit
from run import fastest
from scipy.integrate import solve_ivp

from rigsim import RigParameters, attractors, basins
from rigsim.attraction.attractors import default_box, quasi_random
from rigsim.attraction.flow import accurate_flow

FORCE, FREQUENCY, PERIODS = 3.18, 30.0, 10


@njit
def rates(t, y, ms, ks, cs, m, c, spring, force, omega):
    """Eqs. (3a, b) with the force of Eq. (1), for SciPy."""
    z, (stiffness, d, d0, _) = y[1], spring
    length = math.sqrt(z * z + d * d)
    G = c * y[3] + stiffness * z * (z * z + (d - d0) * (d + d0)) / (length * (length + d0))
    shaker = (force * math.cos(omega * t) - cs * y[2] - ks * y[0] - G) / ms
    return np.array([y[2], y[3], shaker, shaker - G / m])


def by_scipy(state, flow, rtol, scale):
    """End of one trajectory."""
    span = 0, PERIODS / FREQUENCY
    return solve_ivp(rates, span, state, "DOP853", rtol=rtol, atol=rtol * scale, args=flow.numbers).y[:, -1]


def measure():
    """Rows (name, value, unit, ratio)."""
    rig = RigParameters()
    box = default_box(rig, FORCE, FREQUENCY)
    states = quasi_random(1024, box, 2)
    flow = accurate_flow(rig, "exact", FORCE, FREQUENCY, states, box)
    few = states[:16]
    exact = flow.refined(8).advance(few, PERIODS)

    def error(ends):
        return float(np.median(np.abs((ends - exact) / box).max(axis=1)))

    own = error(flow.advance(few, PERIODS))
    # The loosest tolerance, by factors of 1.5, at which SciPy is as accurate.
    rtol = 1e-4
    while error(np.array([by_scipy(state, flow, rtol, box) for state in few])) > own:
        rtol /= 1.5
    peer = error(np.array([by_scipy(state, flow, rtol, box) for state in few]))
    unit = fastest(lambda: [by_scipy(state, flow, rtol, box) for state in few]) / len(few)
    together = fastest(lambda: flow.advance(states, PERIODS)) / len(states)
    alone = fastest(lambda: [flow.advance(state[None], PERIODS) for state in few]) / len(few)
    found = attractors(rig, FORCE, FREQUENCY)
    settled = fastest(lambda: found.settle(states), 3) / len(states)
    whole = fastest(lambda: basins(rig, FORCE, FREQUENCY), 2)
    return [
        (f"unit: SciPy's DOP853, rtol {rtol:.1e}", 1e6 * unit, "us", 1.0),
        ("a trajectory among others, one thread: times faster", 1e6 * together, "us", unit / together),
        ("a trajectory alone: times faster", 1e6 * alone, "us", unit / alone),
        (f"median error in the box, {flow.steps} steps a period", own, "", None),
        ("median error in the box, SciPy", peer, "", None),
        ("a state brought to its motion, every core", 1e6 * settled, "us", settled / unit),
        ("basins: search, 121 x 121 picture, 2048 states", 1e3 * whole, "ms", whole / unit),
    ]
