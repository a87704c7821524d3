"""What a rig of masses and terms does under a recorded force, and how that depends on each of its parameters.

The masses obey m_i a_i = b_i f(t) - sum_t p_t phi_t(r_t) d_ti, or -m_i f(t) in place of b_i f(t) where f is the
acceleration of the base that they stand on and are displaced from. A term acts along a direction d_t between two
masses, or a mass and the ground; phi_t is any function of the relative displacement or velocity r_t. The derivatives by
masses, coefficients and first state obey the derivative of that equation and are integrated with it by the classical
Runge-Kutta rule, so they are those of the computed motion to rounding. Between samples the force is a polynomial.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import make_interp_spline

from ..campaign.stop import sliced
from ..compiled import compiled

SENSED = ("displacement", "velocity", "acceleration")
_SLICE = 20_000  # samples at a time, some 0.1 s
_POINTS = 4096  # of a law's table, which holds a cubic to rounding
_REACH = 3.0  # times what was met: a fit goes beyond the record's motion
_ANGLE = 0.2  # rad of the fastest mode in a step, of which 2e-4 are lost, a sixteenth with each halving
_SMOOTH = 5  # degree of the splines that a band-limited force is
_MOST = 50  # steps a sample
_TIMES = np.array([0.0, 0.5, 0.5, 1.0])
_WEIGHTS = np.array([1.0, 2.0, 2.0, 1.0]) / 6


@dataclass(frozen=True, eq=False)
class Structure:
    """Masses and terms, without their values.

    Attributes
    ----------
    masses : tuple of str
        Names of the masses, d of them.
    terms : tuple of Term
        What acts between them.
    sensors : tuple of (int, str)
        The mass each output belongs to, and which of `SENSED` it is.
    driven : tuple of float
        Share of the recorded force that acts on each mass.
    base : bool
        Whether the input is the acceleration of a base (m/s^2), whatever ``driven`` says. Displacements and velocities
        are relative to it, accelerations are not. Of all parameters only ratios are in such outputs, and a fit keeps
        the first mass.
    """

    masses: tuple
    terms: tuple
    sensors: tuple
    driven: tuple
    base: bool = False

    @property
    def names(self):
        """Of all parameters: masses, then coefficients of terms."""
        return (*self.masses, *(term.name for term in self.terms))

    def directions(self):
        """Of all terms, shape (terms, d)."""
        return np.array([term.direction(len(self.masses)) for term in self.terms])


@dataclass(frozen=True, eq=False)
class Run:
    """Samples of the force of one test or more, end to end, and what it did between them.

    ``begins`` are the first samples of each part, where the motion begins anew, and ``joints`` those of each test,
    where the force does, too.
    """

    force: np.ndarray
    sample_rate: float
    hold: str
    begins: tuple = (0,)
    joints: tuple = (0,)

    def parts(self):
        """Slices of the samples of each part."""
        return _slices(self.begins, self.force.size)

    def pieces(self):
        """The force over each sample interval, a polynomial of the time in it (s): coefficients, lowest first."""
        return np.concatenate([self._pieces(self.force[test]) for test in _slices(self.joints, self.force.size)])

    def _pieces(self, force):
        if self.hold == "zero":
            return force[:, None]
        if self.hold == "linear":
            return np.column_stack([force, np.append(np.diff(force), 0.0) * self.sample_rate])
        samples = np.arange(force.size)
        spline = make_interp_spline(samples, force, k=_SMOOTH)
        return np.column_stack([
            spline(samples, power) * self.sample_rate**power / math.factorial(power) for power in range(_SMOOTH + 1)
        ])  # fmt: skip


def _slices(begins, size):
    return [slice(*ends) for ends in zip(begins, (*begins[1:], size), strict=True)]


def simulate(structure, values, run, starts, reach, wanted=(), extra=None, finer=1):
    """Outputs of a rig, and their derivatives.

    Parameters
    ----------
    structure : Structure
    values : ndarray, shape (parameters,)
        Masses and coefficients, in the order of its names.
    run : Run
        The force.
    starts : ndarray, shape (parts, 2 d)
        Displacements and velocities where each part begins.
    reach : ndarray, shape (terms,)
        Largest relative displacement or velocity that each term was seen at: its law is followed for three times that,
        and runs on straight.
    wanted : sequence of int
        Parameters whose derivatives are wanted, by their place in the names; those by the start of a part come after.
    extra : ndarray, shape (n, forces), optional
        Small forces beside the recorded one, held at their values (N): what each would add comes last.
    finer : int
        Times the steps that are needed at least.

    Returns
    -------
    outputs : ndarray, shape (n, q)
    columns : ndarray, shape (n, q, len(wanted) + 2 d + forces)
        Empty where nothing is wanted.
    """
    d, terms = len(structure.masses), structure.terms
    masses, coefficients = values[:d], values[d:]
    tables, low, step = _tables(terms, reach)
    bent = np.flatnonzero([term.law is not None for term in terms])
    of_velocity = np.array([term.of == "velocity" for term in terms])
    sensed = np.array([(mass, SENSED.index(what)) for mass, what in structure.sensors])
    extra = np.zeros((run.force.size, 0)) if extra is None else extra
    derived = np.array([*wanted, *[-1] * (2 * d), *[-2] * extra.shape[1]]) if len(wanted) else np.zeros(0, dtype=int)
    forces, interval = run.pieces(), 1 / run.sample_rate
    driven, carried = np.array(structure.driven, dtype=float) / masses, np.zeros(d)
    if structure.base:
        driven, carried = np.zeros(d), np.full(d, -1.0)
    steps = max(1.0, np.ceil(_fastest(structure, values, reach) * interval / _ANGLE)) * finer
    outputs = np.empty((run.force.size, len(sensed)))
    columns = np.empty((run.force.size, len(sensed), derived.size))
    if not steps <= _MOST * finer:  # no rig that was sampled so slowly
        return np.full_like(outputs, np.nan), np.full_like(columns, np.nan)
    state, slopes = np.empty(2 * d), np.empty((2 * d, derived.size))
    for whole, start in zip(run.parts(), starts, strict=True):
        state[:] = start
        slopes[:] = 0.0
        if derived.size:
            slopes[np.arange(2 * d), len(wanted) + np.arange(2 * d)] = 1.0
        for part in sliced(whole.stop - whole.start, _SLICE):
            part = slice(whole.start + part.start, whole.start + part.stop)
            _march(
                state, slopes, forces[part], extra[part], interval, int(steps), masses, driven, carried,
                coefficients, structure.directions(), of_velocity, bent, tables, low, step, derived, sensed,
                outputs[part], columns[part],
            )  # fmt: skip
    if structure.base and derived.size:  # an acceleration is that of the base as well
        columns[:, sensed[:, 1] == 2, derived.size - extra.shape[1] :] += extra[:, None]
    return outputs, columns


def displaced(structure, values, run, starts, reach):
    """Displacements and velocities of all masses, (n, d) each; arguments as of `simulate`."""
    d = len(structure.masses)
    sensors = tuple((mass, what) for what in SENSED[:2] for mass in range(d))
    outputs, _ = simulate(replace(structure, sensors=sensors), values, run, starts, reach)
    return outputs[:, :d], outputs[:, d:]


def _fastest(structure, values, reach):
    """Largest angular frequency of the rig with its laws as stiff as they get (rad/s)."""
    d = len(structure.masses)
    stiffness = np.zeros((d, d))
    for term, coefficient, most, direction in zip(
        structure.terms, values[d:], reach, structure.directions(), strict=True
    ):
        if term.of == "displacement":
            tangent = (
                1.0
                if term.law is None
                else np.abs(np.gradient(term.law(np.linspace(-most, most, 201)))).max() * 100 / most
            )
            stiffness += abs(coefficient) * tangent * np.outer(direction, direction)
    root = 1 / np.sqrt(values[:d])
    return np.sqrt(np.linalg.eigvalsh(root[:, None] * stiffness * root)[-1])


def _tables(terms, reach):
    """Values and slopes times the step of each law over its reach, (terms, points, 2), first points and steps."""
    tables, low, step = np.zeros((len(terms), _POINTS, 2)), np.zeros(len(terms)), np.ones(len(terms))
    for index, (term, most) in enumerate(zip(terms, reach, strict=True)):
        if term.law is None:
            continue
        low[index], step[index] = -_REACH * most, 2 * _REACH * most / (_POINTS - 1)
        points = low[index] + step[index] * np.arange(_POINTS)
        nudge = 1e-3 * step[index]
        tables[index, :, 0] = term.law(points)
        tables[index, :, 1] = (term.law(points + nudge) - term.law(points - nudge)) / 2e-3
    return tables, low, step


@compiled
def _law(table, low, step, r):
    """phi(r) and its slope."""
    place = (r - low) / step
    last = table.shape[0] - 1
    if place < 0 or place > last:
        end = 0 if place < 0 else last
        return table[end, 0] + table[end, 1] * (place - end), table[end, 1] / step
    at = min(int(place), last - 1)
    s = place - at
    rise = table[at + 1, 0] - table[at, 0]
    curve, twist = 3 * rise - 2 * table[at, 1] - table[at + 1, 1], table[at, 1] + table[at + 1, 1] - 2 * rise
    value = table[at, 0] + s * (table[at, 1] + s * (curve + s * twist))
    return value, (table[at, 1] + s * (2 * curve + 3 * s * twist)) / step


@compiled
def _march(
    state, slopes, forces, extra, interval, steps, masses, driven, carried, coefficients, directions, of_velocity, bent,
    tables, low, step, derived, sensed, outputs, columns,
):  # fmt: skip
    """Take a state and its derivatives over the next samples, and write down what the sensors see before each."""
    d, count, terms = masses.size, derived.size, coefficients.size
    h = interval / steps
    # The linear terms and the tangent of all, over displacements and velocities: forces on the masses, over their mass.
    linear, tangent = np.zeros((d, 2 * d)), np.empty((d, 2 * d))
    straight = np.ones(terms, np.bool_)
    straight[bent] = False
    for n in range(terms):
        shift = d if of_velocity[n] else 0
        for i in range(d):
            for j in range(d):
                if straight[n]:
                    linear[i, shift + j] -= coefficients[n] * directions[n, i] * directions[n, j] / masses[i]
    phi = np.zeros(terms)
    x, dx = state.copy(), slopes.copy()
    rate, drate = np.empty(2 * d), np.empty((2 * d, count))
    total, dtotal = np.empty(2 * d), np.empty((2 * d, count))
    for k in range(forces.shape[0]):
        for part in range(steps):
            total[:] = 0.0
            dtotal[:] = 0.0
            for stage in range(4):
                t = (part + _TIMES[stage]) * h
                if stage == 0:
                    x[:] = state
                    dx[:] = slopes
                else:
                    ahead = _TIMES[stage] * h
                    for i in range(2 * d):
                        x[i] = state[i] + ahead * rate[i]
                        for j in range(count):
                            dx[i, j] = slopes[i, j] + ahead * drate[i, j]
                f = forces[k, -1]
                for power in range(forces.shape[1] - 2, -1, -1):
                    f = forces[k, power] + t * f
                for i in range(d):
                    rate[i] = x[d + i]
                    force = (driven[i] + carried[i]) * f
                    for j in range(2 * d):
                        tangent[i, j] = linear[i, j]
                        force += linear[i, j] * x[j]
                    rate[d + i] = force
                for n in bent:
                    shift = d if of_velocity[n] else 0
                    r = 0.0
                    for i in range(d):
                        r += directions[n, i] * x[shift + i]
                    phi[n], slope = _law(tables[n], low[n], step[n], r)
                    for i in range(d):
                        share = coefficients[n] * directions[n, i] / masses[i]
                        rate[d + i] -= share * phi[n]
                        for j in range(d):
                            tangent[i, shift + j] -= share * slope * directions[n, j]
                if count:
                    for i in range(d):
                        for j in range(count):
                            drate[i, j] = dx[d + i, j]
                            drate[d + i, j] = 0.0
                        for n in range(2 * d):
                            for j in range(count):
                                drate[d + i, j] += tangent[i, n] * dx[n, j]
                    places = 0
                    for j in range(count):
                        p = derived[j]
                        if p >= d:
                            if straight[p - d]:
                                shift = d if of_velocity[p - d] else 0
                                phi[p - d] = 0.0
                                for i in range(d):
                                    phi[p - d] += directions[p - d, i] * x[shift + i]
                            for i in range(d):
                                drate[d + i, j] -= phi[p - d] * directions[p - d, i] / masses[i]
                        elif p >= 0:
                            drate[d + p, j] -= (rate[d + p] - carried[p] * f) / masses[p]
                        elif p == -2:
                            for i in range(d):
                                drate[d + i, j] += (driven[i] + carried[i]) * extra[k, places]
                            places += 1
                if stage == 0 and part == 0:
                    for i in range(sensed.shape[0]):
                        place, what = sensed[i, 0] + d * min(sensed[i, 1], 1), sensed[i, 1]
                        outputs[k, i] = x[place] if what < 2 else rate[place] - carried[sensed[i, 0]] * f
                        for j in range(count):
                            columns[k, i, j] = dx[place, j] if what < 2 else drate[place, j]
                for i in range(2 * d):
                    total[i] += _WEIGHTS[stage] * rate[i]
                    for j in range(count):
                        dtotal[i, j] += _WEIGHTS[stage] * drate[i, j]
            for i in range(2 * d):
                state[i] += h * total[i]
                for j in range(count):
                    slopes[i, j] += h * dtotal[i, j]
