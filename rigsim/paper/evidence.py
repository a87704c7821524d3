"""What the ledger is computed from: the paper's tests run once on a rig, each when it is first asked for."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from .. import checks
from ..experiment.random_test import random_test
from ..experiment.sine_test import LOWEST, sine_test
from ..identification.identify import identify
from ..model.excitation import Tap
from ..model.planar import linear_modes, static_equilibrium
from ..parameters import RigParameters
from ..results import Result, frame
from ..theory.amplitude import frequency_response
from ..theory.detached import detached_curves
from .virtual_experiment import overlay, virtual_experiment

_SINGLE = 12  # sine tests of the single-set rig, each from rest and tapped
_READINGS = ("all", "force", "none")
_RUNS = ("record", "readings", "experiment", "single")


@dataclass(frozen=True, eq=False, repr=False)
class Evidence(Result):
    """The paper's virtual experiment on one rig; every part is run when first asked for, and kept.

    Parameters
    ----------
    rig : RigParameters
    force : float
        Amplitude of the sine tests (N).
    frequency : array_like, shape (n,)
        Of the sine tests (Hz).
    rms, duration, sample_rate : float
        Of the random test (N, s, Hz).
    progress : bool or callable
        Of the random test and the sine tests.

    Examples
    --------
    >>> evidence = Evidence(frequency=[30, 40, 50])
    >>> evidence.experiment.branch  # runs the random test, the identification and the sine tests  # doctest: +SKIP
    """

    rig: RigParameters = field(default_factory=RigParameters)
    force: float = 3.18
    frequency: np.ndarray = field(default_factory=lambda: np.arange(10.0, 81.0))
    rms: float = 1.115
    duration: float = 100.0
    sample_rate: float = 2000.0
    progress: object = False

    def __post_init__(self):
        set_field = lambda name, value: object.__setattr__(self, name, value)  # noqa: E731
        set_field("rig", checks.instance("rig", self.rig, RigParameters, "RigParameters"))
        for name, unit in (("force", "N"), ("rms", "N"), ("duration", "s"), ("sample_rate", "Hz")):
            set_field(name, checks.positive(name, getattr(self, name), unit))
        set_field("frequency", checks.array("frequency", self.frequency, "Hz", low=LOWEST))
        set_field("progress", checks.progress(self.progress))

    def summary(self):
        """One line: what is run on which rig, and what has been run so far."""
        run = ", ".join(name for name in _RUNS if name in vars(self)) or "nothing"
        return (
            f"Evidence: a random test of {self.duration:g} s at {self.rms:g} N rms and sine tests of {self.force:g} N "
            f"at {self.frequency.size} frequencies of a rig with {self.rig.wire_sets} wire sets; run so far: {run}"
        )

    def table(self):
        """`pandas.DataFrame` with a row for each result so far, or None; nothing is run for it."""
        run = {name: vars(self)[name] for name in _RUNS if vars(self).get(name) is not None}
        run |= {f'reading "{name}"': result for name, result in run.pop("readings", {}).items()}
        return frame({"result": {name: result.summary() for name, result in run.items()}}) if run else None

    @cached_property
    def record(self):
        """`Record` of the random test."""
        return random_test(self.rig, self.rms, self.duration, self.sample_rate, progress=self.progress)

    @cached_property
    def readings(self):
        """`Identification` of the record by each reading of H_E, by name."""
        return {reading: identify(self.record, conversion=reading) for reading in _READINGS}

    @property
    def paper(self):
        """`Identification` by the reading that gives the paper's figures: the whole of H_E through the hold."""
        return self.readings["all"]

    @property
    def right(self):
        """`Identification` by the right reading: the force's column through the hold, the other one directly."""
        return self.readings["force"]

    @property
    def theory(self):
        """`OscillatorParameters` of the curves: the identified ones, as in the paper."""
        return self.paper.parameters

    @cached_property
    def detached(self):
        """Detached curves at the force, from the identified parameters."""
        return detached_curves(self.theory, self.force)

    @cached_property
    def curve(self):
        """`FrequencyResponse` of the identified parameters every 0.1 Hz from 10 to 80 Hz."""
        return frequency_response(self.theory, self.force, np.linspace(10, 80, 701))

    @cached_property
    def experiment(self):
        """`Overlay` of the sine tests, from rest and after taps, on the identified parameters' curves."""
        return virtual_experiment(self.rig, self.force, self.frequency, self.theory, progress=self.progress)

    @cached_property
    def trials(self):
        """`pandas.DataFrame` with a row per sine test: how it began, how it ended, how harmonic it is."""
        import pandas as pd

        parts = []
        for test, branch in zip(self.experiment.tests, self.experiment.branch, strict=True):
            columns = {
                "frequency": test.frequency, "duration": np.round(test.time[-1], 6), "tilt": test.tilt,
                "from rest": [tap is None for tap in test.tap], "light tap": [tap == Tap() for tap in test.tap],
                "branch": branch, "status": test.status, "relative": np.abs(test.relative),
                "below": test.subharmonic[:, 0], **dict(zip(("shaker", "mass", "z"), test.distortion.T, strict=True)),
            }  # fmt: skip
            parts.append(pd.DataFrame(columns))
        return pd.concat(parts, ignore_index=True)

    def inside(self, frequency):
        """Whether frequencies (Hz) lie on a detached curve, bool of the same shape."""
        frequency = checks.array("frequency", frequency, "Hz", ndim=None)
        return np.any([(frequency > c.low) & (frequency < c.high) for c in self.detached], axis=0) & (frequency > 0)

    @cached_property
    def single(self):
        """`Overlay` of the single-set rig at up to 12 frequencies of the detached curve, or None where there is none.

        The first half of the tests starts from rest, the second is tapped.
        """
        frequency = self.frequency[self.inside(self.frequency)]
        if not frequency.size:
            return None
        chosen = frequency[np.unique(np.linspace(0, frequency.size - 1, _SINGLE).astype(int))]
        taps = [None] * chosen.size + [Tap()] * chosen.size
        test = sine_test(self.rig.single_set(), self.force, np.tile(chosen, 2), taps, progress=self.progress)
        return overlay(self.theory, test)

    @cached_property
    def statics(self):
        """(`StaticEquilibrium`, `Modes`) of the rig and of its single-set form."""
        return tuple((static_equilibrium(rig), linear_modes(rig)) for rig in (self.rig, self.rig.single_set()))
