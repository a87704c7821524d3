"""Refinement of a state-space model by Gauss-Newton steps on the record's lines in a band.

A subspace estimate does not weigh its misfit by the outputs' noise, and what it loses is
largest where a record says least: the force of the suspension on the shaker. On the lines
of the discrete Fourier transform a finite record obeys, without leakage,

    Y = [C (z - A)^{-1} B + D] U + C (z - A)^{-1} z (x[0] - x[n]),

so the squared misfit, each output over its own residual, is minimised over A, B, C, D and
the transient x[0] - x[n], one for each test where the record is made of several. The choice of
states leaves as many directions flat as A has entries; least squares of least norm does not move along them.
"""

from dataclasses import replace

import numpy as np

from ..experiment.joints import slices
from .subspace import StateSpace, least_squares, stack

STEPS = 4  # a subspace estimate is near enough for the second step to reach rounding on the paper's record
FLAT = 1e-10  # relative size below which a direction counts as flat
_LINES = 1000  # at a time, whose columns stay in the processor's cache


def fit_to_lines(A, C, inputs, outputs, sample_rate, band, joints=(0,)):
    """The `StateSpace` of given A and C whose B and D fit the record's lines in the band best; it starts at zero.

    Each output counts in proportion to its lines; arguments as those of `refine_state_space` and `StateSpace`.
    """
    (order, p), q = (len(A), inputs.shape[1]), len(C)
    U, Y, z, ends = _band_lines(inputs, outputs, sample_rate, band, joints)
    zeros = (A, np.zeros((order, p)), C, np.zeros((q, p)), np.zeros((order, len(joints))))
    _, B, _, D, _ = _moved(zeros, U, Y, z, ends, np.linalg.norm(Y, axis=0), (1, 3, 4))
    return StateSpace(A, B, C, D, np.zeros(order), np.zeros(q), sample_rate)


def refine_state_space(model, inputs, outputs, band, joints=(0,)):
    """A, B, C and D nearer to the record over ``band`` (a pair in Hz); start and offset are the given model's.

    The record is ``inputs`` (n, p) and ``outputs`` (n, q), and ``joints`` are the first samples of its tests.

    Returns
    -------
    model : StateSpace
        The given one where no step lowers the misfit.
    noise, unexplained : ndarray, shape (q,)
        Rms of what the given model left of a line of each output, and the same as a share of the output's lines.
    """
    U, Y, z, ends = _band_lines(inputs, outputs, model.sample_rate, band, joints)
    matrices = (model.A, model.B, model.C, model.D, np.zeros((len(model.A), len(joints))))
    # The transient alone first: without it the outputs' residuals would not be their noise.
    matrices = _moved(matrices, U, Y, z, ends, np.ones(len(model.C)), (4,))
    size = np.sqrt(np.mean(np.abs(Y) ** 2, axis=0))
    squares = _squares(matrices, U, Y, z, ends)
    noise = np.maximum(np.sqrt(squares / len(z)), 1e-12 * size)
    cost = np.sum(squares / noise**2)

    for _ in range(STEPS):
        moved = _moved(matrices, U, Y, z, ends, noise, range(5))
        moved_cost = np.sum(_squares(moved, U, Y, z, ends) / noise**2)
        if not moved_cost < cost or np.abs(np.linalg.eigvals(moved[0])).max() >= 1:
            break
        settled = cost - moved_cost < 1e-9 * cost
        matrices, cost = moved, moved_cost
        if settled:
            break
    A, B, C, D, _ = matrices
    return replace(model, A=A, B=B, C=C, D=D), noise, noise / size


def _band_lines(inputs, outputs, sample_rate, band, joints):
    """Lines in the band of all tests: inputs (m, p), outputs (m, q), where on the unit circle, and z times whose."""
    U, Y, z, ends = [], [], [], []
    for number, test in enumerate(slices(joints, len(inputs))):
        n = test.stop - test.start
        lines = np.arange(n // 2 + 1)
        hertz = lines * sample_rate / n
        lines = lines[(hertz >= band[0]) & (hertz <= band[1])]
        for found, channels in ((U, inputs), (Y, outputs)):
            found.append(np.column_stack([np.fft.rfft(channel[test])[lines] for channel in channels.T]))
        z.append(np.exp(2j * np.pi * lines / n))
        ends.append(z[-1][:, None] * (np.arange(len(joints)) == number))
    return tuple(np.concatenate(found) for found in (U, Y, z, ends))


def _moved(matrices, U, Y, z, ends, noise, free):
    """A, B, C, D and the transients after one Gauss-Newton step of the ``free`` ones among them, by their numbers."""
    shapes = [matrices[number].shape for number in free]
    triangle = _factor(matrices, U, Y, z, ends, noise, free)
    step = np.split(least_squares(triangle, FLAT), np.cumsum([np.prod(shape) for shape in shapes])[:-1])
    moved = list(matrices)
    for number, shape, change in zip(free, shapes, step, strict=True):
        moved[number] = matrices[number] + change.reshape(shape)
    return tuple(moved)


def _factor(matrices, U, Y, z, ends, noise, free):
    """Triangular factor of the derivatives of all lines over their noise, and of what is left of them."""
    triangle = np.zeros((0, 1 + sum(matrices[number].size for number in free)))
    for begin in range(0, len(z), _LINES):
        part = slice(begin, begin + _LINES)
        modelled, columns = _lines(matrices, U[part], z[part], ends[part], free)
        rows = np.concatenate([columns, (Y[part] - modelled)[..., None]], axis=-1) / noise[:, None]
        rows = rows.reshape(-1, rows.shape[-1])
        triangle = stack(triangle, np.concatenate([rows.real, rows.imag]))
    return triangle


def response_deviations(model, inputs, outputs, noise, band, joints, frequency):
    """Columns whose products are the covariance of D + C (z - A)^-1 B, shape (n, q, p, columns), at ``frequency`` (n,).

    What white ``noise`` (q,), the rms of a line of each output, does to a refined model; other arguments as of
    `refine_state_space`.
    """
    U, Y, z, ends = _band_lines(inputs, outputs, model.sample_rate, band, joints)
    matrices = (model.A, model.B, model.C, model.D, np.zeros((len(model.A), len(joints))))
    triangle = _factor(matrices, U, Y, z, ends, noise, range(5))[:-1, :-1]
    scale = np.linalg.norm(triangle, axis=0)
    _, values, vectors = np.linalg.svd(triangle / scale)
    kept = values > FLAT * values[0]  # the choice of states leaves the others flat, and the response as it is
    # Half the power of a line's noise is in its real part.
    root = vectors[kept].T / values[kept] / scale[:, None] / np.sqrt(2)
    z, nothing = np.exp(2j * np.pi * frequency / model.sample_rate), np.zeros((frequency.size, len(joints)))
    units = (np.tile(one, (frequency.size, 1)) for one in np.eye(inputs.shape[1]))
    return np.stack([_lines(matrices, unit, z, nothing)[1] @ root for unit in units], axis=2)


def _squares(matrices, U, Y, z, ends):
    """Sum of the squares of what the matrices leave of the lines of each output, shape (q,)."""
    parts = [slice(begin, begin + _LINES) for begin in range(0, len(z), _LINES)]
    rest = (Y[part] - _lines(matrices, U[part], z[part], ends[part], ())[0] for part in parts)
    return sum(np.sum(np.abs(left) ** 2, axis=0) for left in rest)


def _lines(matrices, U, z, ends, free=range(5)):
    """Modelled outputs, shape (n, q), and their derivatives by the ``free`` of A, B, C, D and the transients.

    Those are of shape (n, q, columns).
    """
    A, B, C, D, transients = matrices
    q, n = len(C), len(z)
    poles, vectors = np.linalg.eig(A)
    apart = 1 / (z[:, None] - poles)
    observed = (apart[:, None, :] * (C @ vectors)) @ np.linalg.inv(vectors)
    entering = np.linalg.solve(vectors, np.hstack([B, transients]))
    states = (apart * (np.hstack([U, ends]) @ entering.T)) @ vectors.T
    outputs = states @ C.T + U @ D.T
    columns = {
        0: lambda: observed[..., None] * states[:, None, None],
        1: lambda: observed[..., None] * U[:, None, None],
        2: lambda: np.eye(q)[..., None] * states[:, None, None],
        3: lambda: np.eye(q)[..., None] * U[:, None, None],
        4: lambda: observed[..., None] * ends[:, None, None],
    }
    parts = [columns[number]().reshape(n, q, -1) for number in free]
    return outputs, np.concatenate(parts, axis=-1) if parts else None
