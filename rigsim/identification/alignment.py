"""How the channels of a record belong together: delays, clocks, signs, order, and what each sensor measured.

A first look, before anything is identified, at the linear response alone: cross-spectra of blocks of the record. Where
one recorder's clock drifts, or samples are lost, the delay of an output grows from block to block. What is constant
shows in the response over all blocks: a rig's masses, springs and dampers are positive, and of all ways to read the
channels only the right one leaves little of it.
"""

from itertools import product

import numpy as np

from .layout import direct, powers_of
from .readings import blocks, readings
from .troubles import Trouble, clock_of, delay_of

_FAINT, _BROAD = 0.01, 0.5  # of a force's mean power; of the lines that are to be brighter
_BETTER = 3.0  # times less left, for another order, sign or quantity of the channels
_FITS, _FITS_WELL = 0.3, 0.1  # of the response left, by a reading that is believed, and one whose delays are
_LATE = 0.3  # samples, from the linear response, which a strong spring bends
_DRIFT = 0.15  # samples over the record
_READS = ("displacements", "velocities", "accelerations")
BASE = (
    "the force looks like the acceleration of a base, and the displacements as relative to it: "
    "only ratios of the parameters are in such a record; Record(base=True) says so"
)


def brought_together(record, band):
    """Ways to bring the channels of a record together, by their linear response.

    Returns
    -------
    list of (Record, list of Trouble, ndarray or None)
        Each with what was wrong, the last of which no other record mends where it has no ``mend``, and the linear
        parameters that its response shows.
    """
    mended, longest = [], max(record.tests, key=lambda test: test.force.size)
    time, delay = _drifting_delays(longest, band)
    for names, late in _together(tuple(record.kinds), delay, record.sample_rate, _DRIFT):
        trouble = _drift(names, time, late, record.sample_rate)
        mended += [trouble] if trouble else []
    if any(not trouble.mend for trouble in mended):
        return [(record, mended, None)]
    for trouble in mended:
        record, longest = (one.realigned(**trouble.mend) for one in (record, longest))
    found = readings(longest, band)
    if not found:
        return [(record, mended, None)]
    best, powers = found[0], powers_of(record)
    told = (tuple(range(len(powers))), (1,) * len(powers), powers, record.base)
    usual = [reading for reading in found if (reading.order, reading.signs, reading.powers, reading.base) == told]
    if best not in usual and (not usual or best.left < usual[0].left / _BETTER) and best.share < _FITS:
        mended.append(_read_otherwise(best, record))
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
    for names, delay in _together(tuple(record.kinds), late[None], rate, 2 * _LATE):
        delays += [delay_of(names, delay[0], rate)] if abs(delay[0]) * rate > _LATE else []
    together = record
    for trouble in delays:
        together = together.realigned(**trouble.mend)
    expected = -0.5 if record.hold == "zero" else 0.5
    if abs(late[0] * rate - expected) < 0.1 and abs(late[-1] * rate - expected) < 2 * _LATE:
        for hold in ("linear", "band-limited") if record.hold == "zero" else ("zero",):
            early = "early" if expected < 0 else "late"
            message = f'hold = "{hold}" fits better than "{record.hold}" (or the outputs are half a sample {early})'
            ways.append((record.replace(hold=hold), [*mended, Trouble("hold", message, {"hold": hold})]))
    ways.append((together, [*mended, *delays]))
    return ways if direct(record) else [*ways, (record, mended)]


def _together(names, delays, rate, near):
    """Names and delay of the outputs, as one where these are late alike, to so many samples."""
    if np.ptp(delays, axis=1).max() * rate < max(near, 0.02 * np.abs(delays).max() * rate):
        return [(names, delays[:, 0])]  # the shaker's is the surer one
    return [((name,), column) for name, column in zip(names, delays.T, strict=True)]


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


def _read_otherwise(reading, record):
    """Another order, other signs or another quantity than a record tells, in words."""
    said, mend = [], {}
    if reading.order == (1, 0):
        said.append("shaker and mass are exchanged")
        mend["swap"] = True
    wrong = [name for name, sign in zip(record.kinds, reading.signs, strict=True) if sign < 0]
    if wrong:
        sensors = "both sensors are" if len(wrong) == 2 else "the sensor is"
        said.append(
            f"the force is reversed, or {sensors}"
            if len(wrong) == len(record.kinds)
            else f"the sensor of the {wrong[0]} is reversed"
        )
        mend["reverse"] = tuple(wrong)
    base, other = reading.base and not record.base, reading.powers != powers_of(record)
    if base:
        said.append(BASE)
    if other:
        told = " and ".join(dict.fromkeys(_READS[power] for power in powers_of(record)))
        said.append(f"the outputs look like {_READS[reading.powers[0]]}, not {told}")
        mend = {}
    return Trouble("quantity" if base or other else "order", "; ".join(said), mend)


def _drifting_delays(record, band):
    """By how much each output is later in a block than in the first one.

    Returns
    -------
    time : ndarray, shape (blocks,)
        Middle of each block (s).
    delay : ndarray, shape (blocks, q)
        Of the outputs against the force (s).
    """
    lines, force, outputs = blocks(record, band)
    time = (lines.begins[1:-1] + lines.size / 2) / record.sample_rate
    power = np.abs(force) ** 2
    if np.median((power > _FAINT * power.mean()).mean(axis=1)) < _BROAD:
        return time, np.zeros(outputs.shape[::2])  # each block has lines of its own, and nothing to compare
    omega = 2 * np.pi * lines.frequency
    cross = outputs * force.conj()[..., None]
    # The phase between neighbours is that of the delay alone. Bright lines of one block are not the next one's.
    steps = np.zeros(cross.shape[::2])
    reach = 0.25 / lines.frequency[-1]
    tried = np.linspace(-reach, reach, 201)
    turn = np.exp(1j * np.outer(tried, omega))
    for block, output in product(range(1, len(cross)), range(cross.shape[2])):
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
