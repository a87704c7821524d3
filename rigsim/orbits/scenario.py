"""What happens to the pieces of the response as the force grows, in single-term theory or of converged motions."""

from dataclasses import dataclass, fields

import numpy as np

from .. import checks
from ..blas import one_blas_thread
from ..campaign.progress import reporting
from ..parameters import band_of, law_of
from ..results import Result, ResultSequence, frame
from ..theory import detached

_HALVINGS = 6  # of a change of the rig over which an event is not followed at once
_SYMMETRIC = ("inner", "outer", "hysteresis", "merger", "split", "exchange")  # how their events are called


@dataclass(frozen=True, eq=False)
class EventState:
    """Frequency (Hz), force (N) and lines of z (m) of a motion where F is stationary along a fold locus."""

    frequency: float
    force: float
    relative: np.ndarray


def followed(parameters, state, harmonics, law):
    """The `EventState` of a rig near that of a similar one; None if Newton's method finds none there."""
    from .harmonic_balance import balance
    from .loci import Sheet, stationary_near

    equations = balance(parameters, state.force, harmonics, law, symmetric=True)
    y = stationary_near(Sheet(equations), np.append(equations.unknowns(state.frequency, state.relative), 1.0))
    if y is None:
        return None
    frequency, _, _, relative = equations.lines(y[None, :-1])
    return EventState(float(frequency[0]), float(y[-1] * state.force), relative[0])


def followed_to(rig, state, harmonics, law, start=0.0, stop=1.0, halvings=_HALVINGS):
    """The `EventState` of ``rig(stop)`` from that of ``rig(start)``, shares of a way between two; None where lost."""
    found = followed(rig(stop), state, harmonics, law)
    if found is not None or halvings == 0:
        return found
    middle = 0.5 * (start + stop)
    half = followed_to(rig, state, harmonics, law, start, middle, halvings - 1)
    return half and followed_to(rig, half, harmonics, law, middle, stop, halvings - 1)


@dataclass(frozen=True, eq=False, repr=False)
class EventCurves(Result):
    """Where converged events lie as one number of a rig changes: between them its curves exist.

    Attributes
    ----------
    events : tuple of ForceEvent
        Of the rig itself.
    parameters : RigParameters or OscillatorParameters
    name : str
    own : float
        The rig's own value (SI units).
    values : (n,) array
    force, frequency : (n, k) array
        N and Hz; NaN where an event could not be followed to.
    """

    events: tuple
    parameters: object
    name: str
    own: float
    values: np.ndarray
    force: np.ndarray
    frequency: np.ndarray

    plots = {"curves": "event_curves_figure"}

    def table(self):
        """`pandas.DataFrame`: the force (N) of each event at each value."""
        columns = [f"{i} {event.kind} [N]" for i, event in enumerate(self.events, 1)]
        return frame(self.force, columns, index=None).set_axis(self.values, axis=0)

    def summary(self):
        """One line: what was followed, and how far."""
        lost = int(np.isnan(self.force).sum())
        told = f", {lost} points were not reached" if lost else ""
        low, high = self.values.min(), self.values.max()
        return f"EventCurves: {len(self.events)} events over {self.name} from {low:g} to {high:g}{told}"


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

    def states(self):
        """An `EventState` for each event, from which `followed` goes on."""
        folds = [(y, one.sheet) for one in self.sheet.exploration.loci[0] for y, _, _ in one.stationary]
        places = np.array([np.ravel(on.shown(y[None])[:2]) for y, on in folds]).reshape(-1, 2)
        result = []
        for event in self:
            y, on = folds[int(np.abs(places / (event.frequency, event.force) - 1).sum(axis=1).argmin())]
            result.append(EventState(event.frequency, event.force, on.equations.lines(y[None, :-1])[3][0]))
        return tuple(result)

    @one_blas_thread
    def over(self, name, values, *, progress=False):
        """The `EventCurves` of these events as one number of the rig changes.

        Parameters
        ----------
        name : str
            A number among the fields of the parameters.
        values : (n,) array_like
            SI units, ascending. Each event is followed outwards from the rig's own value, as far as it is there; the
            birth of hysteresis, no event of the pieces, is left out.
        progress : bool or callable
            True shows a bar; a callable is told (events followed, events in all).
        """
        sheet = self.sheet
        known = [one.name for one in fields(sheet.parameters) if one.metadata["allowed"] is not None or one.name == "k"]
        name = checks.one_of("name", name, known)
        own = float(np.mean(getattr(sheet.parameters, name)))
        values, progress = checks.array("values", values), checks.progress(progress)
        if not (np.diff(values) > 0).all():
            raise ValueError(f"values = {checks.shown(values)} is not allowed; expected them ascending")
        for end in values[[0, -1]].tolist():
            try:
                law_of(sheet.parameters.replace(**{name: end}))  # before any is followed
            except ValueError as error:
                raise ValueError(f"values: {error}") from None
        followed_ones = [pair for pair in zip(self, self.states(), strict=True) if "hysteresis" not in pair[0].kind]
        force, frequency = (np.full((values.size, len(followed_ones)), np.nan) for _ in range(2))
        sides = np.flatnonzero(values >= own), np.flatnonzero(values < own)[::-1]
        with reporting(progress, len(followed_ones), "events") as report:
            for column, (_, state) in enumerate(followed_ones):
                for side in sides:
                    here, before = state, own
                    for i in side:
                        here = followed_to(self._between(name, before, values[i]), here, sheet.harmonics, sheet.law)
                        if here is None:
                            break
                        force[i, column], frequency[i, column], before = here.force, here.frequency, values[i]
                report(column + 1)
        events = tuple(event for event, _ in followed_ones)
        return EventCurves(events, sheet.parameters, name, own, values, force, frequency)

    def _between(self, name, before, after):
        replaced = self.sheet.parameters.replace
        return lambda share: replaced(**{name: float((1 - share) * before + share * after)})

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
    law, harmonics, progress = law_of(parameters, law), checks.harmonics(harmonics), checks.progress(progress)
    band = None if band is None else band_of(parameters, band)
    force = None if force is None else checks.pair("force", force, "N")
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
