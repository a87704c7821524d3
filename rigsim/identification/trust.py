"""How far a record and what is read from it can be trusted: the likeliest rig, what it leaves, and what that says.

In order: the channels by themselves, then brought together by their linear response, then the rig that repeats the
record best, then what it leaves, mended where that has one cure and named where it has none.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from .alignment import drifting_delays, linear_response, readings
from .channels import breaks, spikes
from .likelihood import FitError, Lines, about_means, fit
from .simulate import Run, Structure
from .terms import CUBIC, LINEAR
from .troubles import Trouble, candidates, suspected
from .uncertainty import uncertainty

MASSES = ("ms", "m")
_BETTER = 3.0  # times less left, for another order, sign or quantity of the channels
_LATE = 0.75  # samples, from the linear response, which a strong spring bends
_DRIFT = 0.15  # samples over the record
_ROUNDS = 4
_MOST = 0.5  # of what is left
_FAR = 10  # samples
_MATTERS = 1e-3  # of a parameter
_MENDABLE = ("delay", "clock")
_READS = {0: "displacements", 1: "velocities", 2: "accelerations"}


@dataclass(frozen=True, eq=False)
class Trust:
    """What `trusted` found.

    Attributes
    ----------
    fit : likelihood.Fit
    lines : likelihood.Lines
    uncertainty : uncertainty.Uncertainty
    mended, troubles : list of Trouble
        What was wrong and is mended, and what is still wrong.
    record : Record
        As it was read in the end.
    force_share : float
        Noise on the recorded force, or a force that is not in it, that would leave what is left, over the force.
    """

    fit: object
    lines: Lines
    uncertainty: object
    mended: list
    troubles: list
    record: object
    force_share: float


def brought_together(record, band):
    """The record with channels in order, by their linear response, and the `Trouble` that each mend was."""
    mended = []
    time, delay = drifting_delays(record, band)
    for names, late in _together(("shaker", "mass"), delay, record.sample_rate):
        trouble = _drift(names, time, late, record.sample_rate)
        mended += [trouble] if trouble else []
    for trouble in mended:
        record = record.realigned(**trouble.mend)
    if any(not trouble.mend for trouble in mended):
        return record, mended, None
    found = readings(*linear_response(record, band), record.sample_rate)
    if not found:
        return record, mended, None
    best = found[0]
    usual = [reading for reading in found if (reading.order, reading.signs, reading.power) == ((0, 1), (1, 1), 0)]
    if best not in usual and (not usual or best.left < usual[0].left / _BETTER) and best.share < 0.3:
        trouble = _read_otherwise(best)
        mended.append(trouble)
        if not trouble.mend:
            return record, mended, best
        record = record.realigned(**trouble.mend)
    elif usual:
        best = usual[0]
    half = 0.5 / record.sample_rate if record.hold == "zero" else 0.0
    late = best.delays - half
    if best.share < 0.1 and np.abs(late).max() * record.sample_rate > _LATE:
        wrong = _wrong_hold(record, late)
        if wrong:
            return record.replace(hold=wrong.mend["hold"]), [*mended, wrong], best
        for names, delay in _together(("shaker", "mass"), late[None], record.sample_rate):
            if abs(delay[0]) * record.sample_rate > _LATE:
                mended.append(_delay_trouble(names, delay[0], record.sample_rate))
                record = record.realigned(**mended[-1].mend)
    return record, mended, best


def _together(names, delays, rate):
    """Channels that are late alike as one group."""
    if np.abs(delays[:, 0] - delays[:, 1]).max() * rate < max(_DRIFT, 0.02 * np.abs(delays).max() * rate):
        return [(names, delays.mean(axis=1))]
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
        return _clock_trouble(names, -1e6 * slope)
    return None


def _clock_trouble(names, fast):
    said, word = " and ".join(names), "fast" if fast > 0 else "slow"
    message = f"the clock of {said} is {abs(fast):.4g} ppm {word} against the force's"
    return Trouble("clock", message, {"clock": dict.fromkeys(names, fast)}, size=fast)


def _delay_trouble(names, late, rate):
    said, word = " and ".join(names), "late" if late > 0 else "early"
    verb = "are" if len(names) > 1 else "is"
    message = f"{said} {verb} {abs(late) * rate:.3g} samples ({1e3 * abs(late):.3g} ms) {word}"
    return Trouble("delay", message, {"delay": dict.fromkeys(names, late)}, size=late)


def _read_otherwise(reading):
    """Another order, other signs or another quantity, in words."""
    said, mend = [], {}
    if reading.order == (1, 0):
        said.append("shaker and mass are exchanged")
        mend["swap"] = True
    wrong = [name for name, sign in zip(("shaker", "mass"), reading.signs, strict=True) if sign < 0]
    if wrong:
        said.append("the force is reversed, or both sensors are" if len(wrong) == 2 else f"the sensor of the {wrong[0]} is reversed")
        mend["reverse"] = tuple(wrong)
    if reading.power:
        said.append(f"the outputs look like {_READS[reading.power]}, not displacements")
        mend = {}
    return Trouble("order" if not reading.power else "quantity", "; ".join(said), mend)


def _wrong_hold(record, late):
    """Whether both outputs are late by the half sample that another hold would explain."""
    half = 0.5 / record.sample_rate
    for hold, expected in (("linear", -half), ("zero", half)):
        if np.abs(late - expected).max() < 0.12 / record.sample_rate and (record.hold == "zero") == (hold != "zero"):
            return Trouble(
                "hold", f'hold = "{hold}" fits better than "{record.hold}" (or the outputs are half a sample '
                f'{"early" if expected < 0 else "late"})', {"hold": hold},
            )  # fmt: skip
    return None


def trusted(record, values, band, terms=(), others=()):
    """`Trust` in a record of displacements, from parameters to start from and troubles that were ``mended`` already.

    ``values`` are ms, ks, cs, m, c, k1, k3, ``others`` more of them to start from.
    """
    structure = Structure(MASSES, (*LINEAR, CUBIC, *terms), tuple((i, "displacement") for i in range(2)), (1.0, 0.0))
    begins, mended = (0,), []
    best = _best_start(structure, record, [values, *others], band)
    for _ in range(_ROUNDS):
        outputs, run, reach = _given(structure, record, begins)
        best = fit(structure, best.values if hasattr(best, "values") else best, run, outputs, band, reach)
        lines = Lines(record.sample_rate, len(outputs), band)
        rest = about_means(outputs - best.modelled, run)
        found = suspected(best, lines, candidates(best, record, reach))
        cure = None if found and found[0].explains > _MOST else _cure(record, rest, begins, mended)
        if cure:
            trouble, record, begins = cure
            mended.append(trouble)
            continue
        timing = [trouble for trouble in found[:1] if trouble.name in _MENDABLE and len(begins) == 1]
        timing = [trouble for trouble in timing if _matters(trouble, best.values) and trouble.explains > _MOST / 2]
        timing = [trouble for trouble in timing if trouble.name == "clock" or abs(trouble.size) * record.sample_rate < _FAR]
        if not timing or len(mended) >= _ROUNDS:
            break
        mended.append(timing[0])
        record = record.realigned(**timing[0].mend)
    sure = uncertainty(best, lines)
    share = _force_share(best, lines, record)
    return Trust(best, lines, sure, mended, found, record, share)


def _best_start(structure, record, starts, band):
    """Of some parameters those under which the rig repeats the record best."""
    from .simulate import simulate

    outputs, run, reach = _given(structure, record, (0,))
    lines, costs = Lines(record.sample_rate, len(outputs), band), []
    size = np.abs(lines(outputs)).std(axis=(0, 1))
    ordered = []
    for values in starts:
        ms, ks, cs, m, c, k1, k3 = values
        low = np.array([1e-6, 1e-6, 0, 1e-6, 0, 0, -np.inf])
        ms, ks, cs, m, c, k1, k3 = np.maximum(values, low)
        ordered.append(np.array([ms, m, ks, cs, c, k1, k3, *[0.0] * (len(structure.terms) - 5)]))
        modelled = simulate(structure, ordered[-1], run, np.zeros((1, 4)), reach)[0]
        left = lines(about_means(outputs - modelled, run)) / size
        costs.append(np.nan_to_num(np.sum(np.abs(left) ** 2), nan=np.inf))
    if not np.isfinite(costs).any():
        raise FitError("the motion of the rig it starts from grows without end")
    return ordered[int(np.argmin(costs))]


def _given(structure, record, begins):
    outputs = np.column_stack([record.shaker, record.mass])
    motion = outputs - outputs.mean(axis=0)
    velocity = np.gradient(motion, 1 / record.sample_rate, axis=0)
    reach = [
        np.abs((velocity if term.of == "velocity" else motion) @ direction).max()
        for term, direction in zip(structure.terms, structure.directions(), strict=True)
    ]
    return outputs, Run(record.force, record.sample_rate, record.hold, begins), np.array(reach)


def _cure(record, rest, begins, mended):
    """For single wrong samples or places where the motion begins anew: the trouble, and record and beginnings without."""
    names = ("shaker", "mass")
    size = np.array([record.shaker.std(), record.mass.std()])
    out = spikes(rest, size)
    if any(places.size for places in out) and sum(map(len, out)) < record.force.size / 100 and not _named(mended, "spikes"):
        said = [f"{len(places)} of {name}, the first at {places[0] / record.sample_rate:.4g} s" for name, places in zip(names, out, strict=True) if len(places)]
        trouble = Trouble("spikes", f"single samples stand out: {'; '.join(said)}", {"spikes": {n: p for n, p in zip(names, out, strict=True) if len(p)}})
        return trouble, record.realigned(**trouble.mend), begins
    places = breaks(rest, size, record.sample_rate)
    if places and not _named(mended, "break"):
        said = ", ".join(f"{place / record.sample_rate:.4g}" for place in places)
        trouble = Trouble("break", f"the motion begins anew at {said} s: samples lost or repeated, runs joined, or a knock")
        return trouble, record, (0, *places)
    return None


def _matters(trouble, values):
    """Whether a trouble moves any parameter by more than a thousandth."""
    return (np.abs(trouble.shift) > _MATTERS * np.abs(values)).any()


def _named(troubles, name):
    return any(trouble.name == name for trouble in troubles)


def _force_share(fitted, lines, record):
    """Share of noise on the force that explains what is left of the outputs, beside white noise of the sensors."""
    force = lines(record.force - record.force.mean())
    modelled = lines(fitted.modelled - fitted.modelled.mean(axis=0))
    power = np.mean(np.abs(force) ** 2, axis=0)
    gain = np.mean(np.abs(modelled) ** 2, axis=0) / np.maximum(power, 1e-300)[:, None]
    left = np.mean(np.abs(fitted.left) ** 2, axis=0)
    rows, wanted = [], []
    for output in range(left.shape[1]):
        row = np.zeros((len(left), left.shape[1] + 1))
        row[:, output], row[:, -1] = 1.0, gain[:, output]
        rows.append(row / left[:, output, None])
        wanted.append(np.ones(len(left)))
    matrix, wanted = np.concatenate(rows), np.concatenate(wanted)
    scale = np.linalg.norm(matrix, axis=0)
    squares = nnls(matrix / scale, wanted)[0] / scale
    return float(np.sqrt(squares[-1] / power.mean()))
