"""Table 5, Section 2.2 and the lines of Fig. 6: what the theory says."""

import numpy as np

from ...parameters import Nondimensional
from ...theory.detached import detached_curves, force_scenario
from .entry import Entry, number, numbers, percent, printed_oscillator

_RANDOM_SETS = 2000


def amplitude_equation(group, Omega):
    """Coefficients a, b, c, d of Eq. (5a) by Eqs. (6a-g) as printed, arrays that broadcast."""
    mu, zeta_s, zeta, Omega0, gamma = group
    detuning, square = 1 - Omega**2 * (1 + mu), Omega0**2 - Omega**2
    e = detuning**2 + 4 * zeta_s**2 * Omega**2
    g = 1.5 * mu * gamma * detuning
    h = 2 * mu * detuning * square - mu**2 * Omega**4 - 8 * mu * zeta_s * zeta * Omega**2
    return (
        9 * gamma**2 / 16,
        1.5 * gamma * square - g * Omega**4 / e,
        square**2 + 4 * zeta**2 * Omega**2 - h * Omega**4 / e,
        -(Omega**4) / e,
    )


def _discriminant_rule(e):
    """The sign of the printed discriminant against the roots of (5a), for oscillators drawn around the rig."""
    rng = np.random.default_rng(2014)
    group = e.rig.nondimensional(e.force)
    centre = np.array([getattr(group, name) for name in Nondimensional.__dataclass_fields__])
    drawn = centre[:, None] * np.exp(rng.normal(0, 1, (5, _RANDOM_SETS)))
    Omega = rng.uniform(0.05, 2.5, _RANDOM_SETS)
    a, b, c, d = amplitude_equation(drawn, Omega)
    discriminant = 18 * a * b * c * d - 27 * a**2 * d**2 - 4 * b**3 * d + b**2 * c**2 - 4 * c**3 * a
    wrong, several = 0, 0
    for coefficients, sign in zip(np.column_stack([a, b, c, d]), np.sign(discriminant), strict=True):
        roots = np.roots(coefficients)
        count = int(((np.abs(roots.imag) < 1e-7 * np.abs(roots)) & (roots.real > 0)).sum())
        wrong += count != (3 if sign > 0 else 1)
        several += count == 3
    return not wrong, f"{_RANDOM_SETS} random oscillators, {several} of them with three solutions: {wrong} exceptions"


def _two_of_three_stable(e):
    several = e.curve.count == 3
    stable = e.curve.stable[several].sum(axis=1)
    if not stable.size:
        return False, "there are never three solutions"
    usual = e.curve.stable[several] == [True, False, True]
    unusual = e.curve.frequency[several][~usual.all(axis=1)]
    if not unusual.size:
        return True, f"at each of {stable.size} frequencies from 10 to 80 Hz"
    return "partly", (
        f"at {percent(usual.all(axis=1).mean(), 3)} of the frequencies; between {unusual.min():.1f} and "
        f"{unusual.max():.1f} Hz from {stable.min()} to {stable.max()} of the three are"
    )


def _detached(e):
    listed = ", ".join(f"{curve.kind} from {curve.low:.2f} to {curve.high:.2f} Hz" for curve in e.detached)
    return [curve.kind for curve in e.detached] == ["inner"], f"at {e.force:g} N: {listed or 'none'}"


def _inside_which(e):
    """Whether the two solutions of the detached curve lie below the third, by displacement."""
    at = e.inside(e.curve.frequency) & (e.curve.count == 3)
    if not at.any():
        return False, "there is no detached curve"
    sizes = {name: np.abs(getattr(e.curve, name)[at]) for name in ("relative", "mass", "shaker")}
    below = {name: (size[:, :2].max(axis=1) < size[:, 2]).mean() for name, size in sizes.items()}
    listed = ", ".join(f"{name} {100 * share:.3g} %" for name, share in below.items())
    return below["relative"] == below["mass"] == 1, f"it lies below the main curve at: {listed}"


def _margin(e):
    """Forces at which an inner curve begins and ends to exist, around the force of the tests."""
    told = ", ".join(
        f"{'begins' if change > 0 else 'ends'} at {force:.3f} N ({100 * (force / e.force - 1):+.2g} %)"
        for force, change in _inner_changes(e.theory)
    )
    inner = any(curve.kind == "inner" for curve in e.detached)
    return inner, f"an inner curve {told}" if told else "there is no inner curve at any force"


def _inner_changes(parameters):
    """(force, by how many) of the events that change the number of inner curves."""
    changes = ((one.force, one.after.count("inner") - one.before.count("inner")) for one in force_scenario(parameters))
    return [(force, change) for force, change in changes if change]


def _quasi_zero(e):
    softest = e.theory.replace(k1=0.0)
    found = detached_curves(softest, e.force)
    births = [force for force, change in _inner_changes(softest) if change > 0]
    listed = ", ".join(f"{curve.kind} {curve.low:.1f}-{curve.high:.1f} Hz" for curve in found)
    first = f"; the first one at {min(births):.3f} N" if births else ""
    inner = any(curve.kind == "inner" for curve in found)
    return inner, f"with k1 = 0 at {e.force:g} N: {listed or 'no detached curve'}{first}"


ROWS = (
    *numbers(
        "Table 5", lambda e, symbol: getattr(e.theory.nondimensional(e.force), symbol),
        causes={"zeta_s": "truncated, not rounded; see the next row"},
    ),
    number(
        "Table 5", "zeta_s", "zeta_s from Table 4 as printed",
        lambda e: printed_oscillator(e).nondimensional(e.force).zeta_s,
        "truncated, not rounded",
    ),
    Entry("Section 2.2", "three solutions, or one, by the sign of the discriminant", _discriminant_rule),
    Entry("Section 2.2", "of three solutions two are stable and one is not", _two_of_three_stable,
          "at large amplitudes the main curve is unstable too, by the same multipliers"),
    Entry("Fig. 6", "there is one closed detached curve, an inner one", _detached),
    Entry("Fig. 6", "it lies inside the main curve of z and of x", _inside_which),
    Entry("Fig. 6", "this force is one at which an inner curve exists", _margin),
    Entry("Fig. 6", "it appears in particular with quasi-zero stiffness", _quasi_zero,
          "a little linear stiffness helps here: with k1 = 0 the curve is born at a larger force"),
)  # fmt: skip
