"""Loci on the response sheet: lines over frequency and force along which motions fold, or lose their stability.

A point of the sheet is y = (coefficients, Omega, F over the wanted force), with as many balance equations as
coefficients, so the sheet is two-dimensional. A locus is where one more test vanishes on it:

- *fold*: the Jacobian by the coefficients is singular. Its fold points over frequency and over force are the same, so
  every closed curve of the response has two at least: the folds of the response at one force are where these lines
  pass that force, all of them.
- *symmetry breaking*, *period doubling*: the block of the Jacobian over the lines that these motions lack is singular.
- *Neimark-Sacker*: the product of a complex pair of multipliers is one.

A singular matrix A is told by g of [[A, b], [c, 0]] (w, g) = (0, 1), which vanishes with its determinant but is of the
order of one; its slope is -v dA w with v the left solution (Griewank and Reddien 1984). The line is followed by
arc length in relative lengths, as in `rigsim.orbits.continuation`, so through cusps, where Omega and F turn together.
Where F alone turns along a fold line, it is stationary on the sheet, and the response's pieces change.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from .continuation import breaking_rows, sizes
from .harmonic_balance import residual
from .stability import test_values

FOLD, BREAKING, DOUBLING, TORUS = "fold", "symmetry breaking", "period doubling", "Neimark-Sacker"

_LONGEST, _FIRST = 0.2, 0.02  # relative lengths of steps
_TURN, _AIM = 0.5, 0.2  # rad
_SHORTEST = 1e-7
_CONVERGED = 1e-9  # relative, of a step whose own error is a small share of it
_PROBE = 1e-5  # relative length over which slopes of a test are measured
_ROOM = 2_000
_SAME = 1e-5  # relative distance of one point found twice
_CUSP = 1e-5  # of the tangent along Omega where F turns: below it Omega turns there, too
_NEAR = 0.3  # relative distance within which a chord is from its line


def apart(one, other):
    """Relative distance of two points, in the sizes at the second."""
    return float(np.linalg.norm((one - other) / sizes(other, 2)))


def _axis(y, column):
    axis = np.zeros(y.size)
    axis[column] = 1
    return axis


class _LostError(Exception):
    """No point of a locus was found between two of it."""


def resized(x, size, last):
    """Unknowns with lines cut or padded to a ``size`` in all, the ``last`` ones, no coefficients, kept."""
    result = np.zeros(size)
    shared = min(size, x.size) - last
    result[:shared], result[-last:] = x[:shared], x[-last:]
    return result


@dataclass(frozen=True, eq=False)
class Sheet:
    """A surface of motions, and what can happen on it.

    Attributes
    ----------
    equations : Balance
        At the wanted force.
    wider : Balance or None
        With the lines that its motions lack, for BREAKING or DOUBLING.
    """

    equations: object
    wider: object = None

    def at(self, y):
        """Residual (m,) and Jacobian (m, m + 2) at a point (m + 2,)."""
        equations = self.equations
        values, known = residual(equations.at_force(y[-1]).system, y[:-1])
        jacobian = np.zeros((values.size, y.size))
        jacobian[:, :-1] = known
        row = self._row
        mu, zeta_s = equations.numbers[:2]
        drive = -(y[-2] ** 2) / (1 - (1 + mu) * y[-2] ** 2 + 2j * zeta_s * y[-2])
        jacobian[row, -1], jacobian[row + 1, -1] = -drive.real, drive.imag
        return values, jacobian

    def test(self, kind, y, frame=None):
        """What vanishes where motions of a ``kind`` lie, smooth about y, and its slope (m + 2,) along the sheet.

        For kinds told by a singular matrix also that matrix's all but null vectors, left and right, and the ``frame``
        of the next test nearby.
        """
        if kind == TORUS:
            return self._torus_test(y)
        equations, columns = (self.equations, slice(None)) if kind == FOLD else (self.wider, self._columns)
        x = y[:-1] if kind == FOLD else equations.widened(self.equations, y[:-1])
        system = equations.system  # the force is no part of these matrices
        rows = breaking_rows(x.size, 0 if kind == BREAKING else 1) if kind != FOLD else slice(x.size - 1)
        block = residual(system, x)[1][rows][:, rows]
        size = len(block)
        matrix = np.zeros((size + 1, size + 1))
        matrix[:-1, :-1] = block
        if frame is None:
            left, _, right = np.linalg.svd(block)
            frame = left[:, -1], right[-1]
        matrix[:-1, -1], matrix[-1, :-1] = frame
        unit = np.zeros(size + 1)
        unit[-1] = 1
        right, left = np.linalg.solve(matrix, unit), np.linalg.solve(matrix.T, unit)
        value, right, left = right[-1], right[:-1], left[:-1]
        probe = np.zeros(x.size)
        probe[rows] = right * _PROBE * np.linalg.norm(x[:-1]) / np.linalg.norm(right)
        ahead, behind = (residual(system, x + p)[1][rows] for p in (probe, -probe))
        slope = -left @ (ahead - behind) * np.linalg.norm(right) / (2 * _PROBE * np.linalg.norm(x[:-1]))
        frame = left / np.linalg.norm(left), right / np.linalg.norm(right)
        return value, np.append(slope[columns], 0.0), frame

    def _torus_test(self, y):
        scale, jacobian = sizes(y, 2), self.at(y)[1]
        basis = np.linalg.svd(jacobian * scale)[2][-2:]
        value = lambda there: float(test_values(self.equations, there[None, :-1])[0, 1])  # noqa: E731
        slope = [(value(y + _PROBE * d * scale) - value(y - _PROBE * d * scale)) / (2 * _PROBE) for d in basis]
        return value(y), slope @ basis / scale, None

    def shown(self, points):
        """Frequency (Hz), force (N), and amplitude of z at the forcing frequency (m), of points (k, m + 2)."""
        one = self.equations
        amplitude = one.unit * np.hypot(points[:, self._row], points[:, self._row + 1])
        return points[:, -2] * one.hertz, points[:, -1] * one.force, amplitude

    def fitted(self, kind, y):
        """The point of a locus at the same force as y, one of a sheet with other harmonics; or None."""
        return self.corrected_at(kind, resized(y, self.equations.size + 2, 2), -1)

    @cached_property
    def _row(self):
        """Where the cosine of the line at the forcing frequency stands among the unknowns; its sine follows."""
        return 2 * int(np.searchsorted(self.equations.orders, self.equations.period)) - int(
            self.equations.orders[0] == 0
        )

    @cached_property
    def _columns(self):
        """Columns of the wider Jacobian that belong to the unknowns of this sheet, in their order."""
        where = self.wider.widened(self.equations, np.arange(1.0, self.equations.size + 2))
        return np.argsort(where)[-self.equations.size - 1 :]

    def corrected_at(self, kind, y, column):
        """The point of a locus near y with its Omega (column -2) or F (-1); None if there is none."""
        found = self.corrected(kind, y, _axis(y, column))
        return found and found[0]

    def corrected(self, kind, y, normal, frame=None, iterations=12):
        """The point of a locus near y in the plane through y across ``normal`` (m + 2,), all in relative lengths.

        Returns
        -------
        tuple of ((m + 2,) array, (m + 2,) array, frame, int), or None
            The point, the unit tangent of the locus there in the sizes at y, and the steps taken.
        """
        scale, new = sizes(y, 2), y
        for count in range(1, iterations + 1):
            values, jacobian = self.at(new)
            test, slope, frame = self.test(kind, new, frame)
            row = slope * scale
            weight = 1 / np.linalg.norm(row)
            matrix = np.vstack([jacobian * scale, weight * row, normal])
            off = np.append(values, [weight * test, normal @ ((new - y) / scale)])
            step, along = np.linalg.solve(matrix, np.column_stack([-off, np.append(np.zeros(y.size - 1), 1.0)])).T
            length = np.linalg.norm(step)
            new = new + step * scale * min(1.0, 0.3 / length)
            if not (np.isfinite(new).all() and (new[-2:] > 0).all()):
                return None
            if length < _CONVERGED:
                return new, along / np.linalg.norm(along), frame, count
        return None


@dataclass(frozen=True, eq=False)
class Locus:
    """A line on a `Sheet`.

    Attributes
    ----------
    kind : str
        FOLD, BREAKING, DOUBLING or TORUS.
    sheet : Sheet
    points, tangents : (k, m + 2) array
        In the order of the line; the last of a closed one is its first. Tangents have length 1 in the sizes there.
    closed : bool
    """

    kind: str
    sheet: Sheet
    points: np.ndarray
    tangents: np.ndarray
    closed: bool

    @property
    def frequency(self):
        """(k,) Hz."""
        return self.sheet.shown(self.points)[0]

    @property
    def force(self):
        """(k,) N."""
        return self.sheet.shown(self.points)[1]

    @property
    def amplitude(self):
        """(k,) of the line of z at the forcing frequency (m)."""
        return self.sheet.shown(self.points)[2]

    @cached_property
    def stationary(self):
        """List of (point, whether F is least there, whether it is a cusp) wherever F turns along it."""
        return [(y, bool(self.tangents[i, -1] < 0), abs(along[-2]) < _CUSP) for i, y, along in self._turns(-1, 1e-12)]

    @cached_property
    def _monotonic(self):
        """Its points, and those at which F or Omega turns along it: so no passage hides between two."""
        found = [(i, apart(y, self.points[i]), y) for column in (-1, -2) for i, y, _ in self._turns(column)]
        found.sort(key=lambda one: one[:2])
        turns = np.array([y for *_, y in found]).reshape(-1, self.points.shape[1])
        return np.insert(self.points, [i + 1 for i, *_ in found], turns, axis=0)

    def _turns(self, column, tolerance=1e-6):
        """(index of the point before, point, tangent) wherever Omega (column -2) or F (-1) turns along it.

        What turns is known to the square of the ``tolerance`` (relative length).
        """
        values = self.tangents[:, column]
        for i in np.flatnonzero(values[:-1] * values[1:] < 0):
            start, scale = self.points[i], sizes(self.points[i], 2)
            chord = (self.points[i + 1] - start) / scale
            length = np.linalg.norm(chord)
            chord /= length

            def there(step, start=start, scale=scale, chord=chord):
                found = self.sheet.corrected(self.kind, start + step * chord * scale, chord)
                if found is None:
                    raise _LostError
                return found

            def slope(step, there=there):
                return there(step)[1][column]

            try:
                if slope(0.0) * slope(length) < 0:
                    yield i, *there(brentq(slope, 0.0, length, xtol=tolerance, rtol=1e-12))[:2]
            except _LostError:  # where two loci all but touch: the nearer of the two points
                j = i + int(abs(values[i + 1]) < abs(values[i]))
                yield i, self.points[j], self.tangents[j]

    def passing(self, column, value, near=None):
        """Its points where Omega (column -2) or F (-1) has a value; only those ``near`` a point, if one is given."""
        points = self._monotonic
        off = points[:, column] - value
        found = []
        for i in np.flatnonzero(np.sign(off[:-1]) != np.sign(off[1:])):
            share = off[i] / (off[i] - off[i + 1])
            start = points[i] + share * (points[i + 1] - points[i])
            start[column] = value
            if near is not None and apart(start, near) > _NEAR:
                continue
            point = self.sheet.corrected_at(self.kind, start, column)
            if point is not None and not any(apart(point, known) < _SAME for known in found):
                found.append(point)
        return found

    def holds(self, y):
        """Whether the point y, or an image of it, lies on it."""
        images = self.sheet.equations.images(y)
        return any(apart(point, image) < _SAME for image in images for point in self.passing(-2, y[-2], image))


def stationary_near(sheet, y, iterations=15):
    """The point of a fold locus near y where F is stationary along it, by secants over Omega; None if there is none."""
    last = None
    for _ in range(iterations):
        found = sheet.corrected(FOLD, y, _axis(y, -2))
        if found is None or abs(found[1][-2]) < _CUSP:
            return None
        y, along = found[:2]
        slope = along[-1] / along[-2]
        if last is None:
            change = 1e-4 * y[-2]
        elif slope == last[1]:
            return None
        else:
            change = slope * (y[-2] - last[0]) / (last[1] - slope)
        if abs(change) < 1e-9 * y[-2]:
            return y
        if abs(change) > 0.1 * y[-2]:
            return None
        last = y[-2], slope
        y = y + along / along[-2] * sizes(y, 2) * change / y[-2]
    return None


def hessian(sheet, y):
    """Second derivatives (2, 2) of ln F over two directions on the sheet where F is stationary; the directions."""
    scale = sizes(y, 2)
    jacobian = sheet.at(y)[1] * scale
    left, _, right = np.linalg.svd(jacobian[:, :-2])
    kernel = np.append(right[-1], [0.0, 0.0])
    aside = np.append(-np.linalg.lstsq(jacobian[:, :-2], jacobian[:, -2], rcond=1e-9)[0], [1.0, 0.0])
    frame = np.array([kernel, aside / np.linalg.norm(aside)])
    bend = [sheet.at(y + _PROBE * d * scale)[1] - sheet.at(y - _PROBE * d * scale)[1] for d in frame]
    rows = [left[:, -1] @ (b * scale) / (2 * _PROBE) for b in bend]
    return -np.array([[row @ d for d in frame] for row in rows]) / (left[:, -1] @ jacobian[:, -1]), frame


def locus(sheet, kind, y, inside):
    """The `Locus` through a point y of it, followed both ways while ``inside(y)`` and until it closes, or is lost."""
    scale = sizes(y, 2)
    _, slope, frame = sheet.test(kind, y)
    row = slope * scale
    along = np.linalg.svd(np.vstack([sheet.at(y)[1] * scale, row / np.linalg.norm(row)]))[2][-1]
    points, tangents, closed = _followed(sheet, kind, y, along, frame, inside)
    if not closed:
        back, others, _ = _followed(sheet, kind, y, -along, frame, inside)
        points, tangents = back[:0:-1] + points, [-t for t in others[:0:-1]] + tangents
    return Locus(kind, sheet, np.array(points), np.array(tangents), closed)


def _followed(sheet, kind, y, along, frame, inside):
    """Points from y on, tangents, and whether they come back to it."""
    points, tangents, step = [y], [along], _FIRST
    while inside(points[-1]) and len(points) < _ROOM:
        here, along = points[-1], tangents[-1]
        scale = sizes(here, 2)
        start = here + step * along * scale
        found = sheet.corrected(kind, start, along, frame, 6) if (start[-2:] > 0).all() else None
        good = found is not None
        if good:
            new, towards, next_frame, count = found
            towards = towards * sizes(start, 2) / scale
            towards /= np.linalg.norm(towards)
            turn = math.acos(max(-1.0, min(1.0, float(towards @ along))))
            good = turn < _TURN and np.linalg.norm((new - here) / scale - step * along) < 0.5 * step
        if not good:
            step *= 0.5
            if step < _SHORTEST:
                break
            continue
        before, after = (float(tangents[0] @ ((p - y) / sizes(y, 2))) for p in (here, new))
        if len(points) > 2 and apart(here, y) < 2 * step and before < 0 <= after and apart(new, y) < 2 * step:
            return [*points, y], [*tangents, tangents[0]], True
        towards *= scale / sizes(new, 2)
        points.append(new)
        tangents.append(towards / np.linalg.norm(towards))
        frame = next_frame
        step = min(_LONGEST, step * min(2.0, max(0.5, _AIM / max(turn, 1e-3))) if count < 5 else step)
    return points, tangents, False
