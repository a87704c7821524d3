"""How far a record and what is read from it can be trusted: the likeliest rig, what it leaves, and what that says.

The rig that repeats the record best, then what it leaves, mended where that has one cure and named where it has none.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import signal
from scipy.optimize import nnls

from .channels import breaks, spikes
from .likelihood import FitError, Lines, fit
from .simulate import Run, Structure, simulate
from .terms import CUBIC, LINEAR
from .troubles import NAMES, TIMING, Trouble, candidates, suspected, timing
from .uncertainty import uncertainty

MASSES = ("ms", "m")
_ROUNDS = 4
_LOST = 0.3  # of an output left by a rig that cannot be foretold so far, ...
_SHORTEST = 64  # samples
_FORETOLD = (8, 4, 2)  # periods of its shaker, but for so long
_MOST = 0.5  # of what is left
_FEW = 0.01  # of the samples
_FAR = 10  # samples
_MATTERS = 1e-3  # of a parameter


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
    mended, begins = [], best.run.begins
    while True:
        lines = Lines(record.sample_rate, record.force.size, band)
        found = suspected(best, lines, candidates(best, record))
        change = None if len(mended) == _ROUNDS else _change(best, record, begins, found, mended, sensitive)
        if change is None:
            break
        trouble, cured, anew, states = change
        outputs, run, reach = _given(structure, cured, anew)
        try:
            again = fit(structure, best.values, run, outputs, band, reach, _states(run, outputs) if states else None)
        except FitError:
            break
        if not _left(again, Lines(cured.sample_rate, cured.force.size, band)).max() < 1:
            break
        best, record, begins = again, cured, anew
        mended.append(trouble)
    sure = uncertainty(best, lines, _estimated(best, record, [*taken, *mended]))
    share = _force_share(best, lines, record)
    return Trust(best, lines, sure, mended, found, record, share, _left(best, lines))


def _change(best, record, begins, found, mended, sensitive):
    """What is to be mended next: the trouble, the record and its beginnings then, and whether states are known."""
    if not sensitive and not (found and found[0].explains > _MOST):
        cure = _cure(record, best.freed(best.outputs - best.modelled), begins, mended)
        if cure:
            return *cure, True
    if len(begins) == 1 and found and _mendable(found[0], best, record):
        return found[0], record.realigned(**found[0].mend), begins, False
    return None


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
    if trouble.name not in TIMING:
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
