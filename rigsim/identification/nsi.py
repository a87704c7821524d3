"""Nonlinear subspace identification: the extended receptance H_E of Eq. (9) and what it holds.

The nonlinear force is fed back as an input: u = [f, -v1] with v1 = z^3 and z = xs - x,
y = [xs, x]. Then

    H_E = [ H11   k3 (H11 - H21) ]
          [ H21   k3 (H21 - H22) ]

One mass on a spring to the ground has z = x and H_E = [ H11  k3 H11 ]. On a base whose acceleration is the first input,
its column is -(ms H11 + m H21), -(ms H21 + m H22), of which `of_displacements` makes that of a force.

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
_STEP = 1e-3  # of a standard deviation


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
    """H_E at each frequency (n,) in Hz: complex, shape (n, q, 2), first column m/N, second m per m^3.

    ``model`` is a `StateSpace` with inputs [f, -z^3] and q outputs, [xs, x] or [x], ``hold`` what the force did between
    samples and ``conversion`` which columns go through its inverse.
    """
    matrices = (model.A, model.B, model.C, model.D, model.sample_rate, frequency)
    direct = sampled_response(*matrices)
    if conversion == "none":
        return direct
    converted = continuous_response(*matrices, hold)
    return converted if conversion == "all" else np.concatenate([converted[..., :1], direct[..., 1:]], axis=-1)


def of_displacements(extended, frequency, powers, base=False):
    """H_E of displacements to a force, (n, q, 2), from that of outputs to be integrated ``powers`` (q,) times.

    Where the input is the acceleration of a ``base``, a displacement is relative to it and an acceleration is not, and
    the force is one on the first mass, which is 1 then.
    """
    if base:
        extended = extended - np.equal(powers, 2)[:, None] * np.array([1.0, 0.0])
    extended = extended / (2j * np.pi * frequency[:, None, None]) ** np.array(powers)[:, None]
    return _from_base(extended) if base else extended


def _from_base(extended):
    """H_E of a force on the first mass, which is 1, from that of the acceleration of a base."""
    first = -extended[..., 0]
    if extended.shape[1] == 1:
        return np.stack([first, extended[..., 1]], axis=-1)
    # The springs' column tells k3 H11 - k3 H21 and k3 H21 - k3 H22, the base's how much of each the masses add:
    # k3 times the difference of its rows is one and m times the other, at every frequency.
    one, two = extended[..., 1].T
    rows = np.stack([first[:, 0] - first[:, 1], -two], axis=-1) / np.abs(one)[:, None]
    rows, wanted = np.concatenate([rows.real, rows.imag]), one / np.abs(one)
    m = np.linalg.lstsq(rows, np.concatenate([wanted.real, wanted.imag]), rcond=None)[0][1]
    k3 = (one + m * two) / (first[:, 0] - first[:, 1])
    shaker = (first[:, 0] + m * one / k3) / (1 + m)
    return np.stack([np.stack([shaker, shaker - one / k3], axis=-1), extended[..., 1]], axis=-1)


def across(column):
    """What the spring is stretched by, (n, ...), of columns (n, q, ...): H11 - H21, or H11 alone."""
    return column[:, 0] - column[:, 1] if column.shape[1] == 2 else column[:, 0]


def nonlinear_coefficient(extended):
    """k3(omega) = H_E12 / (H_E11 - H_E21), complex, shape (n,) (N/m^3), from H_E of shape (n, q, 2)."""
    return extended[:, 0, 1] / across(extended[..., 0])


def coefficient_deviation(extended, deviations, frequency, powers, base):
    """Standard deviation of the real part of k3(omega), (n,), from columns of that of H_E (n, q, 2, columns).

    Both are of the outputs as they were measured; see `of_displacements`.
    """
    moved = []
    for column in np.moveaxis(deviations, -1, 0):
        both = (of_displacements(extended + _STEP * sign * column, frequency, powers, base) for sign in (1, -1))
        one, other = (nonlinear_coefficient(each).real for each in both)
        moved.append((one - other) / (2 * _STEP))
    return np.linalg.norm(moved, axis=0)


def underlying_receptance(extended):
    """Receptance of the underlying linear system (m/N), shape (n, q, q), from H_E: H22 = H21 - H_E22/k3(omega)."""
    if extended.shape[1] == 1:
        return extended[..., :1]
    cross = extended[:, 1, 0]
    own = cross - extended[:, 1, 1] / nonlinear_coefficient(extended)
    return np.stack([extended[:, 0, 0], cross, cross, own], axis=-1).reshape(-1, 2, 2)


def extended_from(receptance, k3):
    """H_E, shape (n, q, 2), of a receptance (n, q, q) in m/N and one coefficient (N/m^3)."""
    return np.stack([receptance[..., 0], k3 * across(receptance)], axis=-1)
