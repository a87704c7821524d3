"""Lines of a spectrum by least squares: sines of known frequency, and the one that stands out of what is left."""

import numpy as np
import scipy.fft
import scipy.linalg

from ..compiled import compiled


def fit_sines(time, signals, frequencies):
    """Least-squares mean and complex amplitudes of sines of given frequencies, fitted together.

    ``time`` (n,) is evenly spaced (s), ``signals`` (n, channels), ``frequencies`` k in Hz. Returns the amplitudes,
    (k, channels), U of u(t) = Re(U exp(2 pi i f t)), and what they and the mean leave, (n, channels).

    Normal equations with one step of refinement, which makes them as good as QR for sines that the time tells
    apart. Their matrix is known in closed form, and the basis is never stored: each sine is a rotation from sample to
    sample, all of them side by side in vector instructions. BLAS would cost a hundred times the arithmetic where its
    threads wait for each other on a busy machine.
    """
    omega = np.concatenate([[0.0], 2 * np.pi * np.asarray(frequencies, dtype=float)])  # the mean is a line at zero
    spacing = (time[-1] - time[0]) / (len(time) - 1)
    gram = _gram(time[0], spacing, len(time), omega)
    # A trace of ridge, which the refinement takes out again, keeps sines that the time cannot tell apart harmless.
    gram[np.diag_indices_from(gram)] += 1e-12 * len(time)
    factor, _ = scipy.linalg.cho_factor(gram, check_finite=False)
    residual = np.array(signals, order="C")
    total = 0.0
    for _ in range(2):
        sums = _project(time[0], spacing, residual, omega)
        solution, _ = scipy.linalg.lapack.dpotrs(factor, np.concatenate([sums.real, sums.imag[1:]]))
        amplitudes = solution[: len(omega)] + 0j
        amplitudes[1:] -= 1j * solution[len(omega) :]
        _subtract(time[0], spacing, residual, omega, amplitudes)
        total = total + amplitudes
    return total[1:], residual


def _gram(start, spacing, count, omega):
    """Products of the columns [cos, sin (but for the mean)] summed over the samples, by geometric series."""
    plus, minus = (_sum_of_rotations(start, spacing, count, np.add.outer(omega, sign * omega)) for sign in (1, -1))
    cc, ss, cs = (plus + minus).real / 2, (minus - plus).real / 2, (plus - minus).imag / 2
    gram = np.empty((2 * len(omega) - 1,) * 2)
    cosines, sines = slice(len(omega)), slice(len(omega), None)
    gram[cosines, cosines], gram[sines, sines] = cc, ss[1:, 1:]
    gram[cosines, sines], gram[sines, cosines] = cs[:, 1:], cs[:, 1:].T
    return gram


def _sum_of_rotations(start, spacing, count, omega):
    """Sum over the samples of exp(i omega t)."""
    half = omega * spacing / 2
    nearly_zero = np.abs(np.sin(half)) < 1e-14
    kernel = np.where(nearly_zero, count, np.sin(count * half) / np.where(nearly_zero, 1.0, np.sin(half)))
    return kernel * np.exp(1j * (omega * start + (count - 1) * half))


@compiled
def _turn(cos, sin, turn_cos, turn_sin):
    """Rotate every line to the next sample."""
    for k in range(len(cos)):
        real = cos[k] * turn_cos[k] - sin[k] * turn_sin[k]
        sin[k] = cos[k] * turn_sin[k] + sin[k] * turn_cos[k]
        cos[k] = real


@compiled(nogil=True)
def _project(start, spacing, signals, omega):
    """Sums over the samples of u exp(i omega t), complex, shape (lines, channels)."""
    cos, sin, turn = np.cos(omega * start), np.sin(omega * start), omega * spacing
    real, imag = np.zeros((signals.shape[1], len(omega))), np.zeros((signals.shape[1], len(omega)))
    turn_cos, turn_sin = np.cos(turn), np.sin(turn)
    for n in range(len(signals)):
        for channel in range(signals.shape[1]):
            u = signals[n, channel]
            for k in range(len(omega)):
                real[channel, k] += u * cos[k]
                imag[channel, k] += u * sin[k]
        _turn(cos, sin, turn_cos, turn_sin)
    return (real + 1j * imag).T


@compiled(nogil=True)
def _subtract(start, spacing, signals, omega, amplitudes):
    """Take Re(U exp(i omega t)) of every line from the signals, in place."""
    cos, sin, turn = np.cos(omega * start), np.sin(omega * start), omega * spacing
    real, imag = amplitudes.real.T.copy(), amplitudes.imag.T.copy()
    turn_cos, turn_sin = np.cos(turn), np.sin(turn)
    for n in range(len(signals)):
        for channel in range(signals.shape[1]):
            for k in range(len(omega)):
                signals[n, channel] -= real[channel, k] * cos[k] - imag[channel, k] * sin[k]
        _turn(cos, sin, turn_cos, turn_sin)


def strongest_lines(time, signal, *bands):
    """Frequency (Hz) and amplitude of the strongest sine of a signal (n,), evenly sampled, within each band (Hz, Hz).

    The amplitude is 0 where the band holds no frequency. A Hann window keeps a strong line's skirt from passing for a
    second line; zero-padding and parabolas through three frequencies, twice, place the peak between the bins.
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
