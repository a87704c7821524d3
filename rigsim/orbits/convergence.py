"""What each number of harmonics is worth: the same curves traced with more and more of them."""

from dataclasses import dataclass

import numpy as np

from .. import checks
from ..blas import one_blas_thread
from ..campaign.progress import reporting
from ..parameters import law_of
from ..results import Result, frame
from .continuation import advance, unit_tangent
from .harmonic_balance import balance
from .periodic_orbits import periodic_orbits

_BEYOND = 10  # harmonics that the reference has more than the largest number asked for


@dataclass(frozen=True, eq=False, repr=False)
class HarmonicsWorth(Result):
    """What `harmonics_worth` returns; row i belongs to ``harmonics[i]``.

    Attributes
    ----------
    harmonics : (k,) array of int
    error : (k, 3) array
        Largest error of xs, x and z (all lines together, relative) of any symmetric orbit, across the curve.
    shift : (k,) array
        Largest distance of a special point from its place (Hz); infinite if its kind does not occur at all.
    pieces, points : (k,) array of int
        Curves and special points found.
    reference : int
        Harmonics of what these are compared with.
    """

    harmonics: np.ndarray
    error: np.ndarray
    shift: np.ndarray
    pieces: np.ndarray
    points: np.ndarray
    reference: int

    plots = {"harmonics": "harmonics_figure"}

    def table(self):
        """`pandas.DataFrame`, one row a number of harmonics."""
        columns = ["harmonics", "error of xs", "error of x", "error of z", "shift [Hz]", "pieces", "special points"]
        values = [self.harmonics, *self.error.T, self.shift, self.pieces, self.points]
        return frame(dict(zip(columns, values, strict=True)), index="harmonics")

    def summary(self):
        """One line: errors of the fewest and of the most harmonics."""
        return (
            f"HarmonicsWorth: error of z from {self.error[0, 2]:.1e} with {self.harmonics[0]} harmonics to "
            f"{self.error[-1, 2]:.1e} with {self.harmonics[-1]}"
        )


@one_blas_thread
def harmonics_worth(parameters, force, band=(5, 80), harmonics=(1, 3, 5, 7, 9, 11), law=None, *, progress=False):
    """Errors of the curves of `periodic_orbits` for several numbers of harmonics, against ten more than the largest.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        Force amplitude F (N, above zero).
    band : (float, float)
        Forcing frequencies (Hz).
    harmonics : sequence of int
        Ascending, from 1 to 190.
    law : {"exact", "cubic"}, optional
    progress : bool or callable
        True shows a bar; a callable is told (numbers of harmonics done, numbers in all).

    Returns
    -------
    HarmonicsWorth

    Raises
    ------
    ValueError
        If an input is not allowed; see `periodic_orbits`.
    """
    law, band = law_of(parameters, law), checks.pair("band", band, "Hz")
    force = checks.positive("force", force, "N")
    counts = checks.integers("harmonics", harmonics, low=1, high=200 - _BEYOND)
    if list(counts) != sorted(set(counts)):
        raise ValueError(f"harmonics = {checks.shown(counts)} is not allowed; expected ascending numbers")
    error, shift, pieces, points = [], [], [], []
    with reporting(progress, len(counts) + 1, "numbers of harmonics") as report:
        best = periodic_orbits(parameters, force, band, counts[-1] + _BEYOND, law)
        places = [(point.kind, point.frequency) for branch in best for point in branch.special_points]
        for i, count in enumerate(counts, 1):
            report(i)
            error.append(_errors(best, count))
            curves = periodic_orbits(parameters, force, band, count, law)
            here = [(point.kind, point.frequency) for branch in curves for point in branch.special_points]
            gaps = [min((abs(f - g) for name, g in here if name == kind), default=np.inf) for kind, f in places]
            shift.append(max(gaps, default=0.0))
            pieces.append(len(curves))
            points.append(len(here))
        report(len(counts) + 1)
    arrays = map(np.array, (counts, error, shift, pieces, points))
    return HarmonicsWorth(*arrays, best[0].harmonics)


def _errors(branches, count):
    """Largest relative error (3,) of all orbits of the curves if only ``count`` harmonics are kept."""
    largest = np.zeros(3)
    for branch in branches:
        if not branch.symmetric:  # with too few harmonics there may be none
            continue
        equations = balance(branch.parameters, branch.force, count, branch.law, symmetric=True)
        points = np.array([equations.unknowns(f, z) for f, z in zip(branch.frequency, branch.relative, strict=True)])
        along = np.gradient(points, axis=0)
        for i, point in enumerate(points):
            sign, _, orbit, _ = advance(*equations.system, point, unit_tangent(point, along[i]), 0.0)
            if sign == 0:
                raise RuntimeError(f"no orbit with {count} harmonics was found near {branch.frequency[i]:g} Hz")
            _, *few = equations.lines(orbit[None])
            for j, (lines, name) in enumerate(zip(few, ("shaker", "mass", "relative"), strict=True)):
                exact = getattr(branch, name)[i]
                padded = np.zeros_like(exact)
                padded[: count + 1] = lines[0]
                largest[j] = max(largest[j], np.linalg.norm(padded - exact) / np.linalg.norm(exact))
    return largest
