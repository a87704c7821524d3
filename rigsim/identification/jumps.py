"""Parameters from the frequencies at which a stepped-sine test jumps: a second way to the rig, beside random shaking.

A motion jumps where it ends, at a fold of the response, and folds are known in closed form (`rigsim.theory.detached`).
That form has one harmonic. The third, Z3, which the cubic spring makes of the first, Z, follows from the receptance of
z at three times the frequency,

    Z3 = R k3 Z^3/4 / (1 - R (k1 + 3 i w c + 3/2 k3 |Z|^2)),   R = 1/(9 w^2 m) - 1/(ks - 9 w^2 ms + 3 i w cs),

and its effect back on the first is that of k3 (1 + e + 2 |e|^2) in place of k3, e = Z3/Z. At a fold the force is
stationary in the amplitude, so the frequency of the fold moves as that change of k3 and c moves it, to first order.

On the paper's rig from 0.25 to 5 N, up to 140 Hz, folds of one harmonic lie up to 0.75 Hz (1.2 %) from those of orbits
with eleven, most of them 0.002 to 0.5 Hz; with the third harmonic up to 0.03 Hz, a twelfth of that shift or less. A
tenth of it is in every interval. The exact law of the wires moves folds by at most 0.03 Hz below 60 Hz and by 0.4 Hz at
119 Hz, where z is 5 mm: this is not in the interval. Nor are folds that a higher harmonic makes of its own, near a
third of the shaker's resonance: at 0.5 N the paper's rig, stepped up, falls at 18.9 Hz from one.
"""

from dataclasses import dataclass

import numpy as np
from scipy import optimize, stats

from .. import checks
from ..parameters import OscillatorParameters, oscillator_of
from ..results import Result, Status, frame
from ..theory.detached import folds
from .physical import NAMES

KINDS = {"rises": "lower", "falls": "upper"}  # what z does where the low, or the high, motion ends
_ENDS = {"down": 0, "up": 1}  # of an interval of three solutions, by how the frequency is stepped
_LEFT = 0.1  # of the shift by the third harmonic: what higher ones add, at most
_LARGE = 0.1  # third harmonic over the first: twice as much as the paper's rig has at any fold
_AWAY = 0.05  # of a frequency: so far the third harmonic moves no fold, but makes another one
_STEP = 1e-5  # of a parameter
_STEPS = 40
_FAR = np.log(20.0)  # of a parameter from the start
_OTHER = 0.2  # of its frequency: a fold of the start that is so far from a jump may be another one
_WIDE = 0.1  # of a parameter: a half-width beyond it says little
_ODD = 0.001  # chance of a disagreement that is taken for one
_BENT = 0.5  # of the way to the interval's end: there a straight line is none
_TALL, _ABOVE = np.log(1.2), 4.0  # least jump of an amplitude, and times its steps beside


@dataclass(frozen=True)
class Jump:
    """A jump of a stepped-sine test.

    Attributes
    ----------
    force : float
        Amplitude (N).
    frequency : float
        Hz; half-way between the last frequency before it and the first after it.
    half_step : float
        Hz; half the step between these: the jump is known no better.
    amplitude : {"rises", "falls"}
        What the amplitude of z does.
    sweep : {"up", "down"}
        How the frequency was stepped.
    """

    force: float
    frequency: float
    half_step: float
    amplitude: str
    sweep: str

    def __post_init__(self):
        checked = {name: checks.positive(name, getattr(self, name), unit)
                   for name, unit in (("force", "N"), ("frequency", "Hz"), ("half_step", "Hz"))}  # fmt: skip
        checked["amplitude"] = checks.one_of("amplitude", self.amplitude, tuple(KINDS))
        checked["sweep"] = checks.one_of("sweep", self.sweep, tuple(_ENDS))
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @classmethod
    def found_in(cls, force, frequency, relative):
        """Tuple of the jumps of a stepped test: where abs(z) changes by a fifth, and far more than in the steps beside.

        Stay at each frequency until the motion has settled: near a fold that takes long.

        Parameters
        ----------
        force : float
            Amplitude (N).
        frequency : array_like, shape (n,)
            Hz, in the order of the test: ascending or descending throughout.
        relative : array_like, shape (n,)
            Amplitude of z at each (m), real or complex.
        """
        force = checks.positive("force", force, "N")
        frequency = checks.array("frequency", frequency, "Hz", low=0.0, low_open=True, min_size=4)
        relative = np.abs(checks.lines("relative", relative, "m"))
        steps = np.diff(frequency)
        if not ((steps > 0).all() or (steps < 0).all()):
            raise ValueError("frequency turns back; expected frequencies that ascend, or descend, throughout")
        if relative.size != frequency.size or not (relative > 0).all():
            raise ValueError(f"relative has {relative.size} amplitudes; expected {frequency.size}, each above zero")
        change = np.diff(np.log(relative))
        size = np.abs(change)
        beside = np.maximum(np.append(size[1:], 0.0), np.insert(size[:-1], 0, 0.0))
        return tuple(
            cls(force, frequency[i : i + 2].mean(), abs(steps[i]) / 2, "rises" if change[i] > 0 else "falls",
                "up" if steps[i] > 0 else "down")
            for i in np.flatnonzero((size > _TALL) & (size > _ABOVE * beside))
        )  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class FromJumps(Result):
    """Parameters that jump frequencies tell; see `parameters_from_jumps`.

    Attributes
    ----------
    parameters : OscillatorParameters
        The free ones as found, the others as they were given.
    free : tuple of str, length n
    value, half_width : ndarray, shape (n,)
        Of the free parameters, and of their 95 % intervals; infinite where the jumps say nothing.
    covariance : ndarray, shape (n, n)
    jumps : tuple of Jump, length k
    predicted, shift : ndarray, shape (k,)
        Folds of these parameters, and how much of them is due to the third harmonic (Hz).
    start : OscillatorParameters
    start_half_width : ndarray, shape (n,)
        Of the 95 % intervals of the free parameters at the start; NaN where they are not known.
    apart : ndarray, shape (n,)
        From the start's values, in half-widths of the 95 % interval of the difference; NaN likewise.
    status : Status
        Found, or doubtful.
    message : str
        What is to be distrusted, and why; empty where nothing is.
    """

    parameters: OscillatorParameters
    free: tuple
    value: np.ndarray
    half_width: np.ndarray
    covariance: np.ndarray
    jumps: tuple
    predicted: np.ndarray
    shift: np.ndarray
    start: OscillatorParameters
    start_half_width: np.ndarray
    apart: np.ndarray
    status: Status
    message: str

    def summary(self):
        """One line: the parameters with their intervals, and what speaks against them."""
        told = ", ".join(
            f"{name} = {value:.5g} +- {width:.2g}"
            for name, value, width in zip(self.free, self.value, self.half_width, strict=True)
        )
        exact = ", if all others are exact" * bool(np.isnan(self.start_half_width).any())
        doubt = f"{self.status}: {self.message}" if self.message else self.status
        return f"Parameters from {len(self.jumps)} jumps: {told}{exact}; {doubt}"

    def table(self):
        """`pandas.DataFrame` of the free parameters, their 95 % half-widths, and the same at the start."""
        start = [getattr(self.start, name) for name in self.free]
        columns = {"parameter": self.free, "value": self.value, "+- (95 %)": self.half_width, "start": start}
        if not np.isnan(self.start_half_width).any():
            columns |= {"start +- (95 %)": self.start_half_width, "apart [half-widths]": self.apart}
        return frame(columns, index="parameter")


def parameters_from_jumps(jumps, start, free=("k3",), covariance=None):
    """`FromJumps`: the free parameters under which folds lie where a stepped test jumped, by least squares.

    Each jump belongs to the fold of its kind nearest to it: the low motion ends where z rises, the high one where it
    falls, at the upper end of an interval of three solutions where the frequency was stepped up. A jump is somewhere
    in its step, whose variance is that of an even chance; to it comes a tenth of the third harmonic's shift.

    Parameters
    ----------
    jumps : sequence of Jump
        Of one or several forces.
    start : OscillatorParameters or RigParameters
        Where to start; the parameters that are not free keep these values.
    free : sequence of str
        Of ms, ks, cs, m, c, k1, k3. The jumps hold at most six: another unit of mass would do as well.
    covariance : array_like, shape (7, 7), optional
        Of the errors of the start, in that order: those of the parameters that are not free are carried on, those of
        the free ones tell how far apart both ways are. By default the others are exact.

    Raises
    ------
    ValueError
        If an input is not allowed, a parameter of the start is zero, or it has no fold of a jump's kind.
    """
    jumps = tuple(checks.one_or_many("jumps", jumps, Jump, "a Jump"))
    start = oscillator_of(start, "start")
    free = tuple(dict.fromkeys(checks.names("free", free, NAMES)))
    known = covariance is not None
    covariance = _checked_covariance(covariance) if known else np.zeros((7, 7))
    if not jumps:
        raise ValueError("jumps are empty; expected at least one Jump")
    for name in NAMES:
        if not getattr(start, name) > 0:
            raise ValueError(f"{name} of the start = {getattr(start, name):g} is not allowed; expected it above zero")
    fit = _Fit(jumps, start, free, covariance)
    found = optimize.least_squares(
        fit.residual, np.zeros(len(free)), lambda u: fit.whiten(fit.slopes(fit.at(u), free)), x_scale="jac",
        bounds=(-_FAR, _FAR), xtol=1e-10, ftol=1e-10, gtol=1e-10, max_nfev=_STEPS,
    )  # fmt: skip
    parameters = fit.at(found.x)
    predicted, single, harmonic = fit.predicted(parameters)
    value = np.array([getattr(parameters, name) for name in free])
    spread, blind, difference = fit.spread(parameters)
    width = stats.norm.ppf(0.975) * np.sqrt(np.diag(spread))
    half_width = np.where(blind, np.inf, value * width)
    own = [NAMES.index(name) for name in free]
    start_value = np.array([getattr(start, name) for name in free])
    start_width = stats.norm.ppf(0.975) * np.sqrt(np.diag(covariance)[own]) if known else np.full(len(free), np.nan)
    apart = np.abs(found.x) / (stats.norm.ppf(0.975) * np.sqrt(np.diag(difference))) if known else start_width
    doubts = fit.doubts(found, predicted, harmonic, spread, np.where(blind, np.inf, width))
    doubts += [
        f"{name} differs from the start's {old:.5g} by {far:.2g} half-widths of the difference"
        for name, old, far in zip(free, start_value, apart, strict=True)
        if far > stats.norm.isf(_ODD / 2) / stats.norm.ppf(0.975)
    ]
    return FromJumps(
        parameters, free, value, half_width, spread * np.outer(value, value), jumps, predicted, predicted - single,
        start, start_width, apart, Status.DOUBTFUL if doubts else Status.FOUND, "; ".join(doubts),
    )  # fmt: skip


def _checked_covariance(covariance):
    covariance = checks.array("covariance", covariance, ndim=2, physical=False)
    if covariance.shape != (7, 7) or not np.allclose(covariance, covariance.T, rtol=1e-6, atol=0):
        raise ValueError(f"covariance of shape {covariance.shape} is not allowed; expected (7, 7), symmetric")
    if (np.diag(covariance) < 0).any():
        raise ValueError(f"covariance has a variance of {np.diag(covariance).min():.3g}; expected none below zero")
    return covariance


class _Fit:
    """The least squares of `parameters_from_jumps`, over the logarithms of the free parameters over the start's."""

    def __init__(self, jumps, start, free, covariance):
        self.jumps, self.start, self.free = jumps, start, free
        self.held = tuple(name for name in NAMES if name not in free)
        self.measured = np.array([jump.frequency for jump in jumps])
        values = np.array([getattr(start, name) for name in NAMES])
        self.relative = covariance / np.outer(values, values)
        predicted, single, _ = self.predicted(start)
        for jump, one in zip(jumps, predicted, strict=True):
            if np.isnan(one):
                told = f"jumps at {jump.frequency:g} Hz and {jump.force:g} N, where z {jump.amplitude}"
                raise ValueError(f"{told} as the frequency goes {jump.sweep}; expected a start with such a fold")
        self.begun = predicted
        half_steps = np.array([jump.half_step for jump in jumps])
        self.variance = half_steps**2 / 3 + (_LEFT * (predicted - single)) ** 2
        own = [NAMES.index(name) for name in self.held]
        slopes = self.slopes(start, self.held)
        total = np.diag(self.variance) + slopes @ self.relative[np.ix_(own, own)] @ slopes.T
        self.root = np.linalg.cholesky(total)

    def at(self, u):
        return self.start.replace(**{name: getattr(self.start, name) * np.exp(x)
                                     for name, x in zip(self.free, u, strict=True)})  # fmt: skip

    def whiten(self, values):
        return np.linalg.solve(self.root, values)

    def predicted(self, parameters):
        """Fold of each jump with and without the third harmonic (Hz), and the size of that; NaN without a fold."""
        forces = {force: _folds(parameters, force) for force in {jump.force for jump in self.jumps}}
        return np.array([_nearest(forces[jump.force], jump) for jump in self.jumps]).T

    def residual(self, u):
        predicted = self.predicted(self.at(u))[0]
        # Where a fold is gone no step is worth it.
        return self.whiten(np.where(np.isnan(predicted), 1e6, predicted - self.measured))

    def slopes(self, parameters, names):
        """Derivatives of the folds by logarithms of parameters, (k, names); one-sided where a fold ends."""
        columns, here = [], self.predicted(parameters)[0]
        for name in names:
            sides = [self.predicted(parameters.replace(**{name: getattr(parameters, name) * np.exp(step)}))[0]
                     for step in (_STEP, -_STEP)]  # fmt: skip
            there = sum(np.isfinite(side) for side in sides)
            up, down = (np.where(np.isnan(side), here, side) for side in sides)
            columns.append((up - down) / (_STEP * np.maximum(there, 1)))
        return np.column_stack(columns) if columns else np.zeros((len(self.jumps), 0))

    def spread(self, parameters):
        """Covariance of the logarithms, which of them the jumps say nothing of, and that of the way from the start."""
        columns = self.whiten(self.slopes(parameters, self.free))
        _, sizes, directions = np.linalg.svd(columns, full_matrices=True)
        sizes = np.concatenate([sizes, np.zeros(len(self.free) - sizes.size)])
        lost = sizes <= 1e-7 * sizes.max()
        blind = (np.abs(directions[lost]) > 1e-3).any(axis=0)
        inverse = np.linalg.pinv(columns, rcond=1e-7)
        # What errors of the start do to both ways: to the free parameters by the others, and to themselves.
        moved = np.zeros((len(self.free), len(NAMES)))
        own, others = ([NAMES.index(name) for name in names] for names in (self.free, self.held))
        moved[:, others] = -inverse @ self.whiten(self.slopes(parameters, self.held))
        moved[:, own] -= np.eye(len(self.free))
        steps = inverse @ self.whiten(np.diag(np.sqrt(self.variance)))
        return inverse @ inverse.T, blind, steps @ steps.T + moved @ self.relative @ moved.T

    def doubts(self, found, predicted, harmonic, spread, width):
        """What speaks against the fit, in words; ``width`` are half-widths of the logarithms."""
        told = []
        wide = [f"{name} (+- {100 * one:.2g} %)" if np.isfinite(one) else name
                for name, one in zip(self.free, width, strict=True) if not one < _WIDE]  # fmt: skip
        if wide:
            told.append(f"not determined by these jumps: {', '.join(wide)}; jumps at other forces would help")
        more, far = len(self.jumps) - len(self.free), np.abs(self.begun / self.measured - 1)
        if more <= 0 and far.max() > _OTHER:  # more jumps would disagree
            jump, fold = self.jumps[int(far.argmax())], self.begun[int(far.argmax())]
            told.append(f"the jump at {jump.frequency:.4g} Hz and {jump.force:g} N may be at another fold: the start's "
                        f"nearest of its kind is at {fold:.4g} Hz")  # fmt: skip
        if not found.success or (more == 0 and 2 * found.cost > 1):
            told.append("no parameters put folds where the jumps are")
        elif more > 0 and 2 * found.cost > stats.chi2.isf(_ODD, more):
            columns = self.whiten(self.slopes(self.at(found.x), self.free))
            own = np.maximum(1 - np.diag(columns @ np.linalg.pinv(columns)), 1e-9)  # what each jump decides not itself
            worst = int(np.argmax(found.fun**2 / own))
            off, jump = abs(predicted[worst] - self.measured[worst]) / own[worst], self.jumps[worst]
            told.append(f"the jumps disagree: that at {jump.frequency:.4g} Hz and {jump.force:g} N is {off:.2g} Hz "
                        "from where the others put its fold")  # fmt: skip
        if (harmonic > _LARGE).any():
            told.append(f"z has {100 * harmonic.max():.2g} % of third harmonic at a jump, too much for this theory")
        if not wide and self._bent(found.x, spread):
            told.append("within the interval a fold ends or bends away: it is too narrow")
        return told

    def _bent(self, u, spread):
        """Whether at an end of an interval the folds are not where the slopes say."""
        slopes, here = self.slopes(self.at(u), self.free), self.predicted(self.at(u))[0]
        for i in range(len(self.free)):
            step = stats.norm.ppf(0.975) * spread[i] / np.sqrt(spread[i, i])
            for sign in (1, -1):
                straight = sign * self.whiten(slopes @ step)
                off = self.whiten(self.predicted(self.at(u + sign * step))[0] - here) - straight
                if not np.linalg.norm(off) < _BENT * np.linalg.norm(straight):
                    return True
        return False


def _folds(parameters, force):
    """(kind, end of its interval, frequency with the third harmonic, without, size of that) of each fold."""
    found = []
    for number, fold in enumerate(folds(parameters, force)):
        size = abs(fold.relative)
        share = _third_harmonic(parameters, fold.frequency, size)
        omega = 2 * np.pi * fold.frequency
        damping = parameters.c + 0.75 * parameters.k3 * size**2 * share.imag / omega
        stiffness = parameters.k3 * max(1 + share.real + 2 * abs(share) ** 2, 0.0)
        moved = folds(parameters.replace(k3=stiffness, c=max(damping, 0.0)), force)
        same = [one.frequency for i, one in enumerate(moved) if one.kind == fold.kind and i % 2 == number % 2]
        off, nearest = min(((abs(one / fold.frequency - 1), one) for one in same), default=(np.inf, np.nan))
        if off < _AWAY:
            found.append((fold.kind, number % 2, nearest, fold.frequency, abs(share)))
    return found


def _third_harmonic(parameters, frequency, amplitude):
    """Third harmonic of z over the first, complex, about a motion of z of that amplitude (m)."""
    p, s = parameters, 6j * np.pi * frequency
    receptance = -1 / (p.m * s**2) - 1 / (p.ms * s**2 + p.cs * s + p.ks)
    cube = p.k3 * amplitude**2
    return receptance * cube / 4 / (1 - receptance * (p.k1 + p.c * s + 1.5 * cube))


def _nearest(found, jump):
    """Of the folds of a jump's kind the nearest: with the third harmonic, without, and the size of that."""
    same = [one for one in found if one[:2] == (KINDS[jump.amplitude], _ENDS[jump.sweep])]
    return min(same, key=lambda one: abs(one[2] - jump.frequency))[2:] if same else (np.nan,) * 3
