"""A motion that lasts, and all of them at one force and frequency, each under an integer that stays its own."""

from dataclasses import dataclass
from numbers import Integral

import numpy as np

from .. import checks
from ..results import Result, ResultSequence, frame
from .flow import Flow
from .settle import until_trapped


@dataclass(frozen=True, eq=False, repr=False)
class Attractor(Result):
    """A motion that lasts.

    Attributes
    ----------
    motion : int
        Its identifier among the `Attractors`, which is also its place there; others found later change neither.
    name : str
        For people: "low", "middle", "high" or "only" where its line at f is that of a single-term solution;
        "subharmonic 1/n" if it repeats after n periods; "not periodic"; or "other". Several may bear the same name.
    period : int
        Forcing periods after which it repeats, 1 to 6; 0 for none.
    orbit : (k, 4) array
        States (xs, z, xs', z') at successive peaks of the force, SI; as many as the period, or a sample if it has none.
    amplitude : float
        Largest abs(z) (m).
    frequency : (l,) array
        Lines of the motion (Hz): 0 for the mean, then multiples of f/period up to 9 f. Empty if not periodic.
    shaker, mass, relative : (l,) complex array
        The lines of xs, x and z (m).
    multipliers : (4,) complex array
        Floquet multipliers over the whole period; NaN if not periodic.
    symmetric : bool
        Whether it is its own mirror image; if not, its twin is counted with it.
    """

    motion: int
    name: str
    period: int
    orbit: np.ndarray
    amplitude: float
    frequency: np.ndarray
    shaker: np.ndarray
    mass: np.ndarray
    relative: np.ndarray
    multipliers: np.ndarray
    symmetric: bool

    @property
    def giveaway(self):
        """Strongest line of z below the force's frequency: (frequency in Hz, amplitude in m); None at period 1."""
        if self.period < 2:
            return None
        at = 1 + int(np.abs(self.relative[1 : self.period]).argmax())
        return float(self.frequency[at]), float(abs(self.relative[at]))

    @property
    def path(self):
        """z (m) and z' (m/s) along the whole orbit, summed from its lines, (2, 400); of no points if not periodic."""
        rate = 2j * np.pi * self.frequency
        time = np.linspace(0, self.period / self.frequency[self.period], 400) if self.period else np.empty(0)
        waves = np.exp(rate * time[:, None])
        return np.array([(waves @ self.relative).real, (waves @ (rate * self.relative)).real])

    def summary(self):
        """One line with name, period and size."""
        if self.period == 0:
            return f"Attractor '{self.name}': no period was found, z up to {1e3 * self.amplitude:.4g} mm"
        below = f", line of {1e3 * self.giveaway[1]:.3g} mm at {self.giveaway[0]:.4g} Hz" if self.giveaway else ""
        return (
            f"Attractor '{self.name}': period {self.period}, z up to {1e3 * self.amplitude:.4g} mm, "
            f"{1e3 * abs(self.relative[self.period]):.4g} mm at f{below}, "
            f"largest multiplier {abs(self.multipliers).max():.3f}"
        )


@dataclass(frozen=True, eq=False, repr=False)
class Attractors(ResultSequence):
    """Every `Attractor` found at one force and frequency, and where any state leads; what `attractors` returns.

    Attributes
    ----------
    members : tuple of Attractor
        By identifier: single-term branches first, in order of amplitude, then others, then what was learnt later.
    flow : Flow
        Parameters, law, force and frequency, and the steps by which states are run.
    box : (4,) array
        Half sizes of the box of starts.
    starts, seed : int
        Of the search.
    patience : int
        Periods after which a state that nothing has trapped is left undecided.
    points : (k, 4) array
        Centres of the traps, at peaks of the force.
    metrics : (k, 4, 4) array
        A state y is trapped at point p if (y - p) M (y - p) < 1.
    owner : (k,) array of int
        Which motion each belongs to.
    """

    members: tuple
    flow: Flow
    box: np.ndarray
    starts: int
    seed: int
    patience: int
    points: np.ndarray
    metrics: np.ndarray
    owner: np.ndarray

    plots = {"motions": "attractors_figure"}

    @property
    def names(self):
        """What people call the motions, a list in their order; those of one name carry their identifiers, too."""
        names = [one.name for one in self]
        return [name if names.count(name) == 1 else f"{name} #{i}" for i, name in enumerate(names)]

    def find(self, motion):
        """The attractor of an identifier, or of a name that only one bears."""
        number = isinstance(motion, Integral) and not isinstance(motion, bool)
        known = [number and motion == one.motion or isinstance(motion, str) and motion == one.name for one in self]
        found = [one for one, same in zip(self, known, strict=True) if same]
        if len(found) != 1:
            told = ", ".join(f"{one.motion} ({one.name})" for one in self)
            expected = f"one of {told}, by its number if names repeat"
            raise ValueError(f"motion = {checks.shown(motion)} is not allowed; expected {expected}")
        return found[0]

    def settle(self, states, **options):
        """Which motion each state (n, 4) leads to, -1 where it is undecided, and after how many periods.

        Two (n,) arrays of int. States are those at a peak of the force, SI. What nothing traps counts as not periodic
        where there is such a motion. Options are ``progress``, ``executor``, ``checkpoint`` and ``label`` of the run.
        """
        states = checks.array("states", states, ndim=2, physical=False)
        if states.shape[1] != 4:
            raise ValueError(f"states have {states.shape[1]} columns; expected 4, one for each of xs, z, xs', z'")
        return self.settled(states, **options)

    def settled(self, states, **options):
        """As `settle`, of an array (n, 4) that need not be finite: a tap may throw the mass away."""
        done = until_trapped(self, states, self.patience, **options)
        found = done["label"]
        for endless in (one.motion for one in self if one.period == 0):
            found = np.where((found < 0) & np.isfinite(done["states"]).all(axis=1), endless, found)
        return found, done["periods"]

    def table(self):
        """`pandas.DataFrame`, a row a motion."""
        rows = []
        for one in self:
            at_f = 1e3 * abs(one.relative[one.period]) if one.period else np.nan
            size = 1e3 * one.amplitude, at_f, abs(one.multipliers).max()
            rows.append((one.motion, one.name, one.period or "none", *size))
        return frame(rows, ["motion", "name", "period", "largest |z| [mm]", "|z| at f [mm]", "largest multiplier"])

    def summary(self):
        """One line: which motions there are."""
        told = ", ".join(self.names)
        return f"Attractors at {self.flow.frequency:g} Hz and {self.flow.force:g} N, from {self.starts} starts: {told}"
