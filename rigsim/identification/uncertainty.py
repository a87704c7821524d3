"""How far a fit's parameters can be trusted: white noise, and what the record disagrees about with itself."""

from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.ndimage import uniform_filter1d

from .likelihood import noise_weights, normal_equations, smoothing, white_weights
from .lines import inverse

_PARTS = 12  # of the record, in time and over the band, whose pulls on the parameters are compared
_LEAST = 0.1  # of a line's noise that is left of it
_TOGETHER = 2.5  # times the variance of lines apart: what is more is no noise, and a disagreement of parts
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


@dataclass(frozen=True, eq=False)
class Score:
    """What a record says of small changes of a rig's p parameters, and of how sure that is.

    Attributes
    ----------
    information, shared, white : ndarray, shape (p, p)
        Fisher's information; the covariance of the slopes; and the information if the noise were white.
    in_time, in_band : ndarray, shape (parts, p)
        Slopes of the weighted squares by parts of the record, and of the band.
    """

    information: np.ndarray
    shared: np.ndarray
    white: np.ndarray
    in_time: np.ndarray
    in_band: np.ndarray

    def __add__(self, other):
        """Of both records."""
        sums = (getattr(self, name) + getattr(other, name) for name in ("information", "shared", "white"))
        return Score(*sums, np.concatenate([self.in_time, other.in_time]), self.in_band + other.in_band)


def score(fit, beside=()):
    """`Score` of a fit, from the lines of its columns and of what it leaves.

    ``beside`` are columns (n, q) of what else was estimated, as the delay that was taken from a record.
    """
    own = np.concatenate([fit.own, *(fit.freed.lines(fit.lines, column)[..., None] for column in beside)], axis=-1)
    weights, count = noise_weights(fit.left, fit.owners), fit.values.size
    weighted = weights[..., None] * own
    information, shared = normal_equations(own, fit.left, weights)[0], 0.0
    inverted = inverse(information)
    # What is left of a line lacks the share of its noise that the parameters took; in blocks that lap a line is a half.
    taken = 2 * np.sum(weighted.conj() * (own @ inverted), axis=-1).real
    left = fit.left / np.sqrt(np.maximum(1 - taken, _LEAST))
    for owner in np.unique(fit.owners):
        heavy, spectra = weighted[fit.owners == owner], _spectra(left[fit.owners == owner])
        shared = shared + np.einsum("blip,lij,bljq->pq", heavy.conj(), spectra, heavy, optimize=True).real
    slopes = np.einsum("blip,bli->blp", weighted.conj(), left).real
    together = _pulling_together(slopes.sum(axis=1), shared, inverted[:, :count])
    shared = shared * (1 + _coherence(left, weighted, own) * (together - 1))
    white = normal_equations(fit.own, fit.left, white_weights(fit.left, fit.owners))[0]
    # Without what a change of the parameters shares with that of all beside them.
    alone = np.eye(count, len(information))
    alone[:, count:] = -information[:count, count:] @ inverse(information[count:, count:])
    return Score(
        alone @ information @ alone.T, alone @ shared @ alone.T, white,
        *(_sums(slopes @ alone.T, axis) for axis in (0, 1)),
    )  # fmt: skip


def uncertainty(found):
    """`Uncertainty` of the parameters with a `Score`."""
    inverted = inverse(found.information)
    covariance = inverted @ found.shared @ inverted
    error = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    time = np.array([part.sum(axis=0) for part in np.array_split(found.in_time, min(_PARTS, len(found.in_time)))])
    disagreement = np.maximum(*(_disagreement(slopes @ inverted, error) for slopes in (time, found.in_band)))
    bound = np.sqrt(np.diag(inverse(found.white)))
    quantile = np.where(disagreement > 1, stats.t.ppf(0.975, _PARTS - 1), stats.norm.ppf(0.975))
    grown = error * disagreement
    return Uncertainty(covariance * np.outer(disagreement, disagreement), grown, quantile * grown, bound, disagreement)


def _spectra(left):
    """Covariance of what is left at each line, (lines, q, q), smoothed."""
    spectra = np.einsum("bli,blj->lij", left, left.conj()) / len(left)
    lines = smoothing(len(left))
    return uniform_filter1d(spectra.real, lines, axis=0) + 1j * uniform_filter1d(spectra.imag, lines, axis=0)


def _coherence(left, weighted, own):
    """Of what is left of two outputs, where the record tells of the parameters: 1 where an unknown force does it all.

    Its noise rings with the rig, louder and at another frequency as the motion is large or small, so that its lines
    pull together; those of sensors' noise do not.
    """
    spectra = _spectra(left)
    if spectra.shape[1] == 1:
        return 0.0
    coherence = np.abs(spectra[:, 0, 1]) ** 2 / (spectra[:, 0, 0] * spectra[:, 1, 1]).real
    told = np.sum(weighted.conj() * own, axis=(0, 2)).real
    told = np.sum(told / np.maximum(told.sum(axis=0), 1e-300), axis=1)
    return float(told @ coherence / told.sum())


def _pulling_together(slopes, shared, inverted):
    """Variance of the parameters by the slopes of whole blocks (blocks, p), over the one by lines; no less.

    Blocks lap by a half, so that neighbours count together; what is left has no slope of its own, which takes three
    blocks of them.
    """
    blocks, lapping = len(slopes), slopes[:-1].T @ slopes[1:]
    whole = (slopes.T @ slopes + lapping + lapping.T) * blocks / max(blocks - 3, 1)
    variance = [np.sum(inverted * (one @ inverted), axis=0) for one in (whole, shared)]
    known = variance[1] > 0
    return np.clip(np.mean(variance[0][known] / variance[1][known]), 1.0, _TOGETHER)


def _sums(slopes, axis):
    """Of slopes (blocks, lines, p) in parts along an axis, (parts, p)."""
    parts = np.array_split(slopes, min(_PARTS, slopes.shape[axis]), axis=axis)
    return np.array([part.sum(axis=(0, 1)) for part in parts])


def _disagreement(sums, error):
    """Standard error from the pulls of parts (parts, p), over the one from noise, where chance would not do it."""
    g = len(sums)
    ratio = np.sum((sums - sums.mean(axis=0)) ** 2, axis=0) * g / (g - 1) / error**2
    return np.where(ratio > stats.chi2.isf(_ODD, g - 1) / (g - 1), np.sqrt(ratio), 1.0)
