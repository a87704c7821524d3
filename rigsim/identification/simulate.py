"""What a rig of masses and terms does under a recorded force, and how that depends on each of its parameters.

The masses obey m_i a_i = b_i f(t) - sum_t p_t phi_t(r_t) d_ti, or -m_i f(t) in place of b_i f(t) where f is the
acceleration of the base that they stand on and are displaced from. A term acts along a direction d_t between two
masses, or a mass and the ground; phi_t is any function of the relative displacement or velocity r_t. The derivatives by
masses, coefficients and first state obey the derivative of that equation and are integrated with it by the classical
Runge-Kutta rule, so they are those of the computed motion to rounding. Between samples the force is a polynomial.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline
from scipy.ndimage import spline_filter1d
from scipy.special import factorial

from ..campaign.stop import sliced
from ..compiled import compiled
from ..experiment.joints import slices

SENSED = ("displacement", "velocity", "acceleration")
_MASSES = 2  # that are followed
_START, _FORCE = -1, -2  # derivatives by the first state, and by a force beside the recorded one
_GONE = 1e-12  # of a first state
_LANES = 8  # derivatives side by side, of each in turn: the state's four, ...
_SHARE, _FELT, _SEEN, _ROWS = 4, 6, 10, 16  # ... what moves the masses, its size at four stages, and what sensors see
_SLICE = 4000  # samples at a time, whose columns stay in the processor's cache
_POINTS = 4096  # of a law's table, which holds a cubic to rounding
_REACH = 3.0  # times what was met: a fit goes beyond the record's motion
_ANGLE = 0.2  # rad of the fastest mode in a step, of which 2e-4 are lost, a sixteenth with each halving
_FORGOTTEN = 50  # samples, after which such a spline knows nothing of its ends
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
        Names of the masses, d of them: one or two.
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
        return slices(self.begins, self.force.size)

    def pieces(self):
        """The force over each sample interval, a polynomial of the time in it (s): coefficients, lowest first."""
        return np.concatenate([self._pieces(self.force[test]) for test in slices(self.joints, self.force.size)])

    def _pieces(self, force):
        if self.hold == "zero":
            return force[:, None]
        if self.hold == "linear":
            return np.column_stack([force, np.append(np.diff(force), 0.0) * self.sample_rate])
        powers = np.arange(_SMOOTH + 1)
        scale = self.sample_rate**powers / factorial(powers)
        ends = 2 * _FORGOTTEN
        if force.size <= 2 * ends:
            spline = make_interp_spline(np.arange(force.size), force, k=_SMOOTH)
            return np.column_stack([spline(np.arange(force.size), power) for power in powers]) * scale
        # Far from the ends the splines that are summed are all alike.
        size, one = spline_filter1d(force, _SMOOTH, mode="mirror"), BSpline.basis_element(np.arange(_SMOOTH + 2))
        found = np.empty((force.size, powers.size))
        for power, unit in zip(powers, scale, strict=True):
            found[:, power] = unit * np.convolve(size, one(powers, power))[_SMOOTH // 2 + 1 :][: force.size]
        found[:_FORGOTTEN] = self._pieces(force[:ends])[:_FORGOTTEN]
        found[-_FORGOTTEN:] = self._pieces(force[-ends:])[-_FORGOTTEN:]
        return found


def simulate(structure, values, run, starts, reach, wanted=(), extra=None, finer=1, states=True):
    """Outputs of a rig, and their derivatives.

    Parameters
    ----------
    structure : Structure
    values : ndarray, shape (parameters,)
        Masses and coefficients, in the order of its names.
    run : Run
        The force.
    starts : ndarray, shape (parts, 2 d), or None
        Displacements and velocities where each part begins; None is at rest.
    reach : ndarray, shape (terms,)
        Largest relative displacement or velocity that each term was seen at: its law is followed for three times that,
        and runs on straight.
    wanted : sequence of int
        Parameters whose derivatives are wanted, by their place in the names; those by the start of a part come after.
    extra : ndarray, shape (n, forces), optional
        Small forces beside the recorded one, held at their values (N): what each would add comes last.
    finer : int
        Times the steps that are needed at least.
    states : bool
        Whether the derivatives by the start of a part are wanted beside those by parameters.

    Returns
    -------
    outputs : ndarray, shape (n, q)
    columns : ndarray, shape (n, q, len(wanted) + 2 d + forces)
        Empty where nothing is wanted; those by the start zero once they have died away.
    """
    run_on = marched(structure, values, run, starts, reach, wanted, extra, finer, states)
    outputs = np.empty((run.force.size, len(structure.sensors)))
    first, forces = len(wanted), 0 if extra is None else extra.shape[1]
    after = 2 * len(structure.masses) * (states and first + forces > 0)
    columns = np.zeros((*outputs.shape, first + after + forces))
    order = np.r_[:first, first + after : first + after + forces, first : first + after]
    for part, these, derived in run_on:
        outputs[part], columns[part][..., order[: derived.shape[2]]] = these, derived
    return outputs, columns


def marched(structure, values, run, starts, reach, wanted=(), extra=None, finer=1, states=True):
    """The outputs and columns of `simulate`, some samples at a time, with the slice of these samples before them.

    No slice belongs to two parts of the run. Columns by the start of a part come last, until they have died away.
    """
    d, coefficients = len(structure.masses), values[len(structure.masses) :]
    starts = np.zeros((len(run.begins), 2 * d)) if starts is None else starts
    own = np.r_[:d, _MASSES : _MASSES + d]  # displacements and velocities of all masses
    extra = np.zeros((run.force.size, 0)) if extra is None else extra
    lasting = [*wanted, *[_FORCE] * extra.shape[1]]
    derived = np.array([*lasting, *[_START] * (2 * d * (states and len(lasting) > 0))], dtype=int)
    *rig, source, share = _rig(structure, values, reach, derived)
    beside = np.arange(derived.size) // _LANES * _ROWS * _LANES + np.arange(derived.size) % _LANES
    resting = np.zeros(_groups(derived.size) * _ROWS * _LANES)
    for i in range(_MASSES):
        resting[beside + (_SHARE + i) * _LANES] = share[i]
    sensed = np.array([mass + _MASSES * SENSED.index(what) for mass, what in structure.sensors])
    fastest, interval = _fastest(structure, values, reach), 1 / run.sample_rate
    steps = max(1.0, np.ceil(fastest * interval / _ANGLE)) * finer
    sound = steps <= _MOST * finer  # else no rig that was sampled so slowly
    begun = beside[len(lasting) :, None] + np.arange(2 * _MASSES) * _LANES
    unit = np.repeat([1.0, max(fastest, 1e-300)], d)
    forces = run.pieces()
    for whole, start in zip(run.parts(), starts, strict=True):
        state, lanes, count = np.zeros(2 * _MASSES), resting.copy(), derived.size
        state[own] = start
        lanes[begun[np.arange(len(begun)), own[: len(begun)]]] = 1.0
        for part in sliced(whole.stop - whole.start, _SLICE):
            part = slice(whole.start + part.start, whole.start + part.stop)
            outputs = np.empty((part.stop - part.start, sensed.size))
            columns = np.empty((*outputs.shape, _groups(count) * _LANES))
            if sound:
                _march(
                    state, lanes, forces[part], extra[part], interval / steps, int(steps), coefficients, *rig,
                    source[: len(lasting)], beside[: len(lasting)] + _FELT * _LANES, sensed, outputs, columns,
                )  # fmt: skip
            else:
                outputs[:], columns[:] = np.nan, np.nan
            if structure.base:  # an acceleration is that of the base as well
                columns[:, sensed >= 2 * _MASSES, len(wanted) : len(lasting)] += extra[part][:, None]
            yield part, outputs, columns[..., :count]
            if (np.abs(lanes[begun[:, own]]) < _GONE * unit / unit[: len(begun), None]).all():
                count = len(lasting)


def _groups(count):
    """Of columns that are taken at once."""
    return -(-count // _LANES)


def _rig(structure, values, reach, derived):
    """What `_march` knows of a rig. One mass alone has an idle one beside it: what is of one size is fast."""
    d, terms = len(structure.masses), structure.terms
    masses = np.append(values[:d], [1.0] * (_MASSES - d))
    coefficients, directions = values[d:], np.zeros((len(terms), _MASSES))
    directions[:, :d] = structure.directions()
    along = np.zeros((len(terms), 2, _MASSES))
    along[np.arange(len(terms)), [int(term.of == "velocity") for term in terms]] = directions
    along, pull = along.reshape(len(terms), -1), -directions / masses
    carried = np.full(_MASSES, -float(structure.base))
    driven = carried.copy()
    if not structure.base:
        driven[:d] = np.array(structure.driven) / masses[:d]
    straight = np.array([term.law is None for term in terms])
    linear = np.einsum("t,ti,tj->ij", coefficients[straight], pull[straight], along[straight])
    present, wanted = coefficients != 0, np.isin(np.arange(len(terms)), derived - d)
    bent, plain, absent = map(np.flatnonzero, (~straight & present, straight & wanted, ~straight & ~present & wanted))
    # What moves each column: a law's force, a mass's own, nothing or a force beside the recorded one.
    share, source = np.zeros((_MASSES, derived.size)), np.full(derived.size, len(terms) + _MASSES)
    for place, which in enumerate(derived):
        if which >= d:
            share[:, place], source[place] = pull[which - d], which - d
        elif which >= 0:
            share[which, place], source[place] = -1 / masses[which], len(terms) + which
        elif which == _FORCE:
            share[:, place], source[place] = driven, source[: place + 1].max() + 1
    tables, low, step = _tables(terms, reach)
    return driven, carried, linear.ravel(), along, pull, bent, plain, absent, tables, low, 1 / step, source, share


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
    """Coefficients of the cubics each law is made of over its reach, (terms, pieces, 4), first points and steps."""
    tables, low, step = np.zeros((len(terms), _POINTS - 1, 4)), np.zeros(len(terms)), np.ones(len(terms))
    for index, (term, most) in enumerate(zip(terms, reach, strict=True)):
        if term.law is None:
            continue
        low[index], step[index] = -_REACH * most, 2 * _REACH * most / (_POINTS - 1)
        points = low[index] + step[index] * np.arange(_POINTS)
        nudge = 1e-3 * step[index]
        value, slope = term.law(points), (term.law(points + nudge) - term.law(points - nudge)) / 2e-3
        rise, first, last = np.diff(value), slope[:-1], slope[1:]
        tables[index] = np.column_stack([value[:-1], first, 3 * rise - 2 * first - last, first + last - 2 * rise])
    return tables, low, step


@compiled(fastmath={"contract"})
def _law(table, low, per, r):
    """phi(r) and its slope."""
    place, last = (r - low) * per, table.shape[0]
    if not 0 <= place < last:  # straight on
        at, end = (last - 1, 1.0) if place > 0 else (0, 0.0)
        rise = table[at, 1] + end * (2 * table[at, 2] + 3 * end * table[at, 3])
        value = table[at, 0] + end * (table[at, 1] + end * (table[at, 2] + end * table[at, 3]))
        return value + rise * (place - at - end), rise * per
    at = int(place)
    s = place - at
    value = table[at, 0] + s * (table[at, 1] + s * (table[at, 2] + s * table[at, 3]))
    return value, (table[at, 1] + s * (2 * table[at, 2] + 3 * s * table[at, 3])) * per


@compiled(fastmath={"contract"})
def _march(
    state, lanes, forces, extra, h, steps, coefficients, driven, carried, linear, along, pull, bent, plain, absent,
    tables, low, per, source, target, sensed, outputs, columns,
):  # fmt: skip
    """Take a state and its derivatives over the next samples, and write down what the sensors see before each.

    First the four stages of a step of the state, then those of each derivative, with the tangents found there.
    """
    count, terms = columns.shape[2], coefficients.size
    tangent, seen = np.empty((4, linear.size)), np.empty(3 * _MASSES)
    sources = np.zeros(terms + 3 + extra.shape[1])
    for k in range(forces.shape[0]):
        sources[terms + 3 :] = extra[k]
        for part in range(steps):
            x0, y0, v0, w0 = state[0], state[1], state[2], state[3]
            x, y, v, w, a, b = x0, y0, v0, w0, 0.0, 0.0
            dx, dy, dv, dw = 0.0, 0.0, 0.0, 0.0
            for stage in range(4):
                ahead = _TIMES[stage] * h
                x, y, v, w = x0 + ahead * v, y0 + ahead * w, v0 + ahead * a, w0 + ahead * b
                t, f = part * h + ahead, forces[k, -1]
                for power in range(forces.shape[1] - 2, -1, -1):
                    f = forces[k, power] + t * f
                a, b = _pulled(linear, x, y, v, w)
                a, b = a + driven[0] * f, b + driven[1] * f
                if count:
                    tangent[stage] = linear
                for n in bent:
                    r = (along[n, 0] * x + along[n, 1] * y) + (along[n, 2] * v + along[n, 3] * w)
                    sources[n], slope = _law(tables[n], low[n], per[n], r)
                    at_first, at_second = coefficients[n] * pull[n, 0], coefficients[n] * pull[n, 1]
                    a, b = a + at_first * sources[n], b + at_second * sources[n]
                    if count:
                        for j in range(4):
                            tangent[stage, j] += at_first * slope * along[n, j]
                            tangent[stage, 4 + j] += at_second * slope * along[n, j]
                dx, dy = dx + _WEIGHTS[stage] * v, dy + _WEIGHTS[stage] * w
                dv, dw = dv + _WEIGHTS[stage] * a, dw + _WEIGHTS[stage] * b
                if stage == 0 and part == 0:
                    seen[0], seen[1], seen[2], seen[3] = x, y, v, w
                    seen[4], seen[5] = a - carried[0] * f, b - carried[1] * f
                    for i in range(sensed.size):
                        outputs[k, i] = seen[sensed[i]]
                if count:
                    sources[terms], sources[terms + 1] = a - carried[0] * f, b - carried[1] * f
                    for n in plain:
                        sources[n] = (along[n, 0] * x + along[n, 1] * y) + (along[n, 2] * v + along[n, 3] * w)
                    if stage > 0 or k + part == 0:  # else as where the last step ended
                        for n in absent:
                            r = (along[n, 0] * x + along[n, 1] * y) + (along[n, 2] * v + along[n, 3] * w)
                            sources[n], _ = _law(tables[n], low[n], per[n], r)
                    for j in range(source.size):
                        lanes[target[j] + stage * _LANES] = sources[source[j]]
            state[0], state[1], state[2], state[3] = x0 + h * dx, y0 + h * dy, v0 + h * dv, w0 + h * dw
            for group in range(count // _LANES):
                beside = lanes[group * _ROWS * _LANES : (group + 1) * _ROWS * _LANES]
                _derive(beside, tangent, h)
                if part == 0:
                    for i in range(sensed.size):
                        row, into = (_SEEN + sensed[i]) * _LANES, columns[k, i, group * _LANES : (group + 1) * _LANES]
                        for j in range(_LANES):
                            into[j] = beside[row + j]


@compiled(fastmath={"contract"})
def _derive(lanes, tangent, h):
    """A step of some derivatives of the state, side by side so that the processor takes them at once.

    What they, and those of the accelerations, were before it stays at `_SEEN`.
    """
    half = h / 2
    first, second, third, fourth = _eight(tangent[0]), _eight(tangent[1]), _eight(tangent[2]), _eight(tangent[3])
    for j in range(_LANES):
        x, y, v, w = lanes[j], lanes[_LANES + j], lanes[2 * _LANES + j], lanes[3 * _LANES + j]
        p, q = lanes[_SHARE * _LANES + j], lanes[(_SHARE + 1) * _LANES + j]
        a1, b1 = _pulled(first, x, y, v, w)
        a1, b1 = a1 + p * lanes[_FELT * _LANES + j], b1 + q * lanes[_FELT * _LANES + j]
        v2, w2 = v + half * a1, w + half * b1
        a2, b2 = _pulled(second, x + half * v, y + half * w, v2, w2)
        a2, b2 = a2 + p * lanes[(_FELT + 1) * _LANES + j], b2 + q * lanes[(_FELT + 1) * _LANES + j]
        v3, w3 = v + half * a2, w + half * b2
        a3, b3 = _pulled(third, x + half * v2, y + half * w2, v3, w3)
        a3, b3 = a3 + p * lanes[(_FELT + 2) * _LANES + j], b3 + q * lanes[(_FELT + 2) * _LANES + j]
        v4, w4 = v + h * a3, w + h * b3
        a4, b4 = _pulled(fourth, x + h * v3, y + h * w3, v4, w4)
        a4, b4 = a4 + p * lanes[(_FELT + 3) * _LANES + j], b4 + q * lanes[(_FELT + 3) * _LANES + j]
        lanes[j] = x + h / 6 * (v + 2 * v2 + 2 * v3 + v4)
        lanes[_LANES + j] = y + h / 6 * (w + 2 * w2 + 2 * w3 + w4)
        lanes[2 * _LANES + j] = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        lanes[3 * _LANES + j] = w + h / 6 * (b1 + 2 * b2 + 2 * b3 + b4)
        lanes[_SEEN * _LANES + j], lanes[(_SEEN + 1) * _LANES + j] = x, y
        lanes[(_SEEN + 2) * _LANES + j], lanes[(_SEEN + 3) * _LANES + j] = v, w
        lanes[(_SEEN + 4) * _LANES + j], lanes[(_SEEN + 5) * _LANES + j] = a1, b1


@compiled(fastmath={"contract"})
def _pulled(tangent, x, y, v, w):
    """Accelerations that displacements x, y and velocities v, w come with."""
    a = (tangent[0] * x + tangent[1] * y) + (tangent[2] * v + tangent[3] * w)
    return a, (tangent[4] * x + tangent[5] * y) + (tangent[6] * v + tangent[7] * w)


@compiled
def _eight(t):
    """An array's numbers, which the processor need not look up again."""
    return t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7]
