"""Rational fraction polynomials (M. H. Richardson and D. L. Formenti, IMAC I, 1982).

Every receptance is a ratio N_r(s)/D(s) with one denominator for all. On the imaginary
axis the monic orthogonal polynomials of a symmetric weight follow G. E. Forsythe's
two-term recursion p_k = omega p_{k-1} - b_k p_{k-2}; in them the normal equations of

    minimise sum |w_r (N_r(i omega) - h_r D(i omega))|^2,   D monic

are well conditioned, and the numerators drop out of them by projection.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial

from .. import checks

RESOLUTION = 0.1  # Hz between frequencies


def frequencies(band, sample_rate):
    """Every 0.1 Hz over the band, both ends included."""
    low, high = checks.pair("band", band, "Hz", high=sample_rate / 2)
    return np.linspace(low, high, max(int(round((high - low) / RESOLUTION)), 40) + 1)


@dataclass(frozen=True, eq=False)
class RationalFraction:
    """Receptances N_r(s)/D(s), s = i omega, by their real coefficients in ascending powers of s."""

    numerators: tuple[np.ndarray, ...]
    denominator: np.ndarray  # the last one 1

    def __call__(self, frequency):
        """The receptances at ``frequency`` (Hz, shape (n,)): complex, shape (n, number of receptances)."""
        s = 2j * np.pi * np.asarray(frequency, dtype=float)
        below = polynomial.polyval(s, self.denominator)
        return np.stack([polynomial.polyval(s, above) / below for above in self.numerators], axis=-1)

    @property
    def poles(self):
        """Roots of the denominator (rad/s), complex."""
        return polynomial.polyroots(self.denominator)


def fit_rational_fraction(frequency, receptances, weights, numerator_orders, denominator_order):
    """`RationalFraction` of receptances (n, r), complex, that share their poles, at ``frequency`` (n,) in Hz.

    ``weights`` (n, r) are the w_r, what a unit of misfit counts for; orders are the degrees of each of the r numerators
    and of the common denominator, twice the number of modes.
    """
    top = 2 * np.pi * frequency.max()
    omega = 2 * np.pi * frequency / top
    below, to_powers = _orthogonal(omega, np.sum(np.abs(weights * receptances) ** 2, axis=1), denominator_order)
    numerators = [_orthogonal(omega, w**2, order) for w, order in zip(weights.T, numerator_orders, strict=True)]
    bases = [_real_rows(w[:, None] * above) for w, (above, _) in zip(weights.T, numerators, strict=True)]
    norms = [np.linalg.norm(basis, axis=0) for basis in bases]
    targets = (weights * receptances).T
    rows, right = [], []
    for basis, norm, target in zip(bases, norms, targets, strict=True):
        # What no numerator of this degree can match is left for the denominator.
        products = _real_rows(target[:, None] * below)
        products = products - (basis / norm) @ ((basis / norm).T @ products)
        rows.append(products[:, :-1])
        right.append(-products[:, -1])
    lower = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
    denominator = np.append(lower, 1.0)
    matched = below @ denominator
    fitted = [
        powers @ (basis.T @ _real_rows(target * matched) / norm**2)
        for basis, norm, target, (_, powers) in zip(bases, norms, targets, numerators, strict=True)
    ]
    in_powers = to_powers @ denominator
    # From s/top back to s, with a monic denominator.
    leading = in_powers[-1] / top**denominator_order
    return RationalFraction(
        tuple(above / top ** np.arange(above.size) / leading for above in fitted),
        in_powers / top ** np.arange(in_powers.size) / leading,
    )


def _orthogonal(omega, weight, order):
    """i^k p_k(omega), shape (n, order + 1), and the matrix that turns its coefficients into powers of s = i omega.

    As polynomials in s the columns are real: q_k = s q_{k-1} + b_k q_{k-2}.
    """
    values = np.zeros((omega.size, order + 1), dtype=complex)
    powers = np.zeros((order + 1, order + 1))
    values[:, 0] = powers[0, 0] = 1.0
    norm = np.sum(weight)
    for k in range(1, order + 1):
        values[:, k] = 1j * omega * values[:, k - 1]
        powers[1:, k] = powers[:-1, k - 1]
        if k > 1:
            before, norm = norm, np.sum(weight * np.abs(values[:, k - 1]) ** 2)
            values[:, k] += norm / before * values[:, k - 2]
            powers[:, k] += norm / before * powers[:, k - 2]
    return values, powers


def _real_rows(values):
    """Real parts above imaginary parts: the rows of a real least-squares problem."""
    return np.concatenate([values.real, values.imag])
