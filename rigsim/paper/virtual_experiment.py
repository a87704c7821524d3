"""The rig laid over the theory: which branch each sine test ended on, and which stable branch no tap reached.

A branch is named only when the whole spectrum allows it: a test that did not settle, or moves with a line below the
force's frequency, is on no branch of the single-term theory, however near its line at f may come.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from .. import checks
from ..experiment.driven import check_force
from ..experiment.out_of_plane import planar_word
from ..experiment.sine_test import LOWEST, SineTest, sine_test
from ..model.excitation import Tap
from ..parameters import oscillator_of, rig_of
from ..results import Result, Status
from ..theory.amplitude import FrequencyResponse, frequency_response

BRANCHES = ("low", "middle", "high")
_NEAR = 0.15  # largest relative distance of z from a theoretical solution that bears its name
_PATIENCE = 6.0  # s, for tests that three seconds do not settle
_LADDER = tuple(itertools.product((0.25, 0.5, 1.0, 2.0), (0, 1 / 4, 1 / 2, 3 / 4)))  # m/s, periods


@dataclass(frozen=True, eq=False, repr=False)
class Overlay(Result):
    """Sine tests of a rig beside the theory at their frequencies.

    Attributes
    ----------
    response : FrequencyResponse
        Theory at the frequencies of the tests, each once, ascending.
    tests : tuple of SineTest
        In the order they were run.
    status : tuple of ndarray of Status
        As the tests', but ELSEWHERE for those that settled near no solution.
    branch : tuple of ndarray of str
        For each test of each campaign "low", "middle", "high" (by abs(z), where theory has three solutions), "only"
        (where it has one), or its status in words, the reason why none.
    """

    response: FrequencyResponse
    tests: tuple
    status: tuple
    branch: tuple

    plots = {"branches": "branches_figure"}

    def reached(self):
        """Whether some test settled on each solution, bool array of shape (n, 3) as in ``response``."""
        result = np.zeros(self.response.relative.shape, dtype=bool)
        for test, branch in zip(self.tests, self.branch, strict=True):
            at = np.searchsorted(self.response.frequency, test.frequency)
            for j, name in enumerate(BRANCHES):
                result[at[branch == name], j] = True
            result[at[branch == "only"], 0] = True
        return result

    @property
    def rigs(self):
        """Every test's `RigParameters`, a tuple."""
        return tuple(p for test in self.tests for p in test.parameters)

    @property
    def circles(self):
        """Four arrays (k,), of every test that settled on a branch: frequency (Hz), lines of xs, x and z at it (m)."""
        kept = [np.isin(branch, (*BRANCHES, "only")) for branch in self.branch]
        columns = ("frequency", "shaker", "mass", "relative")
        return tuple(
            np.concatenate([getattr(test, name)[on] for test, on in zip(self.tests, kept, strict=True)])
            for name in columns
        )

    def missing(self):
        """Frequencies (Hz) and names of branches that theory calls stable and no test reached, as a list of tuples."""
        several = self.response.count == 3
        lost = self.response.stable & ~self.reached()
        places = np.argwhere(lost)
        return [(float(self.response.frequency[i]), BRANCHES[j] if several[i] else "only") for i, j in places]

    def theory(self, band=(10.0, 80.0), parameters=None):
        """Theory as `FrequencyResponse` at 701 frequencies of a ``band`` (a pair in Hz), as lines between the tests.

        ``parameters`` are by default those of ``response``. `ValueError` if the band is not two ascending frequencies.
        """
        low, high = checks.pair("band", band, "Hz")
        parameters = self.response.parameters if parameters is None else parameters
        return frequency_response(parameters, self.response.force, np.linspace(low, high, 701))

    def summary(self):
        """One line: tests, named ones, what was missed."""
        names = np.concatenate(self.branch)
        named = np.isin(names, (*BRANCHES, "only")).sum()
        return (
            f"Overlay: {names.size} tests at {self.response.frequency.size} frequencies, {named} settled on a branch "
            f"of the theory; {len(self.missing())} branches it calls stable were not reached"
            f"{planar_word(self.rigs)}"
        )

    def table(self):
        """`pandas.DataFrame`: every frequency, trial, branch and status, with the distance from the theory."""
        import pandas as pd

        rows = []
        for test, status, branch in zip(self.tests, self.status, self.branch, strict=True):
            nearest, distance = _nearest(self.response, test)
            known = np.isin(branch, (*BRANCHES, "only"))
            columns = {
                "frequency [Hz]": test.frequency,
                "trial": [trial_name(tap) for tap in test.tap],
                "duration [s]": test.time[-1],
                "branch": branch,
                "status": status,
                "rig |z| [mm]": 1e3 * np.abs(test.relative),
                "theory |z| [mm]": np.where(known, 1e3 * np.abs(nearest), np.nan),
                "distance [%]": np.where(known, 100 * distance, np.nan),
                "message": test.message,
            }
            rows.append(pd.DataFrame(columns))
        return pd.concat(rows).sort_values(["frequency [Hz]", "duration [s]"], ignore_index=True, kind="stable")


def trial_name(tap):
    """What was done to the rig, in words."""
    return "from rest" if tap is None else f"tap {tap.velocity:g} m/s at {tap.time:.4f} s"


def overlay(parameters, *tests):
    """Name the branch every test ended on.

    Parameters
    ----------
    parameters : OscillatorParameters or RigParameters
        Of the theory: identified or nominal.
    *tests : SineTest
        At one and the same force.

    Returns
    -------
    Overlay

    Raises
    ------
    ValueError
        If there is no test, or the forces differ.
    """
    oscillator_of(parameters)
    if not tests or not all(isinstance(test, SineTest) for test in tests):
        raise ValueError(f"tests = {checks.shown(tests)} is not allowed; expected at least one SineTest")
    for test in tests:
        check_force("tests", test.shakers, ("current", "force"))
    forces = np.unique(np.concatenate([test.force for test in tests]))
    if forces.size != 1:
        raise ValueError(f"force = {forces[0]:g} to {forces[-1]:g} N in the tests; expected one force for one curve")
    frequency = np.unique(np.concatenate([test.frequency for test in tests]))
    response = frequency_response(parameters, forces[0], frequency)
    status, branch = zip(*(_name(response, test) for test in tests), strict=True)
    return Overlay(response, tests, status, branch)


def virtual_experiment(rig, force, frequency, theory=None, *, duration=3.0, progress=False, executor=None):
    """The paper's harmonic test, and the search for what it leaves out.

    At every frequency the rig is shaken from rest, and again with a light tap. What ``duration`` does not
    settle is run again for 6 s; and where theory has a stable branch that neither trial reached, sixteen more taps
    are tried, of four sizes at four instants of the period. No state is ever set by hand.

    Parameters
    ----------
    rig : RigParameters
    force : float
        Amplitude (N).
    frequency : array_like, shape (n,)
        Hz.
    theory : OscillatorParameters or RigParameters, optional
        What the rig is compared with, by default its own parameters.
    duration : float
        Of the first trials (s).
    progress, executor
        See `rigsim.experiment.sine_test.sine_test`.

    Returns
    -------
    Overlay
    """
    rig, theory = rig_of(rig, "rig"), rig if theory is None else theory
    oscillator_of(theory, "theory")
    progress, executor, _ = checks.running(progress, executor, None)
    force, duration = checks.positive("force", force, "N"), checks.real("duration", duration, "s", low=1.0)
    frequency = checks.array("frequency", frequency, "Hz", low=LOWEST)
    run = {"progress": progress, "executor": executor}
    count = len(frequency)
    tests = [sine_test(rig, force, np.tile(frequency, 2), [None] * count + [Tap()] * count, duration, **run)]
    first = tests[0]
    waiting = np.flatnonzero(np.isin(first.status, (Status.STILL_DRIFTING, Status.NOT_PERIODIC)))
    if waiting.size and duration < _PATIENCE:
        taps = [first.tap[i] for i in waiting]
        tests.append(sine_test(rig, force, first.frequency[waiting], taps, _PATIENCE, **run))
    missed = sorted({f for f, _ in overlay(theory, *tests).missing()})
    if missed:
        taps = [Tap(velocity=velocity, time=1 + part / f) for f in missed for velocity, part in _LADDER]
        tests.append(sine_test(rig, force, np.repeat(missed, len(_LADDER)), taps, _PATIENCE, **run))
    return overlay(theory, *tests)


def _nearest(response, test):
    """Theoretical z nearest to each test's (m), and the relative distance, both of shape (n,)."""
    theory = response.relative[np.searchsorted(response.frequency, test.frequency)]
    distance = np.abs(test.relative[:, None] - theory) / np.abs(theory)
    nearest = np.arange(len(theory)), np.where(np.isnan(distance), np.inf, distance).argmin(axis=1)
    return theory[nearest], distance[nearest]


def _name(response, test):
    """Status and branch of each test, both of shape (n,)."""
    at = np.searchsorted(response.frequency, test.frequency)
    nearest, distance = _nearest(response, test)
    order = (response.relative[at] == nearest[:, None]).argmax(axis=1)
    names = np.where(response.count[at] == 3, np.array(BRANCHES)[order], "only")
    # ~(<=), not >: the distance of a rig that flew apart is NaN
    status = np.where((test.status == Status.SETTLED) & ~(distance <= _NEAR), Status.ELSEWHERE, test.status)
    return status, np.where(status == Status.SETTLED, names, [str(one) for one in status])
