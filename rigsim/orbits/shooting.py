"""Periodic orbits of Eqs. (3a, b) by shooting in time, and their monodromy; of harmonic balance only the wires' law.

The state (xs, x, xs', x') and its derivative with respect to the initial state are carried over the orbit's period
together, in SI units, by Gragg's midpoint rule extrapolated to order 12 (Hairer, Norsett and Wanner, Solving Ordinary
Differential Equations I, section II.9). Newton's method on "the state returns" uses that derivative, the monodromy
matrix, whose eigenvalues at the converged orbit are its Floquet multipliers.
"""

import math
from dataclasses import dataclass

import numpy as np

from .. import checks
from ..compiled import compiled
from ..model.wires import axial_force, axial_stiffness, spring_of
from ..parameters import law_of, oscillator_of
from ..results import Result, Status

_STAGES = 6  # midpoint rules of 2, 4, ..., 12 substeps: order 12
_ANGLE = 0.6  # rad of the fastest motion in a step
_COARSER = 1.2  # steps longer than that are shortened before an orbit is believed
_MOST = 50  # times shorter at once
_FEWEST = 64  # steps to a forcing period, also the samples its lines are read from
_RETURNED = 1e-9  # of the orbit's own size: converged, since the Newton step before was quadratic


@dataclass(frozen=True, eq=False, repr=False)
class ShotOrbit(Result):
    """A periodic orbit found in time; what `shoot_orbit` returns.

    Attributes
    ----------
    frequency : float
        Forcing frequency (Hz).
    period : int
        Forcing periods after which the state returns.
    law : str
    state : (4,) array
        xs, x (m), xs', x' (m/s) where the force F cos(2 pi f t) is at its crest, t = 0.
    multipliers : (4,) complex array
        Eigenvalues of the monodromy matrix over ``period`` forcing periods, descending in modulus.
    shaker, mass, relative : (k,) complex array
        Lines of xs, x and z (m) at 0, f/period, 2 f/period, ...; see `OrbitBranch`.
    residual : float
        Largest change of the state over the period, relative to the orbit's size.
    status : Status
        CONVERGED or NOT_CONVERGED.
    message : str
    """

    frequency: float
    period: int
    law: str
    state: np.ndarray
    multipliers: np.ndarray
    shaker: np.ndarray
    mass: np.ndarray
    relative: np.ndarray
    residual: float
    status: Status
    message: str

    @property
    def converged(self):
        """Whether the state returns."""
        return self.status is Status.CONVERGED

    @property
    def stable(self):
        """Whether all multipliers lie inside the unit circle."""
        return bool(self.converged and (abs(self.multipliers) < 1).all())

    def summary(self):
        """One line: whether it returns, and the largest multiplier."""
        largest = abs(self.multipliers[0])
        told = f"{self.message}, largest multiplier {largest:.6g}"
        return f"ShotOrbit: period {self.period} at {self.frequency:g} Hz, {told}"


@compiled
def _rates(t, state, constants, force, omega, rates):
    """Time derivative of the state and of its four derivatives, (5, 4): row 0 the state."""
    ms, ks, cs, m, c = constants[0], constants[1], constants[2], constants[3], constants[4]
    z = state[0, 0] - state[0, 1]
    force_there, slope = axial_force(constants[5:], z), axial_stiffness(constants[5:], z)
    for i in range(5):
        stiff = force_there if i == 0 else slope * (state[i, 0] - state[i, 1])
        between = c * (state[i, 2] - state[i, 3]) + stiff
        rates[i, 0], rates[i, 1] = state[i, 2], state[i, 3]
        rates[i, 2] = -(cs * state[i, 2] + ks * state[i, 0] + between) / ms
        rates[i, 3] = between / m
    rates[0, 2] += force * math.cos(omega * t) / ms


@compiled
def _carry(start, constants, force, omega, duration, steps, path):
    """State and derivatives (5, 4) after ``duration``; the states (xs, x) before every step go into path."""
    h = duration / steps
    state = np.zeros((5, 4))
    state[0] = start
    for i in range(4):
        state[i + 1, i] = 1.0
    table = np.empty((_STAGES, 5, 4))
    first, rates = np.empty((5, 4)), np.empty((5, 4))
    for step in range(steps):
        path[step, 0], path[step, 1] = state[0, 0], state[0, 1]
        t = step * h
        _rates(t, state, constants, force, omega, first)
        for row in range(_STAGES):
            count = 2 * (row + 1)
            part = h / count
            before, here = state.copy(), state + part * first
            for k in range(1, count):
                _rates(t + k * part, here, constants, force, omega, rates)
                for i in range(5):
                    for j in range(4):
                        before[i, j], here[i, j] = here[i, j], before[i, j] + 2.0 * part * rates[i, j]
            table[row] = here
        for column in range(1, _STAGES):
            for row in range(_STAGES - 1, column - 1, -1):
                ratio = ((row + 1.0) / (row + 1.0 - column)) ** 2
                table[row] += (table[row] - table[row - 1]) / (ratio - 1.0)
        state[:] = table[_STAGES - 1]
    return state


def shoot_orbit(parameters, force, frequency, state, law=None, *, period=1, iterations=15):
    """The periodic orbit near an initial state, by Newton's method on the return of the state, and its stability.

    Parameters
    ----------
    parameters, force, law
        See `rigsim.orbits.periodic_orbits.periodic_orbits`.
    frequency : float
        Forcing frequency (Hz).
    state : (4,) array_like
        xs, x (m), xs', x' (m/s) at a crest of the force.
    period : int
        Forcing periods after which the state shall return. An orbit that returns sooner is found too.
    iterations : int
        Newton steps allowed.

    Returns
    -------
    ShotOrbit
        Its ``status`` and ``message`` say whether and how well the state returns.

    Raises
    ------
    ValueError
        If an input is not allowed, or the exact law is asked of a set without wires.
    """
    force, frequency = checks.positive("force", force, "N"), checks.positive("frequency", frequency, "Hz")
    state = checks.array("state", state, high=1e6, low=-1e6).copy()
    if state.size != 4:
        raise ValueError(f"state has {state.size} values; expected xs, x, xs', x'")
    period = checks.integer("period", period, low=1, high=1000)
    iterations = checks.integer("iterations", iterations, low=1, high=1000)
    law = law_of(parameters, law)
    o = oscillator_of(parameters)
    constants = np.array([o.ms, o.ks, o.cs, o.m, o.c, *spring_of(parameters, law)])
    omega = 2 * np.pi * frequency
    duration = period / frequency
    samples = _samples(constants, omega, period, abs(state[0] - state[1]) + abs(state[2] - state[3]) / omega)
    path = np.empty((samples, 2))
    residual = np.inf
    for _ in range(iterations):
        end = _carry(state, constants, force, omega, duration, samples, path)
        monodromy = end[1:].T
        size = np.abs(path).max() * np.array([1, 1, omega, omega])
        residual = float(np.max(np.abs(end[0] - state) / size)) if np.isfinite(end).all() else np.inf
        if not np.isfinite(residual):
            break
        if residual < _RETURNED:
            needed = _samples(constants, omega, period, abs(path[:, 0] - path[:, 1]).max())
            if needed <= samples * _COARSER:
                break
            # The orbit is larger than the start told: its steps were too long, and it may be none.
            samples, residual = min(needed, _MOST * samples), np.inf
            path = np.empty((samples, 2))
            continue
        state = state - np.linalg.solve(monodromy - np.eye(4), end[0] - state)
    values = np.linalg.eigvals(monodromy).astype(complex) if np.isfinite(monodromy).all() else np.full(4, np.nan + 0j)
    values = values[np.argsort(-abs(values))]
    if residual < _RETURNED:
        status, message = Status.CONVERGED, f"returns to {residual:.1e} of its size"
    else:
        status = Status.NOT_CONVERGED
        message = f"not converged in {iterations} Newton steps: the state changes by {residual:.1e} of the orbit's size"
    with np.errstate(invalid="ignore"):  # of a path that left all bounds
        lines = np.fft.rfft(path, axis=0)[: samples // 3] * (2 / samples)
    lines[0] /= 2
    shaker, mass = lines.T
    return ShotOrbit(frequency, period, law, state, values, shaker, mass, shaker - mass, residual, status, message)


def _samples(constants, omega, period, z):
    """Steps over the orbit's period, from the fastest motion at deflections up to z (m)."""
    ms, ks, _, m, _ = constants[:5]
    slope = axial_stiffness(constants[5:], z)
    fastest = np.sqrt(ks / ms + slope * (1 / m + 1 / ms))
    return period * max(_FEWEST, math.ceil(2 * np.pi / omega * fastest / _ANGLE))
