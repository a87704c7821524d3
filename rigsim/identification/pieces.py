"""Long records: read piece after piece, each mended by itself, under one rig that is likeliest for all of them.

Neither time nor memory grows faster than the record so, and what it cannot repeat of one piece is told of that piece.
Parameters of pieces are not averaged by their errors, for those depend on the very values that they are errors of:
from their plain mean one more step is taken, with derivatives and what is left of each piece at the same values.
"""

import itertools
import re
from dataclasses import dataclass, replace

import numpy as np

from ..experiment.on_disk import let_go
from .asked import afford
from .channels import poor_force
from .layout import layout_of
from .likeliest import given
from .likelihood import FitError, at
from .lines import inverse
from .troubles import TIMING, Trouble, told_once
from .trust import estimated
from .uncertainty import score, uncertainty

_LONG, _PIECE = 1_000_000, 300_000  # samples of a record that is read in pieces, and of a piece at least
_NEAR = 0.2  # of a piece: a test that begins so near to a cut moves it
_IDLE = 0.05  # of the loudest piece's output: nothing to be learnt
_STEADY = 0.98  # correlation with time: delays that grow evenly
_PASSES, _SETTLED, _EXACT = 3, 0.1, 1e-3  # over all pieces, at most; standard errors, and of a value
_SHOWN = 3  # pieces in a message


def pieces_in(samples):
    """How many pieces a record of so many samples is read in."""
    return samples // _PIECE if samples >= _LONG else 1


def pieces(record, block_rows, band, order):
    """Slices of the samples of a record that is read in pieces, the loudest first and those that rest left out.

    It is one slice where the record is short, or where a piece alone has not what tells the parameters apart; what
    cannot be afforded then is refused.
    """
    n = record.force.size
    count = pieces_in(n)
    cuts = np.linspace(0, n, count + 1).astype(int)
    joints = np.array(record.joints)
    for place in range(1, count):
        near = joints[np.abs(joints - cuts[place]).argmin()]
        if abs(near - cuts[place]) < _NEAR * n / count:
            cuts[place] = near
    found = [slice(*ends) for ends in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True)]
    if count > 1:
        loudness = [np.std(record.shaker[samples]) for samples in found]
        order_of = np.argsort(loudness, kind="stable")[::-1]
        found = [found[place] for place in order_of if loudness[place] > _IDLE * max(loudness)]
        let_go(record.shaker)
        if poor_force(piece(record, found[0]), band, order):
            afford(n, block_rows, band)
            return [slice(0, n)]
    return found


def piece(record, samples):
    """Some samples of a record, as one in memory."""
    channels = {name: np.array(channel[samples]) for name, channel in record.channels.items()}
    let_go(*record.channels.values())
    joints = (0, *(joint - samples.start for joint in record.joints if samples.start < joint < samples.stop))
    return record.replace(joints=joints, start=record.start if samples.start == 0 else None, **channels)


@dataclass(frozen=True, eq=False)
class _Known:
    """What is kept of a piece that was read."""

    samples: slice
    mended: list
    values: np.ndarray
    starts: np.ndarray
    begins: tuple
    troubles: list
    force_share: float
    left: np.ndarray
    settled: bool


def combined(record, read, band, terms, report):
    """`Trust` in all pieces of a record, and what was mended of them before they were read.

    What was ``read`` is, of each piece, its slice, what was mended and its `Trust`; that of the first is had already.
    They may come one after the other. ``report`` is told how many pieces are done in a pass over them.
    """
    known, lost, spans, trust = [], [], [], None
    for samples, mended, one in read:
        spans.append(samples)
        trust = trust or one
        if one.fit is None:
            lost.append((samples, one.troubles[0].message))
        else:
            known.append(_known(samples, mended, one))
    values, sure = _agreed(record, known, lost, band, terms, report)
    rate = record.sample_rate
    mended = _grouped([told_once(one.mended, rate) for one in known], known, rate)
    mended += _left_out(lost, len(known), spans, record)
    return mended, replace(
        trust,
        fit=replace(trust.fit, values=values, settled=np.mean([one.settled for one in known]) > 0.5),
        uncertainty=sure, mended=[], troubles=_grouped([one.troubles for one in known], known, rate),
        force_share=float(np.mean([one.force_share for one in known])),
        left=np.sqrt(np.mean([one.left**2 for one in known], axis=0)),
    )  # fmt: skip


def _agreed(record, known, lost, band, terms, report):
    """Values that all known pieces share, and their `Uncertainty`; those that fly apart with them get lost."""
    values = np.mean([one.values for one in known], axis=0)
    for _ in range(_PASSES):
        scores = []
        for done, one in enumerate(list(known)):
            report(done)
            try:
                scores.append(_score(record, one, values, band, terms))
            except FitError as error:
                lost.append((one.samples, f"{error}, with the parameters of the others"))
                known.remove(one)
        if not scores:
            raise ValueError("no rig is to be read from this record: its pieces are of rigs too different to be one")
        total = sum(scores[1:], scores[0])
        sure = uncertainty(total)
        step = inverse(total.information) @ total.in_band.sum(axis=0)
        values = values + step
        if (np.abs(step) <= np.maximum(_SETTLED * sure.standard_error, _EXACT * np.abs(values))).all():
            break
    return values, sure


def _left_out(lost, known, spans, record):
    """`Trouble` for pieces that got lost, beside so many known ones, and for what lies between the spans of all."""
    found, rate = [], record.sample_rate
    if lost:
        told = "; ".join(f"{_span(samples, rate)}: {why}" for samples, why in lost[:_SHOWN])
        more = f" and {len(lost) - _SHOWN} more" if len(lost) > _SHOWN else ""
        found.append(Trouble("pieces", f"{len(lost)} of {known + len(lost)} pieces were left out ({told}{more})"))
    ends = [(0, 0), *sorted((samples.start, samples.stop) for samples in spans), (record.force.size,) * 2]
    rests = [_span(slice(a, b), rate) for (_, a), (b, _) in itertools.pairwise(ends) if a < b]
    if rests:
        found.append(Trouble("rest", f"the rig rests from {', '.join(rests)}, which was left out"))
    return found


def _known(samples, mended, trust):
    fit = trust.fit
    known = fit.values, fit.starts, fit.run.begins, trust.troubles, trust.force_share, trust.left, fit.settled
    return _Known(samples, [*mended, *trust.mended], *known)


def _score(record, known, values, band, terms):
    """What a piece says of values that all share."""
    own = piece(record, known.samples)
    for trouble in known.mended:
        mend = dict(trouble.mend)
        own = own.replace(hold=mend.pop("hold", own.hold)).realigned(**mend)
    structure = layout_of(own).structure(own, terms)
    outputs, run, reach = given(structure, own, known.begins, band)
    fit = at(structure, values, run, outputs, band, reach, known.starts)
    return score(fit, estimated(fit, own, known.mended))


def _span(samples, rate):
    return f"{samples.start / rate:.5g} to {samples.stop / rate:.5g} s"


def _grouped(troubles, known, rate):
    """Troubles of the same kind and channels in several pieces, as one each with the mean of what they move."""
    groups = {}
    for own, one in zip(troubles, known, strict=True):
        for trouble in own:
            key = (
                trouble.name,
                tuple(trouble.mend.get(trouble.name, ())) if trouble.name in TIMING else _words(trouble),
            )
            groups.setdefault(key, []).append((one.samples, trouble))
    return [_as_one(group, len(known), rate) for group in groups.values()]


def _words(trouble):
    """A message without its figures."""
    return re.sub(r"[-+]?\d[\d.e+-]*", "#", trouble.message)


def _as_one(group, count, rate):
    group = sorted(group, key=lambda one: one[0].start)
    (samples, trouble), found = group[0], [one for _, one in group]
    told = trouble.message
    sizes = np.array([one.size for one in found])
    if trouble.name == "delay" and np.ptp(sizes) * rate > 0.1:
        names, are = " and ".join(trouble.mend["delay"]), "are" if len(trouble.mend["delay"]) > 1 else "is"
        told = f"{names} {are} {sizes.min() * rate:.3g} to {sizes.max() * rate:.3g} samples late"
        time = np.array([one.start for one, _ in group]) / rate
        if len(group) > 2 and abs(np.corrcoef(time, sizes)[0, 1]) > _STEADY:
            told += f", ever more: a clock {1e6 * abs(np.polyfit(time, sizes, 1)[0]):.3g} ppm off"
    told += f" (in {len(group)} of {count} pieces, first in {_span(samples, rate)})"
    with_shift = [one.shift for one in found if one.shift.size]
    shift = sum(with_shift) / count if with_shift else trouble.shift
    explains = sum(one.explains for one in found) / count
    return replace(trouble, message=told, shift=shift, explains=explains, size=float(sizes.mean()))
