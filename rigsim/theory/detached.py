"""Folds, detached resonance curves and the force scenario of the single-term response; no frequency grid anywhere.

Everything is decided by comparing the force with the two fold levels at their breakpoints, all of which are found
(see `rigsim.theory.levels` for the argument). A maximal frequency interval with three solutions has a fold at
each end. If the low and middle solutions merge at both ends, they form a closed curve below the high solution, which
passes by: an INNER detached curve. If the middle and high ones merge at both ends, they form an OUTER one. Mixed
ends are ordinary hysteresis of the main curve.
"""

import functools
import math
import operator
from bisect import bisect_left, bisect_right
from dataclasses import dataclass

import numpy as np

from .. import checks
from ..parameters import oscillator_of
from ..results import ResultSequence, frame
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


@dataclass(frozen=True, eq=False, repr=False)
class _AtForce(ResultSequence):
    """What `Folds` and `DetachedCurves` share: ``force`` is the amplitude (N), ``members`` a tuple."""

    members: tuple
    parameters: object
    force: float

    plots = {"response": "detached_curves_figure"}

    @functools.cached_property
    def response(self):
        """The `FrequencyResponse` over all folds, wherever they lie; without any, around the shaker's resonance."""
        from .amplitude import frequency_response  # which is built on this module

        places = jump_frequencies(self.parameters, self.force) or (self.parameters.oscillator.omega_s / (2 * np.pi),)
        return frequency_response(self.parameters, self.force, np.linspace(0.5 * places[0], 1.2 * places[-1], 500))

    def summary(self):
        """How many there are of each kind."""
        kinds = [member.kind for member in self]
        counts = ", ".join(f"{kinds.count(kind)} {kind}" for kind in sorted(set(kinds)))
        return f"{self.words} at {self.force:g} N: {counts or 'none'}"


@dataclass(frozen=True, eq=False, repr=False)
class Folds(_AtForce):
    """Every `Fold` of the single-term response at a force, ascending in frequency; what `folds` returns."""

    words = "Folds"

    def table(self):
        """`pandas.DataFrame` of the folds."""
        rows = [(f.frequency, f.kind, *(1e3 * abs(u) for u in (f.shaker, f.mass, f.relative))) for f in self]
        return frame(rows, ["frequency [Hz]", "kind", "|xs| [mm]", "|x| [mm]", "|z| [mm]"])


@dataclass(frozen=True, eq=False, repr=False)
class DetachedCurves(_AtForce):
    """Every `DetachedCurve` at a force, ascending in frequency; what `detached_curves` returns."""

    words = "Detached curves"

    def table(self):
        """`pandas.DataFrame` of the curves."""
        return frame([(one.kind, one.low, one.high) for one in self], ["detached curve", "from [Hz]", "to [Hz]"])


@dataclass(frozen=True, eq=False, repr=False)
class ForceScenario(ResultSequence):
    """Every `ForceEvent` of a rig, ascending in force; what `force_scenario` returns."""

    members: tuple
    parameters: object

    plots = {"scenario": "force_scenario_figure", "surface": "response_surface_figure"}

    def summary(self):
        """How many events, and over which forces."""
        if not self.members:
            return "Nothing happens at any force: there is no cubic stiffness"
        return f"{len(self)} events as the force grows, from {self[0].force:.4g} to {self[-1].force:.4g} N"

    def table(self):
        """`pandas.DataFrame` of the events."""
        return frame([(one.force, one.frequency, one.kind) for one in self], ["force [N]", "frequency [Hz]", "event"])

    @functools.cached_property
    def regions(self):
        """Where there are three solutions, from half the first event's force to three times the last one's.

        Tuple of (kind, forces (k,) in N, low (k,), high (k,) in Hz), each between two neighbouring events, where the
        list of intervals is one; kinds are "inner", "outer" and "hysteresis".
        """
        if not self.members:
            return ()
        edges = [0.5 * self[0].force, *(event.force for event in self), 3 * self[-1].force]
        # Denser at events, where regions end roundly; an event itself has no definite list of intervals.
        share = np.clip(np.sin(np.linspace(0, np.pi / 2, 40)) ** 2, 1e-9, 1 - 1e-9)
        regions = []
        for low, high in zip(edges, edges[1:], strict=False):
            forces = low * (high / low) ** share
            lists = [_fold_places(self.parameters, force) for force in forces]
            for i in range(0, len(lists[0]), 2):
                ends = np.array([[places[i][0], places[i + 1][0]] for places in lists]).T
                regions.append((interval_kind(lists[0][i][1], lists[0][i + 1][1]), forces, *ends))
        return tuple(regions)

    def surface(self, **options):
        """The `ResponseSurface` over frequency and force; ``options`` of `rigsim.theory.surface.response_surface`."""
        from .surface import response_surface  # which is built on this module

        return response_surface(self.parameters, **options)


def interval_kind(left, right):
    """Kind of an interval of three solutions, "inner", "outer" or "hysteresis", from the kinds of its two folds."""
    return "hysteresis" if left != right else "inner" if left == "lower" else "outer"


def _fold_places(parameters, force, wanted=lambda left, right: True):
    """(frequency in Hz, kind, X) of the folds of those intervals of three solutions whose kinds are ``wanted``."""
    oscillator = oscillator_of(parameters)
    group = oscillator.nondimensional(force)
    if group.gamma == 0:
        return []
    found = levels(group)
    passed = crossings(found, group.gamma)
    places = []
    for pair in zip(passed[::2], passed[1::2], strict=True):
        kinds = [_FOLD_NAMES[kind] for _, kind in pair]
        if wanted(*kinds):
            X = [crossing(found, group.gamma, *one) for one in pair]
            hertz = [math.sqrt(x) * oscillator.omega_s / (2 * math.pi) for x in X]
            places += zip(hertz, kinds, X, strict=True)
    return places


def folds(parameters, force):
    """Every fold of the single-term response, in closed form but for the last bisection.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        Force amplitude (N, above zero).

    Returns
    -------
    Folds
        A sequence of `Fold`, ascending in frequency; two at a time they bound an interval with three solutions.

    Raises
    ------
    ValueError
        If an input is not allowed, or the shaker is undamped.
    """
    force = checks.positive("force", force, "N")
    places = _fold_places(parameters, force)
    if not places:
        return Folds((), parameters, force)
    frequency, names, X = zip(*places, strict=True)
    group = parameters.nondimensional(force)
    U = []  # of the merging solutions
    for x, kind in zip(X, names, strict=True):
        r, s, _ = dynamic_stiffness(group.mu, group.zeta_s, group.zeta, group.Omega0, x)
        U.append(fold_levels(min(r, -math.sqrt(3) * s), s)[3 if kind == "lower" else 2])
    unit = force / parameters.oscillator.ks
    motion = [(unit * values).tolist() for values in complex_amplitudes(group, np.sqrt(X), np.array(U))]
    members = tuple(Fold(*values) for values in zip(frequency, names, *motion, strict=True))
    return Folds(members, parameters, force)


def jump_frequencies(parameters, force):
    """Frequencies of the `folds` (Hz), ascending, as a tuple: where a slow sweep jumps or a detached curve ends.

    Parameters
    ----------
    parameters, force
        See `folds`, for what is raised, too.
    """
    return tuple(frequency for frequency, _, _ in _fold_places(parameters, force))


def detached_curves(parameters, force):
    """Every detached resonance curve of the single-term response, wherever it lies, as `DetachedCurves`.

    Parameters
    ----------
    parameters, force
        See `folds`, for what is raised, too.
    """
    force = checks.positive("force", force, "N")
    places = _fold_places(parameters, force, wanted=operator.eq)
    pairs = zip(places[::2], places[1::2], strict=True)
    members = tuple(DetachedCurve(interval_kind(kind, kind), low, high) for (low, kind, _), (high, _, _) in pairs)
    return DetachedCurves(members, parameters, force)


def force_scenario(parameters):
    """All that happens to the intervals with three solutions as the force grows from nothing without bound.

    Events can only happen at the levels of breakpoints, so the lists of intervals just below and just above each of
    these levels are compared; they are constant in between. An event is named by the comparison, never by the kind
    of extremum. The `ForceScenario` is empty without cubic stiffness.

    Parameters
    ----------
    parameters
        See `folds`, for what is raised, too.
    """
    oscillator = oscillator_of(parameters)
    if oscillator.k3 == 0:
        return ForceScenario((), parameters)
    group = oscillator.nondimensional(1.0)
    found = levels(group)
    both = enumerate(zip(found.minus, found.plus, strict=True))  # they meet at a cusp: one place
    places = sorted({(value, k) for k, pair in both for value in pair if 0 < value < math.inf})
    passed = functools.cache(lambda gamma: crossings(found, gamma))  # above one level is below the next
    values = [value for value, _ in places]
    events = []
    for value, k in places:
        below, above = _neighbours(values, value)
        before, after = _touching(passed(below), k), _touching(passed(above), k)
        if before != after:
            force, frequency = (
                math.sqrt(value / group.gamma),
                math.sqrt(found.X[k]) * oscillator.omega_s / (2 * math.pi),
            )
            events.append(ForceEvent(_event_name(before, after), force, frequency, before, after))
    return ForceScenario(tuple(events), parameters)


def _neighbours(values, value):
    """Levels half-way to the next different one below and above (geometrically)."""
    below, above = bisect_left(values, value * (1 - 1e-13)), bisect_right(values, value * (1 + 1e-13))
    return (
        math.sqrt(values[below - 1] * value) if below else 0.5 * value,
        math.sqrt(values[above] * value) if above < len(values) else 2 * value,
    )


def _touching(passed, k):
    """Kinds of the intervals between `crossings` that reach into the segments on either side of breakpoint k."""
    pairs = zip(passed[::2], passed[1::2], strict=True)
    near = [(one, other) for (left, one), (right, other) in pairs if left <= k and right >= k - 1]
    return tuple(interval_kind(_FOLD_NAMES[one], _FOLD_NAMES[other]) for one, other in near)


def _event_name(before, after):
    if not before:
        return " + ".join(after) + " birth"
    if not after:
        return " + ".join(before) + " death"
    word = "split" if len(after) > len(before) else "merger"
    return f"{word}: {' + '.join(before)} -> {' + '.join(after)}"
