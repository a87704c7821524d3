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
_ROWS, _GROUP = 1000, 16  # samples whose regressors, and whose products, stay in the processor's cache


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


def dynamics(gram, deviation, p, order):
    """A, C and all singular values from the extended Gram matrix of channels, of which the first ``p`` are inputs.

    The channels were divided by ``deviation`` (c,), and C is in the units they had before. Constant offsets of any
    channel are projected out exactly; poles outside the unit circle are mirrored into it. A jump after the
    ``order``-th singular value tells the order of the system.
    """
    observability, singular_values = decomposed(gram, deviation.size, p)
    A, C = truncated(observability, deviation[p:], order)
    return _stable(A), C, singular_values


def decomposed(gram, c, p):
    """Extended observability matrix of every order at once, and singular values, from the Gram matrix of c channels.

    The first o columns are the matrix of order o, whichever o, so that one decomposition serves all; see `truncated`.
    """
    rows = sorted_rows(c, p, len(gram) // (2 * c))
    gram = gram[np.ix_(rows, rows)]
    try:
        lower = linalg.cholesky(gram, lower=True)
    except linalg.LinAlgError:  # as of a clean record, whose G is singular to rounding
        values, vectors = linalg.eigh(gram)
        root = vectors * np.sqrt(np.clip(values, 0.0, None))
        lower = linalg.qr(root.T, mode="r")[0].T
    return from_root(lower, c, p)


def sorted_rows(c, p, block_rows):
    """Which rows of the Hankel matrix are the inputs of the future, the past and the outputs of the future."""
    past, future = np.arange(2 * block_rows * c).reshape(2, block_rows, c)
    return np.concatenate([future[:, :p].ravel(), past.ravel(), future[:, p:].ravel()])


def from_root(lower, c, p):
    """What `decomposed` returns, from the lower triangle of the sorted Hankel matrix."""
    block_rows = len(lower) // (2 * c)
    first, second = block_rows * p, block_rows * (p + c)
    left, singular_values, _ = linalg.svd(lower[second:, first:second], full_matrices=False)
    return left * np.sqrt(singular_values), singular_values


def truncated(observability, deviation, order):
    """A and C of one order from what `decomposed` returns; ``deviation`` (q,) is that of the outputs."""
    kept, q = observability[:, :order], deviation.size
    return np.linalg.lstsq(kept[:-q], kept[q:], rcond=None)[0], deviation[:, None] * kept[:q]


def fit_input_matrices(A, C, inputs, outputs, sample_rate):
    """The `StateSpace` of given A and C whose B, D, start and offset fit the record best, by least squares in time.

    The eigenvalues of A (o, o) are distinct and inside the unit circle. The record is ``inputs`` (n, p) and
    ``outputs`` (n, q) at ``sample_rate`` (Hz); each output counts in proportion to its deviation.
    """
    (order, p), q = (len(A), inputs.shape[1]), len(C)
    to_inputs, to_outputs = 1 / inputs.std(axis=0), outputs.std(axis=0)
    mean = outputs.mean(axis=0)
    poles, vectors = np.linalg.eig(A)
    poles, vectors = poles.astype(complex)[poles.imag >= 0], vectors.astype(complex)[:, poles.imag >= 0]
    # Real coordinates of the states: real and imaginary part of a pair's, the one of a real pole.
    kept = np.concatenate([np.full(poles.size, True), poles.imag > 0])
    states = np.hstack([vectors * np.where(poles.imag > 0, 2, 1), -2 * vectors.imag]).real[:, kept]
    triangle = _triangle(poles, C @ vectors / to_outputs[:, None], inputs, to_inputs, outputs, mean, to_outputs)
    solution = least_squares(triangle, np.finfo(float).eps * len(triangle))
    start, B, D, offset = np.split(solution, np.cumsum([order, p * order, p * q]))
    B = states @ B.reshape(p, order).T * to_inputs
    D = to_outputs[:, None] * D.reshape(p, q).T * to_inputs
    return StateSpace(A, B, C, D, states @ start, mean + to_outputs * offset, sample_rate)


def stack(triangle, rows):
    """Triangular factor of the rows above and those of ``rows``, the last column the right side of least squares."""
    return np.linalg.qr(np.concatenate([triangle, rows]), mode="r")


def least_squares(triangle, flat):
    """Least squares of least norm, columns scaled alike, from the factor of [columns, right side]; see `stack`."""
    scale = np.linalg.norm(triangle[:, :-1], axis=0)
    return np.linalg.lstsq(triangle[:, :-1] / scale, triangle[:, -1], rcond=flat)[0] / scale


def extended_gram(channels, block_rows):
    """Gram matrix (block_rows c, block_rows c) of the block Hankel matrix of ``channels``, each row about its mean.

    Row j of ``channels`` (samples, c) is w[j]; the Hankel matrix has n = samples - block_rows + 1 columns.
    """
    samples, c = channels.shape
    n = samples - block_rows + 1
    gram = np.empty((block_rows, c, block_rows, c))
    gram[0] = _lagged(channels, n, block_rows).transpose(1, 0, 2)
    head, tail = channels[: block_rows - 1], channels[n:]
    for a in range(block_rows - 1):
        added = np.einsum("i,bj->ibj", tail[a], tail[a:]) - np.einsum("i,bj->ibj", head[a], head[a:])
        gram[a + 1, :, a + 1 :] = gram[a, :, a:-1] + added
    for a in range(1, block_rows):
        gram[a, :, :a] = gram[:a, :, a].transpose(2, 0, 1)
    sums = channels[:n].sum(axis=0) + np.vstack([np.zeros(c), np.cumsum(tail - head, axis=0)])
    gram -= np.einsum("ai,bj->aibj", sums, sums / n)
    return gram.reshape(block_rows * c, block_rows * c)


def _lagged(channels, n, lags):
    """Sums over j < n of w[j] w[j + b]^T for each b < lags, shape (lags, c, c).

    Rows of `_GROUP` samples against rows that begin with the same ones and go on: few large products of matrices,
    whose diagonals of blocks are the sums.
    """
    c, whole, width = channels.shape[1], n // _GROUP, lags + _GROUP - 1
    products = np.zeros((_GROUP * c, width * c))
    for begin in range(0, whole, _SLICE // _GROUP):
        first, last = _GROUP * begin, _GROUP * min(begin + _SLICE // _GROUP, whole)
        piece = np.lib.stride_tricks.sliding_window_view(channels[first : last + lags - 1], width, axis=0)[::_GROUP]
        piece = piece.transpose(0, 2, 1).reshape(len(piece), -1)
        products += piece[:, : _GROUP * c].T @ piece
    products = products.reshape(_GROUP, c, width, c)
    sums = sum(products[i, :, i : i + lags] for i in range(_GROUP)).transpose(1, 0, 2)
    for b in range(lags):
        sums[b] += channels[_GROUP * whole : n].T @ channels[_GROUP * whole + b : n + b]
    return sums


def _stable(A):
    """A with every eigenvalue outside the unit circle mirrored into it."""
    values, vectors = np.linalg.eig(A)
    size = np.abs(values)
    if (size < 1).all():
        return A
    mirrored = np.where(size < 1, values, values / np.maximum(size, 1 + 1e-9) ** 2)
    return np.real(vectors * mirrored @ np.linalg.inv(vectors))


def _triangle(poles, observed, inputs, to_inputs, outputs, mean, to_outputs):
    """Triangular factor of [regressors, outputs], a few rows at a time so that few are stored.

    Pole by pole, with l a pole and g = C v the outputs of its vector, output i at sample r has the regressors
    g l^r, g sum l^(r-1-s) u_j[s], u_j[r] and one, which multiply coordinates of the first state and of column j of B,
    column j of D and the offset. Outputs count from ``mean`` in ``to_outputs``.
    """
    p, q = inputs.shape[1], len(observed)
    coordinates = poles.size + np.count_nonzero(poles.imag > 0)
    triangle = np.zeros((0, (1 + p) * coordinates + p * q + q + 1))
    states = np.zeros((1 + p, poles.size), dtype=complex)
    states[0] = 1.0
    for begin in range(0, len(inputs), _ROWS):
        part = slice(begin, begin + _ROWS)
        scaled = (inputs[part] * to_inputs, (outputs[part] - mean) / to_outputs)
        triangle = stack(triangle, _regressors(poles, observed, states, *scaled, triangle.shape[1]))
    return triangle


@compiled
def _regressors(poles, observed, states, inputs, outputs, size):
    """The next rows of `_triangle`; ``states`` (1 + p, poles) go on from sample to sample."""
    (samples, p), (q, modes) = inputs.shape, observed.shape
    coordinates = (size - 1 - q - p * q) // (1 + p)
    rows = np.zeros((samples * q, size))
    for r in range(samples):
        for i in range(q):
            row = rows[r * q + i]
            for j in range(1 + p):
                second = j * coordinates + modes
                for k in range(modes):
                    seen = observed[i, k] * states[j, k]
                    if poles[k].imag > 0:
                        row[j * coordinates + k] = 2 * seen.real
                        row[second] = -2 * seen.imag
                        second += 1
                    else:
                        row[j * coordinates + k] = seen.real
            for j in range(p):
                row[(1 + p) * coordinates + j * q + i] = inputs[r, j]
            row[size - 1 - q + i] = 1.0
            row[size - 1] = outputs[r, i]
        for k in range(modes):
            states[0, k] *= poles[k]
            for j in range(p):
                states[j + 1, k] = poles[k] * states[j + 1, k] + inputs[r, j]
    return rows


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
