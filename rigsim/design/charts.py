"""Existence charts: where inner, outer, both or no detached curves exist, over any two numbers of a rig."""

from dataclasses import dataclass

import numpy as np

from .. import checks
from ..campaign.cost import affordable
from ..parameters import oscillator_of
from ..results import Result
from .count import KINDS
from .variation import half_widths, judge_varied, names_of, quantity, varied_sets

_BYTES = 400  # a point
_HALVINGS = 24  # of a grid's cell, to place the boundary curves
_NEAR, _FAR = 0.01, 0.25  # of ln(F): between them outlines ask how far the edge is, to part or join at saddles
_DECADES = 20.0  # axes that span more than this factor are logarithmic


@dataclass(frozen=True, eq=False, repr=False)
class Outline:
    """Where the last detached curve of a kind comes or goes, or what that and the chart's edges enclose.

    Attributes
    ----------
    kind : str
        "inner" or "outer".
    x, y : (k,) array
        SI units; the last point is the first where a boundary closes on itself.
    codes : (k,) array of int, or None
        Of a region with its holes, one after another: what leads to each point, in the codes of matplotlib's ``Path``.
    """

    kind: str
    x: np.ndarray
    y: np.ndarray
    codes: np.ndarray | None

    def __repr__(self):
        return f"Outline({self.kind}, {self.x.size} points)"


@dataclass(frozen=True, eq=False, repr=False)
class ExistenceChart(Result):
    """The map of `existence_chart`.

    Attributes
    ----------
    parameters, force, tolerances
        As given.
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
    boundaries, regions : tuple of Outline
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
    regions: tuple
    point: tuple
    box: tuple
    tolerances: dict | None

    plots = {"chart": "existence_chart_figure"}

    @property
    def labels(self):
        """(ny, nx) array of "none", "inner", "outer" or "both"."""
        return np.array(["none", "inner", "outer", "both"])[(self.inner > 0) + 2 * (self.outer > 0)]

    def summary(self):
        """What is over what, and how much of the map has which label."""
        labels = "inner", "outer", "both", "none"
        shares = ", ".join(f"{label} {100 * np.mean(self.labels == label):.0f} %" for label in labels)
        return f"Detached curves over {self.names[0]} and {self.names[1]}, of the map: {shares}"


def existence_chart(
    parameters, force, x, y, tolerances=None, points=(121, 101), *, progress=False, executor=None, checkpoint=None
):
    """Where detached curves exist, over any two numbers of a rig, with the curves that bound them.

    Every point of a grid is classified, and contours are drawn between those that differ; where a contour crosses a
    line of the grid is found by classification, to 1e-7 of a cell. So curves have no pixels. A region narrower than
    a cell is left out, where single grid points would hit it here and there: what is drawn holds a whole cell, and goes
    on from there as far as neighbouring points are in it.

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
    progress, executor, checkpoint
        See `rigsim.campaign.run.run_chunks`; by default a thread a core. The outlines come after the grid, in about
        as long again.

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
    progress, executor, checkpoint = checks.running(progress, executor, checkpoint)
    counts = checks.integers("points", points, low=2, size=2)
    affordable(
        f"points = ({counts[0]}, {counts[1]})", instead="fewer points", memory=_BYTES * counts[0] * counts[1],
        seconds=3e-5 * counts[0] * counts[1], shared=executor or checkpoint,
    )  # fmt: skip
    axes = [_axis(parameters, force, *axis) for axis in zip("xy", (x, y), counts, strict=True)]
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
    found, distances = judge_varied(
        parameters, force, everywhere, progress=progress, executor=executor, checkpoint=checkpoint
    )
    inner, outer = found.T.reshape(2, *columns.shape)
    outlines = []
    for number, kind in enumerate(KINDS):

        def exists(column, row, number=number):
            return judge_varied(parameters, force, changes(column, row))[0][:, number] > 0

        for path, codes in _outlines(distances[:, number].reshape(columns.shape), exists):
            outlines.append(Outline(kind, x_of(path[:, 0]), y_of(path[:, 1]), codes))
    distance = distances.T.reshape(2, *columns.shape)
    possible = np.isfinite(varied_sets(parameters, force, everywhere)[:, 0]).reshape(columns.shape)
    boundaries, regions = (tuple(one for one in outlines if (one.codes is None) == line) for line in (True, False))
    point = tuple(quantity(parameters, force, name).value for name in names)
    box = tuple(widths.get(name, 0.0) for name in names)
    return ExistenceChart(
        parameters=parameters, force=force, names=names, x=x_of(columns[0]), y=y_of(rows[:, 0]), inner=inner,
        outer=outer, distance=distance, possible=possible, boundaries=boundaries, regions=regions, point=point, box=box,
        tolerances=tolerances,
    )  # fmt: skip


def _axis(parameters, force, which, given, count):
    """(name, function from cells to values, whether logarithmic)."""
    if not isinstance(given, str) and not (isinstance(given, (list, tuple)) and len(given) == 3):
        raise ValueError(f"axis {which} = {checks.shown(given)} is not allowed; expected a name, or (name, low, high)")
    name, *ends = (given,) if isinstance(given, str) else given
    name = checks.one_of("quantity", name, names_of(parameters))
    item = quantity(parameters, force, name)
    if not ends:
        ends = 0.5 * item.value, 2 * item.value
        if name in ("d", "d0"):
            stretch = 4 * (parameters.d - parameters.d0)
            ends = (parameters.d - stretch, parameters.d) if name == "d0" else (parameters.d0, parameters.d0 + stretch)
    low, high = checks.array(f"ends of the axis {name}", ends, item.unit, low=0.0, low_open=item.low_open, size=2)
    if not low < high:
        raise ValueError(f"ends of the axis {name} = ({low:g}, {high:g}) are not allowed; expected the lower one first")
    if low > 0 and high > _DECADES * low:
        return name, lambda cells: low * (high / low) ** (cells / (count - 1)), True
    return name, lambda cells: low + (high - low) * (cells / (count - 1)), False


def _outlines(distance, exists):
    """(path (k, 2) in cells, codes or None) of the curves around a region, and of its connected parts."""
    from contourpy import contour_generator

    inside = _whole(distance > 0)
    level = np.where(inside, 1, -1) * np.abs(distance).clip(_NEAR, _FAR)
    contours = contour_generator(z=level, line_type="Separate", fill_type="OuterCode")
    lines, (areas, codes) = contours.lines(0.0), contours.filled(0.0, np.inf)
    if not areas:
        return []
    places, back = np.unique(np.concatenate((*lines, *areas)), axis=0, return_inverse=True)
    ends = np.cumsum([len(path) for path in (*lines, *areas)])[:-1]
    paths = np.split(_placed(places, inside, exists)[back.ravel()], ends)
    return list(zip(paths, [None] * len(lines) + codes, strict=True))


def _whole(inside):
    """Without the parts that hold no whole cell."""
    from scipy.ndimage import label

    parts, _ = label(inside)
    cell = inside[:-1, :-1] & inside[1:, :-1] & inside[:-1, 1:] & inside[1:, 1:]
    return inside & np.isin(parts, parts[:-1, :-1][cell])


def _placed(places, inside, exists):
    """Points (k, 2) of contours, moved along the line of the grid that they lie on to where the region ends."""
    places = places.round(6)  # a contour crosses at least 0.01/0.26 from a grid point
    moving = (places != np.floor(places)).any(axis=1)  # others are the chart's own edge
    near = np.floor(places[moving])
    steps = (places[moving] > near).astype(float)
    first = inside[near[:, 1].astype(int), near[:, 0].astype(int)]
    low, high = np.zeros(len(near)), np.ones(len(near))
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        same = exists(*(near + middle[:, None] * steps).T) == first
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    places[moving] = near + (0.5 * (low + high))[:, None] * steps
    return places
