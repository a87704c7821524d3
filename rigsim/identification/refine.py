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

STEPS = 4  # a subspace estimate is near enough for the second step to reach rounding on the paper's record
FLAT = 1e-10  # relative size below which a direction counts as flat


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
    n = len(inputs)
    lines = np.arange(n // 2 + 1)
    hertz = lines * model.sample_rate / n
    lines = lines[(hertz >= band[0]) & (hertz <= band[1])]
    z = np.exp(2j * np.pi * lines / n)
    U, Y = (np.fft.rfft(channels, axis=0)[lines] for channels in (inputs, outputs))

    matrices = (model.A, model.B, model.C, model.D, np.zeros((len(model.A), 1)))
    shapes = [matrix.shape for matrix in matrices]
    ends = np.cumsum([np.prod(shape) for shape in shapes])

    # The transient alone first: without it the outputs' residuals would not be their noise.
    _, columns = _lines(matrices, U, z)
    transient = _solve(columns[..., ends[3] :], Y - _lines(matrices, U, z)[0])
    matrices = (*matrices[:4], transient[:, None])
    misfit = Y - _lines(matrices, U, z)[0]
    size = np.sqrt(np.mean(np.abs(Y) ** 2, axis=0))
    noise = np.maximum(np.sqrt(np.mean(np.abs(misfit) ** 2, axis=0)), 1e-12 * size)
    cost = np.sum(np.abs(misfit / noise) ** 2)

    for _ in range(STEPS):
        modelled, columns = _lines(matrices, U, z)
        step = _solve(columns / noise[:, None], (Y - modelled) / noise)
        changes = (part.reshape(shape) for part, shape in zip(np.split(step, ends[:-1]), shapes, strict=True))
        moved = tuple(matrix + change for matrix, change in zip(matrices, changes, strict=True))
        moved_cost = np.sum(np.abs((Y - _lines(moved, U, z)[0]) / noise) ** 2)
        if not moved_cost < cost or np.abs(np.linalg.eigvals(moved[0])).max() >= 1:
            break
        settled = cost - moved_cost < 1e-9 * cost
        matrices, cost = moved, moved_cost
        if settled:
            break
    A, B, C, D, _ = matrices
    return replace(model, A=A, B=B, C=C, D=D), noise, noise / size


def _lines(matrices, U, z):
    """Modelled outputs, shape (n, q), and their derivatives by A, B, C, D and the transient, shape (n, q, columns)."""
    A, B, C, D, transient = matrices
    (order, p), q, n = B.shape, len(C), len(z)
    resolvent = np.linalg.inv(z[:, None, None] * np.eye(order) - A)
    states = np.einsum("nst,nt->ns", resolvent, U @ B.T + z[:, None] * transient[:, 0])
    observed = C @ resolvent
    outputs = states @ C.T + U @ D.T
    columns = [
        np.einsum("nqs,nt->nqst", observed, states).reshape(n, q, order * order),
        np.einsum("nqs,nj->nqsj", observed, U).reshape(n, q, order * p),
        np.einsum("qi,nt->nqit", np.eye(q), states).reshape(n, q, q * order),
        np.einsum("qi,nj->nqij", np.eye(q), U).reshape(n, q, q * p),
        observed * z[:, None, None],
    ]
    return outputs, np.concatenate(columns, axis=-1)


def _solve(columns, misfit):
    """Real least squares of least norm, columns scaled alike."""
    columns = columns.reshape(-1, columns.shape[-1])
    columns = np.concatenate([columns.real, columns.imag])
    misfit = np.concatenate([misfit.real.ravel(), misfit.imag.ravel()])
    scale = np.linalg.norm(columns, axis=0)
    return np.linalg.lstsq(columns / scale, misfit, rcond=FLAT)[0] / scale
