"""What a protocol found on the bench: its points in order, the jumps between them, and its motion as a record."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ... import checks
from ...campaign.cost import affordable
from ...results import ResultSequence, Status, counted, frame, spanned
from ..kept import Kept
from ..out_of_plane import planar_word
from ..record import Record
from .bench import replay
from .jumps import jumps_between, jumps_in_passing

_SAMPLE, _STEP = 200, 7e-7  # bytes a sample, seconds a step


@dataclass(frozen=True)
class BenchPoint:
    """One reading of a test; complex amplitudes are zero to peak, their phase against the force.

    Attributes
    ----------
    run : int
        Which of the benches side by side.
    time : float
        When its motion had been seen, or half of it of one that moves on (s from the beginning of the test).
    force, frequency : float
        N, Hz.
    shaker, mass, relative : complex
        Lines of xs, x and z at the force's frequency (m).
    tilt : float
        Largest (rad).
    distortion : ndarray, shape (3,)
        Largest harmonic over the fundamental, of xs, x and z: 2-10 of a point, 2-5 of one that moves on.
    subharmonic : ndarray, shape (2,)
        As `rigsim.experiment.sine_test.SineTest` has it; of a reading in passing, of lines at f/3, f/2 and 2f/3.
    drift : float
        Change of z from the last half second but one to the last, over their mean; as measured, which noise may make
        larger than that of the motion.
    left : float
        Share of z that it was yet to go, estimated; NaN where that cannot be told.
    dwell : float
        How long the rig was shaken there, or the length of the window (s).
    velocity : float
        Of the tap before it (m/s), 0 for none.
    tries : int
        Number of taps that were tried there.
    error : float
        Of a reading in passing: what its window smooths away, a share of z; NaN of the first and last two.
    status : Status
        Of the motion, whatever it is measured with.
    message : str
    given : ndarray, complex, shape (3,)
        By a `ShakerDrive`: lines of the force on the frame (N) and of the voltage at the coil (V), phase against the
        cosine that was asked for, and the force's largest harmonic over its fundamental. NaN without one.
    """

    run: int
    time: float
    force: float
    frequency: float
    shaker: complex
    mass: complex
    relative: complex
    tilt: float
    distortion: np.ndarray
    subharmonic: np.ndarray
    drift: float
    left: float
    dwell: float
    velocity: float
    tries: int
    error: float
    status: Status
    message: str
    given: np.ndarray


def _column(name):
    return property(lambda self: self.column(name), doc=f"``{name}`` of each point, an array.")


@dataclass(frozen=True, eq=False, repr=False)
class BenchTest(Kept, ResultSequence):
    """Points of a test on one bench or several, a sequence of `BenchPoint` in the order they were read, bench by bench.

    ``force``, ``frequency``, ``shaker``, ``mass``, ``relative``, ``status``, ``time``, ``dwell`` and ``left`` are
    theirs as arrays.

    Attributes
    ----------
    members : tuple of BenchPoint
    protocol : str
        The call that made it.
    over : {"frequency", "force"}
        What was moved.
    parameters : tuple of RigParameters, length n
        The rig on each bench.
    drives : tuple of tuple of Drive, length n
        The force, stretch by stretch.
    sensors : tuple of Sensors or None, length n
    start : str
    step : float
        s.
    shakers : tuple of ShakerDrive or None, length n
        What drives each bench; ``force`` is what was asked of it.
    """

    members: tuple
    protocol: str
    over: str
    parameters: tuple
    drives: tuple
    sensors: tuple
    start: str
    step: float
    shakers: tuple

    plots = {"points": "bench_test_figure", "waits": "waits_figure"}

    force, frequency, status = _column("force"), _column("frequency"), _column("status")
    shaker, mass, relative = _column("shaker"), _column("mass"), _column("relative")
    time, dwell, left = _column("time"), _column("dwell"), _column("left")

    def column(self, name):
        """Any field of the points by its name, an array with a row a point."""
        name = checks.one_of("name", name, tuple(BenchPoint.__dataclass_fields__))
        return np.array([getattr(point, name) for point in self.members])

    @cached_property
    def runs(self):
        """Tuple of tests of one bench each, that this one is made of."""
        return tuple(
            replace(
                self,
                members=tuple(replace(point, run=0) for point in self.members if point.run == i),
                **{name: getattr(self, name)[i : i + 1] for name in ("parameters", "drives", "sensors", "shakers")},
            )
            for i in range(len(self.parameters))
        )

    @property
    def passing(self):
        """Whether the force moved on all the while."""
        return any(drive.force != drive.force_end or drive.frequency != drive.frequency_end
                   for drives in self.drives for drive in drives)  # fmt: skip

    @property
    def bench_time(self):
        """How long the shakers ran, all benches together (s)."""
        return sum(drive.duration for drives in self.drives for drive in drives)

    @cached_property
    def jumps(self):
        """Tuple of `JumpSeen`, of all benches in order: where z changed by more than the force's moving on explains."""
        find = jumps_in_passing if self.passing else jumps_between
        return tuple(jump for run in self.runs for jump in find(run))

    def to_record(self, run=0, sample_rate=2000.0):
        """The whole time history of one bench as a `Record`, measured by its sensors.

        The rig is run once more, to the same bits, so that nothing is kept that nobody asks for. The sensors' noise is
        another stretch of it than that in the points.

        Parameters
        ----------
        run : int
            Which bench.
        sample_rate : float
            Samples a second (Hz); the nearest that takes whole steps.
        """
        run = checks.integer("run", run, low=0, high=len(self.parameters) - 1)
        sample_rate = checks.real("sample_rate", sample_rate, "Hz", low=10.0, high=(1 + 1e-9) / self.step)
        every = max(1, round(1 / (sample_rate * self.step)))
        steps = sum(drive.steps for drive in self.drives[run])
        given = f"sample_rate = {sample_rate:g} Hz for {steps * self.step:.4g} s"
        affordable(given, memory=_SAMPLE * steps / every, seconds=_STEP * steps, instead="a lower rate")
        drive = self.shakers[run]
        found = replay(self.parameters[run], self.drives[run], self.start, self.step, every, drive)
        shaker, mass, tilt, force, voltage = found.T
        if self.sensors[run] is not None:
            time = every * self.step * np.arange(force.size)
            number = sum(point.run == run for point in self.members) + 2  # after those of all points
            shaker, mass = self.sensors[run].measured(time, np.column_stack([shaker, mass]), number).T
        known = {"parameters": self.parameters[run], "step": self.step, "start": self.start, "tilt": tilt}
        known |= {"voltage": voltage} if drive else {}
        return Record(force, shaker, mass, 1 / (every * self.step), "band-limited", **known)

    def summary(self):
        """One line: which protocol, what it met, and how long it took."""
        benches = f"{len(self.parameters)} benches, " if len(self.parameters) > 1 else ""
        return (
            f"{self.protocol}: {benches}{len(self)} points from {spanned(self.frequency)} Hz, {spanned(self.force)} N: "
            f"{counted(self.status)}; {len(self.jumps)} jumps; {self.bench_time / 60:.3g} min on the bench"
            f"{planar_word(self.parameters)}"
        )

    def table(self):
        """`pandas.DataFrame` with a row a point."""
        given = self.column("given")
        columns = {
            "bench": self.column("run"),
            "time [s]": self.time,
            "frequency [Hz]": self.frequency,
            "force [N]": self.force,
            "|xs| [mm]": 1e3 * abs(self.shaker),
            "|x| [mm]": 1e3 * abs(self.mass),
            "|z| [mm]": 1e3 * abs(self.relative),
            "z harmonics [%]": 100 * self.column("distortion")[:, 2],
            "tap [m/s]": self.column("velocity"),
            "shaken for [s]": self.dwell,
            "left to go [%]": 100 * self.left,
            "error [%]": 100 * self.column("error"),
            "|f| [N]": abs(given[:, 0]),
            "f harmonics [%]": 100 * given[:, 2].real,
            "voltage [V]": abs(given[:, 1]),
            "status": self.status,
        }
        maybe = "left to go [%]", "error [%]", "|f| [N]", "f harmonics [%]", "voltage [V]"
        none = [name for name in maybe if np.isnan(columns[name]).all()]
        none += ["tap [m/s]"] if not columns["tap [m/s]"].any() else []
        return frame({name: values for name, values in columns.items() if name not in none})

    def __repr__(self):
        return self.summary()
