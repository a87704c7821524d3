"""Tests point by point, each from where the last one left the rig: stepped in frequency, in force, or tapped."""

import itertools
from dataclasses import dataclass, replace

import numpy as np

from ... import checks
from ..steady import LOWEST, highest
from .asked import bench_of, broadcast, patience_of, ran, rows, window_of
from .drive import Drive
from .sensors import Sensors
from .swept import FASTEST, SLOWEST, sweep
from .waiting import Patience, differ, wait

QUARTERS = (0.0, 0.25, 0.5, 0.75)  # of a period after the force's peak, at which a tap is tried
SIZES = (0.5, 1.0)  # m/s
PULSE = 2e-3  # s


@dataclass(frozen=True)
class Points:
    """Forces (N) and frequencies (Hz) one after the other, and at each, maybe, taps of several sizes (m/s)."""

    points: tuple  # of (force, frequency)
    patience: Patience
    sensors: Sensors | None
    velocity: tuple = ()
    pulse: float = PULSE  # s

    @property
    def longest(self):
        """s."""
        tries = 1 + len(self.velocity) * len(QUARTERS)
        return len(self.points) * tries * self.patience.longest

    def operate(self, step):
        """Generator; see `bench.run_bench`."""
        readings, drives, began = [], [], 0
        for force, f in self.points:
            steps = max(1, round(self.patience.longest / step))  # said again when it has ended
            drive = drives[-1].then(force, f, steps) if drives else Drive(force, force, f, f, steps, step)
            drive, reading, lines = yield from wait(drive, began, self.patience, self.sensors, len(readings))
            began, untapped = began + drive.steps, lines
            drives.append(drive)
            readings.append(reading)
            if reading["status"] == "FLEW_APART":
                break
            for tries, (velocity, quarter) in enumerate(itertools.product(self.velocity, QUARTERS), 1):
                drive = drives[-1].then(force, f, steps)
                at = (quarter - drive.turns) % 1.0 / f
                drive = replace(drive, velocity=velocity, pulse=self.pulse, tapped=at)
                drive, reading, lines = yield from wait(drive, began, self.patience, self.sensors, len(readings))
                began += drive.steps
                drives.append(drive)
                found = lines is not None and differ(untapped, lines)
                told = "another motion" if found else "the same motion"
                reading |= {"tries": tries, "message": f"{told} after tap {tries}; {reading['message']}"}
                if found or reading["status"] == "FLEW_APART":
                    break
            if self.velocity:
                readings.append(reading)
        return readings, drives


def stepped_test(
    parameters, force, frequency, dwell="settled", start="rest", step=5e-5, *, tolerance=1e-3, limit=30.0,
    sensors=None, drive=None, progress=False, executor=None, checkpoint=None,
):  # fmt: skip
    """`BenchTest`: a stepped sine, up or down in frequency, its phase continuous and the rig's state carried over.

    Parameters
    ----------
    parameters : RigParameters or sequence of them
        This, ``force``, the rows of ``frequency`` and ``sensors`` broadcast against each other: one bench each.
    force : float or array_like, shape (n,)
        Amplitude (N).
    frequency : array_like, shape (k,) or (n, k)
        Hz, in the order of the test; from two whole periods a second to forty steps a period.
    dwell : float or "settled"
        How long each point lasts (s, at least 1 and three periods), or until the motion has settled. Each is read
        over its last second, as `rigsim.experiment.sine_test.sine_test` reads.
    start : {"rest", "equilibrium"}
        Everything zero with wires unsagged and gravity on from t = 0, or the static equilibrium.
    step : float
        Integration step (s).
    tolerance : float
        Share of z that a settled motion may have left to go, as it is estimated from its last three half seconds: see
        `rigsim.experiment.protocols.waiting.Patience`.
    limit : float
        Longest wait for that (s); a point that is not settled by then says so, and the test goes on.
    sensors : Sensors, None, or sequence of them
        What the motion is measured with; waiting looks at the motion itself.
    drive : ShakerDrive, None, or sequence of them
        The shaker and its amplifier, which read ``force`` in their own way: one a bench, too.
    progress, executor, checkpoint
        See `rigsim.experiment.sine_test.sine_test`.

    Raises
    ------
    ValueError
        If an argument is not allowed, lengths do not broadcast, or the step is unstable.

    Notes
    -----
    On the paper's rig, at 1 and 3.18 N and from 10 to 80 Hz, settled points lie within 0.06 % of converged orbits of
    the exact law, half of them within 0.011 %, and jumps of a test stepped by 0.1 Hz within 0.07 Hz of their folds.
    Points take 1.5 to 6 s, most of them up to 3 s; near a fold, or with less damping, far longer.
    """
    options = checks.running(progress, executor, checkpoint)
    rigs, start, step = bench_of(parameters, start, step)
    patience = patience_of(dwell, tolerance, limit)
    force = checks.array("force", force, "N", low=0.0, low_open=True)
    rigs, (force, frequency, sensors, shakers) = broadcast(
        rigs, step, force=force, frequency=rows("frequency", frequency, step), sensors=sensors, drive=drive
    )
    plans = [
        Points(tuple((float(F), float(f)) for f in row), patience, sensor)
        for F, row, sensor in zip(force, frequency, sensors, strict=True)
    ]
    return ran("stepped_test", "frequency", rigs, plans, shakers, start, step, options)


def ramp_test(
    parameters, force, frequency, rate=None, dwell="settled", start="rest", step=5e-5, *, tolerance=1e-3, limit=30.0,
    window=0.5, sensors=None, drive=None, progress=False, executor=None, checkpoint=None,
):  # fmt: skip
    """`BenchTest`: the force goes up, down or both at a fixed frequency, in steps or, at a ``rate``, all the while.

    Parameters
    ----------
    parameters : RigParameters or sequence of them
        This, the rows of ``force``, ``frequency``, ``rate`` and ``sensors`` broadcast: one bench each.
    force : array_like, shape (k,) or (n, k)
        Amplitudes (N), in the order of the test: the points, or where the ramp begins, turns and ends.
    frequency : float or array_like, shape (n,)
        Hz.
    rate : float or array_like, shape (n,), optional
        N/s, of a ramp; without it each amplitude is a point, as in `stepped_test`.
    window : float
        Of a ramp's readings (s); see `rigsim.experiment.protocols.swept.swept_test`.
    dwell, start, step, tolerance, limit, sensors, drive, progress, executor, checkpoint
        See `stepped_test`; a ramp does not wait.

    Raises
    ------
    ValueError
        If an argument is not allowed, lengths do not broadcast, or the step is unstable.
    """
    options = checks.running(progress, executor, checkpoint)
    rigs, start, step = bench_of(parameters, start, step)
    patience, window = patience_of(dwell, tolerance, limit), window_of(window)
    force = rows("force", force, least=1 if rate is None else 2)
    frequency = checks.array("frequency", frequency, "Hz", low=LOWEST, high=highest(step))
    rate = np.array([np.nan]) if rate is None else checks.array("rate", rate, "N/s", low=SLOWEST, high=FASTEST)
    rigs, (force, frequency, rate, sensors, shakers) = broadcast(
        rigs, step, force=force, frequency=frequency, rate=rate, sensors=sensors, drive=drive
    )
    asked = zip(force, frequency, rate, sensors, strict=True)
    plans = [
        Points(tuple((float(F), float(f)) for F in row), patience, sensor)
        if np.isnan(pace)
        else sweep("force", row, float(f), float(pace), window, sensor)
        for row, f, pace, sensor in asked
    ]
    return ran("ramp_test", "force", rigs, plans, shakers, start, step, options)


def tapped_test(
    parameters, force, frequency, velocity=SIZES, dwell="settled", start="rest", step=5e-5, *, pulse=PULSE,
    tolerance=1e-3, limit=30.0, sensors=None, drive=None, progress=False, executor=None, checkpoint=None,
):  # fmt: skip
    """`BenchTest`: at each frequency wait, read, and tap the mass until it goes over to another motion.

    A tap that changes nothing is tried again a quarter, half and three quarters of a period later, then harder. Each
    frequency has two points: before the taps, and after the last of them.

    Parameters
    ----------
    parameters : RigParameters or sequence of them
        This, ``force``, the rows of ``frequency`` and ``sensors`` broadcast against each other: one bench each.
    force : float or array_like, shape (n,)
        Amplitude (N).
    frequency : array_like, shape (k,) or (n, k)
        Hz, in the order of the test, which goes on with whatever motion the last tap led to. ``frequency[:, None]``
        begins each from rest.
    velocity : float or array_like
        Sizes of the taps in the order they are tried (m/s): impulse over the mass, negative along -x. Each is tried at
        a peak of the force and a quarter, half and three quarters of a period later, whenever the motion has settled.
    pulse : float
        Duration of a tap (s), at least four steps.
    dwell, start, step, tolerance, limit, sensors, drive, progress, executor, checkpoint
        See `stepped_test`; another motion is one whose lines at f or below differ by a tenth of z.

    Raises
    ------
    ValueError
        If an argument is not allowed, lengths do not broadcast, or the step is unstable.
    """
    options = checks.running(progress, executor, checkpoint)
    rigs, start, step = bench_of(parameters, start, step)
    patience = patience_of(dwell, tolerance, limit)
    force = checks.array("force", force, "N", low=0.0, low_open=True)
    velocity = checks.array("velocity", velocity, "m/s")
    if not velocity.all():
        raise ValueError("velocity = 0 m/s is not allowed; expected sizes of taps, none of them zero")
    rigs, (force, frequency, sensors, shakers) = broadcast(
        rigs, step, force=force, frequency=rows("frequency", frequency, step), sensors=sensors, drive=drive
    )
    pulse = checks.real("pulse", pulse, "s", low=4 * step, high=0.5)
    plans = [
        Points(tuple((float(F), float(f)) for f in row), patience, sensor, tuple(velocity.tolist()), pulse)
        for F, row, sensor in zip(force, frequency, sensors, strict=True)
    ]
    return ran("tapped_test", "frequency", rigs, plans, shakers, start, step, options)
