"""Lines of a spectrum by least squares: sines of known frequency, and the one that stands out of what is left."""

import numpy as np
import scipy.fft

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
    sample, all of them side by side in vector instructions. BLAS would cost a hundred times the arithmetic where its
    threads wait for each other on a busy machine.
    """
    omega = np.concatenate([[0.0], 2 * np.pi * np.asarray(frequencies, dtype=float)])  # the mean is a line at zero
    residual = np.array(signals, dtype=float, order="C")
    return _fit(time[0], (time[-1] - time[0]) / (len(time) - 1), residual, omega)[1:], residual


@compiled(nogil=True)
def _fit(start, spacing, residual, omega):
    """Amplitudes (lines, channels); the residual is left where the signals were."""
    lines = len(omega)
    factor = _gram(start, spacing, len(residual), omega)
    # A trace of ridge, which the refinement takes out again, keeps sines that the time cannot tell apart harmless.
    for i in range(len(factor)):
        factor[i, i] += 1e-12 * len(residual)
    _factorise(factor)
    total = np.zeros((lines, residual.shape[1]), dtype=np.complex128)
    right = np.empty(len(factor))
    for _ in range(2):
        sums = _project(start, spacing, residual, omega)
        for channel in range(residual.shape[1]):
            right[:lines] = sums[:, channel].real
            right[lines:] = sums[1:, channel].imag
            _substitute(factor, right)
            sums[:, channel] = right[:lines]
            sums[1:, channel] -= 1j * right[lines:]
        _subtract(start, spacing, residual, omega, sums)
        total += sums
    return total


@compiled
def _gram(start, spacing, count, omega):
    """Products of the columns [cos, sin (but for the mean)] summed over the samples, by geometric series."""
    lines = len(omega)
    gram = np.empty((2 * lines - 1, 2 * lines - 1))
    for i in range(lines):
        for j in range(lines):
            plus = _sum_of_rotations(start, spacing, count, omega[i] + omega[j])
            minus = _sum_of_rotations(start, spacing, count, omega[i] - omega[j])
            gram[i, j] = (plus + minus).real / 2
            if i > 0 and j > 0:
                gram[lines + i - 1, lines + j - 1] = (minus - plus).real / 2
            if j > 0:
                gram[i, lines + j - 1] = gram[lines + j - 1, i] = (plus - minus).imag / 2
    return gram


@compiled
def _sum_of_rotations(start, spacing, count, omega):
    """Sum over the samples of exp(i omega t)."""
    half = omega * spacing / 2
    nearly_zero = abs(np.sin(half)) < 1e-14
    kernel = count if nearly_zero else np.sin(count * half) / np.sin(half)
    return kernel * np.exp(1j * (omega * start + (count - 1) * half))


@compiled
def _factorise(a):
    """Cholesky's factor of a symmetric positive definite matrix, in its lower triangle."""
    for i in range(len(a)):
        for j in range(i + 1):
            rest = a[i, j]
            for k in range(j):
                rest -= a[i, k] * a[j, k]
            a[i, j] = np.sqrt(rest) if i == j else rest / a[j, j]


@compiled
def _substitute(factor, b):
    """Solve for ``b``, in place, with the factor and its transpose."""
    n = len(b)
    for i in range(n):
        for k in range(i):
            b[i] -= factor[i, k] * b[k]
        b[i] /= factor[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= factor[k, i] * b[k]
        b[i] /= factor[i, i]


@compiled
def _rotations(start, spacing, omega):
    """Cosine and sine of every line at the first sample, and of its turn to the next."""
    angles = np.stack((omega * start, omega * spacing))
    return np.cos(angles), np.sin(angles)


@compiled
def _turn(cos, sin):
    """Rotate every line to the next sample."""
    for k in range(cos.shape[1]):
        real = cos[0, k] * cos[1, k] - sin[0, k] * sin[1, k]
        sin[0, k] = cos[0, k] * sin[1, k] + sin[0, k] * cos[1, k]
        cos[0, k] = real


@compiled(nogil=True)
def _project(start, spacing, signals, omega):
    """Sums over the samples of u exp(i omega t), complex, shape (lines, channels)."""
    cos, sin = _rotations(start, spacing, omega)
    real, imag = np.zeros((signals.shape[1], len(omega))), np.zeros((signals.shape[1], len(omega)))
    for n in range(len(signals)):
        for channel in range(signals.shape[1]):
            u = signals[n, channel]
            for k in range(len(omega)):
                real[channel, k] += u * cos[0, k]
                imag[channel, k] += u * sin[0, k]
        _turn(cos, sin)
    return (real + 1j * imag).T.copy()


@compiled
def _subtract(start, spacing, signals, omega, amplitudes):
    """Take Re(U exp(i omega t)) of every line from the signals, in place."""
    cos, sin = _rotations(start, spacing, omega)
    real, imag = amplitudes.real.T.copy(), amplitudes.imag.T.copy()
    for n in range(len(signals)):
        for channel in range(signals.shape[1]):
            u = signals[n, channel]
            for k in range(len(omega)):
                u -= real[channel, k] * cos[0, k] - imag[channel, k] * sin[0, k]
            signals[n, channel] = u
        _turn(cos, sin)


def strongest_lines(time, signal, *bands):
    """Frequency and amplitude of the strongest single sine within each band.

    Parameters
    ----------
    time, signal : ndarray, shape (n,)
        Evenly sampled.
    *bands : pair of float
        Where to look (Hz).

    Returns
    -------
    list of tuple of float
        Frequency (Hz) and amplitude, one a band; the amplitude is 0 where the band holds no frequency.

    Notes
    -----
    A Hann window keeps a strong line's skirt from passing for a second line; zero-padding and parabolas through three
    frequencies, twice, place the peak between the bins.
    """
    window = np.hanning(len(signal))
    weighted = (signal - signal.mean()) * window
    step = time[1] - time[0]

    def amplitude(frequencies):
        return 2 * np.abs(_project(0.0, step, weighted[:, None], 2 * np.pi * frequencies)[:, 0]) / window.sum()

    size = scipy.fft.next_fast_len(8 * len(time), real=True)
    frequency = np.fft.rfftfreq(size, step)
    spacing, spectrum = frequency[1], np.abs(np.fft.rfft(weighted, size))
    found = []
    for low, high in bands:
        inside = np.flatnonzero((frequency > low) & (frequency < high))
        if not inside.size:
            found.append((0.5 * (low + high), 0.0))
            continue
        f = frequency[inside[spectrum[inside].argmax()]]
        low, high = max(f - spacing, low), min(f + spacing, high)
        for apart in (spacing / 2, spacing / 32):
            left, middle, right = amplitude(f + apart * np.array([-1.0, 0.0, 1.0]))
            bend = left - 2 * middle + right
            # No peak but a slope, as beside a stronger line outside the band: up to its end.
            f += apart * (left - right) / (2 * bend) if bend < 0 else np.copysign(spacing, right - left)
            f = min(max(f, low), high)
        found.append((float(f), float(amplitude(np.array([f]))[0])))
    return found
