"""Floquet multipliers of periodic orbits from their harmonic coefficients, by Hill's determinant; no time stepping.

About an orbit w the slope phi'(w) = sum_m q_m exp(i m theta) is known by its lines. A disturbance
exp(lambda tau) sum_k v_k exp(i k kappa tau), the shaker eliminated as in `rigsim.orbits.harmonic_balance`, obeys

    d(sigma_k) v_k + D(sigma_k) sum_{m != 0} q_m v_{k-m} = 0,    sigma_k = lambda + i k kappa,
    D(sigma) = (1 + mu) sigma^2 + 2 zeta_s sigma + 1,    d(sigma) = (sigma^2 + 2 zeta sigma + q_0) D - mu sigma^4,

with kappa the orbit's frequency, or twice that where the orbit mirrors itself after half a period, since the slope
then repeats. Divided by d(sigma_k) = prod_j (sigma_k - alpha_j), row by row, the infinite determinant Delta(lambda)
converges, repeats with i kappa, and has the Floquet exponents for zeros and the alpha_j for poles, nothing else. Hence,
with rho = exp(2 pi lambda/kappa), and since the exponents and the alpha_j have one sum,

    P(rho) = Delta(lambda) prod_j (rho - exp(2 pi alpha_j/kappa)) = prod_j (rho - rho_j)

is the characteristic polynomial of the multipliers itself, of degree four: there are no spurious copies to reject.
Its coefficients follow from Delta at four points of the unit circle, two of them conjugate to the others.

Rows beyond those kept enter the logarithm of Delta by -1/2 tr K^2, K the off-diagonal part, which is summed in closed
form; what is neglected is of third order in abs(q_m)/(N kappa)^2. N follows from that, so it grows at low frequencies.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from ..compiled import compiled
from .continuation import advance, distance
from .harmonic_balance import force_lines

_SMALL = 4e-4  # largest abs(q_m)/(N kappa)^2 beyond the rows kept
_FAR = 12  # the second-order sum is taken to this many times N, and its rest as an integral


@dataclass(frozen=True, repr=False)
class SpecialPoint:
    """Where a curve of periodic orbits turns or its stability changes.

    Attributes
    ----------
    kind : str
        "fold", "symmetry breaking", "period doubling" or "Neimark-Sacker".
    frequency : float
        Forcing frequency (Hz).
    index : int
        The orbit of the curve that lies there (fold), or the last one before it.
    shaker, mass, relative : complex
        Lines of xs, x and z at the forcing frequency (m).
    multipliers : tuple of complex
        The four Floquet multipliers there.
    """

    kind: str
    frequency: float
    index: int
    shaker: complex
    mass: complex
    relative: complex
    multipliers: tuple

    def __repr__(self):
        return f"SpecialPoint({self.kind}, {self.frequency:.4f} Hz, |z| = {1e3 * abs(self.relative):.4g} mm)"


@compiled
def _determinant(matrix):
    """Determinant by elimination with row exchanges, in place."""
    n = matrix.shape[0]
    result = 1.0 + 0.0j
    for i in range(n):
        pivot, largest = i, 0.0
        for j in range(i, n):
            size = abs(matrix[j, i].real) + abs(matrix[j, i].imag)
            if size > largest:
                pivot, largest = j, size
        if largest == 0.0:
            return 0.0j
        if pivot != i:
            for k in range(i, n):
                matrix[i, k], matrix[pivot, k] = matrix[pivot, k], matrix[i, k]
            result = -result
        result *= matrix[i, i]
        inverse = 1.0 / matrix[i, i]
        for j in range(i + 1, n):
            factor = matrix[j, i] * inverse
            if factor != 0.0:
                for k in range(i + 1, n):
                    matrix[j, k] -= factor * matrix[i, k]
    return result


@compiled
def _unforced_exponents(mu, zeta_s, zeta, q0):
    """The alpha_j: roots of d(sigma), polished by Newton's method."""
    coefficients = np.array(
        [
            1.0,
            2.0 * zeta_s + 2.0 * zeta * (1.0 + mu),
            1.0 + 4.0 * zeta * zeta_s + q0 * (1.0 + mu),
            2.0 * zeta + 2.0 * zeta_s * q0,
            q0,
        ]
    )
    companion = np.zeros((4, 4), dtype=np.complex128)
    for i in range(4):
        companion[0, i] = -coefficients[i + 1]
    for i in range(3):
        companion[i + 1, i] = 1.0
    roots = np.linalg.eigvals(companion)
    for i in range(4):
        for _ in range(2):
            value, slope = coefficients[0] + 0.0j, 0.0j
            for k in range(1, 5):
                slope = slope * roots[i] + value
                value = value * roots[i] + coefficients[k]
            if abs(slope) > 1e-8:
                roots[i] -= value / slope
    return roots


@compiled
def _hill_value(exponent, kappa, alphas, q, rows, mu, zeta_s):
    """P(exp(2 pi exponent/kappa)) of the module's text; q holds q_0, q_1, ..., and -rows..rows are kept."""
    n, lines, turn = 2 * rows + 1, q.size - 1, 2.0 * math.pi / kappa
    value = 1.0 + 0.0j
    nearest = np.empty(4, dtype=np.int64)
    for j in range(4):
        k = -int(round((exponent - alphas[j]).imag / kappa))
        nearest[j] = min(max(k, -rows), rows)
        apart = exponent - alphas[j] + 1j * kappa * nearest[j]
        # (rho - exp(turn alpha))/apart, which is regular
        angle = turn * apart
        if abs(angle) < 1e-3:
            share = turn * (1.0 + angle / 2.0 * (1.0 + angle / 3.0 * (1.0 + angle / 4.0)))
        else:
            share = (np.exp(angle) - 1.0) / apart
        value *= np.exp(turn * alphas[j]) * share
    matrix = np.zeros((n, n), dtype=np.complex128)
    for a in range(n):
        sigma = exponent + 1j * kappa * (a - rows)
        D = (1.0 + mu) * sigma * sigma + 2.0 * zeta_s * sigma + 1.0
        diagonal = 1.0 + 0.0j
        for j in range(4):
            if nearest[j] == a - rows:
                diagonal *= sigma - alphas[j]
            else:
                D /= sigma - alphas[j]
        matrix[a, a] = diagonal
        for m in range(1, lines + 1):
            if a - m >= 0:
                matrix[a, a - m] = D * q[m]
            if a + m < n:
                matrix[a, a + m] = D * q[m].conjugate()
    value *= _determinant(matrix)
    far = _FAR * rows
    ratio = np.empty(2 * far + 1, dtype=np.complex128)
    for a in range(2 * far + 1):
        sigma = exponent + 1j * kappa * (a - far)
        D = (1.0 + mu) * sigma * sigma + 2.0 * zeta_s * sigma + 1.0
        for j in range(4):
            D /= sigma - alphas[j]
        ratio[a] = D
    tail = 0.0j
    for m in range(1, lines + 1):
        strength = q[m].real ** 2 + q[m].imag ** 2
        pairs = 0.0j
        for k in range(rows + 1, far + 1):
            pairs += ratio[far + k] * ratio[far + k - m] + ratio[far - k] * ratio[far - k + m]
        rest = 2.0 * (1.0 + mu) ** 2 / (3.0 * kappa**4 * (far + 0.5 - 0.5 * m) ** 3)
        tail += strength * (pairs + rest)
    return value * np.exp(-tail)


@compiled
def _hill_polynomials(numbers, law, period, orders, cosine, sine, points):
    """Coefficients c_0 ... c_3 of P (k, 4), leading one 1, over half an orbit's period if ``orders`` are odd."""
    mu, zeta_s, zeta = numbers[0], numbers[1], numbers[2]
    h = cosine.shape[1] // 2
    stride = 1 if orders[0] == 0 else 2
    A, B = np.empty(2 * h + 1), np.empty(2 * h + 1)
    force_a, force_b = np.empty(h + 1), np.empty(h + 1)
    result = np.empty((len(points), 4))
    for i in range(len(points)):
        x = points[i]
        force_lines(law, orders, cosine, sine, x, A, B, force_a, force_b)
        kappa = stride * x[x.size - 1] / period
        largest, lines = 0.0, 0
        for k in range(stride, 2 * h + 1, stride):
            largest = max(largest, math.hypot(A[k], B[k]) / 2.0)
        for k in range(stride, 2 * h + 1, stride):
            if math.hypot(A[k], B[k]) / 2.0 > 1e-13 * largest:
                lines = k // stride
        q = np.empty(lines + 1, dtype=np.complex128)
        q[0] = 0.5 * A[0]
        for m in range(1, lines + 1):
            q[m] = 0.5 * complex(A[stride * m], -B[stride * m])
        rows = max(6, int(math.ceil(math.sqrt((1.0 + mu) * largest / _SMALL) / kappa)), lines // 2 + 2)
        alphas = _unforced_exponents(mu, zeta_s, zeta, 0.5 * A[0])
        first = _hill_value(0.125j * kappa, kappa, alphas, q, rows, mu, zeta_s)
        second = _hill_value(0.375j * kappa, kappa, alphas, q, rows, mu, zeta_s)
        # At rho^4 = -1, P + 1 is a cubic; conjugate points have conjugate values.
        for c in range(4):
            one = (first + 1.0) * np.exp(-0.25j * math.pi * c)
            other = (second + 1.0) * np.exp(-0.75j * math.pi * c)
            result[i, c] = 0.5 * (one.real + other.real)
    return result


def characteristic_polynomials(equations, points):
    """Coefficients c_0, c_1, c_2, c_3 (k, 4) of the characteristic polynomials, leading coefficient 1.

    Over the orbit's period; if only odd lines are kept, over half of it, when a root at -1 belongs to a
    fold and one at +1 to a loss of symmetry.

    Parameters
    ----------
    equations : Balance
    points : (k, n) array
        Its unknowns at the orbits.
    """
    return _hill_polynomials(*equations.system, np.ascontiguousarray(points))


def _roots(polynomials):
    companions = np.zeros((len(polynomials), 4, 4))
    companions[:, 0] = -polynomials[:, ::-1]
    companions[:, [1, 2, 3], [0, 1, 2]] = 1
    return np.linalg.eigvals(companions).astype(complex)


def hill_multipliers(equations, points):
    """Floquet multipliers (k, 4) over the orbit's period, descending in modulus; arguments as above."""
    roots = _roots(characteristic_polynomials(equations, points))
    if equations.orders[0] != 0:
        roots = roots**2
    return np.take_along_axis(roots, np.argsort(-abs(roots), axis=1, kind="stable"), axis=1)


_PAIRS = np.triu_indices(4, 1)
IMAGINARY = 1e-4  # of a multiplier on the unit circle that belongs to a pair, not to two real ones


def test_values(equations, points):
    """(k, 2): functions of the polynomial that vanish where a real multiplier, or the product of two, passes 1.

    The first belongs to symmetry breaking (half the period), or to period doubling.
    """
    polynomials = characteristic_polynomials(equations, points)
    side = 1 if equations.orders[0] != 0 else -1
    real = 1 + polynomials @ np.array([1, side, 1, side])
    roots = _roots(polynomials)
    pairs = (1 - roots[:, _PAIRS[0]] * roots[:, _PAIRS[1]]).prod(axis=1).real
    return np.column_stack([real, pairs])


def stability_changes(equations, points, folds):
    """Every `SpecialPoint` along a traced curve.

    A sign change of a test function between two orbits is followed in between by arc-length steps and Brent's method,
    to 1e-9 of the relative length, so far below 1e-3 Hz. Where the product of two multipliers passes 1 they may be
    real, which changes nothing; only a complex pair on the unit circle is a Neimark-Sacker point.

    Parameters
    ----------
    equations : Balance
    points : (k, n) array
        Its unknowns along the curve.
    folds : tuple of int
        Orbits known to be folds.

    Returns
    -------
    tuple of SpecialPoint
        In the order of the curve.
    """
    names = ("symmetry breaking" if equations.orders[0] != 0 else "period doubling"), "Neimark-Sacker"
    values = test_values(equations, points)
    found = [_special_point(equations, "fold", points[i : i + 1], i) for i in folds]
    for i, test in zip(*np.nonzero(values[:-1] * values[1:] < 0), strict=True):
        length = distance(points[i + 1], points[i])
        chord = (points[i + 1] - points[i]) / length
        ends = {0.0: values[i, test], length: values[i + 1, test]}

        def value(step, start=points[i], chord=chord, test=test, ends=ends):
            return ends[step] if step in ends else test_values(equations, _step(equations, start, chord, step))[0, test]

        place = _step(equations, points[i], chord, brentq(value, 0.0, length, xtol=1e-9))
        point = _special_point(equations, names[test], place, int(i))
        on_circle = [m for m in point.multipliers if abs(abs(m) - 1) < 1e-3]
        if test == 0 or any(abs(m.imag) > IMAGINARY for m in on_circle):
            found.append(point)
    return tuple(sorted(found, key=lambda point: (point.index, point.kind != "fold")))


def _step(equations, start, chord, step):
    sign, _, point, _ = advance(*equations.system, start, chord, step)
    if sign == 0:
        raise RuntimeError(f"no orbit was found between two of a traced curve, near Omega = {start[-1]}")
    return point[None]


def _special_point(equations, kind, point, index):
    frequency, *lines = equations.lines(point)
    motion = (complex(line[0, equations.period]) for line in lines)
    return SpecialPoint(
        kind, float(frequency[0]), int(index), *motion, tuple(hill_multipliers(equations, point)[0].tolist())
    )
