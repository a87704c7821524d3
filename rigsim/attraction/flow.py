"""The forced motion of Eqs. (3a, b) over whole and part periods, many states at once: the flow map that basins rest on.

States are (xs, z, xs', z') in SI units. With G = c z' + r(z), r the wires' force, and a tap's force T on the mass,

    xs'' = (F cos(omega t) - cs xs' - ks xs - G)/ms,        z'' = xs'' - (G + T)/m.

A fixed step makes every state run through the same instants, so that one cosine serves all of them and the innermost
loops run over states: they become vector instructions. The step is Dormand and Prince's of eighth order (Hairer,
Norsett and Wanner, Solving Ordinary Differential Equations I, section II.5) in Nystrom form: since the stages of the
displacements are velocities, only accelerations are kept, weighted by the matrices A and A A.
No operation mixes states, so a state's path is the same to the last bit whoever its neighbours are.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import DOP853

from .. import checks
from ..compiled import compiled
from ..model.wires import axial_force, spring_of
from ..parameters import OscillatorParameters, RigParameters, law_of, oscillator_of

_STAGES = 12
_LANES = 64  # states a block: their stages fit the fastest cache


def _tableau():
    """Weights of velocities and of displacements, a row a stage and one for the step, and the stages' instants."""
    velocity = np.vstack([DOP853.A[:_STAGES, :_STAGES], DOP853.B])
    displacement = velocity @ DOP853.A[:_STAGES, :_STAGES]
    displacement[abs(displacement) < 1e-14] = 0.0  # zero but for rounding
    return velocity, displacement, np.append(DOP853.C[:_STAGES], 1.0)


_VELOCITY, _DISPLACEMENT, _INSTANT = _tableau()


@compiled(forceinline=True)
def _stage(row, y, lo, n, h, a, xs, z, us, uz):
    """Displacements and velocities of ``n`` states from column ``lo`` on, at stage ``row``."""
    share = h * _INSTANT[row]
    for i in range(n):
        xs[i] = y[0, lo + i] + share * y[2, lo + i]
        z[i] = y[1, lo + i] + share * y[3, lo + i]
        us[i] = y[2, lo + i]
        uz[i] = y[3, lo + i]
    for j in range(min(row, _STAGES)):
        p, q = h * h * _DISPLACEMENT[row, j], h * _VELOCITY[row, j]
        if p != 0.0 or q != 0.0:
            for i in range(n):
                xs[i] += p * a[j, 0, i]
                z[i] += p * a[j, 1, i]
                us[i] += q * a[j, 0, i]
                uz[i] += q * a[j, 1, i]


@compiled(nogil=True)
def march(y, n, numbers, start, h, steps, tap, tap_start, tap_rate):
    """Move the first ``n`` columns of ``y`` (4, at least n) by ``steps`` steps of ``h`` (s) from ``start`` (s) on.

    ``numbers`` are `Flow.numbers`. ``tap`` (n,) is the peak force (N) of a half sine that begins at ``tap_start`` and
    runs through pi at ``tap_rate`` (rad/s); it acts all along, so march over just the pulse. Empty means none.
    """
    ms, ks, cs, m, c, spring, force, omega = numbers
    shaker, mass = 1.0 / ms, 1.0 / m
    a = np.empty((_STAGES, 2, _LANES))
    xs, z, us, uz = np.empty(_LANES), np.empty(_LANES), np.empty(_LANES), np.empty(_LANES)
    for lo in range(0, n, _LANES):
        lanes = min(_LANES, n - lo)
        for step in range(steps):
            for row in range(_STAGES):
                _stage(row, y, lo, lanes, h, a, xs, z, us, uz)
                t = start + (step + _INSTANT[row]) * h
                push = force * math.cos(omega * t)
                for i in range(lanes):
                    G = c * uz[i] + axial_force(spring, z[i])
                    a[row, 0, i] = (push - cs * us[i] - ks * xs[i] - G) * shaker
                    a[row, 1, i] = a[row, 0, i] - G * mass
                if tap.size:
                    shape = math.sin(tap_rate * (t - tap_start)) * mass
                    for i in range(lanes):
                        a[row, 1, i] -= shape * tap[lo + i]
            _stage(_STAGES, y, lo, lanes, h, a, xs, z, us, uz)
            for i in range(lanes):
                y[0, lo + i] = xs[i]
                y[1, lo + i] = z[i]
                y[2, lo + i] = us[i]
                y[3, lo + i] = uz[i]


_NO_TAP = np.empty(0)


@dataclass(frozen=True)
class Flow:
    """Forced motion at one force and frequency, by ``steps`` equal steps a period.

    Attributes
    ----------
    parameters : RigParameters or OscillatorParameters
    law : {"exact", "cubic"}
    force : float
        Amplitude F of F cos(omega t) (N).
    frequency : float
        Hz.
    steps : int
        A forcing period.
    """

    parameters: RigParameters | OscillatorParameters
    law: str
    force: float
    frequency: float
    steps: int

    def __post_init__(self):
        set_field = lambda name, value: object.__setattr__(self, name, value)  # noqa: E731
        set_field("law", law_of(self.parameters, self.law))
        set_field("force", checks.positive("force", self.force, "N"))
        set_field("frequency", checks.positive("frequency", self.frequency, "Hz"))
        set_field("steps", checks.integer("steps", self.steps, low=1))

    @property
    def period(self):
        """Of the force (s)."""
        return 1 / self.frequency

    @cached_property
    def numbers(self):
        """What the compiled loops read: ms, ks, cs, m, c, the `spring_of` the wires, force and omega; SI."""
        p, spring = oscillator_of(self.parameters), spring_of(self.parameters, self.law)
        return p.ms, p.ks, p.cs, p.m, p.c, spring, self.force, 2 * math.pi * self.frequency

    def refined(self, factor=2):
        """The same motion by ``factor`` times as many steps."""
        return Flow(self.parameters, self.law, self.force, self.frequency, factor * self.steps)

    def advance(self, states, periods=1.0, start=0.0):
        """States (n, 4) after ``periods`` forcing periods, begun at ``start`` periods after the force's peak.

        Whole periods from a whole start keep the step; parts of a period take equal steps no longer than that.
        """
        y = np.array(states, dtype=float).T.copy()
        steps = math.ceil(periods * self.steps * (1 - 1e-12))
        if steps:
            h = periods * self.period / steps
            march(y, y.shape[1], self.numbers, start * self.period, h, steps, _NO_TAP, 0.0, 0.0)
        return y.T.copy()

    def trace(self, states, periods, samples):
        """States (n, periods * samples, 4) at ``samples`` equal instants a period, from the start on.

        ``samples`` is multiplied by as many steps as accuracy asks for.
        """
        y = np.array(states, dtype=float).T.copy()
        each = math.ceil(self.steps / samples)
        h = self.period / (each * samples)
        result = np.empty((y.shape[1], periods * samples, 4))
        for k in range(periods * samples):
            result[:, k] = y.T
            march(y, y.shape[1], self.numbers, k * each * h, h, each, _NO_TAP, 0.0, 0.0)
        return result

    def tapped(self, state, start, velocity, duration):
        """States (n, 4) at the next peak of the force after taps on one ``state`` (4,), and how many periods later.

        The state is that at a peak of the force, ``start`` periods before the pulse of ``duration`` (s); ``velocity``
        (n,) is the impulse over m (m/s), see `rigsim.model.excitation.Tap`.
        """
        before = self.advance(np.reshape(state, (1, 4)), start)
        velocity = np.asarray(velocity, dtype=float)
        y = np.repeat(before.T, velocity.size, axis=1)
        m = self.numbers[3]
        # The pulse is over in a part of a period: it gets steps of its own, ends and all.
        steps = max(8, math.ceil(duration * self.frequency * self.steps))
        begun = start * self.period
        peak = m * velocity * math.pi / (2 * duration)
        march(y, velocity.size, self.numbers, begun, duration / steps, steps, peak, begun, math.pi / duration)
        over = start + duration * self.frequency
        end = math.ceil(over - 1e-12)
        return self.advance(y.T, max(end - over, 0.0), over), end


def accurate_flow(parameters, law, force, frequency, states, scale, tolerance=1e-6):
    """A `Flow` with as few steps a period as keep the given states (n, 4) accurate over their first period.

    That is within ``tolerance`` of ``scale`` (4,), what counts as one in each coordinate, from twice as many steps;
    `ValueError` if four thousand do not suffice.
    """
    steps = 12
    while steps <= 4096:
        flow = Flow(parameters, law, force, frequency, steps)
        difference = flow.advance(states) - flow.refined().advance(states)
        if (np.abs(difference) <= tolerance * scale).all():  # also false where a step was so long that it blew up
            return flow
        steps = math.ceil(1.2 * steps)
    reached = f"states reach out to z = {np.abs(states[:, 1]).max():g} m"
    raise ValueError(f"{reached}, too fast for {steps} steps a period; expected a smaller box")
