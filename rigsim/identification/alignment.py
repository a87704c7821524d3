"""How the channels of a record belong together: delays, clocks, signs, order, and what each sensor measured.

A first look, before anything is identified, at the linear response alone: cross-spectra of blocks of the record. Where
one recorder's clock drifts, or samples are lost, the delay of an output grows from block to block. What is constant
shows in the response over all blocks: a rig's masses, springs and dampers are positive, and of all ways to read the
channels only the right one leaves little of it.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import least_squares

from .likelihood import Lines

_BLOCKS = 12  # in a record, at least
_FAINT, _BROAD = 0.01, 0.5  # of a force's mean power; of the lines that are to be brighter
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
    power : int
        How often the outputs are to be integrated: 2 where they are accelerations, 1 velocities.
    base : bool
        Whether the input is the acceleration of a base, and the outputs are relative to it: ms is 1 then.
    values : ndarray, shape (6,)
        ms, ks, cs, m, c, k1.
    delays : ndarray, shape (2,)
        By which shaker and mass are late (s).
    left : float
        Rms of what this reading leaves of the response, over its errors.
    share : float
        The same, as a share of the response.
    """

    order: tuple
    signs: tuple
    power: int
    base: bool
    values: np.ndarray
    delays: np.ndarray
    left: float
    share: float


def linear_response(record, band):
    """Response of shaker and mass to the force at lines in the band, and its standard errors.

    Returns
    -------
    frequency : ndarray, shape (lines,)
        Hz.
    response, error : ndarray, shape (lines, 2)
        m/N.
    """
    lines, force, outputs = _blocks(record, band)
    power = np.mean(np.abs(force) ** 2, axis=0)[:, None]
    response = np.mean(outputs * force.conj()[..., None], axis=0) / power
    rest = np.mean(np.abs(outputs - response * force[..., None]) ** 2, axis=0)
    error = np.sqrt(rest / power / (len(force) / 2))
    return lines.frequency, response, np.maximum(error, 1e-3 * np.abs(response))


def _blocks(record, band):
    lines = Lines(record.sample_rate, record.force.size, band, blocks=_BLOCKS, resolved=4.0)
    outputs = np.column_stack([record.shaker, record.mass])
    inside = slice(1, -1)  # the outermost blocks are half empty
    return lines, lines(record.force - record.force.mean())[inside], lines(outputs - outputs.mean(axis=0))[inside]


def drifting_delays(record, band):
    """By how much each output is later in a block than in the first one.

    Returns
    -------
    time : ndarray, shape (blocks,)
        Middle of each block (s).
    delay : ndarray, shape (blocks, 2)
        Of shaker and mass against the force (s).
    """
    lines, force, outputs = _blocks(record, band)
    time = (lines.begins[1:-1] + lines.size / 2) / record.sample_rate
    power = np.abs(force) ** 2
    if np.median((power > _FAINT * power.mean()).mean(axis=1)) < _BROAD:
        return time, np.zeros((len(force), 2))  # each block has lines of its own, and nothing to compare
    omega = 2 * np.pi * lines.frequency
    cross = outputs * force.conj()[..., None]
    # The phase between neighbours is that of the delay alone. Bright lines of one block are not the next one's.
    steps = np.zeros((len(cross), 2))
    reach = 0.25 / lines.frequency[-1]
    tried = np.linspace(-reach, reach, 201)
    turn = np.exp(1j * np.outer(tried, omega))
    for block, output in product(range(1, len(cross)), range(2)):
        pair = cross[block, :, output] * cross[block - 1, :, output].conj()
        pair = pair / np.sqrt(np.abs(pair) + 1e-300)
        steps[block, output] = tried[(turn @ pair).real.argmax()]
    delay = np.cumsum(steps, axis=0)
    for _ in range(3):  # against the mean response of all blocks, once these are aligned
        aligned = cross * np.exp(1j * omega[None, :, None] * delay[:, None, :])
        mean = aligned.sum(axis=0) / np.sum(np.abs(force) ** 2, axis=0)[:, None]
        modelled = mean * np.abs(force[..., None]) ** 2
        weight = 1 / np.mean(np.abs(aligned - modelled) ** 2 + 1e-12 * np.abs(modelled) ** 2, axis=0)
        slope = np.sum(weight * omega[:, None] * (modelled.conj() * aligned).imag, axis=1)
        delay = delay - slope / np.sum(weight * omega[:, None] ** 2 * np.abs(modelled) ** 2, axis=1)
    return time, delay - delay[0]


def readings(frequency, response, error, sample_rate, swaps=True):
    """All ways to read the outputs that make a rig of positive parts, `Reading` each, the best one first."""
    found = []
    orders = ((0, 1), (1, 0)) if swaps else ((0, 1),)
    for order, signs, power in product(orders, product((1, -1), repeat=2), (0, 1, 2)):
        scale = np.array(signs) / (2j * np.pi * frequency[:, None]) ** power
        read, sure = response[:, order] * scale, error[:, order] * np.abs(scale)
        bases = (False, True) if (order, signs, power) == ((0, 1), (1, 1), 0) else (False,)
        for base in bases:
            start, delays = (_base_start if base else _start)(frequency, read, sample_rate)
            if (start[[0, 1, 3, 5]] > 0).all():
                known = _fitted(frequency, read, sure, start, delays, sample_rate, base)
                found.append(Reading(order, signs, power, base, *known))
    return sorted(found, key=lambda reading: reading.left)


def rig_response(values, frequency, base=False):
    """Response of shaker and mass to a force on the shaker (m/N), shape (lines, 2), of ms, ks, cs, m, c, k1.

    To the acceleration of a ``base`` (s^2) where that moves both: forces -ms a and -m a, and motions relative to it.
    """
    ms, ks, cs, m, c, k1 = values
    s = 2j * np.pi * frequency
    coupling = k1 + s * c
    mass = coupling + s**2 * m
    shaker = ks + s * cs + s**2 * ms + coupling
    determinant = shaker * mass - coupling**2
    if base:
        moved = np.stack([ms * mass + m * coupling, ms * coupling + m * shaker], axis=-1)
        return -moved / determinant[:, None]
    return np.stack([mass, coupling], axis=-1) / determinant[:, None]


def _start(frequency, read, sample_rate):
    """The rig, any sign, and the delays, by linear least squares with the best of some delays.

    Shaker and mass obey m x'' = c z' + k1 z, whose delay is that of the mass against the shaker, and
    ms xs'' + cs xs' + ks xs + m x'' = f.
    """
    s = 2j * np.pi * frequency
    late = np.linspace(-_TRIED, _TRIED, 8 * _TRIED + 1) / sample_rate
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


def _least_squares(columns, wanted):
    """The real solution, and the squares that it leaves."""
    columns, wanted = np.concatenate([columns.real, columns.imag]), np.concatenate([wanted.real, wanted.imag])
    scale = np.linalg.norm(columns, axis=0)
    found = np.linalg.lstsq(columns / scale, wanted, rcond=None)[0]
    return found / scale, np.sum((columns / scale @ found - wanted) ** 2)


def _fitted(frequency, read, sure, start, delays, sample_rate, base):
    """Values, delays, and what is left in errors and as a share, from a start."""
    omega = 2 * np.pi * frequency
    ms, ks, _, m, _, k1 = start
    unit = np.array([ms, ks, np.sqrt(ms * ks), m, np.sqrt(m * k1), k1])

    def misfit(scaled):
        modelled = rig_response(scaled[:6] * unit, frequency, base)
        modelled = modelled * np.exp(-1j * omega[:, None] * scaled[6:] / sample_rate)
        difference = (modelled - read) / sure
        return np.concatenate([difference.real.ravel(), difference.imag.ravel()])

    lower = [1e-3, 1e-3, 0.0, 1e-3, 0.0, 1e-3, -np.inf, -np.inf]
    options = {"bounds": (lower, np.inf), "x_scale": "jac", "max_nfev": 40}
    guess = np.clip(start / unit, 1e-2, 1e2)
    begins = [np.append(guess, late) for late in {tuple(delays * sample_rate), (0.5, 0.5)}]
    best = min((least_squares(misfit, begin, **options) for begin in begins), key=lambda found: found.cost)
    rest, size = np.sqrt(2 * best.cost), np.linalg.norm(read / sure)
    return best.x[:6] * unit, best.x[6:] / sample_rate, rest / np.sqrt(2 * read.size), rest / size
