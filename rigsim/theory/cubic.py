"""The Duffing cubic behind Eq. (5a): dynamic stiffness, roots, complex amplitudes; all non-dimensional.

With X = Omega^2, D = 1 - (1 + mu) X + 2i zeta_s Omega and U = (3/4) gamma W^2, eliminating the shaker
from single-term harmonic balance of Eqs. (4a, b) leaves an oscillator of dynamic stiffness
r + i s = Omega0^2 - X + 2i zeta Omega - mu X^2/D, and Eq. (5a) reads

    U [(U + r)^2 + s^2] = rho,    rho = (3/4) gamma X^2/e,    e = abs(D)^2.

Where r < -sqrt(3) s the left side rises to rho_+ at U_+, falls to rho_- at U_- and rises again; between the
two levels there are three solutions, one on each of the three monotonic stretches.
"""

import math

import numpy as np

from ..compiled import compiled, inlinable

_SQRT3 = math.sqrt(3.0)


@inlinable
def dynamic_stiffness(mu, zeta_s, zeta, Omega0, X):
    """r, s and e of the module's text at X = Omega^2 (e above zero)."""
    Omega = math.sqrt(X)
    real = 1.0 - (1.0 + mu) * X
    e = real * real + 4.0 * zeta_s * zeta_s * X
    r = Omega0 * Omega0 - X - mu * X * X * real / e
    s = 2.0 * Omega * (zeta + mu * zeta_s * X * X / e)
    return r, s, e


@inlinable
def fold_levels(r, s):
    """(rho_-, rho_+, U_-, U_+), the two extremes of the cubic's left side; for r <= -sqrt(3) s.

    The lower level comes from the product of the two, (4/27) s^2 (r^2 + s^2)^2, since their difference cancels.
    """
    squared = max((-r - _SQRT3 * s) * (-r + _SQRT3 * s), 0.0)
    root = math.sqrt(squared)
    modulus = r * r + s * s
    twelfth = -r * (r * r + 9.0 * s * s) + squared * root
    upper = 2.0 / 27.0 * twelfth
    lower = 2.0 * s * s * modulus * modulus / twelfth
    return lower, upper, (-2.0 * r + root) / 3.0, modulus / (-2.0 * r + root)


@inlinable
def _polish(U, low, high, rising, r, s, rho):
    """Newton's method from U on a stretch [low, high] where the cubic is monotonic, bisecting when it would leave."""
    U = min(max(U, low), high)
    for _ in range(60):
        shifted = U + r
        stiffness = shifted * shifted + s * s
        residual = U * stiffness - rho
        if residual == 0.0:
            return U
        if (residual > 0.0) == rising:
            high = U
        else:
            low = U
        slope = stiffness + 2.0 * U * shifted
        new = U - residual / slope if slope != 0.0 else 0.5 * (low + high)
        if not low <= new <= high:
            new = 0.5 * (low + high)
        if abs(new - U) <= 4e-16 * abs(new):
            return new
        U = new
    return U


@inlinable
def cubic_roots(r, s, rho):
    """(count, U of the low, middle and high solution), ascending, NaN padded.

    Closed form first (three cosines, or Cardano), then Newton's method inside the monotonic stretch of each root,
    in units of the largest of abs(r), s and rho^(1/3).
    """
    if rho == 0.0:
        return 1, 0.0, np.nan, np.nan
    unit = max(abs(r), s, rho ** (1.0 / 3.0))
    r, s, rho = r / unit, s / unit, rho / unit**3
    ceiling = max(2.0 * abs(r), (4.0 * rho) ** (1.0 / 3.0)) * (1.0 + 1e-15)
    low, high, rising_from = 0.0, ceiling, True
    if r < -_SQRT3 * s:
        rho_minus, rho_plus, U_minus, U_plus = fold_levels(r, s)
        if rho_minus < rho < rho_plus:
            angle = 2.0 / 3.0 * math.atan2(math.sqrt(rho_plus - rho), math.sqrt(rho - rho_minus))
            swing = 3.0 * U_minus + 2.0 * r  # sqrt(r^2 - 3 s^2)
            third = 2.0 * math.pi / 3.0
            first = _polish((2.0 * swing * math.cos(angle + third) - 2.0 * r) / 3.0, 0.0, U_plus, True, r, s, rho)
            second = _polish((2.0 * swing * math.cos(angle - third) - 2.0 * r) / 3.0, U_plus, U_minus, False, r, s, rho)
            third_root = _polish((2.0 * swing * math.cos(angle) - 2.0 * r) / 3.0, U_minus, ceiling, True, r, s, rho)
            return 3, first * unit, second * unit, third_root * unit
        if rho <= rho_minus:
            high = U_plus
        else:
            low = U_minus
    half = 0.5 * (rho + 2.0 / 27.0 * r * (r * r + 9.0 * s * s))
    ninth = (r * r - 3.0 * s * s) / 9.0
    root = math.sqrt(max(half * half - ninth**3, 0.0))
    cube = np.cbrt(half + math.copysign(root, half))
    start = cube + (ninth / cube if cube != 0.0 else 0.0) - 2.0 * r / 3.0
    return 1, _polish(start, low, high, rising_from, r, s, rho) * unit, np.nan, np.nan


@compiled
def solve(mu, zeta_s, zeta, Omega0, gamma, Omega):
    """All solutions U (n, 3), ascending, NaN padded, and their number (n,) at every Omega (n,)."""
    solutions = np.empty((Omega.size, 3))
    count = np.empty(Omega.size, dtype=np.int64)
    for i in range(Omega.size):
        X = Omega[i] * Omega[i]
        real = 1.0 - (1.0 + mu) * X
        if zeta_s == 0.0 and real == 0.0:  # D = 0: the frame's drive fixes W = 1/(mu X), whatever the spring
            count[i] = 1
            solutions[i] = np.nan
            solutions[i, 0] = 0.75 * gamma / (mu * X) ** 2
            continue
        r, s, e = dynamic_stiffness(mu, zeta_s, zeta, Omega0, X)
        count[i], solutions[i, 0], solutions[i, 1], solutions[i, 2] = cubic_roots(r, s, 0.75 * gamma * X * X / e)
    return solutions, count


def complex_amplitudes(group, Omega, U):
    """Complex Y (shaker), Y - Z (mass) and Z (relative) of Eqs. (4a, b) at Omega and U of one shape.

    From D Y + mu Omega^2 Z = 1 and N Z = -Omega^2 Y with N = Omega0^2 - Omega^2 + U + 2i zeta Omega; phases are
    against the force cos(Omega tau), so that y = Re(Y exp(i Omega tau)). Infinite at an undamped linear resonance.
    """
    X = Omega**2
    D = 1 - (1 + group.mu) * X + 2j * group.zeta_s * Omega
    spring = group.Omega0**2 + U + 2j * group.zeta * Omega
    with np.errstate(divide="ignore", invalid="ignore"):
        drive = 1 / (D * (spring - X) - group.mu * X**2)
        return (spring - X) * drive, spring * drive, -X * drive
