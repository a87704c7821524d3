"""The forces between which a converged detached curve exists, followed as a rig changes.

For any number of harmonics a curve begins and ends at stationary points of the response sheet
(`rigsim.orbits.response_sheet`). Two of them, the one before a rig's force and the one after it, are found once, then
followed by Newton's method from rig to rig, so that margins and tolerance studies can ask for them often.
"""

import math

import numpy as np

from .. import checks
from ..orbits.scenario import EventState, followed_to, force_scenario
from .variation import built_names, replaced


class Edges:
    """The events at which the converged curve of a kind at a force (N) begins and ends.

    Parameters
    ----------
    parameters, force, kind
        See `rigsim.design.margins.margins`.
    names : iterable of str
        What will be changed: fields of the parameters, or "force".
    harmonics, law
        See `rigsim.orbits.scenario.force_scenario`.

    Raises
    ------
    ValueError
        If there is no such curve at the force, or a name is another.
    """

    def __init__(self, parameters, force, kind, names, harmonics, law):
        self.names = tuple(checks.one_of("quantity", name, built_names(parameters)) for name in names)
        scenario = force_scenario(parameters, harmonics, law)
        low, high = None, EventState(math.nan, math.inf, None)
        for event, state in zip(scenario, scenario.states(), strict=True):
            gained = event.after.count(kind) - event.before.count(kind)
            if gained > 0 and event.force < force:
                low = state
            elif gained < 0 and event.force > force:
                high = state
                break
            elif gained < 0:
                low = None
        if low is None:
            changes = [f"{e.kind} at {e.force:.5g} N" for e in scenario if kind in e.before + e.after]
            raise ValueError(
                f"force = {force:g} N gives no converged {kind} detached curve; expected one between its events: "
                f"{', '.join(changes) or 'there are none'}"
            )
        self.parameters, self.force, self.law = parameters, force, law
        self.harmonics = scenario.sheet.harmonics
        self.nominal = low, high

    def moved(self, states, values, before=None):
        """The two events of a rig with ``values`` by name, from those ``states`` of one ``before``; None where lost."""
        before = {name: self._usual(name) for name in values} | (before or {})

        def rig(share):
            between = {name: (1 - share) * before[name] + share * value for name, value in values.items()}
            return replaced(self.parameters, self.force, between)[0]

        return tuple(one and self._moved(rig, one) for one in states)

    def _moved(self, rig, event):
        if math.isinf(event.force):
            return event
        try:
            return followed_to(rig, event, self.harmonics, self.law)
        except ValueError:  # no such rig
            return None

    def _usual(self, name):
        return self.force if name == "force" else float(np.mean(getattr(self.parameters, name)))

    def distance(self, states, values):
        """ln(F/F_edge) of the nearer event, positive between them; -infinity if one is lost."""
        if None in states:
            return -math.inf
        force = values.get("force", self.force)
        if not force > 0:
            return -math.inf
        return min(math.log(force / states[0].force), math.log(states[1].force / force))

    def judge(self, changes):
        """Distances (n,) of rigs with some numbers changed, a dict of new values (n,) by name."""
        rows = [dict(zip(changes, row, strict=True)) for row in zip(*changes.values(), strict=True)]
        return np.array([self.distance(self.moved(self.nominal, row), row) for row in rows])

    def reach(self, name, value, step, grid, accuracy=1e-9):
        """Largest distance of ``grid``, ascending, to which name = value + distance*step keeps the curve, and the next.

        The second is infinite if it is never lost.
        """
        inside, states, before = 0.0, self.nominal, {}
        for outside in grid:
            values = {name: value + outside * step}
            there = self.moved(states, values, before)
            if self.distance(there, values) <= 0:
                break
            inside, states, before = outside, there, values
        else:
            return inside, math.inf
        while outside - inside > accuracy * outside:
            middle = 0.5 * (inside + outside)
            values = {name: value + middle * step}
            there = self.moved(states, values, before)
            if self.distance(there, values) > 0:
                inside, states, before = middle, there, values
            else:
                outside = middle
        return inside, outside
