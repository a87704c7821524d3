"""What is wrong with a record, by name: what a sensor, a recorder or another force would add to what a model leaves.

Each trouble that has a form is a column beside those of the parameters: a delay adds the motion's velocity, a clock
that drifts its velocity times the time, a term of the rig what its force would move. So one linear step tells how large
it would be, how sure that is, what of the rest it explains, and by how much it shifts every parameter.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from .likelihood import moved_beside, noise_weights
from .lines import inverse
from .simulate import simulate
from .terms import Friction, Power, Term

_SURE = 7.0  # standard errors
_EXPLAINS = 0.05  # of what is left, at least
_ALIKE = 1e-8  # of a column's squares, beside those of the parameters
TIMING = ("delay", "clock")


@dataclass(frozen=True, eq=False)
class Trouble:
    """One thing that is wrong with a record.

    Attributes
    ----------
    name : str
        What kind.
    message : str
        In words, with figures.
    mend : dict
        Arguments of `Record.realigned` or of `identify` that mend it; empty where nothing does.
    shift : ndarray
        By how much the parameters would move without it; empty where it is not known.
    explains : float
        Share of what is left that it explains.
    size : float
        How large it is, in units of its own.
    """

    name: str
    message: str
    mend: dict = field(default_factory=dict)
    shift: np.ndarray = field(default_factory=lambda: np.zeros(0))
    explains: float = 1.0
    size: float = 0.0


@dataclass(frozen=True, eq=False)
class Candidate:
    """A trouble that might be.

    Attributes
    ----------
    name : str
        What kind.
    column : ndarray, shape (n, q), or None
        What a unit of it adds to the outputs.
    told, mend : callable
        Its words and its cure, given its size.
    lines : ndarray, shape (blocks, lines, q)
        Of the rest of the column, where that itself is not held.
    """

    name: str
    column: np.ndarray
    told: Callable
    mend: Callable = lambda size: {}
    lines: np.ndarray | None = None


def suspected(fit, candidates, most=3):
    """Of the candidates, at most so many that explain what a fit leaves: the best, then the best beside it."""
    flat = lambda array: np.ascontiguousarray(array).view(float).reshape(-1)  # noqa: E731  real and imaginary parts
    own, left, found = [flat(column) for column in np.moveaxis(fit.own, -1, 0)], fit.left, []
    owners = fit.owners
    transformed = [
        (
            replace(one, column=None, lines=None),
            flat(fit.freed.lines(fit.lines, one.column) if one.lines is None else one.lines),
        )
        for one in candidates
    ]
    while len(found) < most:
        weights = flat(noise_weights(left, owners) * (1 + 1j))
        columns = np.array(own)
        covariance, slope = inverse(columns * weights @ columns.T), columns @ (weights * flat(left))
        best, gain = None, max(_SURE**2, _EXPLAINS * left.size)
        for candidate, column in transformed:
            heavy = weights * column
            shared, whole = columns @ heavy, heavy @ column
            apart = whole - shared @ covariance @ shared
            if not apart > _ALIKE * whole:
                continue  # some change of the parameters does the same
            size = (heavy @ flat(left) - shared @ covariance @ slope) / apart
            if size**2 * apart > gain:
                best, gain = (candidate, column, size, covariance @ (slope - shared * size)), size**2 * apart
        if best is None:
            break
        one, column, size, move = best
        shift = move[: fit.values.size]
        found.append(Trouble(one.name, one.told(size), one.mend(size), shift, gain / left.size, size))
        left = left - (move @ columns + column * size).view(complex).reshape(left.shape)
        own.append(column)
    return found


def candidates(fit, record):
    """All troubles that have a form, a `Candidate` each."""
    motion = fit.modelled - fit.modelled.mean(axis=0)
    yield from timing(fit, record)
    yield from _filters(motion, record)
    for one, name in enumerate(record.kinds):
        yield from _sensor(motion, record, one, name)
    yield from _driven(fit, record)


def delay_of(names, delay, rate):
    """The `Trouble` of outputs that are late by a delay (s)."""
    are, word = ("are", "is")[len(names) == 1], "late" if delay > 0 else "early"
    told = f"{' and '.join(names)} {are} {abs(delay) * rate:.3g} samples ({1e3 * abs(delay):.3g} ms) {word}"
    return Trouble("delay", told, {"delay": dict.fromkeys(names, delay)}, size=delay)


def clock_of(names, clock):
    """The `Trouble` of outputs whose clock is fast against the force's (ppm)."""
    word = "fast" if clock > 0 else "slow"
    told = f"the clock of {' and '.join(names)} is {abs(clock):.4g} ppm {word} against the force's"
    return Trouble("clock", told, {"clock": dict.fromkeys(names, clock)}, size=clock)


def told_once(troubles, rate):
    """Delays and clocks of the same channels that were found one after the other, as one."""
    found = {}
    for trouble in troubles:
        kind = trouble.name
        key = (kind, tuple(trouble.mend[kind])) if kind in TIMING else id(trouble)
        if key in found:
            sizes, more = found[key].mend[kind], trouble.mend[kind]
            size = sum(next(iter(part.values())) for part in (sizes, more))
            trouble = delay_of(tuple(sizes), size, rate) if kind == "delay" else clock_of(tuple(sizes), size)
        found[key] = trouble
    return list(found.values())


def _of(which, column):
    """A column of all outputs, of which some take part."""
    found = np.zeros_like(column)
    for output in which:
        found[:, output] = column[:, output]
    return found


def _groups(record):
    """All outputs, then each: their numbers and names."""
    names = tuple(record.kinds)
    alone = [((place,), (name,)) for place, name in enumerate(names)] if len(names) > 1 else []
    return [(tuple(range(len(names))), names), *alone]


def timing(fit, record):
    """Delays and clocks of all outputs and of each, a `Candidate` each."""
    motion, rate = fit.modelled - fit.modelled.mean(axis=0), record.sample_rate
    velocity = np.gradient(motion, 1 / rate, axis=0)
    begins = np.repeat(record.joints, np.diff([*record.joints, len(motion)]))
    time = (np.arange(len(motion)) - begins)[:, None] / rate
    for which, names in _groups(record):
        delayed = lambda size, names=names: delay_of(names, size, rate)  # noqa: E731
        drifted = lambda size, names=names: clock_of(names, 1e6 * size)  # noqa: E731
        for kind, column, made in (("delay", -velocity, delayed), ("clock", velocity * time, drifted)):
            told = lambda size, made=made: made(size).message  # noqa: E731
            yield Candidate(kind, _of(which, column), told, lambda size, made=made: made(size).mend)


def _filters(motion, record):
    rate = record.sample_rate
    total = np.cumsum(motion, axis=0) / rate
    curve = np.gradient(np.gradient(motion, 1 / rate, axis=0), 1 / rate, axis=0)
    for which, names in _groups(record):
        said = " and ".join(names)
        coupled = lambda size, said=said: f"{said} looks AC coupled, at {abs(size) / (2 * np.pi):.2g} Hz"  # noqa: E731
        yield Candidate("AC coupling", _of(which, -total), coupled)
        smoothed = lambda size, said=said: (  # noqa: E731
            f"{said} looks low-passed or averaged, over {2e3 * np.sqrt(abs(size)):.2g} ms"
        )
        yield Candidate("low-pass", _of(which, curve), smoothed)


def _sensor(motion, record, one, name):
    """Of the output with that number and name: its gain, what leaks into it, and whether it is linear."""
    force, others = record.force - record.force.mean(), [other for other in enumerate(record.kinds) if other[0] != one]
    for other, beside in others:
        more = lambda size, beside=beside: (  # noqa: E731
            f"the sensitivity of {name} is {100 * abs(size):.2g} % {'larger' if size > 0 else 'smaller'} than told, "
            f"against that of {beside}"
        )
        yield Candidate("gain", _of((one,), motion), more)
        if record.kinds[name] == record.kinds[beside]:
            leaked = np.repeat(motion[:, [other]], motion.shape[1], axis=1)
            told = lambda size, beside=beside: f"{100 * size:.2g} % of {beside} is in {name}"  # noqa: E731
            yield Candidate("cross-talk", _of((one,), leaked), told)
    leaked = np.repeat(force[:, None], motion.shape[1], axis=1)
    unit = f"{record.units[name]}/({record.units['force']})".replace("(N)", "N")
    told = lambda size: f"the {_input(record)} leaks into {name} ({abs(size):.2g} {unit})"  # noqa: E731
    yield Candidate("cross-talk", _of((one,), leaked), told)
    square = motion * motion
    for power, word in ((square, "square"), (motion * square, "cube")):
        bent = lambda size, word=word: f"the sensor of {name} is not linear: {size:.2g} times its {word}"  # noqa: E731
        yield Candidate("sensor", _of((one,), power), bent)


def _input(record):
    return "base's acceleration" if record.base else "force"


def _library(motion, velocity):
    """Terms that a rig may have, what they are in words, and the largest motion that each sees."""
    places = (((0, 1), "between shaker and mass"), ((0,), "from the shaker to the ground"))
    places = (*places, ((1,), "from the mass to the ground")) if motion.shape[1] == 2 else (((0,), "to the ground"),)
    for between, where in places:
        direction = Term("", between).direction(motion.shape[1])
        far, speed = np.abs(motion @ direction).max(), velocity @ direction
        quick, tag = np.abs(speed).max(), "".join(map(str, between))
        yield Term(f"k2_{tag}", between, Power(2), unit="N/m^2"), f"a quadratic spring {where}", far
        yield Term(f"k3_{tag}", between, Power(3), unit="N/m^3"), f"a cubic spring {where}", far
        yield Term(f"k5_{tag}", between, Power(5), unit="N/m^5"), f"a quintic spring {where}", far
        yield Term(f"mu_{tag}", between, Friction(0.1 * speed.std()), "velocity", "N"), f"dry friction {where}", quick
        yield Term(f"c3_{tag}", between, Power(3), "velocity", "N s^3/m^3"), f"cubic damping {where}", quick
        yield Term(f"k_{tag}", between, unit="N/m"), f"a linear spring {where}", far
        yield Term(f"c_{tag}", between, None, "velocity", "N s/m"), f"a linear damper {where}", quick


def _driven(fit, record):
    """Terms that the rig was not fitted with, an AC-coupled force, a force sensor that is not linear, another hold."""
    motion, velocity = fit.displaced()
    motion = motion - motion.mean(axis=0)
    structure, kinds, name = fit.structure, {_kind(term) for term in fit.structure.terms}, _input(record)
    more = [row for row in _library(motion, velocity) if _kind(row[0]) not in kinds]
    wide = replace(structure, terms=(*structure.terms, *(term for term, _, _ in more)))
    values = np.concatenate([fit.values, np.zeros(len(more))])
    reach = np.concatenate([fit.reach, [far for _, _, far in more]])
    force = record.force - record.force.mean()
    extra = np.column_stack([np.cumsum(force) / record.sample_rate, force**3])
    outputs, columns = moved_beside(fit, wide, values, reach, range(fit.values.size, values.size), extra)
    for place, (term, what, _) in enumerate(more):
        told = lambda size, term=term, what=what: f"{what} seems to be there too, {size:.3g} {term.unit}"  # noqa: E731
        yield Candidate("term", None, told, lambda size, term=term: {"terms": (term,)}, columns[..., place])
    coupled = lambda size: f"the {name} looks AC coupled, at {abs(size) / (2 * np.pi):.2g} Hz"  # noqa: E731
    yield Candidate("AC coupling", None, coupled, lines=columns[..., -2])
    bent = lambda size: f"the sensor of the {name} is not linear: {size:.2g} times its cube"  # noqa: E731
    yield Candidate("sensor", None, bent, lines=columns[..., -1])
    for hold in ("zero", "linear", "band-limited"):
        if hold != record.hold:
            other, _ = simulate(structure, fit.values, replace(fit.run, hold=hold), fit.starts, fit.reach)
            told = lambda size, hold=hold: f'hold = "{hold}" fits better than "{record.hold}"'  # noqa: E731
            yield Candidate("hold", other - outputs, told, lambda size, hold=hold: {"hold": hold})


def _kind(term):
    """What tells one term from another: its place, its motion, and its law at two places."""
    law = None if term.law is None else tuple(np.round(term.law(np.array([0.5, -1.0])), 12))
    return term.between, term.of, law
