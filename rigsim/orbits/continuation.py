"""Arc-length continuation of the balance equations, compiled; every step is checked before it is believed.

Lengths are measured relative to where the curve is: steps of the coefficients over their norm, and of Omega over
Omega, so that neither units nor decades matter. A step along the tangent is corrected by Newton's method in the plane
across it; it is halved where that does not converge, moves the point far, turns the tangent by more than `_TURN`, or
changes the orientation, and otherwise the next one is chosen for a turn of `_AIM`. So the curve is never cut short, at
a fold or anywhere, until steps are lost in rounding, which is then said.

The orientation is the sign of the determinant of the Jacobian bordered by the tangent. It is the same all along a
curve, and another on the far side of a narrow gap to a neighbouring curve, which no other check sees; so steps
across such gaps are refused. Only where two curves cross (as asymmetric orbits do the symmetric ones) does it change
at steps of any size; a change that remains at `_CROSSING` is taken for that.
"""

import math

import numpy as np

from ..compiled import compiled
from .harmonic_balance import residual_and_jacobian

# Why a curve ended.
LOW, HIGH, CLOSED, STUCK, FULL, MIRROR = 0, 1, 2, 3, 4, 5

_TURN, _AIM = 0.35, 0.12  # rad, in relative lengths
_SHORTEST, _CROSSING = 1e-9, 1e-5
_CONVERGED = 1e-8  # of the last Newton step, whose own error is its square


@compiled
def _solve(matrix, right):
    """Solution of matrix x = right (n, r) in place, by elimination with row exchanges; the determinant's sign."""
    n, columns = right.shape
    sign = 1.0
    for i in range(n):
        pivot, largest = i, abs(matrix[i, i])
        for j in range(i + 1, n):
            if abs(matrix[j, i]) > largest:
                pivot, largest = j, abs(matrix[j, i])
        if not largest > 0.0 or not math.isfinite(largest):
            return 0.0
        if pivot != i:
            sign = -sign
            for k in range(i, n):
                matrix[i, k], matrix[pivot, k] = matrix[pivot, k], matrix[i, k]
            for k in range(columns):
                right[i, k], right[pivot, k] = right[pivot, k], right[i, k]
        if matrix[i, i] < 0.0:
            sign = -sign
        for j in range(i + 1, n):
            factor = matrix[j, i] / matrix[i, i]
            if factor != 0.0:
                for k in range(i + 1, n):
                    matrix[j, k] -= factor * matrix[i, k]
                for k in range(columns):
                    right[j, k] -= factor * right[i, k]
    for i in range(n - 1, -1, -1):
        for k in range(columns):
            total = right[i, k]
            for j in range(i + 1, n):
                total -= matrix[i, j] * right[j, k]
            right[i, k] = total / matrix[i, i]
    return sign


@compiled
def _sizes(x):
    """Norm of the coefficients, and Omega: the units of relative length at x."""
    n = x.size - 1
    total = 0.0
    for i in range(n):
        total += x[i] * x[i]
    return max(math.sqrt(total), 1e-300), x[n]


def sizes(x, others=1):
    """(n,) the same for every unknown, of which the last ``others`` are no coefficients."""
    return np.append(np.full(x.size - others, np.linalg.norm(x[:-others])), x[-others:])


@compiled
def _dot(a, b, sizes):
    n = a.size - 1
    total = 0.0
    for i in range(n):
        total += a[i] * b[i]
    return total / sizes[0] ** 2 + a[n] * b[n] / sizes[1] ** 2


@compiled
def _plane(tangent, sizes, x):
    """normal and level of the plane normal . x = level through x across the tangent."""
    n = x.size
    normal, level = tangent / sizes[0] ** 2, 0.0
    normal[n - 1] = tangent[n - 1] / sizes[1] ** 2
    for i in range(n):
        level += normal[i] * x[i]
    return normal, level


@compiled
def correct(numbers, law, period, orders, cosine, sine, x, normal, level, iterations, reach):
    """Newton's method for the orbit on the plane normal . x = level, from x and in place.

    A step longer than ``reach`` (relative) is shortened to it.

    Returns
    -------
    tuple of (float, int, (n,) array)
        The orientation, +1 or -1, or 0 if it did not converge; the steps taken; the tangent with normal . tangent = 1.
    """
    n = x.size
    work, residual = np.empty((4, cosine.shape[1])), np.empty(n - 1)
    matrix, right = np.empty((n, n)), np.empty((n, 2))
    step = np.empty(n)
    for iteration in range(1, iterations + 1):
        residual_and_jacobian(numbers, law, period, orders, cosine, sine, x, work, residual, matrix[: n - 1])
        right[n - 1, 0], right[n - 1, 1] = level, 1.0
        for i in range(n):
            matrix[n - 1, i] = normal[i]
            right[n - 1, 0] -= normal[i] * x[i]
        for i in range(n - 1):
            right[i, 0], right[i, 1] = -residual[i], 0.0
        sign = _solve(matrix, right)
        if sign == 0.0:
            return 0.0, iteration, step
        for i in range(n):
            step[i] = right[i, 0]
        length = math.sqrt(_dot(step, step, _sizes(x)))
        if not math.isfinite(length):
            return 0.0, iteration, step
        factor = 1.0 if length <= reach else reach / length
        for i in range(n):
            x[i] += factor * step[i]
        if x[n - 1] <= 0.0:
            return 0.0, iteration, step
        if length < _CONVERGED:
            return sign, iteration, right[:, 1].copy()
    return 0.0, iterations, step


@compiled
def correct_at(numbers, law, period, orders, cosine, sine, x, Omega, iterations, reach):
    """`correct` at a given Omega."""
    normal = np.zeros(x.size)
    normal[x.size - 1] = 1.0
    x[x.size - 1] = Omega
    return correct(numbers, law, period, orders, cosine, sine, x, normal, Omega, iterations, reach)


@compiled
def advance(numbers, law, period, orders, cosine, sine, x, tangent, step):
    """The orbit ``step`` (relative length) along the tangent from x, corrected across it.

    Returns
    -------
    tuple of (float, int, (n,) array, (n,) array)
        Orientation, 0 if it did not converge; Newton steps taken; the orbit; its tangent, of length 1 in units at x.
    """
    sizes = _sizes(x)
    predicted = x + step * tangent
    normal, level = _plane(tangent, sizes, predicted)
    if predicted[x.size - 1] <= 0.0:
        return 0.0, 0, predicted, tangent
    sign, count, along = correct(numbers, law, period, orders, cosine, sine, predicted, normal, level, 8, np.inf)
    if sign != 0.0:
        along /= math.sqrt(_dot(along, along, sizes))
    return sign, count, predicted, along


@compiled
def unit_tangent(x, tangent):
    """The tangent at x in the units there."""
    return tangent / math.sqrt(_dot(tangent, tangent, _sizes(x)))


@compiled
def distance(x, other):
    """Relative length between two orbits, in the units at the second."""
    apart = x - other
    return math.sqrt(_dot(apart, apart, _sizes(other)))


@compiled
def breaking_rows(size, parity):
    """Unknowns, all lines kept, that belong to the even lines and the mean (parity 0) or to the odd ones (1)."""
    rows = [0 for _ in range(1 - parity)]
    for k in range(2 - parity, (size - 2) // 2 + 1, 2):
        rows.append(2 * k - 1)
        rows.append(2 * k)
    return np.array(rows)


@compiled
def _product(x, other, rows):
    total = 0.0
    for i in rows:
        total += x[i] * other[i]
    return total


@compiled
def trace(numbers, law, period, orders, cosine, sine, x, tangent, low, high, longest, room, parity):
    """The curve from x along ``tangent`` until it leaves (low, high) in Omega, closes, fills the room or is stuck.

    With a parity of 0 or 1, not -1, also until its even or its odd lines (all being kept) pass through zero, where it
    goes over to its own image half an orbit's period later.

    Returns
    -------
    tuple of ((k, n) array, (k, n) array, list of int, int)
        Orbits from x on, their tangents, indices of the orbits before which another curve was and why it
        ended; an end of the band is an orbit at exactly that Omega.
    """
    n = x.size
    points, tangents = np.empty((room, n)), np.empty((room, n))
    points[0], tangents[0] = x, unit_tangent(x, tangent)
    start_sizes = _sizes(x)
    count, step = 1, 0.1 * longest
    orientation, _, _, _ = advance(numbers, law, period, orders, cosine, sine, x, tangents[0], 0.0)
    while count < room:
        here, along = points[count - 1], tangents[count - 1]
        sign, newton, new, turned = advance(numbers, law, period, orders, cosine, sine, here, along, step)
        good, turn = sign != 0.0, 0.0
        if good:
            sizes = _sizes(here)
            turn = math.acos(min(1.0, max(-1.0, _dot(along, turned, sizes))))
            moved = new - here
            moved -= step * along
            good = turn < _TURN and math.sqrt(_dot(moved, moved, sizes)) < 0.3 * step
            if good and parity >= 0 and count > 1:
                rows = breaking_rows(n, parity)
                if _product(new, here, rows) < 0.0 or _product(new, new, rows) < 1e-12 * sizes[0] ** 2:
                    return points[:count].copy(), tangents[:count].copy(), MIRROR
            good = good and (sign == orientation or step <= _CROSSING)
        if not good:
            step *= 0.5
            if step < _SHORTEST:
                return points[:count].copy(), tangents[:count].copy(), STUCK
            continue
        if sign != orientation:
            orientation = sign
        edge = low if new[n - 1] <= low else high if new[n - 1] >= high else 0.0
        if edge > 0.0:
            share = (edge - here[n - 1]) / (new[n - 1] - here[n - 1])
            last = here + share * (new - here)
            sign, _, turned = correct_at(numbers, law, period, orders, cosine, sine, last, edge, 10, np.inf)
            if sign == 0.0 or distance(last, here) > 1.5 * step:
                step *= 0.5
                if step < _SHORTEST:
                    return points[:count].copy(), tangents[:count].copy(), STUCK
                continue
            points[count] = last
            tangents[count] = unit_tangent(last, turned)
            if _dot(tangents[count], along, _sizes(here)) < 0.0:
                tangents[count] *= -1.0
            return points[: count + 1].copy(), tangents[: count + 1].copy(), LOW if edge == low else HIGH
        if count > 2:
            before, after = here - points[0], new - points[0]
            near = math.sqrt(max(_dot(before, before, start_sizes), _dot(after, after, start_sizes))) < 2.0 * step
            first = tangents[0]
            if near and _dot(before, first, start_sizes) < 0.0 <= _dot(after, first, start_sizes):
                # Back at the start? Decided by the orbit in the plane across the start.
                normal, level = _plane(first, start_sizes, points[0])
                back = new.copy()
                sign, _, _ = correct(numbers, law, period, orders, cosine, sine, back, normal, level, 10, np.inf)
                if sign != 0.0 and distance(back, points[0]) < 1e-6:
                    points[count], tangents[count] = points[0], tangents[0]
                    return points[: count + 1].copy(), tangents[: count + 1].copy(), CLOSED
        points[count] = new
        tangents[count] = unit_tangent(new, turned)
        count += 1
        wanted = _AIM / max(turn, 1e-3)
        if newton > 4:
            wanted = min(wanted, 1.0)
        step = min(longest, step * min(2.0, max(0.5, wanted)))
    return points, tangents, FULL


def both_ways(system, x, tangent, low, high, longest, room):
    """The whole curve through x: its orbits, tangents, and why it ends at its two ends; see `trace`."""
    points, tangents, code = trace(*system, x, tangent, low, high, longest, room, -1)
    if code == CLOSED:
        return points, tangents, (code, code)
    back, others, other = trace(*system, x, -tangent, low, high, longest, room, -1)
    return np.concatenate([back[:0:-1], points]), np.concatenate([-others[:0:-1], tangents]), (other, code)


@compiled
def locate_fold(numbers, law, period, orders, cosine, sine, x, tangent, length):
    """The orbit between x and ``length`` along its tangent at which Omega turns: where the tangent has no Omega part.

    False position, halved where one end is kept (Illinois). Omega is stationary there, so it is known to the square
    of the length's own error.
    """
    n = x.size
    left, right = 0.0, length
    at_left = tangent[n - 1]
    _, _, best, along = advance(numbers, law, period, orders, cosine, sine, x, tangent, length)
    at_right = along[n - 1]
    kept = 0
    for _ in range(60):
        middle = right - at_right * (right - left) / (at_right - at_left)
        if not min(left, right) < middle < max(left, right):
            middle = 0.5 * (left + right)
        sign, _, new, turned = advance(numbers, law, period, orders, cosine, sine, x, tangent, middle)
        if sign == 0.0:
            return False, best, along
        best, along = new, turned
        if abs(turned[n - 1]) < 1e-11 * x[n - 1] or abs(right - left) < 1e-13:
            break
        if (turned[n - 1] > 0.0) == (at_right > 0.0):
            right, at_right = middle, turned[n - 1]
            at_left *= 0.5 if kept == 1 else 1.0
            kept = 1
        else:
            left, at_left = middle, turned[n - 1]
            at_right *= 0.5 if kept == -1 else 1.0
            kept = -1
    return True, best, unit_tangent(best, along)


@compiled
def between(x, tangent, other, other_tangent, share):
    """The cubic curve through two neighbouring orbits along their tangents, at a share of the way."""
    length = distance(other, x)
    s, r = share, 1.0 - share
    return (
        (1.0 + 2.0 * s) * r * r * x
        + s * r * r * length * tangent
        + s * s * (3.0 - 2.0 * s) * other
        - s * s * r * length * other_tangent
    )


@compiled
def place_on(numbers, law, period, orders, cosine, sine, points, tangents, x):
    """The index of the point of a traced curve after which the orbit x lies on it, to 1e-6; -1 if it does not."""
    for i in range(len(points) - 1):
        sizes, length = _sizes(points[i]), distance(points[i + 1], points[i])
        if not 0.0 < length or distance(x, points[i]) > 2.0 * length:
            continue
        chord = (points[i + 1] - points[i]) / math.sqrt(
            _dot(points[i + 1] - points[i], points[i + 1] - points[i], sizes)
        )
        share = _dot(x - points[i], chord, sizes) / _dot(points[i + 1] - points[i], chord, sizes)
        if not -1e-6 < share < 1.0 + 1e-6:
            continue
        guess = between(points[i], tangents[i], points[i + 1], tangents[i + 1], share)
        normal, level = _plane(chord, sizes, x)
        sign, _, _ = correct(numbers, law, period, orders, cosine, sine, guess, normal, level, 10, 0.3)
        if sign != 0.0 and distance(guess, x) < 1e-6:
            return i
    return -1


@compiled
def _breaking_block(numbers, law, period, orders, cosine, sine, x, rows):
    jacobian = np.empty((x.size - 1, x.size))
    residual_and_jacobian(
        numbers, law, period, orders, cosine, sine, x, np.empty((4, cosine.shape[1])), np.empty(x.size - 1), jacobian
    )
    block = np.empty((rows.size, rows.size))
    for i in range(rows.size):
        for j in range(rows.size):
            block[i, j] = jacobian[rows[i], rows[j]]
    return block


@compiled
def breaking_sign(numbers, law, period, orders, cosine, sine, x, parity):
    """Sign of the Jacobian's determinant over the even lines and the mean, or over the odd lines, where x has none.

    Where it changes along a curve of such orbits, a curve of orbits that do have these lines branches off: parity 0
    where symmetry breaks, parity 1 (over two forcing periods) where the period doubles.
    """
    rows = breaking_rows(x.size, parity)
    block = _breaking_block(numbers, law, period, orders, cosine, sine, x, rows)
    return _solve(block, np.empty((rows.size, 0)))


@compiled
def breaking_signs(numbers, law, period, orders, cosine, sine, points, parity):
    """`breaking_sign` at each of the points (k, n)."""
    signs = np.empty(len(points))
    for i in range(len(points)):
        signs[i] = breaking_sign(numbers, law, period, orders, cosine, sine, points[i], parity)
    return signs


@compiled
def breaking_direction(numbers, law, period, orders, cosine, sine, x, parity):
    """Unit direction (relative length) in which orbits branch off at x, as for `breaking_sign`.

    By inverse iteration: that block of the Jacobian is all but singular there.
    """
    rows = breaking_rows(x.size, parity)
    block = _breaking_block(numbers, law, period, orders, cosine, sine, x, rows)
    vector = np.ones((rows.size, 1))
    for _ in range(6):
        _solve(block.copy(), vector)
        vector /= math.sqrt((vector**2).sum())
    direction = np.zeros(x.size)
    for i in range(rows.size):
        direction[rows[i]] = vector[i, 0]
    return unit_tangent(x, direction)
