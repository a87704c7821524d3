"""Tests that move on all the while: a sine swept in frequency, or a force that goes up and down."""

import itertools
import math
from dataclasses import dataclass

import numpy as np

from ... import checks
from ...results import Status
from ..driven import NOTHING
from ..steady import sampling
from .asked import bench_of, broadcast, ran, rows, window_of
from .bench import Request
from .drive import Drive
from .sensors import Sensors

SPACINGS = ("linear", "logarithmic")
SLOWEST, FASTEST = 1e-4, 1e4  # Hz/s or N/s
_BELOW = np.array([1 / 3, 1 / 2, 2 / 3])  # multiples of the force's frequency that a window is fitted with,
_MULTIPLES = np.array([*_BELOW, 1, 2, 3, 4, 5])  # and all of them
_WINDOWS = 3  # that a stretch lasts at least
_TURNS = 6  # periods of the force in a window at least


@dataclass(frozen=True)
class Sweep:
    """Force (N) and frequency (Hz) run through stretches, and are read in windows that overlap by half."""

    stretches: tuple  # of (force, its end, frequency, its end, duration in s)
    logarithmic: bool
    window: float  # s
    sensors: Sensors | None

    @property
    def longest(self):
        """s."""
        return sum(stretch[-1] for stretch in self.stretches)

    def operate(self, step):
        """Generator; see `bench.run_bench`."""
        readings, drives, began, number = [], [], 0, 0
        every = sampling(max(f for stretch in self.stretches for f in stretch[2:4]), step)
        for force, force_end, f, f_end, duration in self.stretches:
            steps = max(1, round(duration / step))
            ends = {"force_end": force_end, "frequency_end": f_end, "logarithmic": self.logarithmic}
            if drives:
                drive = drives[-1].then(force, f, steps, **ends)
            else:
                drive = Drive(force, frequency=f, steps=steps, step=step, **ends)
            found, last, first = [], None, 0
            while first < steps:
                window = max(self.window, _TURNS / float(drive.frequency_at(first * step)))
                half = max(1, math.ceil(window / (2 * every * step) * (1 - 1e-12))) * every
                told = yield Request(drive, first, min(half, steps - first))
                if not np.isnan(told.parted):
                    readings += [*_with_errors(found), _parted(drive, began, first + len(told.samples), told)]
                    return readings, [*drives, drive.ended(first + len(told.samples))]
                if len(told.samples) < half:
                    break  # what is left over at the end is no half window
                time = step * np.arange(first, first + half, every)
                samples = told.samples[::every]
                if self.sensors is not None:
                    shown = self.sensors.measured(step * began + time, samples[:, :2], number)
                    samples, number = np.column_stack([shown, samples[:, 2:]]), number + 1
                if last is not None:
                    both = np.concatenate([last[0], time]), np.concatenate([last[1], samples])
                    found.append(_read(drive, began, *both))
                last, first = (time, samples), first + half
            readings += _with_errors(found)
            drives.append(drive)
            began += steps
        return readings, drives


def _read(drive, began, time, samples):
    """What a window shows: lines at multiples of the force's own frequency of the moment, by least squares."""
    turned = 2 * np.pi * np.outer(drive.turned(time), _MULTIPLES)
    columns = np.column_stack([np.ones(time.size), np.cos(turned), np.sin(turned)])
    # Neither product is left to a library whose threads would change the last bits.
    gram, sums = np.einsum("ti,tj->ij", columns, columns), np.einsum("ti,tj->ij", columns, samples[:, :2])
    solved = np.linalg.solve(gram, sums)
    given = NOTHING
    if samples.shape[1] > 3:
        sent = np.linalg.solve(gram, np.einsum("ti,tj->ij", columns, samples[:, 3:]))
        sent = (sent[1 : _MULTIPLES.size + 1] - 1j * sent[_MULTIPLES.size + 1 :])[_BELOW.size :]
        given = np.append(sent[0], np.abs(sent[1:, 0]).max() / np.abs(sent[0, 0]))
    lines = solved[1 : _MULTIPLES.size + 1] - 1j * solved[_MULTIPLES.size + 1 :]
    lines = np.column_stack([lines, lines[:, 0] - lines[:, 1]])
    below, (fundamental, *harmonics) = np.abs(lines[: _BELOW.size, 2]), lines[_BELOW.size :]
    left = samples[:, :2] - np.einsum("ti,ij->tj", columns, solved)
    size, strongest = np.maximum(np.abs(fundamental), 1e-300), below.argmax()  # a coarse sensor may see no motion
    stray = math.sqrt(2) * (left[:, 0] - left[:, 1]).std() / size[2]
    centre = 0.5 * (time[0] + time[-1])
    shaker, mass, relative = fundamental
    return {
        "time": began * drive.step + centre, "force": drive.amplitude_at(centre), "frequency":
        drive.frequency_at(centre), "shaker": shaker, "mass": mass, "relative": relative,
        "tilt": np.abs(samples[:, 2]).max(), "distortion": np.abs(harmonics).max(axis=0) / size,
        "subharmonic": (below[strongest] / size[2], 1 / _BELOW[strongest]), "drift": np.nan, "left": np.nan,
        "dwell": time[-1] - time[0],
        "velocity": 0.0, "tries": 0, "status": Status.PASSING.name, "message": f"other motion {stray:.1%} of z",
        "given": given,
    }  # fmt: skip


def _with_errors(found):
    """The readings, each with what its window smooths away of z: b T^2/12 where z goes as a + b t^2 over T."""
    z = np.array([reading["relative"] for reading in found])
    errors = np.full(len(found), np.nan)
    if len(found) > 4:  # windows next to each other are two readings apart, and theirs differ by 2 b T^2
        errors[2:-2] = np.abs(z[:-4] - 2 * z[2:-2] + z[4:]) / 24 / np.abs(z[2:-2])
    return [reading | {"error": error} for reading, error in zip(found, errors, strict=True)]


def _parted(drive, began, steps, told):
    """The reading of a rig that flew apart."""
    time, nothing = steps * drive.step, complex(np.nan)
    return {
        "time": began * drive.step + time, "force": drive.amplitude_at(time), "frequency": drive.frequency_at(time),
        "shaker": nothing, "mass": nothing, "relative": nothing, "tilt": np.abs(told.samples[:, 2]).max(),
        "distortion": np.full(3, np.nan), "subharmonic": (np.nan, np.nan), "drift": np.nan, "left": np.nan,
        "dwell": np.nan, "velocity": 0.0, "tries": 0, "error": np.nan, "status": Status.FLEW_APART.name,
        "message": f"past its wires' reach at t = {told.parted:.4g} s", "given": NOTHING,
    }  # fmt: skip


def sweep(name, turns, fixed, rate, window, sensors, logarithmic=False):
    """The `Sweep` of a force (N) or a frequency (Hz), by ``name``, through ``turns`` (k,) at a ``rate`` a second."""
    stretches = []
    for one, other in itertools.pairwise(float(turn) for turn in turns):
        duration = abs(other - one) / rate
        if duration < _WINDOWS * window:
            least = f"{_WINDOWS} windows of {window:g} s"
            raise ValueError(
                f"rate = {rate:g} takes {name} from {one:g} to {other:g} in {duration:.3g} s; expected {least} or more"
            )
        ends = (one, other, fixed, fixed) if name == "force" else (fixed, fixed, one, other)
        stretches.append((*ends, duration))
    return Sweep(tuple(stretches), logarithmic, window, sensors)


def swept_test(
    parameters, force, frequency, rate, spacing="linear", start="rest", step=5e-5, *, window=0.5, sensors=None,
    drive=None, progress=False, executor=None, checkpoint=None,
):  # fmt: skip
    """`BenchTest`: a sine swept in frequency, up or down, read in a moving window.

    A sweep is always late: the motion follows at its own pace, and where it jumps the frequency has gone on.

    Parameters
    ----------
    parameters : RigParameters or sequence of them
        This, ``force``, the rows of ``frequency``, ``rate`` and ``sensors`` broadcast: one bench each.
    force : float or array_like, shape (n,)
        Amplitude (N).
    frequency : array_like, shape (k,) or (n, k)
        Where the sweep begins and ends (Hz), and turns, if it does, in between: (10, 80), (80, 10) or (10, 80, 10).
    rate : float or array_like, shape (n,)
        Hz/s; of a logarithmic sweep on average from end to end, so that both take equally long.
    spacing : {"linear", "logarithmic"}
        Equal steps in equal times, or equal factors.
    start : {"rest", "equilibrium"}
        Everything zero with wires unsagged and gravity on from t = 0, or the static equilibrium.
    step : float
        Integration step (s).
    window : float
        s of motion that a reading is fitted to, at least six periods of the force; one every half of it,
        at the frequency in its middle. ``error`` of a point is what the window smooths away.
    sensors, drive, progress, executor, checkpoint
        See `rigsim.experiment.protocols.stepped.stepped_test`.

    Raises
    ------
    ValueError
        If an argument is not allowed, lengths do not broadcast, or the step is unstable.
    """
    options = checks.running(progress, executor, checkpoint)
    rigs, start, step = bench_of(parameters, start, step)
    force = checks.array("force", force, "N", low=0.0, low_open=True)
    rate = checks.array("rate", rate, "Hz/s", low=SLOWEST, high=FASTEST)
    logarithmic = checks.one_of("spacing", spacing, SPACINGS) == "logarithmic"
    window, frequency = window_of(window), rows("frequency", frequency, step, least=2)
    rigs, (force, frequency, rate, sensors, shakers) = broadcast(
        rigs, step, force=force, frequency=frequency, rate=rate, sensors=sensors, drive=drive
    )
    plans = [
        sweep("frequency", row, float(F), float(pace), window, sensor, logarithmic)
        for F, row, pace, sensor in zip(force, frequency, rate, sensors, strict=True)
    ]
    return ran("swept_test", "frequency", rigs, plans, shakers, start, step, options)
