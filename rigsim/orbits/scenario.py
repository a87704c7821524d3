"""What happens to the pieces of the response as the force grows, in single-term theory or of converged motions."""

from dataclasses import dataclass

import numpy as np

from ..results import ResultSequence, frame
from ..theory import detached

_SYMMETRIC = ("inner", "outer", "hysteresis", "merger", "split", "exchange")  # how their events are called


@dataclass(frozen=True, eq=False, repr=False)
class ConvergedScenario(ResultSequence):
    """Events of converged motions as the force grows; what `force_scenario` with several harmonics returns.

    Attributes
    ----------
    members : tuple of ForceEvent
        Of symmetric motions.
    sheet : rigsim.orbits.response_sheet.ResponseSheet
        On which they lie, with events of the other motions among its ``events``.
    single_term : ForceScenario
        What single-term theory says instead.
    """

    members: tuple
    sheet: object
    single_term: detached.ForceScenario

    plots = {"scenario": "sheet_figure"}

    def summary(self):
        """How many events, and over which forces."""
        told = f", from {self[0].force:.4g} to {self[-1].force:.4g} N" if self.members else ""
        return f"{len(self)} events of motions of {self.sheet.harmonics} harmonics as the force grows{told}"

    def table(self):
        """`pandas.DataFrame` of the events, with the nearest one of single-term theory, if any is within a quarter."""
        rows = []
        for event in self:
            apart = [
                (max(abs(one.force / event.force - 1), abs(one.frequency / event.frequency - 1)), one.force)
                for one in self.single_term
            ]
            near, force = min(apart, default=(np.inf, np.nan))
            rows.append((event.force, event.frequency, event.kind, force if near < 0.25 else np.nan))
        return frame(rows, ["force [N]", "frequency [Hz]", "event", "single-term force [N]"])


def force_scenario(parameters, harmonics=1, law=None, *, band=None, force=None, progress=False):
    """Every birth, split, merger and death of pieces of the response as the force grows.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    harmonics : int or "auto"
        1: single-term theory, all its events at all forces, exactly. More: converged events on the response sheet.
    law : {"exact", "cubic"}, optional
        Of the converged motions; single-term theory has the cubic one.
    band : (float, float), optional
        Frequencies (Hz) of converged events; by default well beyond all single-term ones.
    force : (float, float), optional
        Forces (N) likewise.
    progress : bool or callable
        See `response_sheet`.

    Returns
    -------
    rigsim.theory.detached.ForceScenario or ConvergedScenario
        Sequences of `ForceEvent`, ascending in force.

    Raises
    ------
    ValueError
        If an input is not allowed, or there is no single-term event that would tell band and force.
    """
    single = detached.force_scenario(parameters)
    if harmonics == 1:
        return single
    if (band is None or force is None) and not len(single):
        raise ValueError("band and force are needed where single-term theory has no events; expected pairs (Hz, N)")
    places = [event.frequency for event in single]
    band = band or (0.6 * min(places), 1.8 * max(places))
    force = force or (0.5 * single[0].force, 1.5 * single[-1].force)
    from .response_sheet import response_sheet  # which single-term theory can do without

    sheet = response_sheet(parameters, band, force, harmonics, law, progress=progress)
    members = tuple(event for event in sheet.events if event.kind.startswith(_SYMMETRIC))
    return ConvergedScenario(members, sheet, single)
