"""Folds, detached resonance curves and the force scenario of the single-term response; no frequency grid anywhere.

Everything is decided by comparing the force with the two fold levels at their breakpoints, all of which are found
(see `rigsim.theory.levels` for the argument). A maximal frequency interval with three solutions has a fold at
each end. If the low and middle solutions merge at both ends, they form a closed curve below the high solution, which
passes by: an INNER detached curve. If the middle and high ones merge at both ends, they form an OUTER one. Mixed
ends are ordinary hysteresis of the main curve.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..parameters import oscillator_of
from .cubic import complex_amplitudes, dynamic_stiffness, fold_levels
from .levels import LOWER, UPPER, crossing, crossings, levels

_FOLD_NAMES = {LOWER: "lower", UPPER: "upper"}


@dataclass(frozen=True, repr=False)
class Fold:
    """A frequency at which two solutions merge.

    Attributes
    ----------
    frequency : float
        Hz.
    kind : str
        "lower" where the low and middle solutions merge, "upper" where the middle and high ones do.
    shaker, mass, relative : complex
        Amplitudes of the merging solutions (m).
    """

    frequency: float
    kind: str
    shaker: complex
    mass: complex
    relative: complex

    def __repr__(self):
        return f"Fold({self.kind}, {self.frequency:.4f} Hz, |z| = {1e3 * abs(self.relative):.4g} mm)"


@dataclass(frozen=True, repr=False)
class DetachedCurve:
    """A detached resonance curve, "inner" or "outer", between its two folds (Hz)."""

    kind: str
    low: float
    high: float

    def __repr__(self):
        return f"DetachedCurve({self.kind}, {self.low:.4f} to {self.high:.4f} Hz)"


@dataclass(frozen=True, repr=False)
class ForceEvent:
    """A force at which the list of intervals with three solutions changes.

    Attributes
    ----------
    kind : str
        What happens as the force grows: "inner birth", "outer death", "split: inner -> inner + inner", "merger:
        hysteresis + outer -> hysteresis" and so on.
    force : float
        Force amplitude (N).
    frequency : float
        Where it happens (Hz).
    before, after : tuple of str
        The intervals that take part, "inner", "outer" or "hysteresis", just below and just above the force.
    """

    kind: str
    force: float
    frequency: float
    before: tuple
    after: tuple

    def __repr__(self):
        return f"ForceEvent({self.kind}, {self.force:.5g} N, {self.frequency:.4f} Hz)"


def interval_kind(left, right):
    """Kind of an interval of three solutions, "inner", "outer" or "hysteresis", from the kinds of its two folds."""
    if left != right:
        return "hysteresis"
    return "inner" if left == "lower" else "outer"


def _double_solution(group, X, kind):
    """U of the two merging solutions at a fold at X = Omega^2."""
    r, s, _ = dynamic_stiffness(group.mu, group.zeta_s, group.zeta, group.Omega0, X)
    _, _, U_minus, U_plus = fold_levels(min(r, -math.sqrt(3) * s), s)
    return U_plus if kind == LOWER else U_minus


def folds(parameters, force):
    """Every fold of the single-term response, in closed form but for the last bisection.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        Force amplitude (N, above zero).

    Returns
    -------
    tuple of Fold
        Ascending in frequency; two at a time they bound an interval with three solutions.

    Raises
    ------
    ValueError
        If an input is not allowed, or the shaker is undamped.
    """
    oscillator = oscillator_of(parameters)
    group = oscillator.nondimensional(force)
    if group.gamma == 0:
        return ()
    found = levels(group)
    passed = crossings(found, group.gamma)
    X = np.array([crossing(found, group.gamma, segment, kind) for segment, kind in passed])
    U = np.array([_double_solution(group, x, kind) for x, (_, kind) in zip(X, passed, strict=True)])
    unit = force / oscillator.ks
    motion = [(unit * values).tolist() for values in complex_amplitudes(group, np.sqrt(X), U)]
    frequency = (np.sqrt(X) * oscillator.omega_s / (2 * np.pi)).tolist()
    names = [_FOLD_NAMES[kind] for _, kind in passed]
    return tuple(Fold(*values) for values in zip(frequency, names, *motion, strict=True))


def jump_frequencies(parameters, force):
    """Frequencies of the `folds`, where a slow sweep jumps or a detached curve ends.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        Force amplitude (N, above zero).

    Returns
    -------
    tuple of float
        Hz, ascending.

    Raises
    ------
    ValueError
        If an input is not allowed, or the shaker is undamped.
    """
    return tuple(fold.frequency for fold in folds(parameters, force))


def detached_curves(parameters, force):
    """Every detached resonance curve of the single-term response, wherever it lies.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        Force amplitude (N, above zero).

    Returns
    -------
    tuple of DetachedCurve
        Ascending in frequency.

    Raises
    ------
    ValueError
        If an input is not allowed, or the shaker is undamped.
    """
    points = folds(parameters, force)
    pairs = [
        (interval_kind(a.kind, b.kind), a.frequency, b.frequency)
        for a, b in zip(points[::2], points[1::2], strict=True)
    ]
    return tuple(DetachedCurve(*pair) for pair in pairs if pair[0] != "hysteresis")


def force_scenario(parameters):
    """All that happens to the intervals with three solutions as the force grows from nothing without bound.

    Events can only happen at the levels of breakpoints, so the lists of intervals just below and just above each of
    these levels are compared; they are constant in between. An event is named by the comparison, never by the kind
    of extremum.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters

    Returns
    -------
    tuple of ForceEvent
        Ascending in force; empty without cubic stiffness.

    Raises
    ------
    ValueError
        If an input is not allowed, or the shaker is undamped.
    """
    oscillator = oscillator_of(parameters)
    if oscillator.k3 == 0:
        return ()
    group = oscillator.nondimensional(1.0)
    found = levels(group)
    places = sorted(
        (float(value), k)
        for values in (found.minus, found.plus)
        for k, value in enumerate(values)
        if 0 < value < math.inf
    )
    events = []
    for value, k in dict.fromkeys(places):  # the levels meet at a cusp: one place
        below, above = _neighbours([level for level, _ in places], value)
        before, after = _touching(crossings(found, below), k), _touching(crossings(found, above), k)
        if before != after:
            frequency = math.sqrt(found.X[k]) * oscillator.omega_s / (2 * math.pi)
            events.append(
                ForceEvent(_event_name(before, after), math.sqrt(value / group.gamma), frequency, before, after)
            )
    return tuple(events)


def _neighbours(values, value):
    """Levels half-way to the next different one below and above (geometrically)."""
    below = [other for other in values if other < value * (1 - 1e-13)]
    above = [other for other in values if other > value * (1 + 1e-13)]
    return (
        math.sqrt(below[-1] * value) if below else 0.5 * value,
        math.sqrt(above[0] * value) if above else 2 * value,
    )


def _touching(passed, k):
    """Kinds of the intervals between `crossings` that reach into the segments on either side of breakpoint k."""
    pairs = zip(passed[::2], passed[1::2], strict=True)
    return tuple(
        interval_kind(_FOLD_NAMES[left_kind], _FOLD_NAMES[right_kind])
        for (left, left_kind), (right, right_kind) in pairs
        if left <= k and right >= k - 1
    )


def _event_name(before, after):
    if not before:
        return " + ".join(after) + " birth"
    if not after:
        return " + ".join(before) + " death"
    word = "split" if len(after) > len(before) else "merger"
    return f"{word}: {' + '.join(before)} -> {' + '.join(after)}"
