"""Order of the model of a record: where its singular values fall, and which poles stay as the order grows.

One decomposition serves every order, since the observability matrix of a smaller one is its first columns. A pole of
the structure returns at every higher order; those that fit noise or rounding wander. So each pole is held against the
nearest one of the order before, by the usual criteria of a stabilisation diagram: frequency within 1 %, damping within
5 % and a modal assurance criterion of at least 0.98 (B. Peeters and G. De Roeck, Mechanical Systems and Signal
Processing 13, 1999; W. Heylen, S. Lammens and P. Sas, Modal Analysis Theory and Testing, 1997).
"""

from dataclasses import dataclass

import numpy as np

from .. import checks
from ..blas import one_blas_thread
from ..experiment.record import Record
from ..model.modes import largest_to_one
from ..results import Result, Status, frame
from .asked import checked_record
from .layout import displacing, layout_of, outputs_of
from .model import about_springs_zero, displacements, scaled_gram
from .nsi import extended_inputs
from .subspace import decomposed, truncated

CRITERIA = ("frequency", "damping", "shape")
_WITHIN = {"frequency": 0.01, "damping": 0.05, "shape": 0.98}
_MOST = 1 / 2  # of the higher orders: there a pole returns that belongs to the structure
_FEWEST = 3  # of them, to tell
_FALL = 10.0  # of singular values; noise and rounding alone make them fall by up to six
_SMALL = 3e-4  # of the largest singular value: twelve bits, or the z^3 that folds in a slow record, look like modes
LEAST_ROWS = 10  # enough for so many orders
_HIGHEST = 20  # of the orders that are compared unless others are asked for


@dataclass(frozen=True, eq=False, repr=False)
class ModelOrder(Result):
    """Which order the model of a record needs; see `model_order`. Poles are listed order by order, n in all.

    Attributes
    ----------
    chosen : int
        The order.
    orders : tuple of int
        Those that were compared.
    singular_values : ndarray, shape (2 block_rows,)
        Descending.
    band : pair of float
        Hz.
    order : ndarray of int, shape (n,)
        Of the model that each pole belongs to.
    frequency, damping : ndarray, shape (n,)
        Natural frequency (Hz) and damping ratio.
    shape : ndarray, complex, shape (n, q)
        Over the outputs, largest entry 1.
    meets : ndarray of bool, shape (n, 3)
        Which of `CRITERIA` it meets with the nearest pole of the order before; none at the lowest order.
    steady : ndarray of bool, shape (n,)
        Whether a stable pole, one that meets all, returns near its frequency at half of the higher orders.
    status : Status
        Found, or doubtful where singular values and poles do not tell one order.
    message : str
        What is to be distrusted, and why; empty where nothing is.
    """

    chosen: int
    orders: tuple
    singular_values: np.ndarray
    band: tuple
    order: np.ndarray
    frequency: np.ndarray
    damping: np.ndarray
    shape: np.ndarray
    meets: np.ndarray
    steady: np.ndarray
    status: Status
    message: str

    plots = {"stabilisation": "stabilisation_figure"}

    @property
    def stable(self):
        """Whether each pole meets all criteria, shape (n,)."""
        return self.meets.all(axis=1)

    def fall(self, order):
        """By what factor the singular values fall after the one of that number."""
        order = checks.integer("order", order, low=1, high=self.singular_values.size - 1)
        return float(self.singular_values[order - 1] / self.singular_values[order])

    def summary(self):
        """One sentence: the order, and why it is that one."""
        own = np.sort(self.frequency[self.order == self.chosen])
        why = (
            f"singular values fall by {self.fall(self.chosen):.2g} after it, and its modes are at "
            f"{', '.join(f'{one:.4g}' for one in own)} Hz"
        )
        if self.status is Status.FOUND:
            return f"Model order {self.chosen}: {why}, where poles stay as the order grows to {self.orders[-1]}"
        return f"Model order {self.chosen}, {self.status}: {self.message} ({why})"

    def table(self):
        """`pandas.DataFrame` of the orders: how far singular values fall after each, and how many poles are stable."""
        inside = _inside(self.frequency, self.band)
        rows = []
        for order in self.orders:
            own = self.order == order
            counts = (own.sum(), (own & self.stable).sum(), (own & self.stable & inside).sum())
            rows.append((order, self.fall(order), *counts))
        return frame(rows, ["order", "fall after it", "poles", "stable", "stable in band"], index="order")


@one_blas_thread
def model_order(record, orders=None, block_rows=40, band=(2, 80)):
    """`ModelOrder`: the order that singular values and stable poles of a record tell, with the stabilisation diagram.

    The order is the largest even one, at least the rig's own, after which singular values fall by ten or more and whose
    poles are all steady: a pole that meets every criterion returns near each at half of the higher orders. It is
    doubtful where there is none, where singular values fall so far again after a higher order, or where a pole in the
    band keeps frequency and shape at half of the higher orders and is not among those of the order chosen; and so is
    an order beyond the rig's own where z was not measured. A mode that noise drowns at every order is not seen.

    Parameters
    ----------
    record : Record
        As `identify` takes it.
    orders : sequence of int, optional
        Even, the rig's own (4, or 2 of one mass) and at least three beyond it, each up to ``block_rows``, of one sensor
        below it; by default those up to 20.
    block_rows : int
        Block rows of the past and of the future in the subspace step, at least ten.
    band : pair of float
        Hz; the springs' zero is found from it, and poles outside are no ground for doubt.

    Raises
    ------
    ValueError
        If the record is not one that `identify` takes, or another input is not allowed.
    """
    record = Record.joined(checks.one_or_many("record", record, Record, "a Record"))
    least = layout_of(record).order
    block_rows = checks.integer("block_rows", block_rows, low=LEAST_ROWS)
    _, block_rows, band = checked_record(record, least, block_rows, band)
    orders = _checked_orders(orders, min(block_rows, block_rows * len(record.kinds) - 1), least)
    gram, scale = _gram(record, least, block_rows, band)
    observability, singular_values = decomposed(gram, scale.size, 2)
    poles = _compared([_poles(*truncated(observability, scale[2:], one), record.sample_rate) for one in orders])
    order = np.repeat(orders, [len(frequency) for frequency, *_ in poles])
    frequency, damping, shape, meets = (np.concatenate(each) for each in zip(*poles, strict=True))
    returns = _returns(orders, order, frequency, meets.all(axis=1))
    steady = returns >= _MOST
    chosen, doubts = _chosen(orders, singular_values, order, steady, least)
    if chosen > least and not displacing(record):
        doubts.append("z was not measured, and what it lacks below the band may look like modes")
    kept = _returns(orders, order, frequency, meets[:, 0] & meets[:, 2]) >= _MOST
    kept &= singular_values[order - 1] > _SMALL * singular_values[0]
    doubts += _left_out(chosen, band, order, frequency, kept)
    status = Status.DOUBTFUL if doubts else Status.FOUND
    return ModelOrder(
        chosen, orders, singular_values, band, order, frequency, damping, shape, meets, steady, status,
        "; ".join(doubts),
    )  # fmt: skip


def _gram(record, order, block_rows, band):
    """Gram matrix of inputs and outputs as measured, and the deviations that channels were divided by."""
    motion = displacements(record, band)
    if displacing(record):
        return about_springs_zero(motion, order, block_rows, band)[1:]
    inputs = extended_inputs(record.force, layout_of(record).across(outputs_of(motion)))
    return scaled_gram(np.column_stack([inputs, outputs_of(record)]), record.joints, block_rows)


def _checked_orders(orders, highest, least):
    """Tuple of the orders: none of more than ``highest``, after which there is a singular value to fall to."""
    orders = range(2, min(_HIGHEST, highest) + 1, 2) if orders is None else orders
    orders = tuple(sorted(set(checks.integers("orders", orders, low=2, high=highest))))
    odd = [one for one in orders if one % 2]
    if odd:
        raise ValueError(f"orders = {odd[0]} is not allowed; expected even numbers, two a mode")
    if least not in orders or sum(one > least for one in orders) < _FEWEST:
        told = ", ".join(map(str, orders))
        raise ValueError(f"orders = {told} do not tell; expected {least} and at least {_FEWEST} beyond it")
    return orders


def _poles(A, C, sample_rate):
    """Frequency (Hz), damping and shape of the oscillating modes of a model that decay."""
    values, vectors = np.linalg.eig(A)
    values, shapes = values.astype(complex), (C @ vectors).T
    own = np.flatnonzero((values.imag > 0) & (np.abs(values) < 1))
    poles = np.log(values[own]) * sample_rate
    return np.abs(poles) / (2 * np.pi), -poles.real / np.abs(poles), largest_to_one(shapes[own])


def _compared(models):
    """The poles of each model, and which criteria they meet with the nearest of the model before, (n, 3)."""
    found = []
    for number, (frequency, damping, shape) in enumerate(models):
        meets = np.zeros((frequency.size, len(CRITERIA)), dtype=bool)
        if number and models[number - 1][0].size:
            meets = _meets((frequency, damping, shape), models[number - 1])
        found.append((frequency, damping, shape, meets))
    return found


def _meets(poles, before):
    """Criteria of poles against the nearest in the complex plane of those before."""
    place = lambda frequency, damping: frequency * (-damping + 1j * np.sqrt(1 - damping**2))  # noqa: E731
    frequency, damping, shape = poles
    nearest = np.abs(place(frequency, damping)[:, None] - place(*before[:2])).argmin(axis=1)
    earlier, earlier_damping, earlier_shape = (each[nearest] for each in before)
    size = np.linalg.norm(shape, axis=1) * np.linalg.norm(earlier_shape, axis=1)
    assurance = (np.abs(np.sum(shape.conj() * earlier_shape, axis=1)) / size) ** 2
    return np.column_stack([
        np.abs(frequency / earlier - 1) <= _WITHIN["frequency"],
        np.abs(damping / earlier_damping - 1) <= _WITHIN["damping"],
        assurance >= _WITHIN["shape"],
    ])  # fmt: skip


def _returns(orders, order, frequency, good):
    """At what share of the higher orders a pole that is ``good`` lies near each; none where they are too few."""
    shares = np.zeros(frequency.size)
    for i in range(frequency.size):
        near = good & (np.abs(frequency / frequency[i] - 1) <= _WITHIN["frequency"]) & (order > order[i])
        higher = sum(one > order[i] for one in orders)
        shares[i] = np.unique(order[near]).size / higher if higher >= _FEWEST else 0.0
    return shares


def _chosen(orders, singular_values, order, steady, least):
    """The order, and what speaks against it."""
    falls = {one: singular_values[one - 1] / singular_values[one] for one in orders if one >= least}
    whole = {one: bool(steady[order == one].all() and (order == one).any()) for one in falls}
    far = [one for one, fall in falls.items() if fall >= _FALL]
    told = [one for one in far if whole[one]]
    if not told:
        best = max(far or [least], key=falls.get)
        stay = ", and its poles do not stay as the order grows" * bool(far)
        return best, [f"the order is not clear: singular values fall by {falls[best]:.2g} after order {best}{stay}"]
    chosen = max(told)
    beyond = [f"{falls[one]:.2g} after order {one}" for one in far if one > chosen]
    return chosen, [f"singular values also fall by {' and by '.join(beyond)}, where poles do not stay"] * bool(beyond)


def _left_out(chosen, band, order, frequency, kept):
    """Words for a mode in the band that stays at higher orders, and that the model of the order chosen lacks."""
    own = frequency[order == chosen]
    found = []
    for one in np.flatnonzero(kept & (order > chosen) & _inside(frequency, band)):
        known = np.concatenate([own, found])
        if not (np.abs(known / frequency[one] - 1) <= 2 * _WITHIN["frequency"]).any():
            found.append(frequency[one])
    if not found:
        return []
    told = ", ".join(f"{one:.4g}" for one in found)
    return [f"a mode at {told} Hz keeps frequency and shape at higher orders, and this one lacks it"]


def _inside(frequency, band):
    return (frequency >= band[0]) & (frequency <= band[1])
