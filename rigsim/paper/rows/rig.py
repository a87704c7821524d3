"""Tables 1 and 2, Eq. (2) and the settings of the tests: what the rig is made of."""

import numpy as np

from ...model.wires import cubic_law_error, suspension_force
from ..printed import printed
from .entry import Entry, numbers, percent


def _conditions(e, symbol):
    first = e.experiment.tests[0]
    return {
        "gravity": lambda: e.rig.gravity,
        "random force, rms": lambda: np.sqrt(np.mean(e.record.force**2)),
        "sample rate": lambda: e.record.sample_rate,
        "length of the record": lambda: e.record.duration,
        "force F": lambda: first.force[0],
        "length of a sine test": lambda: round(first.time[-1], 6),
    }[symbol]()


def _taylor(e):
    """Eq. (2) against a polynomial through Eq. (1) near z = 0."""
    z = 1e-2 * e.rig.d * np.cos(np.pi * (np.arange(16) + 0.5) / 16)
    powers = z[:, None] ** np.arange(1, 8, 2)
    scale = np.abs(powers).max(axis=0)
    fitted = np.linalg.lstsq(powers / scale, suspension_force(z, e.rig), rcond=None)[0] / scale
    cubic = e.rig.k3 * np.abs(z).max() ** 2
    error = max(abs(fitted[0] - e.rig.k1) / cubic, abs(fitted[1] / e.rig.k3 - 1))
    return error < 1e-4, f"a polynomial through Eq. (1) gives the same k1 and k3 to {error:.0e}"


def fitted_amplitude(rig, k3):
    """Largest abs(z) (m) up to which a least-squares k1 z + k3 z^3 of Eq. (1) has this k3, or NaN where none has."""
    z = np.linspace(-1, 1, 401)

    def fitted(reach):
        powers = np.column_stack([z, z**3])
        return np.linalg.lstsq(powers, suspension_force(reach * z, rig), rcond=None)[0][1] / reach**3

    low, high = 1e-3 * rig.d, 0.3 * rig.d
    if not fitted(high) < k3 < fitted(low):
        return np.nan
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fitted(middle) > k3 else (low, middle)
    return 0.5 * (low + high)


def _k3_cause(e):
    reach = fitted_amplitude(e.rig, printed("Eq. (2)", "k3"))
    return (
        f"Eq. (2) with Table 2 gives {e.rig.k3:.5e}; the printed value is what a cubic fitted to Eq. (1) has up to "
        f"|z| = {1e3 * reach:.2g} mm, and also our mean over 2-80 Hz in the paper's reading "
        f"({e.paper.nonlinear_mean((2, 80)):.4e})"
    )


def _k1_range(e):
    half = 0.5e-6  # m: Table 2 prints d0 to a micrometre
    change = e.rig.wire_stiffness.sum() * half / e.rig.d
    share = f", ±{percent(change / e.rig.k1)}" if e.rig.k1 else ""
    return change < 5e-5 * e.rig.k1, f"k1 is {e.rig.k1:.2f} ± {change:.2f} N/m{share}"


def _cubic_error(e):
    largest = e.trials["relative"].max()
    error = float(cubic_law_error(largest, e.rig))
    return abs(error) < 0.01, f"error of the force {percent(error)} at |z| = {1e3 * largest:.2f} mm"


def _slightly_tightened(e):
    tension = e.rig.wire_stiffness.mean() * (e.rig.d - e.rig.d0)
    weight = e.rig.m * e.rig.gravity
    strain = (e.rig.d - e.rig.d0) / e.rig.d0
    return strain < 1e-3, f"a strain of {strain:.2g}, {tension:.2g} N a wire; the mass weighs {weight:.2g} N"


ROWS = (
    *numbers("Table 1", lambda e, symbol: e.rig.wire_stiffness.mean() if symbol == "k" else getattr(e.rig, symbol)),
    *numbers("Table 2", lambda e, symbol: e.rig.LG / e.rig.Lm if symbol == "LG/Lm" else getattr(e.rig, symbol)),
    *numbers("Eq. (2)", lambda e, symbol: getattr(e.rig, symbol), causes={"k3": _k3_cause}),
    Entry("Eq. (2)", "k1 = 8k(1 - d0/d) and k3 = 4k d0/d^3 are the Taylor coefficients of Eq. (1)", _taylor),
    Entry(
        "Eq. (2)", "k1 = 28.235 N/m, five digits, follows from Table 2", _k1_range,
        "d0 is printed to a micrometre, and k1 rests on d - d0 = 3 µm",
    ),
    Entry("Eq. (2)", "the cubic law is good enough for the motions tested", _cubic_error),
    Entry("Eq. (2)", "the wires are only slightly tightened", _slightly_tightened),
    *numbers("Tests", _conditions),
)  # fmt: skip
