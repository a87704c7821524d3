"""How far a fit's parameters can be trusted: white noise, and what the record disagrees about with itself."""

from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.ndimage import uniform_filter1d

from .likelihood import noise_weights, normal_equations, smoothing, white_weights
from .lines import inverse

_PARTS = 12  # of the record, in time and over the band, whose pulls on the parameters are compared
_ODD = 0.001  # chance of a disagreement that is taken for one


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Of the parameters of a fit.

    Attributes
    ----------
    covariance : ndarray, shape (parameters, parameters)
        Of all of them.
    standard_error : ndarray, shape (parameters,)
    half_width : ndarray, shape (parameters,)
        Of the 95 % interval.
    bound : ndarray, shape (parameters,)
        Cramer-Rao: the smallest standard error that any unbiased reading could have under noise of this size, white.
    disagreement : ndarray, shape (parameters,)
        Standard error from parts of the record, in time or over the band, over the one from noise; 1 where they agree.
    """

    covariance: np.ndarray
    standard_error: np.ndarray
    half_width: np.ndarray
    bound: np.ndarray
    disagreement: np.ndarray


def uncertainty(fit, beside=()):
    """`Uncertainty` of a fit, from the lines of its columns and of what it leaves.

    ``beside`` are columns (n, q) of what else was estimated, as the delay that was taken from a record.
    """
    own = np.concatenate([fit.own, *(fit.freed.lines(fit.lines, column)[..., None] for column in beside)], axis=-1)
    weights, count = noise_weights(fit.left, fit.owners), fit.values.size
    weighted = weights[..., None] * own
    inverted = inverse(normal_equations(own, fit.left, weights)[0])
    # Outputs that share a noise, as that of an unknown force, say less than two would.
    shared = 0.0
    for owner in np.unique(fit.owners):
        heavy, spectra = weighted[fit.owners == owner], _spectra(fit.left[fit.owners == owner])
        shared = shared + np.einsum("blip,lij,bljq->pq", heavy.conj(), spectra, heavy, optimize=True).real
    covariance = inverted @ shared @ inverted
    error = np.sqrt(np.maximum(np.diag(covariance)[:count], 1e-300))
    pulls = np.einsum("blip,bli->blp", weighted.conj(), fit.left).real @ inverted[:, :count]
    disagreement = np.maximum(*(_disagreement(pulls, axis, error) for axis in (0, 1)))
    bound = np.sqrt(
        np.diag(inverse(normal_equations(own[..., :count], fit.left, white_weights(fit.left, fit.owners))[0]))
    )
    quantile = np.where(disagreement > 1, stats.t.ppf(0.975, _PARTS - 1), stats.norm.ppf(0.975))
    grown = error * disagreement
    covariance = covariance[:count, :count] * np.outer(disagreement, disagreement)
    return Uncertainty(covariance, grown, quantile * grown, bound, disagreement)


def _spectra(left):
    """Covariance of what is left at each line, (lines, q, q), smoothed."""
    spectra = np.einsum("bli,blj->lij", left, left.conj()) / len(left)
    lines = smoothing(len(left))
    return uniform_filter1d(spectra.real, lines, axis=0) + 1j * uniform_filter1d(spectra.imag, lines, axis=0)


def _disagreement(pulls, axis, error):
    """Standard error from parts of the record along an axis, over the one from noise, where chance would not do it."""
    parts = np.array_split(pulls, min(_PARTS, pulls.shape[axis]), axis=axis)
    sums = np.array([part.sum(axis=(0, 1)) for part in parts])
    g = len(sums)
    ratio = np.sum((sums - sums.mean(axis=0)) ** 2, axis=0) * g / (g - 1) / error**2
    return np.where(ratio > stats.chi2.isf(_ODD, g - 1) / (g - 1), np.sqrt(ratio), 1.0)
