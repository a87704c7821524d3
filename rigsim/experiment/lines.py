"""Lines of a spectrum by least squares: sines of known frequency, and the one that stands out of what is left."""

import numpy as np
import scipy.linalg
import scipy.optimize


def fit_sines(time, signals, frequencies):
    """Least-squares mean and complex amplitudes of sines of given frequencies, fitted together.

    Parameters
    ----------
    time : ndarray, shape (n,)
        s.
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
    apart. QR calls BLAS once a column: where its threads wait for each other on a busy machine, that costs a
    hundred times the arithmetic.
    """
    phase = 2 * np.pi * np.outer(time, frequencies)
    basis = np.hstack([np.ones((len(time), 1)), np.cos(phase), np.sin(phase)])
    gram = basis.T @ basis
    solution, residual = 0.0, signals
    for _ in range(2):
        solution = solution + scipy.linalg.lstsq(gram, basis.T @ residual, lapack_driver="gelsy", check_finite=False)[0]
        residual = signals - basis @ solution
    cosine, sine = np.split(solution[1:], 2)
    return cosine - 1j * sine, residual


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
    window = np.hanning(len(signal))
    weighted = (signal - signal.mean()) * window

    def amplitude(f):
        return 2 * abs(weighted @ np.exp(-2j * np.pi * f * (time - time[0]))) / window.sum()

    spacing = 1 / (8 * len(time) * (time[1] - time[0]))
    frequency = np.arange(8 * len(time) // 2 + 1) * spacing
    spectrum = np.abs(np.fft.rfft(weighted, 8 * len(time)))[: len(frequency)]
    inside = (frequency > band[0]) & (frequency < band[1])
    if not inside.any():
        return 0.5 * (band[0] + band[1]), 0.0
    start = frequency[inside][spectrum[inside].argmax()]
    found = scipy.optimize.minimize_scalar(
        lambda f: -amplitude(f), bounds=(max(start - spacing, band[0]), min(start + spacing, band[1])), method="bounded"
    )
    return float(found.x), float(-found.fun)
