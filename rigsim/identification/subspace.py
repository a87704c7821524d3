"""State-space models from records: PO-MOESP on an extended Gram matrix, Eq. (8).

The block Hankel matrix of a long record is never formed. Its Gram matrix follows from
the correlations of the record with itself, one block row, by the shift recursion

    G[a+1, b+1] = G[a, b] + w[n+a] w[n+b]^T - w[a] w[b]^T,

where G[a, b] is the sum of w[a+j] w[b+j]^T over the n Hankel columns j. A triangular
square root of G then stands for the LQ factor of the Hankel matrix (P. Van Overschee and
B. De Moor, Subspace Identification for Linear Systems, 1996, chapter 6; M. Verhaegen,
Automatica 30, 1994, for the weights).
"""

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from ..campaign.stop import sliced
from ..compiled import compiled

_SLICE = 20_000  # samples at a time, some 0.1 s


@dataclass(frozen=True, eq=False)
class StateSpace:
    """x[r+1] = A x[r] + B u[r], y[r] = C x[r] + D u[r] + offset, Eq. (8), with o states, p inputs, q outputs.

    Attributes
    ----------
    A, B, C, D : ndarray, shapes (o, o), (o, p), (q, o), (q, p)
        The matrices, in the units of inputs and outputs.
    start : ndarray, shape (o,)
        State at the first sample.
    offset : ndarray, shape (q,)
        Constant part of the outputs.
    sample_rate : float
        Samples a second (Hz).
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    start: np.ndarray
    offset: np.ndarray
    sample_rate: float

    def simulate(self, inputs):
        """Outputs, shape (n, q), for ``inputs`` of shape (n, p)."""
        inputs, state = np.ascontiguousarray(inputs), self.start.copy()
        matrices = self.A, self.B, self.C, self.D, self.offset
        return np.concatenate([_simulate(*matrices, state, inputs[part]) for part in sliced(len(inputs), _SLICE)])


def identify_state_space(inputs, outputs, sample_rate, order, block_rows):
    """State-space model of ``order`` states that turns ``inputs`` into ``outputs``.

    The channels, (n, p) and (n, q), are sampled at ``sample_rate`` (Hz) and each varies; ``block_rows`` are those of
    the past and of the future, at least one more than ``order / q``. Constant offsets of any channel are projected out
    exactly, and come back as the model's ``offset``. Poles outside the unit circle are mirrored into it.

    Returns the `StateSpace` and the singular values (block_rows q,) of the projected future outputs, channels scaled to
    unit deviation: a jump after the ``order``-th tells the order of the system.
    """
    p, q = inputs.shape[1], outputs.shape[1]
    channels = np.hstack([inputs, outputs])
    deviation = channels.std(axis=0)
    channels = (channels - channels.mean(axis=0)) / deviation
    observability, singular_values = _observability(channels, p, order, block_rows)

    C = observability[:q]
    A = _stable(np.linalg.lstsq(observability[:-q], observability[q:], rcond=None)[0])
    return fit_input_matrices(A, deviation[p:, None] * C, inputs, outputs, sample_rate), singular_values


def fit_input_matrices(A, C, inputs, outputs, sample_rate):
    """The `StateSpace` of given A and C whose B, D, start and offset fit the record best, by least squares in time.

    Every eigenvalue of A (o, o) is inside the unit circle. The record is ``inputs`` (n, p) and ``outputs`` (n, q) at
    ``sample_rate`` (Hz); each output counts in proportion to its deviation.
    """
    (order, p), q = (len(A), inputs.shape[1]), len(C)
    to_inputs, to_outputs = 1 / inputs.std(axis=0), outputs.std(axis=0)
    mean = outputs.mean(axis=0)
    scaled = np.ascontiguousarray(C / to_outputs[:, None])
    triangle = _triangle(A, scaled, inputs * to_inputs, (outputs - mean) / to_outputs)
    scale = np.linalg.norm(triangle[:, :-1], axis=0)
    solution = np.linalg.lstsq(triangle[:, :-1] / scale, triangle[:, -1], rcond=None)[0] / scale
    start, B, D, offset = np.split(solution, np.cumsum([order, p * order, p * q]))
    B = B.reshape(p, order).T * to_inputs
    D = to_outputs[:, None] * D.reshape(p, q).T * to_inputs
    return StateSpace(A, B, C, D, start, mean + to_outputs * offset, sample_rate)


def extended_gram(channels, block_rows):
    """Gram matrix (block_rows c, block_rows c) of the block Hankel matrix of ``channels``, each row about its mean.

    Row j of ``channels`` (samples, c) is w[j]; the Hankel matrix has n = samples - block_rows + 1 columns.
    """
    samples, c = channels.shape
    n = samples - block_rows + 1
    gram = np.empty((block_rows, c, block_rows, c))
    for b in range(block_rows):
        gram[0, :, b] = channels[:n].T @ channels[b : b + n]
    head, tail = channels[: block_rows - 1], channels[n:]
    for a in range(block_rows - 1):
        added = np.einsum("i,bj->ibj", tail[a], tail[a:]) - np.einsum("i,bj->ibj", head[a], head[a:])
        gram[a + 1, :, a + 1 :] = gram[a, :, a:-1] + added
    for a in range(1, block_rows):
        gram[a, :, :a] = gram[:a, :, a].transpose(2, 0, 1)
    sums = channels[:n].sum(axis=0) + np.vstack([np.zeros(c), np.cumsum(tail - head, axis=0)])
    gram -= np.einsum("ai,bj->aibj", sums, sums / n)
    return gram.reshape(block_rows * c, block_rows * c)


def _observability(channels, p, order, block_rows):
    """Extended observability matrix, shape (block_rows q, order), and all singular values."""
    c = channels.shape[1]
    gram = extended_gram(channels, 2 * block_rows)
    past, future = np.arange(2 * block_rows * c).reshape(2, block_rows, c)
    sorted_rows = np.concatenate([future[:, :p].ravel(), past.ravel(), future[:, p:].ravel()])
    # A Cholesky factor does not exist when the record is clean, since G is then singular to rounding.
    values, vectors = linalg.eigh(gram[np.ix_(sorted_rows, sorted_rows)])
    root = vectors * np.sqrt(np.clip(values, 0.0, None))
    lower = linalg.qr(root.T, mode="r")[0].T
    first, second = block_rows * p, block_rows * (p + c)
    left, singular_values, _ = linalg.svd(lower[second:, first:second], full_matrices=False)
    return left[:, :order] * np.sqrt(singular_values[:order]), singular_values


def _stable(A):
    """A with every eigenvalue outside the unit circle mirrored into it."""
    values, vectors = np.linalg.eig(A)
    size = np.abs(values)
    if (size < 1).all():
        return A
    mirrored = np.where(size < 1, values, values / np.maximum(size, 1 + 1e-9) ** 2)
    return np.real(vectors * mirrored @ np.linalg.inv(vectors))


def _triangle(A, C, inputs, outputs):
    """Triangular factor of [regressors, outputs], a row rotated in at a time so that none is stored.

    The regressors of output i at sample r: C A^r, C sum A^(r-1-s) u_j[s], u_j[r] and one,
    which multiply the first state, column j of B, column j of D and the offset.
    """
    p, (q, order) = inputs.shape[1], C.shape
    size = order + p * order + p * q + q + 1
    triangle, free, forced = np.zeros((size, size)), np.eye(order), np.zeros((p, order, order))
    for part in sliced(len(inputs), _SLICE):
        _rotate_rows_in(triangle, free, forced, A, C, inputs[part], outputs[part])
    return triangle


@compiled
def _rotate_rows_in(triangle, free, forced, A, C, inputs, outputs):
    """The next rows of `_triangle`; ``free`` (A^r) and ``forced`` (a matrix an input) go on from sample to sample."""
    (samples, p), (q, order) = inputs.shape, C.shape
    last = triangle.shape[0] - 1
    row = np.empty(last + 1)
    for r in range(samples):
        for i in range(q):
            row[:] = 0.0
            for t in range(order):
                for s in range(order):
                    row[s] += C[i, t] * free[t, s]
                    for j in range(p):
                        row[order + j * order + s] += C[i, t] * forced[j, t, s]
            for j in range(p):
                row[order + p * order + j * q + i] = inputs[r, j]
            row[last - q + i] = 1.0
            row[last] = outputs[r, i]
            _rotate_in(triangle, row)
        free[:] = _times(A, free)
        for j in range(p):
            forced[j] = _times(A, forced[j])
            for s in range(order):
                forced[j, s, s] += inputs[r, j]


@compiled
def _rotate_in(triangle, row):
    """Givens rotations that take one more row into an upper triangle; ``row`` is used up."""
    for k in range(row.size):
        if row[k] != 0.0:
            size = np.hypot(triangle[k, k], row[k])
            cosine, sine = triangle[k, k] / size, row[k] / size
            for j in range(k, row.size):
                above = triangle[k, j]
                triangle[k, j] = cosine * above + sine * row[j]
                row[j] = cosine * row[j] - sine * above


@compiled
def _times(left, right):
    product = np.zeros_like(right)
    for i in range(left.shape[0]):
        for k in range(left.shape[1]):
            for j in range(right.shape[1]):
                product[i, j] += left[i, k] * right[k, j]
    return product


@compiled
def _simulate(A, B, C, D, offset, state, inputs):
    """Outputs (n, q) from a ``state``, which becomes the one after them."""
    order, q, p = A.shape[0], C.shape[0], B.shape[1]
    outputs, following = np.empty((inputs.shape[0], q)), np.empty(order)
    for r in range(inputs.shape[0]):
        for i in range(q):
            total = offset[i]
            for s in range(order):
                total += C[i, s] * state[s]
            for j in range(p):
                total += D[i, j] * inputs[r, j]
            outputs[r, i] = total
        for s in range(order):
            total = 0.0
            for t in range(order):
                total += A[s, t] * state[t]
            for j in range(p):
                total += B[s, j] * inputs[r, j]
            following[s] = total
        state[:] = following
    return outputs
