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
from .physical import oscillator_receptance
from .troubles import NAMES, Trouble, clock_of, delay_of

_BLOCKS = 12  # in a record, at least
_FAINT, _BROAD = 0.01, 0.5  # of a force's mean power; of the lines that are to be brighter
_TRIED = 8  # samples that an output may be late or early in a first guess
_BETTER = 3.0  # times less left, for another order, sign or quantity of the channels
_FITS, _FITS_WELL = 0.3, 0.1  # of the response left, by a reading that is believed, and one whose delays are
_LATE = 0.3  # samples, from the linear response, which a strong spring bends
_DRIFT = 0.15  # samples over the record
_READS = {1: "velocities", 2: "accelerations"}
BASE = (
    "the force looks like the acceleration of a base, and the displacements as relative to it: "
    "only ratios of the parameters are in such a record"
)


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


def brought_together(record, band):
    """Ways to bring the channels of a record together, by their linear response.

    Returns
    -------
    list of (Record, list of Trouble, ndarray or None)
        Each with what was wrong, the last of which no other record mends where it has no ``mend``, and the ms, ks, cs,
        m, c, k1 that its response shows.
    """
    mended = []
    time, delay = _drifting_delays(record, band)
    for names, late in _together(delay, record.sample_rate, _DRIFT):
        trouble = _drift(names, time, late, record.sample_rate)
        mended += [trouble] if trouble else []
    if any(not trouble.mend for trouble in mended):
        return [(record, mended, None)]
    for trouble in mended:
        record = record.realigned(**trouble.mend)
    found = _readings(*_linear_response(record, band), record.sample_rate)
    if not found:
        return [(record, mended, None)]
    best = found[0]
    told = ((0, 1), (1, 1), 0, False)
    usual = [reading for reading in found if (reading.order, reading.signs, reading.power, reading.base) == told]
    if best not in usual and (not usual or best.left < usual[0].left / _BETTER) and best.share < _FITS:
        mended.append(_read_otherwise(best))
        if not mended[-1].mend:
            return [(record, mended, best.values)]
        record = record.realigned(**mended[-1].mend)
    elif usual:
        best = usual[0]
    return [(*way, best.values) for way in _in_time(record, mended, best)]


def _in_time(record, mended, best):
    """Records without the constant delays of a reading, each with what was wrong."""
    rate = record.sample_rate
    late = best.delays - (0.5 / rate if record.hold == "zero" else 0.0)
    if best.share > _FITS_WELL or np.abs(late).max() * rate < _LATE:
        return [(record, mended)]
    ways, delays = [], []
    for names, delay in _together(late[None], rate, 2 * _LATE):
        delays += [delay_of(names, delay[0], rate)] if abs(delay[0]) * rate > _LATE else []
    together = record
    for trouble in delays:
        together = together.realigned(**trouble.mend)
    expected = -0.5 if record.hold == "zero" else 0.5
    if abs(late[0] * rate - expected) < 0.1 and abs(late[1] * rate - expected) < 2 * _LATE:
        for hold in ("linear", "band-limited") if record.hold == "zero" else ("zero",):
            early = "early" if expected < 0 else "late"
            message = f'hold = "{hold}" fits better than "{record.hold}" (or the outputs are half a sample {early})'
            ways.append((record.replace(hold=hold), [*mended, Trouble("hold", message, {"hold": hold})]))
    return [*ways, (together, [*mended, *delays])]


def _together(delays, rate, near):
    """Names and delay of shaker and mass, as one where these are late alike, to so many samples."""
    if np.abs(delays[:, 0] - delays[:, 1]).max() * rate < max(near, 0.02 * np.abs(delays).max() * rate):
        return [(NAMES, delays[:, 0])]  # the shaker's is the surer one
    return [((name,), column) for name, column in zip(NAMES, delays.T, strict=True)]


def _drift(names, time, late, rate):
    """What a delay that changes means, if it does: another clock, or samples lost here and there."""
    slope, start = np.polyfit(time, late, 1)
    rest = late - slope * time - start
    scatter = np.std(np.diff(late, 2)) / np.sqrt(6) * rate  # samples, of a delay that only noise moves
    grown = abs(slope) * np.ptp(time) * rate
    if np.abs(rest).max() * rate > max(0.5, 8 * scatter, 0.02 * grown):
        steps = np.abs(np.diff(late)) * rate
        place = time[steps.argmax()]
        message = (
            f"the delay of {' and '.join(names)} changes by {np.ptp(late) * rate:.3g} samples during the record, most "
            f"near {place:.3g} s: samples of it were lost or repeated"
        )
        return Trouble("lost", message)
    if grown > max(_DRIFT, 5 * scatter):
        return clock_of(names, -1e6 * slope)
    return None


def _read_otherwise(reading):
    """Another order, other signs or another quantity, in words."""
    said, mend = [], {}
    if reading.order == (1, 0):
        said.append("shaker and mass are exchanged")
        mend["swap"] = True
    wrong = [name for name, sign in zip(NAMES, reading.signs, strict=True) if sign < 0]
    if wrong:
        said.append(
            "the force is reversed, or both sensors are"
            if len(wrong) == 2
            else f"the sensor of the {wrong[0]} is reversed"
        )
        mend["reverse"] = tuple(wrong)
    if reading.base:
        said.append(BASE)
    if reading.power:
        said.append(f"the outputs look like {_READS[reading.power]}, not displacements")
        mend = {}
    return Trouble("quantity" if reading.power or reading.base else "order", "; ".join(said), mend)


def _linear_response(record, band):
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


def _drifting_delays(record, band):
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


def _readings(frequency, response, error, sample_rate):
    """All ways to read the outputs that make a rig of positive parts, `Reading` each, the best one first."""
    found = []
    for order, signs, power in product(((0, 1), (1, 0)), product((1, -1), repeat=2), (0, 1, 2)):
        scale = np.array(signs) / (2j * np.pi * frequency[:, None]) ** power
        read, sure = response[:, order] * scale, error[:, order] * np.abs(scale)
        bases = (False, True) if (order, signs, power) == ((0, 1), (1, 1), 0) else (False,)
        for base in bases:
            start, delays = (_base_start if base else _start)(frequency, read, sample_rate)
            if (start[[0, 1, 3, 5]] > 0).all():
                known = _fitted(frequency, read, sure, start, delays, sample_rate, base)
                found.append(Reading(order, signs, power, base, *known))
    return sorted(found, key=lambda reading: reading.left)


def _response(values, frequency, base):
    """Of shaker and mass to a force on the shaker (m/N), shape (lines, 2), of ms, ks, cs, m, c, k1.

    To the acceleration of a ``base`` (s^2) where that moves both: forces -ms a and -m a, and motions relative to it.
    """
    receptance = oscillator_receptance(values, frequency)
    return -receptance @ values[[0, 3]] if base else receptance[..., 0]


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
        modelled = _response(scaled[:6] * unit, frequency, base)
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
