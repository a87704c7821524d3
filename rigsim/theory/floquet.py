"""Floquet multipliers about the single-term orbit (Eqs. (4a, b) linearised, as in the paper's Fig. 6).

About z = W cos(theta), theta = Omega tau, the cubic's slope 3 gamma z^2 is 2 U (1 + cos 2 theta) with
U = (3/4) gamma W^2. So the variational equation, with ' = d/d theta,

    y'' = -(2 zeta_s/Omega) y' - y/Omega^2 - mu G,      w'' = -(2 zeta_s/Omega) y' - y/Omega^2 - (1 + mu) G,
    G = (2 zeta/Omega) w' + (Omega0^2 + 2 U + 2 U cos 2 theta) w/Omega^2,

repeats after half a forcing period, and the phase of the orbit does not matter. The multipliers over a whole
period are the squares of the eigenvalues of the half-period map.

The orbit is the single-term approximation, not a solution: where its multipliers pass through the unit circle is
an approximation too, and a multiplier need not pass +1 at a fold of Eq. (5a). Where the high and middle solutions
run close together the two can part by tens of Hz: on the paper's rig at 3.18 N the high solution comes out unstable
from 69.0 to 79.1 Hz and the middle one stable from 72.1 Hz on, though they fold only at 106.9 Hz. Only multipliers
about converged orbits decide there.

`rigsim.orbits.stability.hill_multipliers` of the orbit's one line gives the same to 1e-9 on the paper's rig, at five
times the cost (measured for the 3777 solutions at 1501 frequencies); that is why this integration is kept.
"""

import math
from itertools import pairwise

import numpy as np

from ..campaign.stop import sliced
from ..compiled import compiled

_SLICE = 5000  # orbits at a time, some 0.1 s
_SLOWEST = 1e6  # times slower than the fastest rate
_ORDER = 22
_STEP = 2.5  # of the Taylor series, in units of the fastest rate: (2.5)^23/23! = 5e-14


@compiled
def _half_period_maps(mu, zeta_s, zeta, Omega0, Omega, U):
    """Maps of (y, w, y', w') over theta from 0 to pi, (n, 4, 4), by Taylor series.

    Everything is linear and the coefficients are entire, so a series of fixed order converges at any step; the
    step is kept well inside what the fastest rate of the equations asks for.
    """
    maps = np.empty((Omega.size, 4, 4))
    y = np.zeros((_ORDER + 1, 4))
    w = np.zeros((_ORDER + 1, 4))
    cosine = np.zeros(_ORDER + 1)
    product = np.zeros(4)
    for i in range(Omega.size):
        inverse = 1.0 / Omega[i]
        rate = math.sqrt(1.0 + (1.0 + mu) * (Omega0 * Omega0 + 4.0 * U[i])) + 2.0 * zeta_s + 2.0 * (1.0 + mu) * zeta
        steps = int(math.ceil(math.pi * (rate * inverse + 2.0) / _STEP))
        h = math.pi / steps
        shaker_damping, damping = 2.0 * zeta_s * inverse * h, 2.0 * zeta * inverse * h
        square = (h * inverse) ** 2
        mean, swing = square * (Omega0 * Omega0 + 2.0 * U[i]), square * 2.0 * U[i]
        state = np.eye(4)
        for step in range(steps):
            cosine[0], cosine[1] = math.cos(2.0 * step * h), -2.0 * h * math.sin(2.0 * step * h)
            for k in range(2, _ORDER + 1):
                cosine[k] = -4.0 * h * h * cosine[k - 2] / (k * (k - 1))
            for j in range(4):
                y[0, j], w[0, j] = state[0, j], state[1, j]
                y[1, j], w[1, j] = h * state[2, j], h * state[3, j]
            for k in range(_ORDER - 1):
                product[:] = 0.0
                for order in range(k + 1):
                    for j in range(4):  # innermost, so that it becomes one vector operation
                        product[j] += cosine[order] * w[k - order, j]
                for j in range(4):
                    G = damping * (k + 1) * w[k + 1, j] + mean * w[k, j] + swing * product[j]
                    common = shaker_damping * (k + 1) * y[k + 1, j] + square * y[k, j]
                    y[k + 2, j] = -(common + mu * G) / ((k + 1) * (k + 2))
                    w[k + 2, j] = -(common + (1.0 + mu) * G) / ((k + 1) * (k + 2))
            for j in range(4):
                position, relative, speed, rate_of_change = 0.0, 0.0, 0.0, 0.0
                for k in range(_ORDER, -1, -1):
                    position += y[k, j]
                    relative += w[k, j]
                    speed += k * y[k, j]
                    rate_of_change += k * w[k, j]
                state[0, j], state[1, j] = position, relative
                state[2, j], state[3, j] = speed / h, rate_of_change / h
        maps[i] = state
    return maps


def multipliers(group, Omega, U):
    """Floquet multipliers about the single-term orbits at Omega and U of one shape; NaN where U is.

    They are over one forcing period, complex, of the shape of ``U`` with an axis of 4 added, descending in modulus.
    """
    Omega, U = np.broadcast_arrays(np.asarray(Omega, dtype=float), U)
    result = np.full((*U.shape, 4), np.nan + 0j)
    known = np.isfinite(U)
    Omega, U, found = Omega[known], U[known], np.empty((np.count_nonzero(known), 4), dtype=complex)
    for part in sliced(len(found), _SLICE):
        maps = _half_period_maps(group.mu, group.zeta_s, group.zeta, group.Omega0, Omega[part], U[part])
        values = np.linalg.eigvals(maps).astype(complex) ** 2
        order = np.argsort(-abs(values), axis=-1, kind="stable")
        found[part] = np.take_along_axis(values, order, axis=-1)
    result[known] = found
    return result


def orbit_multipliers(oscillator, force, frequency, relative):
    """`multipliers` about single-term orbits of amplitude ``relative`` (m) at ``frequency`` (Hz), one shape."""
    group = oscillator.nondimensional(force)
    U = 0.75 * group.gamma * abs(relative * (oscillator.ks / force)) ** 2
    Omega = 2 * np.pi * frequency / oscillator.omega_s
    fastest = (
        np.sqrt(1 + (1 + group.mu) * (group.Omega0**2 + 4 * U)) + 2 * group.zeta_s + 2 * (1 + group.mu) * group.zeta
    )
    slow = fastest / (_SLOWEST * Omega)  # an orbit of more steps than that would take seconds
    if (slow > 1).any():
        at = np.unravel_index(np.nanargmax(slow), slow.shape)
        slowest = float(np.broadcast_to(frequency, slow.shape)[at])
        told = f"frequency = {slowest:g} Hz is not allowed for Floquet multipliers, so slow beside the rig's own rates"
        raise ValueError(f"{told}; expected at least {slowest * float(slow[at]):.3g} Hz")
    return multipliers(group, Omega, U)


def is_stable(multipliers):
    """Whether every multiplier lies inside the unit circle; False where they are NaN."""
    return (abs(multipliers) < 1).all(axis=-1)


def runs_of(stable):
    """Runs of equal stability along a curve, from that of its points (n,), bool: tuple of (slice, whether stable).

    Each run reaches up to the first point of the next, so that lines have no gap.
    """
    ends = [0, *(np.flatnonzero(np.diff(stable)) + 1).tolist(), len(stable)]
    return tuple((slice(start, stop + 1), bool(stable[start])) for start, stop in pairwise(ends))
