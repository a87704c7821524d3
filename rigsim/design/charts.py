"""Existence charts: where inner, outer, both or no detached curves exist, over any two numbers of a rig."""

from dataclasses import dataclass

import numpy as np

from .. import checks
from ..parameters import oscillator_of
from ..results import Result
from .count import KINDS
from .variation import half_widths, judge_varied, names_of, quantity, varied_sets

_HALVINGS = 24  # of a grid's cell, to place the boundary curves
_DECADES = 20.0  # axes that span more than this factor are logarithmic


@dataclass(frozen=True, eq=False, repr=False)
class Boundary:
    """A curve on a chart where the last detached curve of a kind comes or goes.

    Attributes
    ----------
    kind : str
        "inner" or "outer".
    x, y : (k,) array
        SI units; the last point is the first where the curve closes on itself.
    """

    kind: str
    x: np.ndarray
    y: np.ndarray

    def __repr__(self):
        return f"Boundary({self.kind}, {self.x.size} points)"


@dataclass(frozen=True, eq=False, repr=False)
class ExistenceChart(Result):
    """The map of `existence_chart`.

    Attributes
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        Amplitude (N).
    names : (str, str)
        The quantities along x and y.
    x, y : (nx,), (ny,) array
        The grid (SI units).
    inner, outer : (ny, nx) int array
        Number of detached curves of each kind.
    distance : (2, ny, nx) array
        For inner and outer: ln(F/F_edge) of the nearest edge of existence, positive where the curve exists; -infinity
        where it does at no force.
    possible : (ny, nx) bool array
        False where there is no such rig (slack wires).
    boundaries : tuple of Boundary
    point : (float, float)
        The rig itself.
    box : (float, float)
        Its tolerances along x and y (half-widths, SI units); 0 where none is given.
    """

    parameters: object
    force: float
    names: tuple
    x: np.ndarray
    y: np.ndarray
    inner: np.ndarray
    outer: np.ndarray
    distance: np.ndarray
    possible: np.ndarray
    boundaries: tuple
    point: tuple
    box: tuple

    plots = {"chart": "existence_chart_figure"}

    @property
    def labels(self):
        """(ny, nx) array of "none", "inner", "outer" or "both"."""
        return np.array(["none", "inner", "outer", "both"])[(self.inner > 0) + 2 * (self.outer > 0)]

    def summary(self):
        """What is over what, and how much of the map has which label."""
        shares = [
            f"{label} {100 * np.mean(self.labels == label):.0f} %" for label in ("inner", "outer", "both", "none")
        ]
        return f"Detached curves over {self.names[0]} and {self.names[1]}, of the map: {', '.join(shares)}"


def existence_chart(parameters, force, x, y, tolerances=None, points=(121, 101)):
    """Where detached curves exist, over any two numbers of a rig, with the curves that bound them.

    Every point of a grid is classified as `rigsim.classify` does it; where two neighbours differ, the place between
    them is found by classification, to 1e-7 of their distance. So curves have no pixels, but a region narrower than
    a cell is seen only if a grid point falls into it.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
        What is not on the axes stays.
    force : float
        Amplitude (N, above zero).
    x, y : str, or (str, float, float)
        A field of the parameters, "force", "k1", "k3" or a name of Table 5, and the ends of its axis (SI units).
        Without ends from half to twice the value; for wire lengths from no stretch to four times the stretch.
    tolerances : dict of str to float or str, optional
        As for `tolerance_study`; those of x and y become the box around the rig.
    points : (int, int)
        Grid points along x and y. An axis that spans more than a factor of 20 is spaced evenly in its logarithm.

    Returns
    -------
    ExistenceChart

    Raises
    ------
    ValueError
        If an input is not allowed, or x and y are the same quantity.

    Examples
    --------
    >>> existence_chart(RigParameters(), 3.18, ("d0", 33.985e-3, 34e-3), ("force", 0.3, 8)).plot()  # doctest: +SKIP
    """
    oscillator_of(parameters)
    force = checks.positive("force", force, "N")
    counts = [checks.integer("points", number, low=2) for number in points]
    axes = [_axis(parameters, force, given, number) for given, number in zip((x, y), counts, strict=True)]
    names = axes[0][0], axes[1][0]
    if names[0] == names[1]:
        raise ValueError(f"x and y are both {names[0]}; expected two quantities")
    widths = {} if tolerances is None else half_widths(parameters, force, tolerances)
    (_, x_of, _), (_, y_of, _) = axes
    # Places on the chart are counted in cells from its lower left corner.
    columns, rows = np.meshgrid(np.arange(counts[0], dtype=float), np.arange(counts[1], dtype=float))

    def changes(column, row):
        return {names[0]: x_of(column), names[1]: y_of(row)}

    everywhere = changes(columns.ravel(), rows.ravel())
    found, distances = judge_varied(parameters, force, everywhere)
    inner, outer = found.T.reshape(2, *columns.shape)
    boundaries = []
    for kind in range(2):

        def exists(column, row, kind=kind):
            return judge_varied(parameters, force, changes(column, row))[0][:, kind] > 0

        for path in _boundaries((inner, outer)[kind] > 0, exists):
            boundaries.append(Boundary(KINDS[kind], x_of(path[:, 0]), y_of(path[:, 1])))
    return ExistenceChart(
        parameters=parameters,
        force=force,
        names=names,
        x=x_of(columns[0]),
        y=y_of(rows[:, 0]),
        inner=inner,
        outer=outer,
        distance=distances.T.reshape(2, *columns.shape),
        possible=np.isfinite(varied_sets(parameters, force, everywhere)[:, 0]).reshape(columns.shape),
        boundaries=tuple(boundaries),
        point=tuple(quantity(parameters, force, name).value for name in names),
        box=tuple(widths.get(name, 0.0) for name in names),
    )


def _axis(parameters, force, given, count):
    """(name, function from cells to values, whether logarithmic)."""
    if isinstance(given, str):
        name, ends = given, None
    else:
        if len(given) != 3:
            raise ValueError(f"axis {given!r} is not allowed; expected a name, or (name, low, high)")
        name, ends = given[0], given[1:]
    checks.one_of("quantity", name, names_of(parameters))
    item = quantity(parameters, force, name)
    if ends is None:
        if name in ("d", "d0"):
            stretch = 4 * (parameters.d - parameters.d0)
            ends = (parameters.d - stretch, parameters.d) if name == "d0" else (parameters.d0, parameters.d0 + stretch)
        else:
            ends = 0.5 * item.value, 2 * item.value
    low, high = checks.array(f"ends of the axis {name}", ends, item.unit, low=0.0, low_open=item.low_open)
    if not low < high:
        raise ValueError(f"ends of the axis {name} = ({low:g}, {high:g}) are not allowed; expected the lower one first")
    if low > 0 and high > _DECADES * low:
        return name, lambda cells: low * (high / low) ** (cells / (count - 1)), True
    return name, lambda cells: low + (high - low) * (cells / (count - 1)), False


def _boundaries(inside, exists):
    """Paths (k, 2), column and row in cells, between grid points that differ (marching squares)."""
    crossings = {}
    for down, right in ((0, 1), (1, 0)):
        one = inside[: inside.shape[0] - down, : inside.shape[1] - right]
        differs = np.argwhere(one != inside[down:, right:])
        for row, column in differs.tolist():
            crossings[row, column, down] = None
    if not crossings:
        return []
    keys = np.array(list(crossings))
    near, steps = keys[:, 1::-1].astype(float), np.stack([1 - keys[:, 2], keys[:, 2]], axis=1).astype(float)
    low, high = np.zeros(len(keys)), np.ones(len(keys))
    first = inside[keys[:, 0], keys[:, 1]]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        same = exists(*(near + middle[:, None] * steps).T) == first
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    places = near + (0.5 * (low + high))[:, None] * steps
    crossings = dict(zip(crossings, places, strict=True))
    return [np.array([crossings[key] for key in path]) for path in _walks(_links(inside, crossings, exists))]


def _links(inside, crossings, exists):
    """Neighbours of each crossing along its boundary, at most two."""
    links = {key: [] for key in crossings}
    cells = {(row, column) for row, column, _ in crossings}
    cells |= {(row - (1 - down), column - down) for row, column, down in crossings}  # on the edge's other side
    for row, column in sorted(cells):
        bottom, top = (row, column, 0), (row + 1, column, 0)
        left, right = (row, column, 1), (row, column + 1, 1)
        sides = [side for side in (bottom, right, top, left) if side in crossings]
        if not (0 <= row < inside.shape[0] - 1 and 0 <= column < inside.shape[1] - 1):
            continue
        if len(sides) == 4:  # a saddle: its middle says which corners belong together
            middle = bool(exists(np.array([column + 0.5]), np.array([row + 0.5]))[0])
            apart = middle == bool(inside[row, column])
            pairs = [(bottom, right), (top, left)] if apart else [(bottom, left), (top, right)]
        else:
            pairs = [tuple(sides)] if len(sides) == 2 else []
        for one, other in pairs:
            links[one].append(other)
            links[other].append(one)
    return links


def _walks(links):
    """The chains of linked keys, open ones from end to end, closed ones back to their start."""
    waiting = dict.fromkeys(sorted(links, key=lambda key: (len(links[key]), key)))
    paths = []
    while waiting:
        key = next(iter(waiting))
        path = [key]
        del waiting[key]
        while ahead := [other for other in links[path[-1]] if other in waiting]:
            path.append(ahead[0])
            del waiting[ahead[0]]
        if len(path) > 2 and path[0] in links[path[-1]]:
            path.append(path[0])
        if len(path) > 1:
            paths.append(path)
    return paths
