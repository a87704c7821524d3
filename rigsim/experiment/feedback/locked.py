"""A phase-locked loop: the force's frequency follows the phase of a motion, so that phase resonance can be followed.

The force is F cos(theta), theta' = 2 pi f. An adaptive filter keeps the lines a_n of the signal at the multiples n of
theta, by a share of what they leave of each sample, so that neither harmonics nor the mean disturb the phase it tells.
The frequency follows the error of that phase, e = arg a_1 - phase, by a proportional and an integral part,

    f = f_0 + K (tau e + integral of e),    K = -rate / (dphase/df),    tau = 2 m/c,

whose zero lies on the decay of the free mass, so that what is left is an integrator of the given rate. The slope of the
phase is that of one harmonic of the design's model at the amplitude and frequency of the moment, the amplitude held:
that of a constant force changes its sign where the response folds, beside which the loop is to go on.
"""

from dataclasses import dataclass

import numpy as np

from ... import checks
from ...campaign.cost import affordable
from ...campaign.progress import reporting
from ...campaign.stop import look
from ...compiled import compiled
from ...model.chipmunk import STARTS, RigSpace, check_step, leapfrog
from ...model.oscillator import oscillator_modes
from ...parameters import OscillatorParameters, RigParameters, oscillator_of, rig_of
from ...results import ResultSequence, Status, counted, frame
from ..kept import Kept
from .balance import phase_slope
from .loop import substeps
from .sweep import held

_WEIGHTS = {"relative": (1.0, -1.0), "mass": (0.0, 1.0), "shaker": (1.0, 0.0)}  # of xs and x
_BLOCK = 100  # samples between two looks at the keyboard, and at the gain
_LINES = 5  # multiples that the filter keeps, and that are read
_FILTER = 3.0  # periods in which it follows the signal
_RATE = 3.0  # 1/s, of the loop
_SLOWEST = 2.0  # s, longest decay of the free mass that the loop counts on
_RAMP = 0.5  # s in which force and phase go to the next
_ERROR, _WANDER, _OFF = np.radians(1.0), 3e-4, np.radians(20.0)  # of a locked motion at most; a lost one has more
_SLOPES = 0.05, 10.0  # rad/Hz, within which slopes of the phase are believed
_RANGE = 1.0, 200.0  # Hz


@dataclass(frozen=True, eq=False)
class LockedMotion:
    """A motion at a phase: see `PhaseLockedTest` for its numbers."""

    force: float
    phase: float
    frequency: float
    shaker: complex
    mass: complex
    relative: complex
    error: float
    wander: float
    status: Status
    message: str


@dataclass(frozen=True, eq=False, repr=False)
class PhaseLockedTest(Kept, ResultSequence):
    """What `phase_locked_test` returns: a sequence of `LockedMotion`, in the order in which they were followed.

    A motion has its ``force`` (N) and asked ``phase`` (deg), the ``frequency`` (Hz) that the loop found, the first
    lines of ``shaker``, ``mass`` and ``relative`` (complex, m, phase against the force), the ``error`` of the phase
    (deg), the ``wander`` of the frequency from one half of the window to the other, over itself, and ``status`` and
    ``message``: held (within 1 degree and 3e-4), still drifting, lost (20 degrees off), or flew apart, which ends the
    test.

    Attributes
    ----------
    members : tuple of LockedMotion
    parameters : RigParameters
    model : OscillatorParameters
    signal : {"relative", "mass", "shaker"}
    bench_time : float
        s.
    """

    members: tuple
    parameters: RigParameters
    model: OscillatorParameters
    signal: str
    bench_time: float

    plots = {"backbone": "phase_locked_figure"}
    units = {"error": "deg"}

    @property
    def frequency(self):
        """Hz, shape (n,)."""
        return np.array([one.frequency for one in self])

    def summary(self):
        """One line: motions, of which status, where, and the bench's time."""
        told = counted(one.status for one in self)
        return (
            f"PhaseLockedTest of {len(self)} motions by the phase of {self.signal}, {np.nanmin(self.frequency):.4g} to "
            f"{np.nanmax(self.frequency):.4g} Hz: {told}; {self.bench_time / 60:.3g} min of a bench"
        )

    def to_dataframe(self):
        """`pandas.DataFrame` with a row per motion."""
        rows = [
            {
                "force [N]": one.force,
                "phase [deg]": one.phase,
                "frequency [Hz]": one.frequency,
                "|xs| [mm]": 1e3 * abs(one.shaker),
                "|x| [mm]": 1e3 * abs(one.mass),
                "|z| [mm]": 1e3 * abs(one.relative),
                "error [deg]": one.error,
                "status": one.status,
            }
            for one in self
        ]
        return frame(rows)

    table = to_dataframe


def phase_locked_test(
    parameters, force, phase=90.0, frequency=None, design=None, *, signal="relative", sample_rate=2000, patience=30.0,
    average=1.0, start="rest", step=5e-5, progress=False,
):  # fmt: skip
    """`PhaseLockedTest`: follow the motion that has a given phase against the force, step by step of force and phase.

    With z at 90 degrees (of x - xs, which is -z, a lag of 90 degrees) and the force stepped up this is phase resonance:
    the backbone from rest. Which motion is found where several have the phase depends on where the loop comes from; a
    curve none of whose motions has the phase is not found. Of the default rig's detached curve at 3.18 N that holds at
    90 degrees: there the phase of z is between -61 and 2 degrees.

    Parameters
    ----------
    parameters : RigParameters
    force, phase : float or array_like, shape (n,)
        Amplitude of the force (N) and phase of the signal against it (deg), in the order in which they are stepped;
        they broadcast.
    frequency : float, optional
        Where the oscillator begins (Hz); by default the lower natural frequency of the model.
    design : OscillatorParameters, optional
        The model that the loop's gains follow from; by default, the rig's own Eq. (2).
    signal : {"relative", "mass", "shaker"}
        Whose phase: z, x or xs.
    sample_rate : float
        Of the digital loop (Hz), whose force is held from sample to sample.
    patience, average : float
        s for each step, after its ramp of 0.5 s, until it is held; it is read over every ``average`` s of them.
    start : {"rest", "equilibrium"}
    step : float
        Integration step (s); shortened to divide a sample.
    progress : bool or callable
        True shows a bar; a callable is told (steps done, steps in all).

    Raises
    ------
    ValueError
        If an argument is not allowed, force and phase do not broadcast, or the step is unstable.
    """
    rig, progress = rig_of(parameters), checks.progress(progress)
    model = oscillator_of(rig if design is None else design, "design")
    force = checks.array("force", force, "N", low=0.0, low_open=True)
    phase = checks.array("phase", phase, "deg", low=-360.0, high=360.0)
    if 1 not in (force.size, phase.size) and force.size != phase.size:
        raise ValueError(f"phase has {phase.size} elements; expected 1 or {force.size}, as many as force")
    begin = float(oscillator_modes(model).frequency[0]) if frequency is None else frequency
    begin = checks.real("frequency", begin, "Hz", low=_RANGE[0], high=_RANGE[1])
    signal, start = checks.one_of("signal", signal, tuple(_WEIGHTS)), checks.one_of("start", start, STARTS)
    sample_rate = checks.real("sample_rate", sample_rate, "Hz", low=1000.0, high=1e6)
    average = checks.real("average", average, "s", low=0.5, high=1e3)
    patience = checks.real("patience", patience, "s", low=average, high=1e4)
    step = checks.positive("step", step, "s")
    check_step([rig], step)
    steps = list(zip(*(one.tolist() for one in np.broadcast_arrays(force, phase)), strict=True))
    seconds = len(steps) * (_RAMP + patience)
    affordable(f"{len(steps)} steps", seconds=seconds * sample_rate * 2e-5, instead="fewer or shorter ones")
    loop, members = _Lock(rig, model, signal, sample_rate, begin, start, step), []
    with reporting(progress, len(steps), "phase-locked test") as report:
        for F, degrees in steps:
            loop.run(F, np.radians(degrees), _RAMP)
            for _ in range(int(np.ceil(patience / average))):
                found = _read(loop, F, degrees, loop.run(F, np.radians(degrees), average))
                if found.status in (Status.HELD, Status.FLEW_APART):
                    break
            members.append(found)
            report(len(members))
            if members[-1].status is Status.FLEW_APART:
                break
    return PhaseLockedTest(tuple(members), rig, model, signal, loop.done / sample_rate)


class _Lock:
    """The loop on one rig; time goes on from call to call."""

    def __init__(self, rig, model, signal, rate, frequency, start, step):
        self._every = substeps(rate, step)
        self._space = RigSpace([rig], 1 / (rate * self._every), start)
        self.model, self.rate, self.signal = model, rate, signal
        self._offset, self._base, self._aim = rig.LG, frequency, None
        self._decay = 2 * model.m / max(model.c, 2 * model.m / _SLOWEST)
        self._filter = np.zeros((2, _LINES + 1), dtype=complex)  # of the signal, and of z
        self._state = np.array([0.0, frequency, 0.0, 0.0])  # theta, f, the integral part, the force until now
        self.done = 0

    @property
    def parted(self):
        """When the rig flew apart (s), else NaN."""
        return float(self._space.handed[-1][0])

    def run(self, force, phase, seconds):
        """Go to a force (N) and a phase (rad); returned are rows of theta, f, its slow part (Hz), xs, x."""
        samples, aim = int(np.ceil(seconds * self.rate)), np.array([force, phase])
        share = np.minimum(np.arange(1, samples + 1) / (_RAMP * self.rate), 1.0)[:, None]
        before = np.array([0.0, phase]) if self._aim is None else self._aim
        path, told, weights = before + share * (aim - before), np.empty((samples, 5)), _WEIGHTS[self.signal]
        for first in range(0, samples, _BLOCK):
            look()
            part = slice(first, first + _BLOCK)
            slope = phase_slope(self.model, self._state[1], abs(self._filter[1, 1]))
            gain = _RATE / np.clip(-slope, *_SLOPES)
            _run(
                *self._space.handed, self._space.step, self._every, self._space.done, self._offset, path[part],
                self.rate, self._base, gain, self._decay, weights, self._filter, self._state,
                told[part],
            )  # fmt: skip
            self._space.done += len(path[part]) * self._every
        self._aim = aim
        self.done += samples
        return told


@compiled(nogil=True)
def _run(
    each_body, space_step, space, read_handles, read, write_handles, write,
    rigs, wires, mass, flown, reach, drives, circuits, slack, parted, h, every, done, offset,
    path, rate, base, gain, decay, weights, lines, state, told,
):  # fmt: skip
    """`_Lock.run` with a gain that stays; ``lines`` and ``state`` are its."""
    kicks, taps, positions = np.empty((every, 1)), np.zeros((every, 1)), np.empty((1, 4, 1))
    sent, nominal = np.empty((1, 2, 1)), np.zeros((1, 1), dtype=np.complex128)  # no drives
    for k in range(len(path)):
        force, wanted = path[k]
        theta, f = state[0], state[1]
        now = force * np.cos(theta)
        kicks[0, 0], kicks[1:, 0] = 0.5 * (state[3] + now), now
        leapfrog(
            each_body, space_step, space, read_handles, read, write_handles, write,
            rigs, wires, mass, flown, reach, drives, circuits, slack, parted, kicks, taps, nominal,
            h, done + k * every, every, positions, sent,
        )  # fmt: skip
        xs, x = positions[0, 0, 0], positions[0, 1, 0] - offset * np.cos(positions[0, 3, 0])
        told[k, 0], told[k, 1], told[k, 2], told[k, 3], told[k, 4] = theta, f, base + state[2], xs, x
        signals = weights[0] * xs + weights[1] * x, xs - x
        for j in range(2):
            left = signals[j]
            for n in range(lines.shape[1]):
                left -= (lines[j, n] * np.exp(1j * n * theta)).real
            for n in range(lines.shape[1]):
                lines[j, n] += 2 * f / (_FILTER * rate) * left * np.exp(-1j * n * theta)
        # Against the force that acts, half a sample after its samples.
        error = np.angle(lines[0, 1] * np.exp(1j * (np.pi * f / rate - wanted)))
        state[2] += gain * error / rate
        state[1] = min(max(base + state[2] + gain * decay * error, _RANGE[0]), _RANGE[1])
        state[0] = (theta + 2 * np.pi * f / rate) % (2 * np.pi)
        state[3] = now


def _read(loop, force, degrees, told):
    """`LockedMotion` of a window of a `_Lock`: lines at the multiples of its own phase, by least squares."""
    theta, frequency, slow, *readings = told.T
    turns = np.exp(1j * np.outer(theta, np.arange(1, _LINES + 1)))
    basis = np.column_stack([np.ones(len(theta)), turns.real, turns.imag])
    found = np.linalg.lstsq(basis, np.column_stack(readings), rcond=None)[0]
    mean = float(frequency.mean())
    late = held(mean / loop.rate)  # phases are against the force that acts, half a sample after its samples
    xs, x = (found[1] - 1j * found[1 + _LINES]) * abs(late) / late
    lines = {"shaker": xs, "mass": x, "relative": xs - x}
    error = float(np.angle(lines[loop.signal] * np.exp(-1j * np.radians(degrees))))
    half = len(theta) // 2
    wander = float(abs(slow[half:].mean() / slow[:half].mean() - 1))
    told = f"the phase is {np.degrees(error):.2g} deg off, the frequency wanders by {wander:.2g} between half windows"
    status = Status.STILL_DRIFTING
    if np.isfinite(loop.parted):
        status, told = Status.FLEW_APART, f"past its wires' reach at t = {loop.parted:.4g} s"
    elif abs(error) > _OFF:
        status = Status.LOST
    elif abs(error) < _ERROR and wander < _WANDER:
        status = Status.HELD
    lines = {name: complex(line) for name, line in lines.items()}
    return LockedMotion(
        force, degrees, mean, **lines, error=float(np.degrees(error)), wander=wander, status=status, message=told
    )
