"""Nonlinear subspace identification: the extended receptance H_E of Eq. (9) and what it holds.

The nonlinear force is fed back as an input: u = [f, -v1] with v1 = z^3 and z = xs - x,
y = [xs, x]. Then

    H_E = [ H11   k3 (H11 - H21) ]
          [ H21   k3 (H21 - H22) ]

The force was held between samples and v1 was not, so the two columns are to be read
differently. ``conversion`` says how:

"force"
    the force's column through the inverse of its hold, the column of v1 directly. Right.
"all"
    both columns through the inverse of the hold, which is what the paper's figures show.
"none"
    both columns directly, Eq. (9) as printed.

With theta = omega dt/2 and a force held at its value, "all" and "none" multiply the
coefficient by theta cot(theta) + i theta; with a force that runs straight from sample to
sample, by (theta / sin(theta))^2.
"""

import numpy as np

from .hold import continuous_response, sampled_response

CONVERSIONS = ("force", "all", "none")


def extended_inputs(force, relative):
    """u = [f, -z^3], shape (n, 2), from force (N) and relative displacement (m), each of shape (n,)."""
    return np.column_stack([force, -(relative * relative * relative)])


def folded_share(relative, sample_rate, band):
    """Share of the lines of z^3 over ``band`` (a pair in Hz) that came from above half the sample rate.

    Against the cube of z laid out twice as finely, whose lines reach the band only from above 3/2 the sample rate.
    """
    n = relative.size
    smooth = relative * np.hanning(n)  # the ends of the record would ring between the samples
    finer = 2 * np.fft.irfft(np.fft.rfft(smooth), 2 * n)
    lines = slice(int(band[0] * n / sample_rate), int(band[1] * n / sample_rate) + 1)
    folded, true = np.fft.rfft(smooth**3)[lines], np.fft.rfft(finer**3)[lines] / 2
    return float(np.linalg.norm(folded - true) / np.linalg.norm(true))


def extended_receptance(model, frequency, hold="zero", conversion="force"):
    """H_E at each frequency (n,) in Hz: complex, shape (n, 2, 2), first column m/N, second m per m^3.

    ``model`` is a `StateSpace` with inputs [f, -z^3] and outputs [xs, x], ``hold`` what the force did between samples
    and ``conversion`` which columns go through its inverse.
    """
    matrices = (model.A, model.B, model.C, model.D, model.sample_rate, frequency)
    direct = sampled_response(*matrices)
    if conversion == "none":
        return direct
    converted = continuous_response(*matrices, hold)
    return converted if conversion == "all" else np.concatenate([converted[..., :1], direct[..., 1:]], axis=-1)


def nonlinear_coefficient(extended):
    """k3(omega) = H_E12 / (H_E11 - H_E21), complex, shape (n,) (N/m^3), from H_E of shape (n, 2, 2)."""
    return extended[:, 0, 1] / (extended[:, 0, 0] - extended[:, 1, 0])


def underlying_receptance(extended):
    """Receptance of the underlying linear system (m/N), shape (n, 2, 2), from H_E: H22 = H21 - H_E22/k3(omega)."""
    cross = extended[:, 1, 0]
    own = cross - extended[:, 1, 1] / nonlinear_coefficient(extended)
    return np.stack([extended[:, 0, 0], cross, cross, own], axis=-1).reshape(-1, 2, 2)


def extended_from(receptance, k3):
    """H_E, shape (n, 2, 2), of a receptance of that shape (m/N) and one coefficient (N/m^3)."""
    return np.stack([receptance[..., 0], k3 * (receptance[..., 0] - receptance[..., 1])], axis=-1)
