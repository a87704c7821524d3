"""How the linear response of a record can be read: order, signs and quantities of its outputs, and the rig of each."""

from dataclasses import dataclass
from functools import partial
from itertools import permutations, product

import numpy as np
from scipy.optimize import least_squares

from .layout import layout_of, outputs_of, powers_of
from .lines import Lines

_BLOCKS = 12  # in a record, at least
_TRIED = 8  # samples that an output may be late or early in a first guess


@dataclass(frozen=True, eq=False)
class Reading:
    """One way to read the outputs, and the rig that it would be.

    Attributes
    ----------
    order : tuple of int
        Which channel is the shaker, and which the mass.
    signs : tuple of int
        By which each is multiplied.
    powers : tuple of int
        How often each output is to be integrated: 2 where it is an acceleration, 1 a velocity.
    base : bool
        Whether the input is the acceleration of a base, and motions are relative to it: the first mass is 1 then.
    values : ndarray, shape (p,)
        The linear parameters in the order of the names of the record's `Layout`.
    delays : ndarray, shape (q,)
        By which the outputs are late (s).
    left : float
        Rms of what this reading leaves of the response, over its errors.
    share : float
        The same, as a share of the response.
    """

    order: tuple
    signs: tuple
    powers: tuple
    base: bool
    values: np.ndarray
    delays: np.ndarray
    left: float
    share: float


def readings(record, band):
    """All ways to read the outputs that make a rig of positive parts, `Reading` each, the best one first."""
    (frequency, response, error), layout = _linear_response(record, band), layout_of(record)
    q, rate, found = response.shape[1], record.sample_rate, []
    told = powers_of(record)
    several = dict.fromkeys([told, *((power,) * q for power in range(3))])
    for order, signs, powers in product(permutations(range(q)), product((1, -1), repeat=q), several):
        usual = (order, signs, powers) == (tuple(range(q)), (1,) * q, told)
        scale = np.array(signs) / (2j * np.pi * frequency[:, None]) ** np.array(powers)
        for base in (True,) if record.base else (False, True) if usual and q == 2 else (False,):
            carried = np.equal(powers, 2) if base else 0.0  # an acceleration is that of the base as well
            read, sure = (response[:, order] - carried) * scale, error[:, order] * np.abs(scale)
            step = _step(frequency, rate) if record.hold == "zero" and powers[0] == 2 and not base else 0.0
            start, delays = _START[q, base](frequency, read, rate)
            if np.ndim(step) and start[0] > 0:
                read_later = read - np.outer(step / start[0] * np.exp(-1j * np.pi * frequency / rate), np.eye(q)[0])
                start, delays = _START[q, base](frequency, read_later, rate)
            if (start[layout.least[: start.size] > 0] > 0).all() and start[-1] > 0:
                modelled = partial(_response, layout, frequency, base, step)
                values, *known = _fitted(modelled, frequency, read, sure, start, delays, rate)
                values = values / values[0] if base else values
                found.append(Reading(order, signs, powers, base, values, *known))
    return sorted(found, key=lambda reading: reading.left)


def _linear_response(record, band):
    """Response of the outputs to the force at lines in the band, and its standard errors.

    Returns
    -------
    frequency : ndarray, shape (lines,)
        Hz.
    response, error : ndarray, shape (lines, q)
        In the outputs' units over the force's.
    """
    lines, force, outputs = blocks(record, band)
    power = np.mean(np.abs(force) ** 2, axis=0)[:, None]
    response = np.mean(outputs * force.conj()[..., None], axis=0) / power
    rest = np.mean(np.abs(outputs - response * force[..., None]) ** 2, axis=0)
    error = np.sqrt(rest / power / (len(force) / 2))
    return lines.frequency, response, np.maximum(error, 1e-3 * np.abs(response))


def blocks(record, band):
    """Lines of a record's blocks, then force (blocks, lines) and outputs (blocks, lines, q) on them."""
    lines = Lines(record.sample_rate, record.force.size, band, blocks=_BLOCKS, resolved=4.0)
    outputs = outputs_of(record)
    inside = slice(1, -1)  # the outermost blocks are half empty
    return lines, lines(record.force - record.force.mean())[inside], lines(outputs - outputs.mean(axis=0))[inside]


def _step(frequency, sample_rate):
    """What an acceleration read in the instant of a held force has before all else, times the mass, as a displacement.

    Motions follow a held force half a sample late, which a reading's delays count from; its own acceleration does not.
    """
    omega = 2 * np.pi * frequency
    return (np.exp(0.5j * omega / sample_rate) - 1) / (1j * omega) ** 2


def _response(layout, frequency, base, step, values):
    """Of the outputs to a force on the first mass (m/N), shape (lines, q), of linear parameters; see `_step`.

    To the acceleration of a ``base`` (s^2) where that moves all masses: forces -m_i a, and motions relative to it.
    """
    receptance = layout.receptance(values, frequency)
    masses = np.array([values[layout.names.index(name)] for name in layout.masses])
    first = np.arange(masses.size) == 0
    return -receptance @ masses if base else receptance[..., 0] + np.multiply.outer(step / masses[0], first)


def _start(frequency, read, sample_rate):
    """The rig, any sign, and the delays, by linear least squares with the best of some delays.

    Shaker and mass obey m x'' = c z' + k1 z, whose delay is that of the mass against the shaker, and
    ms xs'' + cs xs' + ks xs + m x'' = f.
    """
    s = 2j * np.pi * frequency
    late = _tried(sample_rate)
    shaker, mass = read.T

    def coupled(delay):
        inertia = s**2 * mass * np.exp(s * delay)
        relative = shaker - mass * np.exp(s * delay)
        size = np.abs(inertia)[:, None]
        return _least_squares(np.stack([s * relative, relative], axis=1) / size, inertia / size[:, 0])

    between = min(late, key=lambda delay: coupled(delay)[1])
    (c, k1), _ = coupled(between)

    def driven(delay):
        there, with_it = np.exp(s * delay), np.exp(s * (delay + between))
        columns = np.stack([s**2 * shaker * there, shaker * there, s * shaker * there, s**2 * mass * with_it], axis=1)
        return _least_squares(columns, np.ones(frequency.size, complex))

    delay = min(late, key=lambda delay: driven(delay)[1])
    (ms, ks, cs, m), _ = driven(delay)
    return np.array([ms, ks, cs, m, c * m, k1 * m]), np.array([delay, delay + between])


def _mass_start(frequency, read, sample_rate):
    """The same for one mass: (m s^2 + c s + k1) x = f."""
    s, mass = 2j * np.pi * frequency, read[:, 0]
    columns = np.stack([s**2 * mass, s * mass, mass], axis=1)

    def driven(delay):
        return _least_squares(columns * np.exp(s * delay)[:, None], np.ones(frequency.size, complex))

    delay = min(_tried(sample_rate), key=lambda delay: driven(delay)[1])
    return driven(delay)[0], np.array([delay])


def _tried(sample_rate):
    return np.linspace(-_TRIED, _TRIED, 8 * _TRIED + 1) / sample_rate


def _base_start(frequency, read, sample_rate):
    """The same for the acceleration of a base: x'' + a = (c z' + k1 z)/m, xs'' + cs xs' + ks xs + m (x'' + a) = -a."""
    s = 2j * np.pi * frequency
    shaker, mass = read.T
    whole = s**2 * mass + 1
    relative = shaker - mass
    (c, k1), _ = _least_squares(np.stack([s * relative, relative], axis=1), whole)
    (ks, cs, m), _ = _least_squares(np.stack([shaker, s * shaker, whole], axis=1), -1 - s**2 * shaker)
    half = np.full(2, 0.5 / sample_rate)
    return np.array([1.0, ks, cs, m, c * m, k1 * m]), half


def _mass_base_start(frequency, read, sample_rate):
    """The same for one mass: x'' + c x' + k1 x = -a."""
    s, mass = 2j * np.pi * frequency, read[:, 0]
    (c, k1), _ = _least_squares(np.stack([s * mass, mass], axis=1), -1 - s**2 * mass)
    return np.array([1.0, c, k1]), np.full(1, 0.5 / sample_rate)


_START = {(2, False): _start, (2, True): _base_start, (1, False): _mass_start, (1, True): _mass_base_start}


def _least_squares(columns, wanted):
    """The real solution, and the squares that it leaves."""
    columns, wanted = np.concatenate([columns.real, columns.imag]), np.concatenate([wanted.real, wanted.imag])
    scale = np.linalg.norm(columns, axis=0)
    found = np.linalg.lstsq(columns / scale, wanted, rcond=None)[0]
    return found / scale, np.sum((columns / scale @ found - wanted) ** 2)


def _fitted(modelled, frequency, read, sure, start, delays, sample_rate):
    """Values, delays, and what is left in errors and as a share, from a start; ``modelled`` leads to the response."""
    omega, size = 2 * np.pi * frequency, start.size
    unit = np.abs(start) + 1e-300
    if size == 6:
        ms, ks, _, m, _, k1 = start
        unit[[2, 4]] = np.sqrt(ms * ks), np.sqrt(m * k1)
    else:
        unit[1] = np.sqrt(start[0] * start[2])

    def misfit(scaled):
        late = np.exp(-1j * omega[:, None] * scaled[size:] / sample_rate)
        difference = (modelled(scaled[:size] * unit) * late - read) / sure
        return np.concatenate([difference.real.ravel(), difference.imag.ravel()])

    lower = np.concatenate([np.full(size, 1e-3), np.full(delays.size, -np.inf)])
    lower[[2, 4] if size == 6 else [1]] = 0.0
    options = {"bounds": (lower, np.inf), "x_scale": "jac", "max_nfev": 40}
    guess = np.clip(start / unit, 1e-2, 1e2)
    begins = [np.append(guess, late) for late in {tuple(delays * sample_rate), (0.5,) * delays.size}]
    best = min((least_squares(misfit, begin, **options) for begin in begins), key=lambda found: found.cost)
    rest, whole = np.sqrt(2 * best.cost), np.linalg.norm(read / sure)
    return best.x[:size] * unit, best.x[size:] / sample_rate, rest / np.sqrt(2 * read.size), rest / whole
