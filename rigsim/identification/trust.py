"""How far a record and what is read from it can be trusted: the likeliest rig, what it leaves, and what that says.

In order: the channels by themselves, then brought together by their linear response, then the rig that repeats the
record best, then what it leaves, mended where that has one cure and named where it has none.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import signal
from scipy.optimize import nnls

from .alignment import drifting_delays, linear_response, readings
from .channels import breaks, spikes
from .likelihood import FitError, Lines, fit
from .simulate import Run, Structure, simulate
from .terms import CUBIC, LINEAR
from .troubles import NAMES, Trouble, candidates, clock_of, delay_of, suspected, timing
from .uncertainty import uncertainty

MASSES = ("ms", "m")
_BETTER = 3.0  # times less left, for another order, sign or quantity of the channels
_LATE = 0.3  # samples, from the linear response, which a strong spring bends
_DRIFT = 0.15  # samples over the record
_ROUNDS = 4
_LOST = 0.3  # of an output left by a rig that cannot be foretold so far, ...
_SHORTEST = 64  # samples
_FORETOLD = (8, 4, 2)  # periods of its shaker, but for so long
_MOST = 0.5  # of what is left
_FEW = 0.01  # of the samples
_FAR = 10  # samples
_MATTERS = 1e-3  # of a parameter
_MENDABLE = ("delay", "clock")
BASE = (
    "the force looks like the acceleration of a base, and the displacements as relative to it: "
    "only ratios of the parameters are in such a record"
)
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
    left : ndarray, shape (q,)
        Rms of what the rig leaves of each output over the band, over that output; infinite where there is no rig.
    """

    fit: object
    lines: Lines
    uncertainty: object
    mended: list
    troubles: list
    record: object
    force_share: float
    left: np.ndarray


def brought_together(record, band):
    """Ways to bring the channels of a record together, by their linear response.

    Returns
    -------
    list of (Record, list of Trouble, ndarray or None)
        Each with what was wrong, the last of which no other record mends where it has no ``mend``, and the ms, ks, cs,
        m, c, k1 that its response shows.
    """
    mended = []
    time, delay = drifting_delays(record, band)
    for names, late in _together(delay, record.sample_rate, _DRIFT):
        trouble = _drift(names, time, late, record.sample_rate)
        mended += [trouble] if trouble else []
    if any(not trouble.mend for trouble in mended):
        return [(record, mended, None)]
    for trouble in mended:
        record = record.realigned(**trouble.mend)
    found = readings(*linear_response(record, band), record.sample_rate)
    if not found:
        return [(record, mended, None)]
    best = found[0]
    told = ((0, 1), (1, 1), 0, False)
    usual = [reading for reading in found if (reading.order, reading.signs, reading.power, reading.base) == told]
    if best not in usual and (not usual or best.left < usual[0].left / _BETTER) and best.share < 0.3:
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
    if best.share > 0.1 or np.abs(late).max() * rate < _LATE:
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
    names = NAMES
    if np.abs(delays[:, 0] - delays[:, 1]).max() * rate < max(near, 0.02 * np.abs(delays).max() * rate):
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


def add(one, other, rate):
    """Two troubles of the same kind and channels, found one after the other, as one."""
    ((kind, sizes),) = one.mend.items()
    size = next(iter(sizes.values())) + next(iter(other.mend[kind].values()))
    return delay_of(tuple(sizes), size, rate) if kind == "delay" else clock_of(tuple(sizes), size)


def _read_otherwise(reading):
    """Another order, other signs or another quantity, in words."""
    said, mend = [], {}
    if reading.order == (1, 0):
        said.append("shaker and mass are exchanged")
        mend["swap"] = True
    wrong = [name for name, sign in zip(("shaker", "mass"), reading.signs, strict=True) if sign < 0]
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


def trusted(record, starts, band, terms=(), sensitive=False, taken=()):
    """`Trust` in a record of displacements.

    ``starts`` are some ms, ks, cs, m, c, k1, k3 to start from. A motion may be so ``sensitive`` that it cannot be
    foretold from its first state: then it is cut into parts, each with a first state of its own.
    ``taken`` are troubles that the record had before it was brought together.
    """
    structure = Structure(MASSES, (*LINEAR, CUBIC, *terms), tuple((i, "displacement") for i in range(2)), (1.0, 0.0))
    lines = Lines(record.sample_rate, record.force.size, band)
    try:
        best = _in_parts(structure, record, starts, band) if sensitive else _whole(structure, record, starts, band)
        left = _left(best, lines)
        if not left.max() < (1.0 if sensitive else _LOST):
            raise FitError(f"the likeliest one leaves {100 * left.max():.2g} % of an output")
    except FitError as error:
        trouble = Trouble("fit", f"no rig of this kind repeats the record: {error}")
        return Trust(None, lines, None, [], [trouble], record, 0.0, np.full(2, np.inf))
    begins = best.run.begins
    mended, parts = [], len(begins) > 1
    for _ in range(_ROUNDS):
        lines = Lines(record.sample_rate, record.force.size, band)
        found = suspected(best, lines, candidates(best, record, _given(structure, record, begins)[2]))
        cure = None
        if not parts and not (found and found[0].explains > _MOST):
            cure = _cure(record, best.freed(_given(structure, record, begins)[0] - best.modelled), begins, mended)
        late = []
        if not cure and len(begins) == 1:
            late = [trouble for trouble in found[:1] if _mendable(trouble, best, record)]
        if cure:
            trouble, cured, anew = cure
        elif late:
            (trouble,), anew = late, begins
            cured = record.realigned(**trouble.mend)
        else:
            break
        outputs, run, reach = _given(structure, cured, anew)
        try:
            again = fit(structure, best.values, run, outputs, band, reach, _states(run, outputs) if cure else None)
        except FitError:
            break
        if not _left(again, Lines(cured.sample_rate, cured.force.size, band)).max() < 1:
            break
        best, record, begins = again, cured, anew
        mended.append(trouble)
    lines = Lines(record.sample_rate, record.force.size, band)
    sure = uncertainty(best, lines, _estimated(best, record, [*taken, *mended]))
    share = _force_share(best, lines, record)
    return Trust(best, lines, sure, mended, found, record, share, _left(best, lines))


def _estimated(fitted, record, mended):
    """Columns of the delays and clocks that were taken from a record, whose own errors the parameters share."""
    known = {(trouble.name, tuple(trouble.mend.get(trouble.name, ()))) for trouble in mended}
    return [one.column for one in timing(fitted, record) if (one.name, tuple(one.mend(1.0)[one.name])) in known]


def _left(fitted, lines):
    left = np.mean(np.abs(fitted.left) ** 2, axis=(0, 1))
    return np.sqrt(left / np.mean(np.abs(lines(fitted.outputs - fitted.outputs.mean(axis=0))) ** 2, axis=(0, 1)))


def _whole(structure, record, starts, band):
    outputs, run, reach = _given(structure, record, (0,))
    return fit(structure, _best_start(structure, record, starts, band), run, outputs, band, reach)


def _in_parts(structure, record, starts, band):
    """The fit to parts that are as long as can be."""
    lines, found = Lines(record.sample_rate, record.force.size, band), None
    outputs, run, reach = _given(structure, record, (0,))
    values = _ordered(starts[0], structure)
    for periods in _FORETOLD:
        short = max(_SHORTEST, int(periods * record.sample_rate * 2 * np.pi / np.sqrt(values[2] / values[0])))
        run = replace(run, begins=tuple(range(0, max(1, len(outputs) - short // 2), short)))
        try:
            pieces = fit(structure, values, run, outputs, band, reach, _states(run, outputs))
        except FitError:
            continue
        if found is None or (_left(pieces, lines) < _left(found, lines) / 3).any():
            found = pieces
        if _left(found, lines).max() < _LOST / 10:
            break
    if found is None:
        raise FitError("its motion grows without end")
    return found


def _states(run, outputs):
    """First states of the parts as the outputs show them, (parts, 2 d)."""
    motion = outputs - outputs.mean(axis=0)
    velocity = signal.savgol_filter(motion, 9, 3, deriv=1, delta=1 / run.sample_rate, axis=0)
    return np.hstack([motion, velocity])[list(run.begins)]


def _mendable(trouble, best, record):
    """Whether a delay or a clock is sure and matters, and no larger than a linear step tells."""
    if trouble.name not in _MENDABLE:
        return False
    near = trouble.name == "clock" or abs(trouble.size) * record.sample_rate < _FAR
    return near and (np.abs(trouble.shift) > _MATTERS * np.abs(best.values)).any()


def _ordered(values, structure):
    """ms, ks, cs, m, c, k1, k3 in the order of the structure's names, none that no rig can have."""
    ms, ks, cs, m, c, k1, k3 = np.maximum(values, [1e-6, 1e-6, 0, 1e-6, 0, 0, -np.inf])
    return np.array([ms, m, ks, cs, c, k1, k3, *[0.0] * (len(structure.terms) - 5)])


def _best_start(structure, record, starts, band):
    """Of some parameters those under which the rig repeats the record best."""
    outputs, run, reach = _given(structure, record, (0,))
    lines, costs = Lines(record.sample_rate, len(outputs), band), []
    ordered = [_ordered(values, structure) for values in starts]
    if len(ordered) == 1:
        return ordered[0]
    size = np.abs(lines(outputs)).std(axis=(0, 1))
    for values in ordered:
        rest = outputs - simulate(structure, values, run, np.zeros((1, 4)), reach)[0]
        costs.append(np.nan_to_num(np.sum(np.abs(lines(rest - rest.mean(axis=0)) / size) ** 2), nan=np.inf))
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
    """For single wrong samples, or places where the motion begins anew: the trouble, and record and beginnings then."""
    size = np.array([record.shaker.std(), record.mass.std()])
    places = breaks(rest, size, record.sample_rate)
    if places and not _named(mended, "break"):
        said = ", ".join(f"{place / record.sample_rate:.4g}" for place in places)
        told = f"the motion begins anew at {said} s: samples lost or repeated, runs joined, or a knock"
        return Trouble("break", told), record, (0, *places)
    out = {name: places for name, places in zip(NAMES, spikes(rest, size), strict=True) if places.size}
    if out and sum(map(len, out.values())) < _FEW * record.force.size and not _named(mended, "spikes"):
        said = "; ".join(
            f"{len(places)} of {name}, the first at {places[0] / record.sample_rate:.4g} s"
            for name, places in out.items()
        )
        trouble = Trouble("spikes", f"single samples stand out: {said}", {"spikes": out})
        return trouble, record.realigned(**trouble.mend), begins
    return None


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
