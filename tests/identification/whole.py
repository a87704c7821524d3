"""The subspace step as a whole, from the Gram matrix or, as a check on that, from the Hankel matrix itself."""

import numpy as np

from rigsim.identification.subspace import (
    dynamics,
    extended_gram,
    fit_input_matrices,
    from_root,
    sorted_rows,
    truncated,
)


def identify_state_space(inputs, outputs, sample_rate, order, block_rows, method="gram"):
    """State-space model of ``order`` states that turns ``inputs`` into ``outputs``.

    The channels, (n, p) and (n, q), are sampled at ``sample_rate`` (Hz) and each varies; ``block_rows`` are those of
    the past and of the future, at least one more than ``order / q``. Constant offsets of any channel are projected out
    exactly, and come back as the model's ``offset``. Poles outside the unit circle are mirrored into it.
    ``method`` "qr" forms the Hankel matrix and factors it, which takes long and much memory: the check on "gram".

    Returns the `StateSpace` and the singular values (block_rows q,) of the projected future outputs, channels scaled to
    unit deviation: a jump after the ``order``-th tells the order of the system.
    """
    channels = np.hstack([inputs, outputs])
    deviation = channels.std(axis=0)
    channels = (channels - channels.mean(axis=0)) / deviation
    if method == "qr":
        windows = np.lib.stride_tricks.sliding_window_view(channels, 2 * block_rows, axis=0).transpose(0, 2, 1)
        hankel = windows.reshape(len(windows), -1)
        hankel = (hankel - hankel.mean(axis=0))[:, sorted_rows(*channels.shape[1:], inputs.shape[1], block_rows)]
        root = np.linalg.qr(hankel, mode="r").T
        observability, singular_values = from_root(root, deviation.size, inputs.shape[1])
        A, C = truncated(observability, deviation[inputs.shape[1] :], order)
    else:
        gram = extended_gram(channels, 2 * block_rows)
        A, C, singular_values = dynamics(gram, deviation, inputs.shape[1], order)
    return fit_input_matrices(A, C, inputs, outputs, sample_rate), singular_values
