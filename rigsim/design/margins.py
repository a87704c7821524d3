"""How far each number of a rig may move, all others held, before its detached curve is lost."""

import math
from dataclasses import dataclass

import numpy as np

from .. import checks
from ..blas import one_blas_thread
from ..campaign.progress import reporting
from ..orbits.accuracy import checked_harmonics
from ..parameters import law_of
from ..results import ResultSequence, frame
from .converged import Edges
from .variation import built_names, checked_start, judge_varied, kind_number, names_of, quantity

_STEPS = 181  # of the scan outwards: distances from a billionth of the range to all of it, 12 % apart
_COARSE = 49  # of the same of a converged curve, from a millionth
_BETWEEN = 41  # where the scan comes near the edge and leaves it again
_UNLIMITED = 1000.0  # a quantity without upper bound is followed to so many times its value
_OPEN = 1e-6  # and one that may not be zero down to this part of it


def reach(parameters, force, number, moves, grid, accuracy=1e-12):
    """How far along each move the curve exists: the last distance with it and the first without.

    A move is (name, value at distance 0, its change at distance 1), and ``number`` is 0 for inner curves, 1 for outer
    ones. Each move is scanned over a ``grid`` (k,) of distances, ascending and above 0; where the force's distance from
    the edge has a minimum between grid points, again between them. Then the interval of the first loss is halved down
    to ``accuracy``, relative. Both bounds, (n,) arrays, are judged, not inferred; the second is infinite where the
    curve is never lost on the grid.
    """
    names = np.array([move[0] for move in moves])
    origins, steps = (np.array([move[i] for move in moves], dtype=float) for i in (1, 2))

    def judged(rows, distances):
        values = origins[rows] + distances * steps[rows]
        changes = {name: np.where(names[rows] == name, values, np.nan) for name in set(names)}
        counts, distances = judge_varied(parameters, force, changes)
        return counts[:, number] > 0, distances[:, number]

    rows = np.repeat(np.arange(len(moves)), grid.size)
    kept, margin = (part.reshape(len(moves), -1) for part in judged(rows, np.tile(grid, len(moves))))
    inside, outside = np.full(len(moves), grid[-1]), np.full(len(moves), math.inf)
    for row in range(len(moves)):
        lost = int(np.argmin(kept[row])) if not kept[row].all() else grid.size
        near = margin[row, : lost + 1]
        dips = 1 + np.flatnonzero((near[1:-1] < near[:-2]) & (near[1:-1] <= near[2:]))
        for dip in dips:
            fine = np.linspace(grid[dip - 1], grid[dip + 1], _BETWEEN)
            there, _ = judged(np.full(fine.size, row), fine)
            if not there.all():
                first = int(np.argmin(there))
                inside[row], outside[row] = fine[first - 1], fine[first]
                break
        else:
            if lost < grid.size:
                inside[row], outside[row] = grid[lost - 1] if lost else 0.0, grid[lost]
    while (active := np.flatnonzero(np.isfinite(outside) & (outside - inside > accuracy * outside))).size:
        middle = 0.5 * (inside[active] + outside[active])
        there, _ = judged(active, middle)
        inside[active[there]], outside[active[~there]] = middle[there], middle[~there]
    return inside, outside


@dataclass(frozen=True, repr=False)
class Margin:
    """How far one quantity may move.

    Attributes
    ----------
    name, unit : str
    value : float
        SI units, as are all that follow.
    low, high : float
        Last values down and up at which the curve was found; where it is never lost, the end of what was searched.
    low_lost, high_lost : float or None
        First values at which it was not; None where it is never lost.
    shown_unit, factor
        What is shown to people, and the factor from SI to it.
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    low_lost: float | None
    high_lost: float | None
    shown_unit: str
    factor: float

    @property
    def down(self):
        """Largest move down (SI units); infinite if the curve is never lost."""
        return math.inf if self.low_lost is None else self.value - self.low

    @property
    def up(self):
        """Largest move up (SI units); infinite if the curve is never lost."""
        return math.inf if self.high_lost is None else self.high - self.value

    @property
    def smallest(self):
        """The smaller move, relative to the value (infinite for a quantity that is zero)."""
        return min(self.down, self.up) / self.value if self.value else math.inf

    def __repr__(self):
        moves = f"-{self.down * self.factor:.4g}, +{self.up * self.factor:.4g}"
        return f"Margin({self.name} = {self.value * self.factor:.6g} {self.shown_unit}: {moves})"


@dataclass(frozen=True, eq=False, repr=False)
class Margins(ResultSequence):
    """The `margins` of a rig: a sequence of `Margin`, smallest relative move first.

    It knows the ``parameters``, the ``force`` (N) and the ``kind``, "inner" or "outer".
    """

    members: tuple
    parameters: object
    force: float
    kind: str

    plots = {"margins": "margins_figure"}

    def __getitem__(self, which):
        """The `Margin` of a name, or at a place."""
        return {entry.name: entry for entry in self}[which] if isinstance(which, str) else self.members[which]

    def summary(self):
        """What limits the rig most."""
        first = self[0]
        move = min(first.down, first.up)
        if not math.isfinite(move):
            return f"The {self.kind} detached curve at {self.force:g} N survives any move of a single quantity"
        sign = "-" if first.down <= first.up else "+"
        told = f"{sign}{move * first.factor:.3g} {first.shown_unit} ({sign}{100 * move / first.value:.2g} %)"
        return f"The {self.kind} detached curve at {self.force:g} N is lost first by {first.name}: {told}"

    def table(self):
        """`pandas.DataFrame` of each quantity's value, bounds and moves; infinite where nothing is lost."""
        rows = []
        for entry in self:
            percent = 100 / entry.value if entry.value else math.nan
            moves = [-entry.down * entry.factor, entry.up * entry.factor, -entry.down * percent, entry.up * percent]
            rows.append((entry.name, entry.value * entry.factor, entry.shown_unit, *moves))
        columns = ["quantity", "value", "unit", "down", "up", "down [%]", "up [%]"]
        return frame(rows, columns, index="quantity")


@one_blas_thread
def margins(parameters, force, kind="inner", names=None, *, harmonics=1, law=None, progress=False):
    """How far each single number may move, all others held, before the rig has no detached curve of a kind.

    A quantity is moved outwards until the number of curves of the kind falls to zero for the first time, and the
    two values on either side of that place, 1e-12 of the move apart, are both classified. A quantity without upper
    bound is followed to a thousand times its value, one that may not be zero down to a millionth of it.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        Amplitude (N, above zero).
    kind : {"inner", "outer"}
    names : sequence of str, optional
        Fields of the parameters, "force", "k1", "k3", or non-dimensional names of Table 5; by default the fields that
        matter to the theory, and the force. ``k`` stands for all wires alike.
    harmonics : int or "auto"
        1: of the curve of single-term theory. More: of the converged one, by the fields and the force only, until the
        event that makes or ends it passes the force, to 1e-9 of the move; see `rigsim.design.converged`.
    law : {"exact", "cubic"}, optional
        Of the converged one.
    progress : bool or callable
        True shows a bar; a callable is told (moves done, moves in all).

    Returns
    -------
    Margins
        Smallest relative move first.

    Raises
    ------
    ValueError
        If an input is not allowed, or there is no such curve to lose.

    Examples
    --------
    >>> margins(RigParameters(), 3.18)["d0"]  # doctest: +SKIP
    """
    built = built_names(parameters)
    names = built if names is None else checks.names("names", names, names_of(parameters), "quantity")
    harmonics, law = checked_harmonics(harmonics), law_of(parameters, law)
    if harmonics == 1:
        force, number = checked_start(parameters, force, kind)
    else:
        force, number = checks.positive("force", force, "N"), kind_number(kind)
        edges = Edges(parameters, force, kind, names, harmonics, law)
    items = [quantity(parameters, force, name) for name in names]
    moves = []
    for item in items:
        top = item.high if math.isfinite(item.high) else item.value * _UNLIMITED or _scale(parameters, item.name)
        bottom = item.value * _OPEN if item.low_open else item.low
        moves += [(item.name, item.value, bottom - item.value), (item.name, item.value, top - item.value)]
    with reporting(progress, len(moves), "moves") as report:
        if harmonics == 1:
            reached = reach(parameters, force, number, moves, np.geomspace(1e-9, 1, _STEPS))
        else:
            reached = np.empty((2, len(moves)))
            for i, move in enumerate(moves):
                reached[:, i] = edges.reach(*move, np.geomspace(1e-6, 1, _COARSE))
                report(i + 1)
        report(len(moves))
    ends = []  # of each move: the last value with the curve and the first without
    for (_, origin, step), kept, lost in zip(moves, *reached, strict=True):
        never = step == 0 or math.isinf(lost)
        ends.append((float(origin + kept * step), None if never else float(origin + lost * step)))
    entries = []
    for item, (low, low_lost), (high, high_lost) in zip(items, ends[::2], ends[1::2], strict=True):
        shown = item.shown_unit, item.factor
        entries.append(Margin(item.name, item.unit, item.value, low, high, low_lost, high_lost, *shown))
    return Margins(tuple(sorted(entries, key=lambda entry: entry.smallest)), parameters, force, kind)


def _scale(parameters, name):
    """How far a quantity that is zero is followed upwards: far beyond what any rig has."""
    oscillator = parameters.oscillator
    stiffness = oscillator.m * oscillator.omega_s**2
    return _UNLIMITED * {"c": oscillator.m * oscillator.omega_s, "k1": stiffness}.get(name, 1.0)
