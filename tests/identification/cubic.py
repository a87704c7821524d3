"""Records of the cubic two-degree-of-freedom system, Eqs. (3a, b), from an integrator written for the tests alone."""

import numpy as np
from numba import njit

from rigsim.experiment.record import Record
from rigsim.parameters import RigParameters

SUBSTEPS = 8  # Runge-Kutta steps a sample: the force between two samples is a polynomial, so the order is kept


@njit(cache=True)
def _rate(state, force, p):
    ms, ks, cs, m, c, k1, k3 = p
    xs, x, vs, v = state
    z, w = xs - x, vs - v
    spring = c * w + k1 * z + k3 * z**3
    return np.array([vs, v, (force - cs * vs - ks * xs - spring) / ms, spring / m])


@njit(cache=True)
def _integrate(force, dt, p, linear):
    n = force.size
    states = np.empty((n, 4))
    state = np.zeros(4)
    h = dt / SUBSTEPS
    for k in range(n):
        states[k] = state
        slope = (force[k + 1] - force[k]) / SUBSTEPS if linear and k + 1 < n else 0.0
        for i in range(SUBSTEPS):
            left = force[k] + i * slope
            a = _rate(state, left, p)
            b = _rate(state + h / 2 * a, left + slope / 2, p)
            c = _rate(state + h / 2 * b, left + slope / 2, p)
            d = _rate(state + h * c, left + slope, p)
            state = state + h / 6 * (a + 2 * b + 2 * c + d)
    return states


def _numbers(p):
    return p.ms, p.ks, p.cs, p.m, p.c, p.k1, p.k3


def cubic_record(parameters=None, duration=100, seed=2014, hold="zero", noise=0.0, rms=1.115, sample_rate=2000):
    """Record of the cubic law, from rest, under a Gaussian force; ``noise`` is a share of each displacement's rms."""
    p = (parameters or RigParameters()).oscillator
    rng = np.random.default_rng(seed)
    force = rng.normal(size=int(duration * sample_rate))
    force *= rms / np.sqrt(np.mean(force**2))
    shaker, mass = _integrate(force, 1 / sample_rate, _numbers(p), hold == "linear").T[:2]
    shaker, mass = (x + noise * x.std() * rng.normal(size=x.size) for x in (shaker, mass))
    return Record(force, shaker, mass, sample_rate, hold=hold, seed=seed, start="rest", parameters=p)


def softening_record(size, duration=10, seed=2014, sample_rate=2000):
    """Record of the paper's rig with a cubic coefficient of minus ``size`` (N/m^3), which stays in its well."""
    force = np.random.default_rng(seed).normal(scale=1.115, size=int(duration * sample_rate))
    states = _integrate(force, 1 / sample_rate, (*_numbers(RigParameters().oscillator)[:6], -size), False)
    return Record(force, states[:, 0], states[:, 1], sample_rate)


def band_limited_record(cut=200.0, duration=30, seed=3, sample_rate=2000, finer=16):
    """Record of the cubic law under a force without anything above ``cut`` Hz, integrated ``finer`` times as fast."""
    p = RigParameters().oscillator
    n = int(duration * sample_rate * finer)
    spectrum = np.fft.rfft(np.random.default_rng(seed).normal(size=n))
    frequency = np.fft.rfftfreq(n, 1 / (sample_rate * finer))
    spectrum[frequency > cut] = 0
    force = np.fft.irfft(spectrum, n)
    spectrum *= 0.5 / force.std()
    force *= 0.5 / force.std()
    # Straight lines between samples weaken a line by sinc^2, 2e-5 at 80 Hz: enough to be seen in m, c, k1 and k3.
    driven = np.fft.irfft(spectrum / np.sinc(frequency / (sample_rate * finer)) ** 2, n)
    shaker, mass = _integrate(driven, 1 / (sample_rate * finer), _numbers(p), True)[::finer, :2].T
    return Record(force[::finer], shaker, mass, sample_rate, hold="band-limited", parameters=p)


def linear_matrices(p):
    """Mass, damping and stiffness matrix of Eqs. (3a, b) without the cubic term, over [xs, x]."""
    coupling = np.array([[1, -1], [-1, 1]])
    first = np.diag([1.0, 0.0])
    return np.diag([p.ms, p.m]), p.cs * first + p.c * coupling, p.ks * first + p.k1 * coupling


def true_receptance(p, frequency):
    """Inverse of the dynamic stiffness matrix (m/N), shape (n, 2, 2)."""
    mass, damping, stiffness = linear_matrices(p)
    omega = 2 * np.pi * np.asarray(frequency)[:, None, None]
    return np.linalg.inv(stiffness + 1j * omega * damping - omega**2 * mass)


def first_order(p):
    """Continuous state matrices A, B (force on the shaker), C, with the state [xs, x, xs', x']."""
    mass, damping, stiffness = linear_matrices(p)
    inverse = np.linalg.inv(mass)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ stiffness, -inverse @ damping]])
    return A, np.array([[0.0], [0.0], [1 / p.ms], [0.0]]), np.eye(2, 4)


def stepped_amplitudes(force, frequencies, dwell=1.0, sample_rate=8000, parameters=None):
    """Amplitude of z (m) at each frequency of a stepped test, each begun where the one before ended; dwells in s."""
    p = (parameters or RigParameters()).oscillator
    periods = np.ceil(dwell * frequencies)
    samples = np.round(periods / frequencies * sample_rate).astype(int)
    phase = np.cumsum(2 * np.pi / sample_rate * np.repeat(frequencies, samples))
    states = _integrate(force * np.cos(phase), 1 / sample_rate, _numbers(p), True)
    found, ends = [], np.cumsum(samples)
    for f, end in zip(frequencies, ends, strict=True):
        part = slice(end - int(round(5 / f * sample_rate)), end)  # the last five periods
        z = states[part, 0] - states[part, 1]
        found.append(2 * abs(np.mean(z * np.exp(-1j * phase[part]))))
    return np.array(found)
