"""Lines of a spectrum by least squares: sines of known frequency, and the one that stands out of what is left."""

import functools

import numpy as np
import scipy.fft
import scipy.linalg
import scipy.optimize

from ..compiled import compiled


def fit_sines(time, signals, frequencies):
    """Least-squares mean and complex amplitudes of sines of given frequencies, fitted together.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Evenly spaced (s).
    signals : ndarray, shape (n, channels)
    frequencies : sequence of float, length k
        Hz.

    Returns
    -------
    amplitudes : ndarray, complex, shape (k, channels)
        U of u(t) = Re(U exp(2 pi i f t)), zero to peak.
    residual : ndarray, shape (n, channels)
        What the mean and the sines leave.

    Notes
    -----
    Normal equations with one step of refinement, which makes them as good as QR for sines that the time tells
    apart. Their matrix is known in closed form, and the basis is never stored: each sine is a rotation from sample to
    sample. BLAS would cost a hundred times the arithmetic where its threads wait for each other on a busy machine.
    """
    omega = np.concatenate([[0.0], 2 * np.pi * np.asarray(frequencies, dtype=float)])  # the mean is a line at zero
    spacing = (time[-1] - time[0]) / (len(time) - 1)
    gram = _gram(time[0], spacing, len(time), omega)
    # A trace of ridge, which the refinement takes out again, keeps sines that the time cannot tell apart harmless.
    gram[np.diag_indices_from(gram)] += 1e-12 * len(time)
    factor = scipy.linalg.cho_factor(gram, check_finite=False)
    residual = np.array(signals)
    total = 0.0
    for _ in range(2):
        sums = _project(time[0], spacing, residual, omega)
        right = np.concatenate([sums.real, sums.imag[1:]])
        solution = scipy.linalg.cho_solve(factor, right, check_finite=False)
        amplitudes = solution[: len(omega)] - 1j * np.concatenate(
            [np.zeros_like(sums.real[:1]), solution[len(omega) :]]
        )
        parts = np.ascontiguousarray(amplitudes.real.T), np.ascontiguousarray(amplitudes.imag.T)
        _subtract(time[0], spacing, residual, omega, *parts)
        total = total + amplitudes
    return total[1:], residual


def _gram(start, spacing, count, omega):
    """Products of the columns [cos, sin (but for the mean)] summed over the samples, by geometric series."""
    plus, minus = (_sum_of_rotations(start, spacing, count, np.add.outer(omega, sign * omega)) for sign in (1, -1))
    cc, ss, cs = (plus + minus).real / 2, (minus - plus).real / 2, (plus - minus).imag / 2
    return np.block([[cc, cs[:, 1:]], [cs[:, 1:].T, ss[1:, 1:]]])


def _sum_of_rotations(start, spacing, count, omega):
    """Sum over the samples of exp(i omega t)."""
    half = omega * spacing / 2
    nearly_zero = np.abs(np.sin(half)) < 1e-14
    kernel = np.where(nearly_zero, count, np.sin(count * half) / np.where(nearly_zero, 1.0, np.sin(half)))
    return kernel * np.exp(1j * (omega * start + (count - 1) * half))


@compiled(nogil=True, fastmath={"reassoc", "contract"})
def _project(start, spacing, signals, omega):
    """Sums over the samples of u exp(i omega t), complex, shape (lines, channels)."""
    cosine, sine = np.cos(omega * start), np.sin(omega * start)
    across, along = np.cos(omega * spacing), np.sin(omega * spacing)
    real = np.zeros((signals.shape[1], len(omega)))
    imaginary = np.zeros_like(real)
    for n in range(len(signals)):
        for channel in range(signals.shape[1]):
            u = signals[n, channel]
            for k in range(len(omega)):  # innermost over lines, so that it becomes vector operations
                real[channel, k] += u * cosine[k]
                imaginary[channel, k] += u * sine[k]
        _turn(cosine, sine, across, along)
    return (real + 1j * imaginary).T


@compiled(nogil=True, fastmath={"reassoc", "contract"})
def _subtract(start, spacing, signals, omega, real, imaginary):
    """Take Re(U exp(i omega t)) of every line from the signals, in place; U (channels, lines) in two parts."""
    cosine, sine = np.cos(omega * start), np.sin(omega * start)
    across, along = np.cos(omega * spacing), np.sin(omega * spacing)
    for n in range(len(signals)):
        for channel in range(signals.shape[1]):
            total = 0.0
            for k in range(len(omega)):
                total += real[channel, k] * cosine[k] - imaginary[channel, k] * sine[k]
            signals[n, channel] -= total
        _turn(cosine, sine, across, along)


@compiled
def _turn(cosine, sine, across, along):
    """Turn every line's rotation on by one sample, in place."""
    for k in range(len(cosine)):
        turned = cosine[k] * across[k] - sine[k] * along[k]
        sine[k] = sine[k] * across[k] + cosine[k] * along[k]
        cosine[k] = turned


@compiled(nogil=True)
def _sum(signal, angle):
    """Sum of u[n] exp(i n angle)."""
    result, rotation, turn = 0.0j, 1.0 + 0.0j, np.exp(1j * angle)
    for u in signal:
        result += rotation * u
        rotation *= turn
    return result


@functools.lru_cache(8)
def _hann(count):
    return np.hanning(count)


def strongest_line(time, signal, band):
    """Frequency and amplitude of the strongest single sine within a band.

    Parameters
    ----------
    time, signal : ndarray, shape (n,)
        Evenly sampled.
    band : tuple of float
        Where to look (Hz).

    Returns
    -------
    tuple of float
        Frequency (Hz) and amplitude; the amplitude is 0 where the band holds no frequency.

    Notes
    -----
    A Hann window keeps a strong line's skirt from passing for a second line; zero-padding and a local search
    place the peak between the bins.
    """
    window = _hann(len(signal))
    weighted = (signal - signal.mean()) * window
    step, total = time[1] - time[0], window.sum()
    size = scipy.fft.next_fast_len(8 * len(time), real=True)
    frequency = np.fft.rfftfreq(size, step)
    spacing, spectrum = frequency[1], np.abs(scipy.fft.rfft(weighted, size))
    inside = (frequency > band[0]) & (frequency < band[1])
    if not inside.any():
        return 0.5 * (band[0] + band[1]), 0.0
    start = frequency[inside][spectrum[inside].argmax()]
    reach = max(start - spacing, band[0]), min(start + spacing, band[1])
    found = scipy.optimize.minimize_scalar(
        lambda f: -2 * abs(_sum(weighted, 2 * np.pi * f * step)) / total, bounds=reach, method="bounded"
    )
    return float(found.x), float(-found.fun)
