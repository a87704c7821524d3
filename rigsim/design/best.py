"""The force, or other free numbers of a rig, that keep its detached curve farthest from being lost."""

import itertools
from dataclasses import dataclass

import numpy as np

from .. import checks
from ..campaign.progress import reporting
from ..parameters import oscillator_of
from ..results import Result, Status, frame
from .margins import reach
from .variation import built_names, half_widths, judge_varied, kind_number, quantity, replaced

# Moves in tolerances, and how well their ends are found: while searching, and for the designs that are reported.
_COARSE = {"grid": np.geomspace(1e-2, 30.0, 17), "accuracy": 1e-5}
_FINE = {"grid": np.geomspace(1e-6, 1e3, 181)}
_GRID, _POLISH = 61, 100  # values of one free number, the others held, and steps to the best of them at most
_POPULATION, _GENERATIONS = 8, 60  # rigs for each of several free numbers, and how often they are bettered at most


@dataclass(frozen=True, eq=False, repr=False)
class Design(Result):
    """The best rig found; see `design_for_detached_curve`.

    Attributes
    ----------
    parameters, force
        The best rig, and its force (N).
    free : dict of str to (float, float, float)
        For each free number its bounds and the value found (SI units): (low, high, found).
    start : dict of str to float
        The free numbers of the rig given.
    kind, tolerances, seed
        As given.
    reach : dict of str to float
        How many times its tolerance each quantity may move, the worse way, before the curve is lost.
    margin, start_margin : float
        The smallest of them, for the best rig and for the one given (0 if that has no such curve).
    profiles : dict of str to (2, k) array
        Values of each free number, the others at their best, and the margin there (NaN where there is no curve).
    status : Status
        CONVERGED or NOT_CONVERGED, of the search.
    message : str
        How many rigs it tried.
    """

    parameters: object
    force: float
    kind: str
    free: dict
    start: dict
    tolerances: dict
    reach: dict
    margin: float
    start_margin: float
    profiles: dict
    seed: object
    status: Status
    message: str

    plots = {"design": "design_figure"}

    def summary(self):
        """What was found and what it is worth."""
        items = {name: quantity(self.parameters, self.force, name) for name in self.free}
        found = [f"{n} = {v * items[n].factor:.6g} {items[n].shown_unit}".strip() for n, (_, _, v) in self.free.items()]
        weakest = min(self.reach, key=self.reach.get)
        return (
            f"{', '.join(found)}: the {self.kind} detached curve survives moves of {self.margin:.3g} tolerances "
            f"(before: {self.start_margin:.3g}); {weakest} would lose it first"
        )

    def table(self):
        """`pandas.DataFrame` of the free numbers: bounds, before and found."""
        rows = []
        for name, (low, high, value) in self.free.items():
            item = quantity(self.parameters, self.force, name)
            rows.append((name, item.shown_unit, *(item.factor * v for v in (low, high, self.start[name], value))))
        return frame(rows, ["quantity", "unit", "from", "to", "before", "best"], index="quantity")


def design_for_detached_curve(
    parameters, force, free=("force",), kind="inner", tolerances=None, seed=2014, *, progress=False
):
    """The free numbers, within bounds, for which the detached curve survives the largest errors.

    What is maximised is the *margin*: the largest t such that any one toleranced quantity may move by t times its
    tolerance, either way and all the others exact, with the curve there all along and the wires taut; among equals,
    the least sum of the reciprocals of all such moves decides. With the default tolerance, the
    force's own value, t is the relative change of the force that the curve survives: min(1 - F_low/F, F_high/F - 1).

    One free number is searched on a grid, then refined; several by differential evolution (seeded). A local search
    cannot prove that nothing better exists.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
        What is not free stays.
    force : float
        Amplitude (N), also if it is free: the margin "before" is there.
    free : sequence of str, or dict of str to (float, float)
        Fields of the parameters or "force", with bounds (SI units); without, from a fifth to five times the value,
        within physical bounds.
    kind : {"inner", "outer"}
    tolerances : dict of str to float or str, optional
        As for `tolerance_study`; per cent are of the value that is being tried. By default ``{"force": "100 %"}``.
    seed : int or numpy.random.Generator
        Only used with several free numbers.
    progress : bool or callable
        True shows a bar; a callable is told (rigs tried, rigs to try at most).

    Returns
    -------
    Design

    Raises
    ------
    ValueError
        If an input is not allowed, a bound lies outside what is physical, or no curve of the kind was found within
        the bounds.

    Examples
    --------
    >>> design_for_detached_curve(RigParameters(), 3.18)  # doctest: +SKIP
    """
    oscillator_of(parameters)
    force, number = checks.positive("force", force, "N"), kind_number(kind)
    bounds, progress = _bounds(parameters, force, free), checks.progress(progress)
    seed = checks.seed("seed", seed, generator=True)
    tolerances = {"force": "100 %"} if tolerances is None else tolerances
    half_widths(parameters, force, tolerances)  # of each rig that is tried they are found again
    tolerances = dict(tolerances)
    names, low, high = tuple(bounds), *np.array(list(bounds.values())).T

    def reached_at(point, **scan):
        return _reached(parameters, force, number, tolerances, dict(zip(names, point, strict=True)), **scan)

    def score(point):
        """Margin at a point (len(names),); where there is no curve the force's distance from existence, negative."""
        reached = reached_at(point, **_COARSE)
        if isinstance(reached, float):
            return reached
        # Where slack wires limit the margin it is the same over a range: the other quantities then decide.
        return min(reached.values()) - 1e-3 * sum(1 / max(moves, 1e-9) for moves in reached.values())

    searched = _GRID + _POLISH if len(names) == 1 else _POPULATION * len(names) * (_GENERATIONS + 1)
    tried = itertools.count(1)
    with reporting(progress, searched, "rigs tried") as report:

        def counted(point):
            report(min(next(tried), searched))
            return score(point)

        best, status, message = _search(counted, low, high, seed)
        report(searched)
    found = dict(zip(names, best.tolist(), strict=True))
    reached = reached_at(best, **_FINE)
    if isinstance(reached, float):
        limits = ", ".join(f"{name} from {a:g} to {b:g}" for name, (a, b) in bounds.items())
        raise ValueError(f"no {kind} detached curve was found for {limits}; expected bounds that hold one")
    start = {name: quantity(parameters, force, name).value for name in names}
    before = reached_at(np.array(list(start.values())), **_FINE)
    profiles = {}
    for i, name in enumerate(names):
        values = np.union1d(np.linspace(low[i], high[i], _GRID), best[i])
        points = np.tile(best, (values.size, 1))
        points[:, i] = values
        reaches = [reached_at(point, **_COARSE) for point in points]
        heights = [np.nan if isinstance(one, float) else min(one.values()) for one in reaches]
        profiles[name] = np.stack([values, heights])
    better, level = replaced(parameters, force, found)
    margin, start_margin = min(reached.values()), 0.0 if isinstance(before, float) else min(before.values())
    free = {name: (*bounds[name], found[name]) for name in names}
    return Design(
        parameters=better, force=level, kind=kind, free=free, start=start, tolerances=tolerances, reach=reached,
        margin=margin, start_margin=start_margin, profiles=profiles, seed=seed, status=status, message=message,
    )  # fmt: skip


def _bounds(parameters, force, free):
    if not isinstance(free, (list, tuple, dict)):
        told = f"free = {checks.shown(free)} is not allowed"
        raise ValueError(f"{told}; expected a sequence of names, or a dict of bounds")
    if not free:
        raise ValueError("free is empty; expected at least one name")
    bounds = {}
    for name in checks.names("free", list(free), built_names(parameters), "free quantity"):
        item = quantity(parameters, force, name)
        # Wires are compared with each other only when both are set: d may fall below d0 if d0 is free as well.
        lowest, highest = (0.0, np.inf) if name in ("d", "d0") else (item.low, item.high)
        usual = max(0.2 * item.value, item.low), min(5 * item.value, item.high)
        given = free[name] if isinstance(free, dict) else usual
        ends = checks.array(f"bounds of {name}", given, item.unit, low=lowest, high=highest)
        if ends.size != 2 or not ends[0] < ends[1] or (item.low_open and ends[0] == 0):
            told = f"bounds of {name} = {checks.shown(given)} are not allowed"
            raise ValueError(f"{told}; expected (low, high), low below high")
        bounds[name] = tuple(ends.tolist())
    return bounds


def _reached(parameters, force, number, tolerances, values, **scan):
    """Reach of each toleranced quantity in tolerances; or a float of at most zero where there is no curve."""
    counts, distances = judge_varied(parameters, force, {name: np.array([v]) for name, v in values.items()})
    if not counts[0, number]:
        return max(float(distances[0, number]), -1e3)
    tried, level = replaced(parameters, force, values)
    widths = half_widths(tried, level, tolerances)
    moves = []
    for name, width in widths.items():
        value = quantity(tried, level, name).value
        moves += [(name, value, -width), (name, value, width)]
    inside, _ = reach(tried, level, number, moves, **scan)
    return {name: float(inside[2 * i : 2 * i + 2].min()) for i, name in enumerate(widths)}


def _search(objective, low, high, seed):
    """Point of the largest objective within bounds (d,), how the search ended, and after how much."""
    from scipy.optimize import differential_evolution, minimize_scalar

    if low.size > 1:
        # Scaled to 0..1, for wires differ by parts in ten thousand and forces by multiples.
        found = differential_evolution(
            lambda share: -objective(low + share * (high - low)), [(0, 1)] * low.size,
            seed=np.random.default_rng(seed), popsize=_POPULATION, maxiter=_GENERATIONS, tol=1e-4, polish=False,
        )  # fmt: skip
        best, tried = low + found.x * (high - low), found.nfev
    else:
        values = np.linspace(low[0], high[0], _GRID)
        heights = [objective(np.array([value])) for value in values]
        top = int(np.argmax(heights))
        bounds = values[[max(top - 1, 0), min(top + 1, _GRID - 1)]]
        accuracy = {"xatol": 1e-7 * abs(values[top]), "maxiter": _POLISH}
        lost = lambda value: -objective(np.array([value]))  # noqa: E731
        found = minimize_scalar(lost, bounds=bounds, method="bounded", options=accuracy)
        best, tried = np.array([found.x if -found.fun > heights[top] else values[top]]), _GRID + found.nfev
    return best, Status.CONVERGED if found.success else Status.NOT_CONVERGED, f"{tried} rigs were tried"
