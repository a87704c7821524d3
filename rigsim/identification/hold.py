"""From sampled to continuous receptances: the inverse of a held input.

With Ac = log(A)/dt and phi1(M) = (e^M - 1)/M, an input held at its value for a sample dt
enters the state as B = dt phi1(Ac dt) Bc. One that runs straight from sample to sample
enters as B = dt phi1(Ac dt)^2 Bc, and through D = Dc + C dt phi2(Ac dt) Bc with
phi2(M) = (e^M - 1 - M)/M^2, in coordinates where y[r] needs no u[r+1].
"""

import numpy as np


def sampled_response(A, B, C, D, sample_rate, frequency):
    """D + C (e^{i omega dt} - A)^{-1} B of Eq. (9) at each frequency (n,) in Hz, shape (n, q, p).

    A, B, C and D are the matrices of Eq. (8) with q outputs and p inputs, at ``sample_rate`` samples a second.
    """
    points = np.exp(2j * np.pi * frequency / sample_rate)
    resolvent = points[:, None, None] * np.eye(len(A)) - A
    return D + C @ np.linalg.solve(resolvent, np.broadcast_to(B, (points.size, *B.shape)))


def continuous_response(A, B, C, D, sample_rate, frequency, hold):
    """Response of the continuous system behind a held input, shape (n, q, p); otherwise as `sampled_response`.

    ``hold`` says what the inputs did between samples. A band-limited one leaves no gap: the response is read directly.
    """
    if hold == "band-limited":
        return sampled_response(A, B, C, D, sample_rate, frequency)
    # Pole by pole, in the time unit dt; the poles of an identified model are distinct.
    values, vectors = np.linalg.eig(A)
    poles = np.log(values.astype(complex))
    phi1, phi2 = _phi(poles)
    entering = np.linalg.solve(vectors, B) / (phi1 if hold == "zero" else phi1**2)[:, None]
    observed = C @ vectors
    if hold == "linear":
        D = D - observed @ (phi2[:, None] * entering)
    points = 2j * np.pi * frequency / sample_rate
    return D + (observed / (points[:, None, None] - poles)) @ entering


def _phi(values):
    """phi1 and phi2 of each value; the second by its series where the difference would cancel."""
    small = np.abs(values) < 1e-3
    divisor = np.where(small, 1.0, values)
    series = 1 / 2 + values / 6 + values**2 / 24 + values**3 / 120
    phi2 = np.where(small, series, (np.expm1(values) - values) / divisor**2)
    return 1 + values * phi2, phi2
