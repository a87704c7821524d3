"""How far a record and what is read from it can be trusted: the likeliest rig, what it leaves, and what that says.

The rig that repeats the record best, then what it leaves, mended where that has one cure and named where it has none.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.optimize import nnls

from .channels import breaks, spikes
from .layout import layout_of, outputs_of
from .likeliest import LOST, given, likeliest, states_of
from .likelihood import FitError, fit
from .troubles import TIMING, Trouble, candidates, suspected, timing
from .uncertainty import score, uncertainty

_ROUNDS = 4
_IN_PARTS = 0.7  # of an output left by a rig that does not repeat the record, though each part begins anew
_MOST = 0.5  # of what is left
_LARGE, _SEVERAL = 0.9, 2  # quantile of a motion that is large; places that tell where they are
_NEAR = 0.2  # s about a place where the motion begins anew
_FEW = 0.01  # of the samples
_FAR = 10  # samples
_MATTERS = 1e-3  # of a parameter


@dataclass(frozen=True, eq=False)
class Trust:
    """What `trusted` found.

    Attributes
    ----------
    fit : likelihood.Fit
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
    uncertainty: object
    mended: list
    troubles: list
    record: object
    force_share: float
    left: np.ndarray


def trusted(record, starts, band, terms=(), sensitive=False, taken=()):
    """`Trust` in a record.

    ``starts`` are some values to start from, in the order of the names of its `Layout`. A motion may be so
    ``sensitive`` that it cannot be foretold from its first state: then it is cut into parts, each with a first state of
    its own. ``taken`` are troubles that the record had before it was brought together.
    """
    layout = layout_of(record)
    structure = layout.structure(record, terms)
    starts = [layout.ordered(values, structure) for values in starts]
    try:
        best = likeliest(structure, record, starts, band, sensitive)
        left = best.share_left
        if not left.max() < (_IN_PARTS if sensitive else LOST):
            raise FitError(f"the likeliest one leaves {100 * left.max():.2g} % of an output")
    except FitError as error:
        trouble = Trouble("fit", f"no rig of this kind repeats the record: {error}")
        return Trust(None, None, [], [trouble], record, 0.0, np.full(len(structure.masses), np.inf))
    mended, begins = [], best.run.begins
    while True:
        found = suspected(best, candidates(best, record))
        change = None if len(mended) == _ROUNDS else _change(best, record, begins, found, mended, sensitive)
        if change is None:
            break
        trouble, cured, anew, states = change
        structure = layout.structure(cured, terms)
        outputs, run, reach = given(structure, cured, anew, band)
        try:
            again = fit(
                structure, best.values, run, outputs, band, reach, states_of(run, cured, band) if states else None
            )
        except FitError:
            break
        if not again.share_left.max() < 1:
            break
        best, record, begins = again, cured, anew
        mended.append(trouble)
    sure = uncertainty(score(best, estimated(best, record, [*taken, *mended])))
    return Trust(best, sure, mended, found, record, _force_share(best, record), best.share_left)


def _change(best, record, begins, found, mended, sensitive):
    """What is to be mended next: the trouble, the record and its beginnings then, and whether states are known."""
    if not sensitive and not (found and found[0].explains > _MOST):
        cure = _cure(record, best, begins, mended)
        if cure:
            return *cure, True
    if len(begins) == len(record.joints) and found and _mendable(found[0], best, record):
        cured = record.realigned(**found[0].mend)
        return found[0], cured, cured.joints, False
    return None


def estimated(fitted, record, mended):
    """Columns of the delays and clocks that were taken from a record, whose own errors the parameters share."""
    known = {(trouble.name, tuple(trouble.mend.get(trouble.name, ()))) for trouble in mended}
    return [one.column for one in timing(fitted, record) if (one.name, tuple(one.mend(1.0)[one.name])) in known]


def _mendable(trouble, best, record):
    """Whether a delay or a clock is sure and matters, and no larger than a linear step tells."""
    if trouble.name not in TIMING:
        return False
    near = trouble.name == "clock" or abs(trouble.size) * record.sample_rate < _FAR
    return near and (np.abs(trouble.shift) > _MATTERS * np.abs(best.values)).any()


def _cure(record, best, begins, mended):
    """For single wrong samples, or places where the motion begins anew: the trouble, and record and beginnings then."""
    rest, motion = best.freed(best.outputs - best.modelled), np.abs(best.modelled - best.modelled.mean(axis=0))
    places, out = [], {name: [] for name in record.kinds}
    for first, test in zip(record.joints, record.tests, strict=True):
        size, own = outputs_of(test).std(axis=0), rest[first : first + test.force.size]
        places += [first + place for place in breaks(own, size, record.sample_rate)]
        for name, alone in zip(out, spikes(own, size), strict=True):
            out[name] += (first + alone).tolist()
    out = {
        name: [] if _at_peaks(where, one) else where for (name, where), one in zip(out.items(), motion.T, strict=True)
    }
    near = maximum_filter1d(motion, int(_NEAR * record.sample_rate) | 1, axis=0)
    if any(_at_peaks(places, one) for one in near.T):
        places = []
    if places and not _named(mended, "break"):
        said = ", ".join(f"{place / record.sample_rate:.4g}" for place in places)
        told = f"the motion begins anew at {said} s: samples lost or repeated, runs joined, or a knock"
        return Trouble("break", told), record, tuple(sorted({*record.joints, *places}))
    out = {name: places for name, places in out.items() if places}
    if out and sum(map(len, out.values())) < _FEW * record.force.size and not _named(mended, "spikes"):
        said = "; ".join(
            f"{len(places)} of {name}, the first at {places[0] / record.sample_rate:.4g} s"
            for name, places in out.items()
        )
        trouble = Trouble("spikes", f"single samples stand out: {said}", {"spikes": out})
        return trouble, record.realigned(**trouble.mend), begins
    return None


def _at_peaks(places, motion):
    """Whether places are those where the motion (n,) is largest: then it is a law or a sensor that does it."""
    return len(places) >= _SEVERAL and np.mean(motion[places] > np.quantile(motion, _LARGE)) > _MOST


def _named(troubles, name):
    return any(trouble.name == name for trouble in troubles)


def _force_share(fitted, record):
    """Share of noise on the force that explains what is left of the outputs, beside white noise of the sensors."""
    lines = fitted.lines
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
