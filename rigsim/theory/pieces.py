"""Connected curves of the single-term response, drawn through their folds without gaps."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..parameters import OscillatorParameters
from .cubic import complex_amplitudes, solve
from .detached import folds, interval_kind
from .floquet import is_stable, orbit_multipliers, runs_of

_MERGING = {"lower": (0, 1), "upper": (1, 2)}  # solutions that meet at a fold
_DETACHED = {"inner": (0, 1), "outer": (1, 2), "hysteresis": ()}  # solutions that form a detached curve
# Added between the ends of an interval of three solutions, denser there: a fold's tip is a square root.
_BETWEEN = np.sin(np.linspace(0, np.pi / 2, 42)[1:-1]) ** 2


@dataclass(frozen=True, eq=False)
class Piece:
    """A connected curve of single-term solutions inside the band, ordered along itself; force in N.

    Attributes
    ----------
    kind : str
        "main", "inner" or "outer".
    closed : bool
        Whether it closes on itself inside the band; its last point is then its first.
    folds : tuple of Fold
        The folds on it, in the order of the curve.
    frequency : (k,) array
        Hz; turns back at every fold.
    shaker, mass, relative : (k,) complex array
        Amplitudes (m); see `FrequencyResponse`.
    """

    parameters: OscillatorParameters
    force: float
    kind: str
    closed: bool
    folds: tuple
    frequency: np.ndarray
    shaker: np.ndarray
    mass: np.ndarray
    relative: np.ndarray

    @cached_property
    def stable(self):
        """(k,) bool: stability by Floquet multipliers about the single-term orbits; see `FrequencyResponse`."""
        return is_stable(orbit_multipliers(self.parameters, self.force, self.frequency, self.relative))

    @cached_property
    def runs(self):
        """Tuple of (slice, bool): the `runs_of` equal stability along the curve."""
        return runs_of(self.stable)


@dataclass(frozen=True, eq=False)
class _Strand:
    """One solution between two cuts; an end is (number of the fold, whether two strands of this region meet there)."""

    kind: str
    ends: tuple
    frequency: np.ndarray
    U: np.ndarray


def connected_pieces(oscillator, force, frequency):
    """Every connected curve over the band that ``frequency`` (Hz) spans, as a tuple of `Piece`.

    The folds cut the band into regions with one or three solutions, one strand each. At a fold two strands of a
    region meet, and the third goes on into the next region. Strands are followed from the ends of the band first;
    those left over form closed curves.
    """
    points = folds(oscillator, force)
    strands = _strands(oscillator, force, np.unique(frequency), points)
    meeting = {}
    for strand in strands:
        for end in strand.ends:
            meeting.setdefault(end, []).append(strand)
    pieces, used = [], set()
    for first in sorted(strands, key=lambda strand: None not in strand.ends):
        if first not in used:
            walk = _follow(first, meeting)
            used.update(strand for strand, _ in walk)
            pieces.append(_piece(oscillator, force, points, walk))
    return tuple(pieces)


def _strands(oscillator, force, frequency, points):
    group = oscillator.nondimensional(force)
    numbers = group.mu, group.zeta_s, group.zeta, group.Omega0, group.gamma
    scale = 2 * np.pi / oscillator.omega_s
    low, high = frequency[0], frequency[-1]
    merging, passing = _fold_solutions(numbers, scale, oscillator.ks / force, points)
    edges = [-np.inf, *(fold.frequency for fold in points), np.inf]
    strands = []
    for region, (left_edge, right_edge) in enumerate(pairwise(edges)):
        if left_edge >= high or right_edge <= low:
            continue
        # A fold beyond the band is no cut: the strand ends with the band.
        left, right = region - 1 if left_edge > low else None, region if right_edge < high else None
        start, stop = max(left_edge, low), min(right_edge, high)
        places = frequency[(frequency > start) & (frequency < stop)]
        places = np.union1d(places, [f for f, cut in ((start, left), (stop, right)) if cut is None])
        several = region % 2 == 1
        if several:
            kind = interval_kind(points[region - 1].kind, points[region].kind)
            places = np.union1d(places, start + (stop - start) * _BETWEEN)
        U, count = solve(*numbers, places * scale)
        sure = count == (3 if several else 1)  # within rounding of a fold the count may be the neighbour's
        for i in range(3 if several else 1):
            ends = [
                None if cut is None else (cut, several and i in _MERGING[points[cut].kind]) for cut in (left, right)
            ]
            tips = [[] if end is None else [(merging if end[1] else passing)[end[0]]] for end in ends]
            f = np.concatenate([[start] * len(tips[0]), places[sure], [stop] * len(tips[1])])
            u = np.concatenate([tips[0], U[sure, i], tips[1]])
            detached = several and i in _DETACHED[kind]
            strands.append(_Strand(kind if detached else "main", tuple(ends), f, u))
    return strands


def _fold_solutions(numbers, scale, unit, points):
    """U at each fold of the double solution and of the one that passes by."""
    merging = [0.75 * numbers[-1] * abs(fold.relative * unit) ** 2 for fold in points]
    U, count = solve(*numbers, np.array([fold.frequency * scale for fold in points]))
    passing = [u[n - 1] if fold.kind == "lower" else u[0] for fold, u, n in zip(points, U, count, strict=True)]
    return merging, passing


def _follow(first, meeting):
    """The strands of one piece in order, each with whether it is walked from left to right."""
    strand, forward = first, first.ends[0] is None or first.ends[1] is not None
    walk = [(strand, forward)]
    while (end := strand.ends[1 if forward else 0]) is not None:
        one, other = meeting[end]
        strand = other if strand is one else one
        if strand is first:
            break
        forward = strand.ends[0] == end
        walk.append((strand, forward))
    return walk


def _piece(oscillator, force, points, walk):
    group = oscillator.nondimensional(force)
    frequency = np.concatenate([strand.frequency[:: 1 if forward else -1] for strand, forward in walk])
    U = np.concatenate([strand.U[:: 1 if forward else -1] for strand, forward in walk])
    leaving = [strand.ends[1 if forward else 0] for strand, forward in walk]
    keep = np.ones(frequency.size, dtype=bool)  # neighbouring strands share their end point
    keep[np.cumsum([strand.frequency.size for strand, _ in walk])[:-1]] = False
    frequency, U = frequency[keep], U[keep]
    motion = complex_amplitudes(group, 2 * np.pi / oscillator.omega_s * frequency, U)
    return Piece(
        oscillator,
        float(force),
        walk[0][0].kind,
        leaving[-1] is not None,
        tuple(points[end[0]] for end in leaving if end is not None and end[1]),
        frequency,
        *(force / oscillator.ks * values for values in motion),
    )
