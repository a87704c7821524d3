"""Referee for folds: the discriminant of Eq. (5a) as printed, in exact rational arithmetic, with certified roots."""

from fractions import Fraction

from flint import fmpq, fmpq_poly


def _rational(value):
    numerator, denominator = Fraction(value).as_integer_ratio()
    return fmpq(numerator, denominator)


def cleared_coefficients(group):
    """Coefficients a, b, c, d of Eqs. (6a-g) times e, and e, polynomials in X = Omega^2."""
    mu, zeta_s, zeta, Omega0, gamma = (
        _rational(v) for v in (group.mu, group.zeta_s, group.zeta, group.Omega0, group.gamma)
    )
    X = fmpq_poly([0, 1])
    shaker, oscillator = 1 - (1 + mu) * X, Omega0**2 - X
    e = shaker**2 + 4 * zeta_s**2 * X
    g = fmpq(3, 2) * mu * gamma * shaker
    h = 2 * mu * shaker * oscillator - mu**2 * X**2 - 8 * mu * zeta_s * zeta * X
    a = fmpq(9, 16) * gamma**2 * e
    b = fmpq(3, 2) * gamma * oscillator * e - g * X**2
    c = (oscillator**2 + 4 * zeta**2 * X) * e - h * X**2
    return a, b, c, -(X**2), e


def fold_polynomial(group):
    """Discriminant of Eq. (5a) without its factors X and e, which have no positive root: degree at most 12."""
    a, b, c, d, e = cleared_coefficients(group)
    polynomial = b**2 * c**2 - 4 * a * c**3 - 4 * b**3 * d - 27 * a**2 * d**2 + 18 * a * b * c * d
    for factor in (fmpq_poly([0, 1]), e):
        while True:
            quotient, rest = divmod(polynomial, factor)
            if rest != 0:
                break
            polynomial = quotient
    return polynomial.numer()


def exact_folds(group):
    """List of (Omega, kind) of every fold: certified real roots, told apart by which two solutions are equal."""
    a, b, c, d, _ = cleared_coefficients(group)
    found = []
    for root, multiplicity in fold_polynomial(group).complex_roots():
        # A real root is certified as such: its imaginary part is exactly zero.
        if multiplicity % 2 == 0 or root.imag != 0 or not root.real > 0:
            continue
        mantissa, exponent = root.real.mid().man_exp()
        X = fmpq(mantissa) * fmpq(2) ** exponent
        A, B, C, D = (p(X) for p in (a, b, c, d))
        double = (9 * A * D - B * C) / (2 * (B**2 - 3 * A * C))
        single = (4 * A * B * C - 9 * A**2 * D - B**3) / (A * (B**2 - 3 * A * C))
        found.append((float(root.real.mid()) ** 0.5, "lower" if double < single else "upper"))
    return sorted(found)
