"""What is wrong with a record, by name: what a sensor, a recorder or another force would add to what a model leaves.

Each trouble that has a form is a column beside those of the parameters (a delay adds the motion's velocity, a clock that
drifts its velocity times the time, a term of the rig what its force would move), so one linear step tells how large it
would be, how sure that is, what of the rest it explains, and by how much it shifts every parameter.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from .likelihood import inverse, noise_weights
from .simulate import Structure, simulate
from .terms import Term, friction, power

_SURE = 7.0  # standard errors
_EXPLAINS = 0.05  # of what is left, at least


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
    """A trouble that might be: its column, (n, q), and how to say and mend it, given its size."""

    name: str
    column: np.ndarray
    told: object
    mend: object = lambda size: {}


def suspected(fit, lines, candidates, most=3):
    """Of the candidates, at most so many that explain what a fit leaves, `Trouble` each: the best, then the best beside."""
    own, left, found = lines(fit.columns), fit.left, []
    transformed = [(candidate, lines(fit.freed(candidate.column))) for candidate in candidates]
    while len(found) < most:
        weights = noise_weights(left)
        weighted = np.einsum("lij,bljp->blip", weights, own)
        p = own.shape[-1]
        covariance = inverse((weighted.reshape(-1, p).conj().T @ own.reshape(-1, p)).real)
        slope = np.einsum("blip,bli->p", weighted.conj(), left).real
        best, gain = None, max(_SURE**2, _EXPLAINS * left.size)
        for candidate, column in transformed:
            heavy = np.einsum("lij,blj->bli", weights, column)
            shared = np.einsum("blip,bli->p", weighted.conj(), column).real
            whole = np.vdot(heavy, column).real
            apart = whole - shared @ covariance @ shared
            if not apart > 1e-8 * whole:
                continue  # some change of the parameters does the same
            size = (np.vdot(heavy, left).real - shared @ covariance @ slope) / apart
            if size**2 * apart > gain:
                best, gain = (candidate, column, size, covariance @ (slope - shared * size)), size**2 * apart
        if best is None:
            break
        candidate, column, size, move = best
        told, mend = candidate.told(size), candidate.mend(size)
        found.append(Trouble(candidate.name, told, mend, move[: fit.values.size], gain / left.size, size))
        left = left - own @ move - column * size
        own = np.concatenate([own, column[..., None]], axis=-1)
    return found


def candidates(fit, record, reach):
    """All troubles that have a form, as columns."""
    rate, dt = record.sample_rate, 1 / record.sample_rate
    time = np.arange(record.force.size) * dt
    motion = fit.modelled - fit.modelled.mean(axis=0)
    velocity = np.gradient(motion, dt, axis=0)
    names = ("shaker", "mass")
    yield from _timing(motion, velocity, time, names, rate)
    yield from _channels(motion, velocity, record.force - record.force.mean(), names, dt)
    yield from _forces_and_terms(fit, record, motion, velocity, reach)


def _only(column, output, outputs):
    alone = np.zeros((column.size, outputs))
    alone[:, output] = column
    return alone


def _late(which, size, rate):
    word = "late" if size > 0 else "early"
    return f"{which} {'are' if ' and ' in which else 'is'} {abs(size) * rate:.3g} samples ({1e3 * abs(size):.3g} ms) {word}"


def _timing(motion, velocity, time, names, rate):
    q = motion.shape[1]
    groups = [(names[:q], np.arange(q)), *[((names[i],), np.array([i])) for i in range(q)]]
    for who, which in groups if q > 1 else groups[:1]:
        column = np.zeros_like(motion)
        column[:, which] = -velocity[:, which]
        said = " and ".join(who)
        yield Candidate(
            "delay", column, lambda size, said=said: _late(said, size, rate),
            lambda size, who=who: {"delay": dict.fromkeys(who, size)},
        )  # fmt: skip
        drifting = np.zeros_like(motion)
        drifting[:, which] = velocity[:, which] * time[:, None]
        yield Candidate(
            "clock", drifting,
            lambda size, said=said: f"the clock of {said} is {1e6 * abs(size):.3g} ppm {'fast' if size > 0 else 'slow'} against the force's",
            lambda size, who=who: {"clock": dict.fromkeys(who, 1e6 * size)},
        )  # fmt: skip


def _channels(motion, velocity, force, names, dt):
    q = motion.shape[1]
    total = np.cumsum(motion, axis=0) * dt
    curve = np.gradient(velocity, dt, axis=0)
    both = " and ".join(names[:q])
    coupled = lambda who: lambda size: f"{who} looks AC coupled, at {size / (2 * np.pi):.2g} Hz"  # noqa: E731
    smooth = lambda who: lambda size: f"{who} looks low-passed or averaged, over {2e3 * np.sqrt(abs(size)):.2g} ms"  # noqa: E731
    yield Candidate("AC coupling", -total, coupled(both))
    yield Candidate("low-pass", curve, smooth(both))
    for i in range(q):
        if q > 1:
            yield Candidate(
                "gain", _only(motion[:, i], i, q),
                lambda size, i=i: f"the sensitivity of {names[i]} is {100 * abs(size):.2g} % {'larger' if size > 0 else 'smaller'} "
                f"than told, against {names[1 - i]}'s",
            )  # fmt: skip
            yield Candidate("AC coupling", _only(-total[:, i], i, q), coupled(names[i]))
            yield Candidate("low-pass", _only(curve[:, i], i, q), smooth(names[i]))
            other = names[1 - i]
            yield Candidate(
                "cross-talk", _only(motion[:, 1 - i], i, q),
                lambda size, i=i, other=other: f"{100 * size:.2g} % of {other} is in {names[i]}",
            )  # fmt: skip
        yield Candidate(
            "cross-talk", _only(force, i, q),
            lambda size, i=i: f"the force leaks into {names[i]} ({abs(size):.2g} m/N)",
        )  # fmt: skip
        for exponent in (2, 3):
            yield Candidate(
                "sensor", _only(motion[:, i] ** exponent, i, q),
                lambda size, i=i, exponent=exponent: f"the sensor of {names[i]} is not linear: {size:.2g} times its {('square', 'cube')[exponent - 2]}",
            )  # fmt: skip


def library(structure, reach, motion, velocity):
    """Terms that a rig may have beside those it was fitted with, their places in words, and their reach."""
    x, v = np.abs(motion).max(axis=0), np.abs(velocity).max(axis=0)
    relative = motion[:, 0] - motion[:, 1] if motion.shape[1] > 1 else motion[:, 0]
    speed = np.gradient(relative)
    speed *= v[0] / max(np.abs(np.gradient(motion[:, 0])).max(), 1e-300)
    z, w, rms = np.abs(relative).max(), np.abs(speed).max(), speed.std()
    inner = (0, 1) if motion.shape[1] > 1 else (0,)
    places = [(inner, "between shaker and mass" if len(inner) > 1 else "to the ground", z, w, rms)]
    if len(inner) > 1:
        places += [((0,), "from the shaker to the ground", x[0], v[0], velocity[:, 0].std())]
        places += [((1,), "from the mass to the ground", x[1], v[1], velocity[:, 1].std())]
    for between, where, far, fast, usual in places:
        tag = "".join(map(str, between))
        yield Term(f"k2_{tag}", between, power(2), unit="N/m^2"), f"a quadratic spring {where}", far
        yield Term(f"k3_{tag}", between, power(3), unit="N/m^3"), f"a cubic spring {where}", far
        yield Term(f"k5_{tag}", between, power(5), unit="N/m^5"), f"a quintic spring {where}", far
        yield Term(f"mu_{tag}", between, friction(0.1 * usual), "velocity", "N"), f"dry friction {where}", fast
        yield Term(f"c3_{tag}", between, power(3), "velocity", "N s^3/m^3"), f"cubic damping {where}", fast
        yield Term(f"k_{tag}", between, unit="N/m"), f"a linear spring {where}", far
        yield Term(f"c_{tag}", between, None, "velocity", "N s/m"), f"a linear damper {where}", fast


def _forces_and_terms(fit, record, motion, velocity, reach):
    structure, d, dt = fit.structure, len(fit.structure.masses), 1 / record.sample_rate
    held = {(term.between, term.of, _shape(term)) for term in structure.terms}
    more = [
        row
        for row in library(structure, reach, motion, velocity)
        if (row[0].between, row[0].of, _shape(row[0])) not in held
    ]
    wide = Structure(
        structure.masses, (*structure.terms, *(term for term, _, _ in more)), structure.sensors, structure.driven
    )
    values = np.concatenate([fit.values, np.zeros(len(more))])
    far = np.concatenate([reach, [most for _, _, most in more]])
    force = record.force - record.force.mean()
    extra = np.column_stack([np.cumsum(force) * dt, force**3])
    wanted = range(fit.values.size, values.size)
    _, columns = simulate(wide, values, fit.run, fit.starts, far, wanted, extra)
    for place, (term, where, _) in enumerate(more):
        told = lambda size, term=term, where=where: f"{where} seems to be there too, {size:.3g} {term.unit}"  # noqa: E731
        yield Candidate("term", columns[..., place], told, lambda size, term=term: {"terms": (term,)})
    first = len(more) + 2 * d
    yield Candidate(
        "AC coupling", columns[..., first], lambda size: f"the force looks AC coupled, at {size / (2 * np.pi):.2g} Hz"
    )
    yield Candidate(
        "sensor", columns[..., first + 1], lambda size: f"the force sensor is not linear: {size:.2g} times its cube"
    )
    usual = simulate(structure, fit.values, fit.run, fit.starts, reach)[0]
    for hold in ("zero", "linear", "band-limited"):
        if hold != record.hold:
            other = simulate(structure, fit.values, replace(fit.run, hold=hold), fit.starts, reach)[0]
            yield Candidate(
                "hold",
                other - usual,
                lambda size, hold=hold: f'hold = "{hold}" fits better',
                lambda size, hold=hold: {"hold": hold},
            )


def _shape(term):
    """What tells one law from another: its value at two places."""
    return None if term.law is None else tuple(np.round(term.law(np.array([0.5, -1.0])), 12))
