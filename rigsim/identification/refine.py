"""Refinement of a state-space model by Gauss-Newton steps on the record's lines in a band.

A subspace estimate does not weigh its misfit by the outputs' noise, and what it loses is
largest where a record says least: the force of the suspension on the shaker. On the lines
of the discrete Fourier transform a finite record obeys, without leakage,

    Y = [C (z - A)^{-1} B + D] U + C (z - A)^{-1} z (x[0] - x[n]),

so the squared misfit, each output over its own residual, is minimised over A, B, C, D and
the transient x[0] - x[n]. The choice of states leaves as many directions flat as A has
entries; least squares of least norm does not move along them.
"""

from dataclasses import replace

import numpy as np

from .subspace import StateSpace, least_squares, stack

STEPS = 4  # a subspace estimate is near enough for the second step to reach rounding on the paper's record
FLAT = 1e-10  # relative size below which a direction counts as flat
_LINES = 1000  # at a time, whose columns stay in the processor's cache


def fit_to_lines(A, C, inputs, outputs, sample_rate, band):
    """The `StateSpace` of given A and C whose B and D fit the record's lines in the band best; it starts at zero.

    Each output counts in proportion to its lines; arguments as those of `refine_state_space` and `StateSpace`.
    """
    (order, p), q = (len(A), inputs.shape[1]), len(C)
    U, Y, z = _band_lines(inputs, outputs, sample_rate, band)
    zeros = (A, np.zeros((order, p)), C, np.zeros((q, p)), np.zeros((order, 1)))
    _, B, _, D, _ = _moved(zeros, U, Y, z, np.linalg.norm(Y, axis=0), (1, 3, 4))
    return StateSpace(A, B, C, D, np.zeros(order), np.zeros(q), sample_rate)


def refine_state_space(model, inputs, outputs, band):
    """A, B, C and D nearer to the record over ``band`` (a pair in Hz); start and offset are the given model's.

    The record is ``inputs`` (n, p) and ``outputs`` (n, q).

    Returns
    -------
    model : StateSpace
        The given one where no step lowers the misfit.
    noise, unexplained : ndarray, shape (q,)
        Rms of what the given model left of a line of each output, and the same as a share of the output's lines.
    """
    U, Y, z = _band_lines(inputs, outputs, model.sample_rate, band)
    matrices = (model.A, model.B, model.C, model.D, np.zeros((len(model.A), 1)))
    # The transient alone first: without it the outputs' residuals would not be their noise.
    matrices = _moved(matrices, U, Y, z, np.ones(len(model.C)), (4,))
    size = np.sqrt(np.mean(np.abs(Y) ** 2, axis=0))
    squares = _squares(matrices, U, Y, z)
    noise = np.maximum(np.sqrt(squares / len(z)), 1e-12 * size)
    cost = np.sum(squares / noise**2)

    for _ in range(STEPS):
        moved = _moved(matrices, U, Y, z, noise, range(5))
        moved_cost = np.sum(_squares(moved, U, Y, z) / noise**2)
        if not moved_cost < cost or np.abs(np.linalg.eigvals(moved[0])).max() >= 1:
            break
        settled = cost - moved_cost < 1e-9 * cost
        matrices, cost = moved, moved_cost
        if settled:
            break
    A, B, C, D, _ = matrices
    return replace(model, A=A, B=B, C=C, D=D), noise, noise / size


def _band_lines(inputs, outputs, sample_rate, band):
    """Lines of inputs and outputs in the band, shapes (m, p) and (m, q), and where on the unit circle they are."""
    n = len(inputs)
    lines = np.arange(n // 2 + 1)
    hertz = lines * sample_rate / n
    lines = lines[(hertz >= band[0]) & (hertz <= band[1])]
    U, Y = (np.column_stack([np.fft.rfft(channel)[lines] for channel in channels.T]) for channels in (inputs, outputs))
    return U, Y, np.exp(2j * np.pi * lines / n)


def _moved(matrices, U, Y, z, noise, free):
    """A, B, C, D and the transient after one Gauss-Newton step of the ``free`` ones among them, by their numbers."""
    shapes = [matrices[number].shape for number in free]
    triangle = np.zeros((0, 1 + sum(np.prod(shape) for shape in shapes)))
    for begin in range(0, len(z), _LINES):
        part = slice(begin, begin + _LINES)
        modelled, columns = _lines(matrices, U[part], z[part], free)
        rows = np.concatenate([columns, (Y[part] - modelled)[..., None]], axis=-1) / noise[:, None]
        rows = rows.reshape(-1, rows.shape[-1])
        triangle = stack(triangle, np.concatenate([rows.real, rows.imag]))
    step = np.split(least_squares(triangle, FLAT), np.cumsum([np.prod(shape) for shape in shapes])[:-1])
    moved = list(matrices)
    for number, shape, change in zip(free, shapes, step, strict=True):
        moved[number] = matrices[number] + change.reshape(shape)
    return tuple(moved)


def _squares(matrices, U, Y, z):
    """Sum of the squares of what the matrices leave of the lines of each output, shape (q,)."""
    parts = [slice(begin, begin + _LINES) for begin in range(0, len(z), _LINES)]
    return sum(np.sum(np.abs(Y[part] - _lines(matrices, U[part], z[part], ())[0]) ** 2, axis=0) for part in parts)


def _lines(matrices, U, z, free=range(5)):
    """Modelled outputs, shape (n, q), and their derivatives by the ``free`` of A, B, C, D and the transient.

    Those are of shape (n, q, columns).
    """
    A, B, C, D, transient = matrices
    q, n = len(C), len(z)
    poles, vectors = np.linalg.eig(A)
    apart = 1 / (z[:, None] - poles)
    observed = (apart[:, None, :] * (C @ vectors)) @ np.linalg.inv(vectors)
    entering = np.linalg.solve(vectors, np.hstack([B, transient]))
    states = (apart * (np.hstack([U, z[:, None]]) @ entering.T)) @ vectors.T
    outputs = states @ C.T + U @ D.T
    columns = {
        0: lambda: observed[..., None] * states[:, None, None],
        1: lambda: observed[..., None] * U[:, None, None],
        2: lambda: np.eye(q)[..., None] * states[:, None, None],
        3: lambda: np.eye(q)[..., None] * U[:, None, None],
        4: lambda: observed * z[:, None, None],
    }
    parts = [columns[number]().reshape(n, q, -1) for number in free]
    return outputs, np.concatenate(parts, axis=-1) if parts else None
