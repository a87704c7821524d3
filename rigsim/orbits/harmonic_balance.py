"""Multi-harmonic balance of Eqs. (3a, b) with the shaker eliminated: residual and exact Jacobian; non-dimensional.

With theta = Omega tau / p (p the period of the orbit in forcing periods) let

    w(theta) = a_0 + sum_k a_k cos(k theta) + b_k sin(k theta),    W_k = a_k - i b_k,    s = k Omega / p.

The shaker is linear, so each of its lines follows from that of w, as in `rigsim.theory.cubic` for the first:
D(s) Y_k + mu s^2 W_k = (1 where k = p), D(s) = 1 - (1 + mu) s^2 + 2i zeta_s s. What is left are 2h + 1 real equations

    S(s) W_k + Phi_k = (-Omega^2/D(Omega) where k = p),    S(s) = -s^2 + 2i zeta s - mu s^4/D(s),

with Phi_k the lines of the wires' force phi(w). Those are found by alternating between frequency and time: w and phi
are sampled over a period, and the samples' sums give Phi_k and, from phi'(w), the Jacobian, a Toeplitz and a Hankel
matrix. With more than 4h samples nothing is aliased under the cubic law. The exact law's Taylor terms shrink with
(z/d)^2; its samples are more than 6h, so the first term that is aliased at all is that of the seventh power.

Both laws are odd, so orbits of odd period whose second half mirrors the first, w(theta + pi) = -w(theta), are solutions
among themselves. They have odd lines only, and half a period of samples. Every single-term solution is one; orbits
with even lines and a mean branch off them where the symmetry breaks.

Unknowns are held as (a_0, a_1, b_1, ..., a_h, b_h, Omega), or (a_1, b_1, a_3, b_3, ..., Omega), n of them.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from .. import checks
from ..compiled import compiled
from ..model.wires import axial_force, axial_stiffness, spring_of
from ..parameters import OscillatorParameters, law_of, oscillator_of


@dataclass(frozen=True, eq=False)
class Balance:
    """The equations of one rig, force, law, number of harmonics and period, as the compiled functions take them.

    Attributes
    ----------
    parameters : OscillatorParameters
    force : float
        N.
    period : int
        Period of the orbits, in forcing periods.
    harmonics : int
        Highest line kept, in multiples of the forcing frequency over ``period``.
    orders : (k,) array of int
        Lines kept: 0, 1, 2, ... or 1, 3, 5, ...
    cosine, sine : (samples, 2 harmonics + 1) array
        Of k theta at the samples of a period, or of half a period if only odd lines are kept.
    numbers : (5,) array
        mu, zeta_s, zeta; 0, or the Omega at which the force is the last unknown, see `at`; the force over ``force``.
    law : (4,) array
        `rigsim.model.wires.spring_of` the wires over m omega_s^2 and x0.
    """

    parameters: OscillatorParameters
    force: float
    period: int
    harmonics: int
    orders: np.ndarray
    cosine: np.ndarray
    sine: np.ndarray
    numbers: np.ndarray
    law: np.ndarray

    @property
    def system(self):
        """What the compiled functions take first: (numbers, law, period, orders, cosine, sine)."""
        return self.numbers, self.law, self.period, self.orders, self.cosine, self.sine

    @property
    def size(self):
        """Number of coefficients, the unknowns but for the last one."""
        return 2 * self.orders.size - int(self.orders[0] == 0)

    def at(self, frequency):
        """The same equations at a given frequency (Hz), with the force over ``force`` as the last unknown."""
        numbers = self.numbers.copy()
        numbers[3] = frequency / self.hertz
        return replace(self, numbers=numbers)

    def at_force(self, share):
        """The same equations at ``share`` times the force."""
        numbers = self.numbers.copy()
        numbers[4] = share
        return replace(self, numbers=numbers)

    def with_harmonics(self, harmonics):
        """The same equations with another number of harmonics, multiples of the forcing frequency."""
        return self._with(harmonics, self.orders[0] != 0)

    def symmetric(self):
        """The same equations with odd lines only."""
        return self._with(self.harmonics // self.period, True)

    def _with(self, harmonics, symmetric):
        names = "harmonics", "orders", "cosine", "sine"
        return replace(self, **dict(zip(names, _lines(self.law, self.period, harmonics, symmetric), strict=True)))

    def widened(self, fewer, x):
        """Unknowns (..., n) of these equations from those ``x`` of ``fewer``, of fewer lines or half the period."""
        result = np.zeros((*x.shape[:-1], self.size + 1))
        result[..., -1] = x[..., -1]
        start = int(fewer.orders[0] == 0)
        result[..., :start] = x[..., :start]
        k = fewer.orders[start:] * (self.period // fewer.period)
        result[..., 2 * k - 1], result[..., 2 * k] = x[..., start:-1:2], x[..., start + 1 : -1 : 2]
        return result

    def images(self, x):
        """Unknowns, or a point of the sheet, (n,) of the same motion begun later by half a forcing period and mirrored.

        Both laws are odd, so these solve the same equations: ``2 period`` of them, itself first; one if only odd lines
        are kept.
        """
        if self.orders[0] != 0:
            return [x]
        found = []
        k = self.orders[1:]
        for j in range(2 * self.period):
            turned = x.copy()
            turned[0] *= (-1) ** j
            lines = (
                (x[1 : self.size : 2] - 1j * x[2 : self.size : 2])
                * (-1) ** j
                * np.exp(1j * np.pi * j * k / self.period)
            )
            turned[1 : self.size : 2], turned[2 : self.size : 2] = lines.real, -lines.imag
            found.append(turned)
        return found

    @property
    def unit(self):
        """x0 = F/ks (m)."""
        return self.force / self.parameters.ks

    @property
    def hertz(self):
        """Hz of Omega = 1."""
        return self.parameters.omega_s / (2 * math.pi)

    def unknowns(self, frequency, relative):
        """(n,) unknowns of an orbit from its lines ``relative`` (m), cut or padded to harmonics + 1, at Hz."""
        lines = np.zeros(self.harmonics + 1, dtype=complex)
        lines[: len(relative)] = relative[: self.harmonics + 1]
        kept = lines[self.orders] / self.unit
        x = np.column_stack([kept.real, -kept.imag]).ravel()
        return np.append(x[0:1].tolist() + x[2:].tolist() if self.orders[0] == 0 else x, frequency / self.hertz)

    def lines(self, points):
        """Frequency (k,) in Hz, and lines of xs, x and z (k, harmonics + 1) in m, of points (k, n)."""
        Omega = points[:, -1]
        W = np.zeros((len(points), self.harmonics + 1), dtype=complex)
        start = int(self.orders[0] == 0)
        if start:
            W[:, 0] = points[:, 0]
        W[:, self.orders[start:]] = points[:, start:-1:2] - 1j * points[:, start + 1 : -1 : 2]
        mu, zeta_s = self.numbers[:2]
        s = Omega[:, None] / self.period * np.arange(self.harmonics + 1)
        drive = np.zeros(self.harmonics + 1)
        drive[self.period] = self.numbers[4]
        Y = (drive - mu * s**2 * W) / (1 - (1 + mu) * s**2 + 2j * zeta_s * s)
        return Omega * self.hertz, self.unit * Y, self.unit * (Y - W), self.unit * W


def balance(parameters, force, harmonics, law, period=1, symmetric=False):
    """The `Balance` of checked inputs; ``harmonics`` counts multiples of the forcing frequency.

    ``symmetric`` keeps odd lines only, which an even period does not allow.

    Raises
    ------
    ValueError
        If an input is not allowed, the exact law is asked of a set without wires, or the shaker is undamped.
    """
    oscillator = oscillator_of(parameters)
    force = checks.positive("force", force, "N")
    harmonics = checks.integer("harmonics", harmonics, low=1, high=200)
    period = checks.one_of("period", period, (1, 2, 3))
    law = law_of(parameters, law)
    if oscillator.cs == 0:
        raise ValueError("cs = 0 N s/m is not allowed here; expected a damped shaker, for else solutions have no bound")
    group = oscillator.nondimensional(force)
    spring = np.array(spring_of(parameters, law, oscillator.m * oscillator.omega_s**2, force / oscillator.ks))
    numbers = np.array([group.mu, group.zeta_s, group.zeta, 0.0, 1.0])
    return Balance(oscillator, force, period, *_lines(spring, period, harmonics, symmetric), numbers, spring)


def _lines(spring, period, harmonics, symmetric):
    """The last four of a `Balance`: lines kept, and cosines and sines at the samples."""
    lines = period * harmonics
    samples = (4 if spring[0] == 0 else 6) * (lines + 1)
    phase = 2 * np.pi / samples * (np.outer(np.arange(samples), np.arange(2 * lines + 1)) % samples)
    if symmetric:
        phase = phase[: samples // 2]
    return lines, np.arange(1, lines + 1, 2) if symmetric else np.arange(lines + 1), np.cos(phase), np.sin(phase)


@compiled
def force_lines(law, orders, cosine, sine, x, slope_a, slope_b, force_a, force_b):
    """Lines of phi'(w) (into slope_a, slope_b, 2h + 1) and of phi(w) (into force_a, force_b, h + 1) about x.

    All are (1/pi) times the integral over a period against cos and sin, so that the first is twice the mean.
    """
    samples, h = cosine.shape
    h //= 2
    start = 1 if orders[0] == 0 else 0
    slope_a[:], slope_b[:], force_a[:], force_b[:] = 0.0, 0.0, 0.0, 0.0
    for i in range(samples):
        w = x[0] if start else 0.0
        for j in range(start, orders.size):
            c = 2 * j - start
            w += x[c] * cosine[i, orders[j]] + x[c + 1] * sine[i, orders[j]]
        force, slope = axial_force(law, w), axial_stiffness(law, w)
        force *= 2.0 / samples
        slope *= 2.0 / samples
        for k in range(h + 1):  # innermost over lines, so that it becomes one vector operation
            force_a[k] += force * cosine[i, k]
            force_b[k] += force * sine[i, k]
        for k in range(2 * h + 1):
            slope_a[k] += slope * cosine[i, k]
            slope_b[k] += slope * sine[i, k]


@compiled
def residual_and_jacobian(numbers, law, period, orders, cosine, sine, x, work, residual, jacobian):
    """Residual (n - 1,) and Jacobian (n - 1, n) of the module's equations at x (n,); work is (4, 2h + 1)."""
    mu, zeta_s, zeta = numbers[0], numbers[1], numbers[2]
    sliced = numbers[3] > 0.0
    Omega = numbers[3] if sliced else x[x.size - 1]
    share = x[x.size - 1] if sliced else numbers[4]
    h = cosine.shape[1] // 2
    A, B, force_a, force_b = work[0], work[1], work[2, : h + 1], work[3, : h + 1]
    force_lines(law, orders, cosine, sine, x, A, B, force_a, force_b)
    start, last = 1 if orders[0] == 0 else 0, x.size - 1
    if start:
        residual[0], jacobian[0, 0], jacobian[0, last] = 0.5 * force_a[0], 0.5 * A[0], 0.0
    for row in range(start, orders.size):
        k = orders[row]
        c, s = 2 * row - start, 2 * row - start + 1  # rows and columns of the cosine and the sine
        if start:
            jacobian[0, c], jacobian[0, s] = 0.5 * A[k], 0.5 * B[k]
            jacobian[c, 0], jacobian[s, 0] = A[k], B[k]
        for column in range(start, orders.size):
            j, at = orders[column], 2 * column - start
            apart = abs(k - j)
            odd = B[apart] if k >= j else -B[apart]
            jacobian[c, at] = 0.5 * (A[apart] + A[k + j])
            jacobian[s, at + 1] = 0.5 * (A[apart] - A[k + j])
            jacobian[c, at + 1] = 0.5 * (B[k + j] - odd)
            jacobian[s, at] = 0.5 * (B[k + j] + odd)
        rate = k / period
        sigma = rate * Omega
        D = complex(1.0 - (1.0 + mu) * sigma * sigma, 2.0 * zeta_s * sigma)
        dD = complex(-2.0 * (1.0 + mu) * sigma, 2.0 * zeta_s)
        cube = mu * sigma * sigma * sigma / D
        S = complex(-sigma * sigma, 2.0 * zeta * sigma) - cube * sigma
        dS = complex(-2.0 * sigma, 2.0 * zeta) - cube * (4.0 - sigma * dD / D)
        residual[c] = S.real * x[c] + S.imag * x[s] + force_a[k]
        residual[s] = S.real * x[s] - S.imag * x[c] + force_b[k]
        jacobian[c, c] += S.real
        jacobian[c, s] += S.imag
        jacobian[s, c] -= S.imag
        jacobian[s, s] += S.real
        along_c = dS.real * x[c] + dS.imag * x[s]
        along_s = dS.real * x[s] - dS.imag * x[c]
        if k == period:
            drive = -sigma * sigma / D
            change = -(2.0 * sigma - sigma * sigma * dD / D) / D
            residual[c] -= share * drive.real
            residual[s] += share * drive.imag
            along_c -= share * change.real
            along_s += share * change.imag
        if not sliced:
            jacobian[c, last] = rate * along_c
            jacobian[s, last] = rate * along_s
        elif k == period:
            jacobian[c, last] = -drive.real
            jacobian[s, last] = drive.imag
        else:
            jacobian[c, last], jacobian[s, last] = 0.0, 0.0


def residual(system, x):
    """Residual (n - 1,) and Jacobian (n - 1, n) at x (n,) of a `Balance.system`; new arrays."""
    work, values, jacobian = np.empty((4, system[-1].shape[1])), np.empty(x.size - 1), np.empty((x.size - 1, x.size))
    residual_and_jacobian(*system, x, work, values, jacobian)
    return values, jacobian
