"""From sampled to continuous receptances: the inverse of a held input.

With Ac = log(A)/dt and phi1(M) = (e^M - 1)/M, an input held at its value for a sample dt
enters the state as B = dt phi1(Ac dt) Bc. One that runs straight from sample to sample
enters as B = dt phi1(Ac dt)^2 Bc, and through D = Dc + C dt phi2(Ac dt) Bc with
phi2(M) = (e^M - 1 - M)/M^2, in coordinates where y[r] needs no u[r+1].
"""

import numpy as np
from scipy import linalg


def sampled_response(A, B, C, D, sample_rate, frequency):
    """D + C (e^{i omega dt} - A)^{-1} B, Eq. (9), shape (n, q, p).

    Parameters
    ----------
    A, B, C, D : ndarray
        Matrices of Eq. (8) with q outputs and p inputs.
    sample_rate : float
        Samples a second (Hz).
    frequency : ndarray, shape (n,)
        Hz.
    """
    return _response(A, B, C, D, np.exp(2j * np.pi * frequency / sample_rate))


def continuous_response(A, B, C, D, sample_rate, frequency, hold):
    """Response of the continuous system behind a held input, shape (n, q, p); otherwise as `sampled_response`.

    Parameters
    ----------
    hold : {"zero", "linear", "band-limited"}
        What the inputs did between samples. A band-limited one leaves no gap: the response is read directly.
    """
    if hold == "band-limited":
        return sampled_response(A, B, C, D, sample_rate, frequency)
    logarithm = linalg.logm(A)  # Ac dt
    phi1, phi2 = _phi(logarithm)
    if hold == "zero":
        continuous = np.linalg.solve(phi1, B)
    else:
        continuous = np.linalg.solve(phi1 @ phi1, B)
        D = D - C @ phi2 @ continuous
    # continuous is Bc dt, so that everything stays in the time unit dt.
    return _response(logarithm, continuous, C, D, 2j * np.pi * frequency / sample_rate)


def _response(A, B, C, D, points):
    resolvent = points[:, None, None] * np.eye(len(A)) - A
    return D + C @ np.linalg.solve(resolvent, np.broadcast_to(B, (points.size, *B.shape)))


def _phi(matrix):
    """phi1 and phi2 of a matrix, singular or not, as blocks of one exponential."""
    o = len(matrix)
    block = np.zeros((3 * o, 3 * o), dtype=matrix.dtype)
    block[:o, :o] = matrix
    block[:o, o : 2 * o] = block[o : 2 * o, 2 * o :] = np.eye(o)
    exponential = linalg.expm(block)
    return exponential[:o, o : 2 * o], exponential[:o, 2 * o :]
