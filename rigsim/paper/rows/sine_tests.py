"""The points of Fig. 6, and Section 4: what the rig does when it is shaken by sines."""

import numpy as np

from ...results import Status
from ..printed import printed
from .entry import Entry, percent

_LIMIT = printed("Claims", "harmonics") / 100
_THIRD = "the cubic stiffness makes a third harmonic that grows with the amplitude of z, so on the higher branch"
_ABSORBED = (
    "above 60 Hz the suspended mass works as an absorber: the shaker's line at f is small, its harmonics are not"
)
_EDGE = "this close to the end of the detached curve, the start's transient takes the rig past its low side"


def _share(e, began, branch, where):
    """Verdict on the share of frequencies ``where`` tests that ``began`` so reach ``branch``."""
    trials = e.trials[where(e, e.trials["frequency"]) & began(e.trials)]
    if trials.empty:
        return False, "no test at such a frequency"
    reached = (trials["branch"] == branch).groupby(trials["frequency"]).any()
    told = f"at {reached.sum()} of {reached.size} frequencies"
    if not reached.all():
        lost = reached.index[~reached]
        which = f"{lost[0]:g}" if lost.size == 1 else f"{lost.size} from {lost[0]:g} to {lost[-1]:g}"
        told += f"; not at {which} Hz"
    return True if reached.all() else "partly" if reached.mean() > 0.5 else False, told


def _on_detached(e, frequency):
    return e.inside(frequency)


def _several(e, frequency):
    response = e.experiment.response
    return np.isin(frequency, response.frequency[response.count == 3])


def _settled(e):
    first = e.trials[e.trials["duration"] == e.trials["duration"].min()]
    share = (first["status"] == Status.SETTLED).groupby(first["from rest"]).mean()
    return (
        True if share.min() > 0.99 else "partly" if share.max() > 0.5 else False,
        f"{percent(share.get(True, 0), 3)} of the tests from rest and {percent(share.get(False, 0), 3)} of the "
        f"tapped ones are steady in the last second of {first['duration'].min():g} s",
    )


def _harmonics(e, channel):
    settled = e.trials[e.trials["status"] == Status.SETTLED]
    if settled.empty:
        return False, "no test settled"
    largest = settled.groupby("branch")[channel].max().sort_values(ascending=False)
    worst = settled.loc[settled[channel].idxmax()]
    listed = ", ".join(f"{percent(value)} {_where(branch)}" for branch, value in largest.items())
    told = f"largest {percent(worst[channel])}, at {worst['frequency']:g} Hz (by branch: {listed})"
    return worst[channel] < _LIMIT, told


def _where(branch):
    return "where there is one solution" if branch == "only" else f"on {branch}"


def _lower_harmonics(e):
    odd = e.trials[e.trials["status"] == Status.SUBHARMONIC]
    if odd.empty:
        return True, f"none in {len(e.trials)} tests"
    rest = int(odd["from rest"].sum())
    return False, (
        f"{len(odd)} of {len(e.trials)} tests, {rest} of them from rest, end in motions with a line below f that "
        f"is up to {odd['below'].max():.2g} times z's line at f, between {odd['frequency'].min():g} and "
        f"{odd['frequency'].max():g} Hz"
    )


def _agreement(e, branches):
    table = e.experiment.table()
    on = table[table["branch"].isin(branches)]
    if on.empty:
        return False, "no test ended there"
    worst = on.loc[on["distance [%]"].idxmax()]
    return worst["distance [%]"] < 5 or "partly", (
        f"z of {len(on)} tests within {worst['distance [%]']:.2g} % (at {worst['frequency [Hz]']:g} Hz), in the middle "
        f"{on['distance [%]'].median():.2g} %"
    )


def _reached(e):
    missing = e.experiment.missing()
    if not missing:
        return True, "every one was reached"
    listed = ", ".join(f"{'the only one' if branch == 'only' else branch} at {f:g} Hz" for f, branch in missing)
    return "partly", f"{len(missing)} stable solutions were reached by no test: {listed}"


ROWS = (
    Entry("Fig. 6", "three seconds are enough for the transient", _settled,
          "the suspended mass is lightly damped; those tests were run again for six seconds"),
    Entry("Fig. 6", "from rest the rig settles on the lower branch of the detached curve",
          lambda e: _share(e, lambda t: t["from rest"], "low", _on_detached), _EDGE),
    Entry("Fig. 6", "a light tap then takes it to the higher branch",
          lambda e: _share(e, lambda t: t["light tap"], "high", _on_detached),
          "where one tap does not do it, another size or another instant of the period may"),
    Entry("Fig. 6", "from rest it settles on the lower branch wherever there are several",
          lambda e: _share(e, lambda t: t["from rest"], "low", _several), _EDGE),
    Entry("Fig. 6", "a tap takes it to the higher branch wherever there are several",
          lambda e: _share(e, lambda t: ~t["from rest"], "high", _several),
          "taps of four sizes at four instants were tried there: above the detached curve the rig ends in subharmonic "
          "motions or falls back"),
    Entry("Fig. 6", "rig and analytic solution agree, lower branch", lambda e: _agreement(e, ["low"])),
    Entry("Fig. 6", "rig and analytic solution agree, higher branch", lambda e: _agreement(e, ["high"]),
          "the third harmonic, which single-term theory leaves out"),
    Entry("Fig. 6", "rig and analytic solution agree where there is one", lambda e: _agreement(e, ["only"])),
    Entry("Fig. 6", "every stable solution can be reached", _reached,
          "stability about the single-term orbit is not that of the rig's own motion; and close to its end, hardly any "
          "start leads to the low side of the detached curve"),
    Entry("Section 4", "harmonics of the shaker xs below 5 %", lambda e: _harmonics(e, "shaker"), _ABSORBED),
    Entry("Section 4", "harmonics of the mass x below 5 %", lambda e: _harmonics(e, "mass"), _THIRD),
    Entry("Section 4", "harmonics of the relative displacement z below 5 %", lambda e: _harmonics(e, "z"), _THIRD),
    Entry("Section 4", "no lower harmonics", _lower_harmonics,
          "subharmonic motions that the single-term theory does not know; a tap can start them"),
)  # fmt: skip
