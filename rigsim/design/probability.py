"""How likely an identified rig has a detached curve, given how sure its parameters are."""

from dataclasses import dataclass

import numpy as np

from .. import checks
from ..blas import one_blas_thread
from ..identification.result import Identification
from ..parameters import OscillatorParameters
from ..results import Result, frame
from .count import KINDS, existence_forces, having
from .variation import varied_sets

_POINTS = 801
_WIDER = 3.0  # times the forces at which a curve comes or goes are shown
_LIKE_RECORD = 10.0  # times the record's force, where no force gives a curve
_NAMES = ("ms", "ks", "cs", "m", "c", "k1", "k3")


@dataclass(frozen=True, eq=False, repr=False)
class CurveProbability(Result):
    """Detached curves of an identified rig over force; see `curve_probability`.

    Attributes
    ----------
    parameters : OscillatorParameters
        The identified rig.
    force : ndarray, shape (n,)
        Amplitude (N).
    inner, outer : ndarray, shape (n,)
        Shares of the sampled rigs that have a curve of the kind there, 0 to 1.
    samples : int
        Number of rigs.
    """

    parameters: OscillatorParameters
    force: np.ndarray
    inner: np.ndarray
    outer: np.ndarray
    samples: int

    plots = {"probability": "curve_probability_figure"}

    def summary(self):
        """From where to where each kind is likely."""
        return "; ".join(self.told(kind) for kind in KINDS)

    def told(self, kind):
        """In words, at which of the forces a kind, "inner" or "outer", is more likely than not."""
        share = getattr(self, kind)
        if not share.max() >= 0.5:
            return f"{kind} detached curve: unlikely at every force shown (at most {100 * share.max():.0f} %)"
        ends = np.flatnonzero(np.diff(np.pad(share >= 0.5, 1).astype(int))).reshape(-1, 2)
        ranges = " and ".join(f"{self.force[low]:.3g} to {self.force[high - 1]:.3g} N" for low, high in ends)
        return f"{kind} detached curve: more likely than not from {ranges}"

    def at(self, force):
        """Probabilities of an inner and of an outer curve at a force (N), straight lines between those there are."""
        force = checks.real("force", force, "N", low=self.force[0], high=self.force[-1])
        return tuple(float(np.interp(force, self.force, share)) for share in (self.inner, self.outer))

    def table(self):
        """`pandas.DataFrame` of the probabilities (%) at each force."""
        columns = {"force [N]": self.force, "inner [%]": 100 * self.inner, "outer [%]": 100 * self.outer}
        return frame(columns, index="force [N]")


@one_blas_thread
def curve_probability(identification, force=None, samples=1000, seed=2014):
    """`CurveProbability`: at each force the share of rigs, as sure as the record makes them, that have the curves.

    Rigs are drawn from the normal distribution of the identified parameters, correlated as their covariance says and as
    wide as their 95 % intervals; each is judged as `rigsim.detached_curves` would judge it. A drawn rig that cannot be
    (a negative stiffness) has no curve.

    Parameters
    ----------
    identification : Identification
        With errors.
    force : float or sequence of float, optional
        Amplitudes (N) beside the usual 801, about those at which curves of the identified rig come and go.
    samples : int
        Number of rigs.
    seed : int
        The same seed gives the same rigs.

    Raises
    ------
    ValueError
        If an input is not allowed, or the identification has no errors or is not of two masses that a force shakes.
    """
    identification = checks.instance("identification", identification, Identification, "an Identification")
    if identification.errors is None:
        raise ValueError("identification.errors is None; expected an identification whose parameters have errors")
    if identification.record.mass is None or identification.record.base:
        raise ValueError("identification is of one mass, or on a base; expected one of two masses that a force shakes")
    samples = checks.integer("samples", samples, low=1, high=100_000)
    generator = np.random.default_rng(checks.seed("seed", seed))
    parameters = identification.parameters
    others = [] if force is None else checks.array("force", force, "N", low=0.0, low_open=True)
    forces = np.union1d(_usual_forces(identification), others)
    drawn = sampled(identification.errors, samples, generator)
    sets = varied_sets(parameters, 1.0, dict(zip(_NAMES, drawn.T, strict=True)))
    inner, outer = having(sets[np.isfinite(sets[:, 0])], forces) / samples
    return CurveProbability(parameters, forces, inner, outer, samples)


def sampled(errors, samples, generator):
    """Parameters (samples, 7) ms, ks, cs, m, c, k1, k3 drawn as `ParameterErrors` say: correlated, and so wide."""
    count = len(_NAMES)
    covariance, width = errors.covariance[:count, :count], errors.half_width[:count] / 1.96
    usual = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    correlation = covariance / np.outer(usual, usual)
    np.fill_diagonal(correlation, 1.0)
    values, vectors = np.linalg.eigh((correlation + correlation.T) / 2)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return errors.value[:count] + width * (generator.standard_normal((samples, count)) @ root.T)


def _usual_forces(identification):
    """Amplitudes (N) about those at which curves come or go; where they never do, about the record's force."""
    parameters = identification.parameters
    ends = [end for kind in KINDS for span in _spans(parameters, kind) for end in span if 0 < end < np.inf]
    wider = _WIDER if ends else _LIKE_RECORD
    ends = ends or [np.sqrt(2) * identification.record.force.std()]
    return np.geomspace(min(ends) / wider, max(ends) * wider, _POINTS)


def _spans(parameters, kind):
    return existence_forces(parameters, kind) if parameters.cs > 0 else ()
