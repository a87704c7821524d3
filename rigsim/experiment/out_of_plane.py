"""Whether a planar sine test lasts in three dimensions: the same tests with the mass free to shift, roll and yaw.

The planar motion solves the equations in space exactly, so that only a deviation tells: each test is run again from a
yaw and a roll of a millionth. Where that grows, the same integration with the mass guided in the plane says what it
changes. For tests that settled, the linear equations out of the plane about the planar periodic motion tell as well,
by Floquet's multipliers, and how slowly: what has no time to grow in the test may do so in a longer one. The two differ
where a deviation grows during the transient only, about a motion that is stable in the end. And where the planar motion
does not settle, any disturbance may change z's line by a per cent: a mark there says that no line of z is to be relied
on, and one near the limit may fall on either side of it.
"""

from dataclasses import dataclass, fields

import numpy as np

from ..campaign.cost import affordable
from ..campaign.run import join, run_chunks, split
from ..campaign.stop import look
from ..model import spatial
from ..model.planar import largest_tilt, longest_step, rest_position, static_equilibrium
from ..results import Result, Status, counted, frame
from .driven import check_force
from .record import Record

YAW, ROLL = 1e-6, 2e-6  # rad, at the start
GROWN = 1e-3  # rad; past it a deviation is no longer small
CHANGED = 0.01  # of z's line; past it the planar test says too much
_SLOW = 1e-3  # 1/s; slower growth of a deviation is rounding, or of no interest
_WINDOW, _HARMONICS, _SAMPLES = 1.0, 10, 40  # s; of a line's fit; steps a period at least, on soft rigs too
_CHUNK = 4  # tests that one thread takes at a time
_SLICE = 2000  # steps between two looks, some 5 ms
_STEP = 5e-6  # seconds of a step, of a run in the plane and one in space
_KEPT = 8 * (spatial.SIZE + 1)  # bytes of a step that is kept
_ROUNDS = 16  # of Newton's method
_SIZES = np.array([1e-3, 1e-3, 1e-4, 1e-2, 0.2, 0.2, 0.2, 10.0])  # of planar coordinates and rates, m, rad and s


@dataclass(frozen=True, eq=False, repr=False)
class OutOfPlane(Result):
    """What becomes of the motions of a `SineTest` in three dimensions, seeded with 1e-6 rad of yaw and 2e-6 of roll.

    Attributes
    ----------
    test : SineTest
        In the plane, of n rigs.
    roll, yaw, shift : ndarray, shape (n,)
        Largest about the cylinder's axis and of that axis (rad), and of its centre of mass (m), in the whole test.
    relative : ndarray, complex, shape (n,)
        z's line in space (m), over the last second.
    change : ndarray, shape (n,)
        Its difference from that of the same run with the mass guided in the plane, over it; zero where nothing grew.
    multipliers : ndarray, complex, shape (n, 6)
        Floquet multipliers out of the plane about the planar periodic motion; NaN where the test did not settle, its
        motion was not found, or the side wires differ, so that no motion is planar.
    growth : ndarray, shape (n,)
        Rate at which the fastest of these deviations grows (1/s); NaN likewise.
    status : ndarray of Status, shape (n,)
        STAYS_IN_PLANE, LEAVES_THE_PLANE or OPTIMISTIC, the last where z changes by more than 1 %; or FLEW_APART.
    message : tuple of str, length n
        The status in words and figures.
    """

    test: object
    roll: np.ndarray
    yaw: np.ndarray
    shift: np.ndarray
    relative: np.ndarray
    change: np.ndarray
    multipliers: np.ndarray
    growth: np.ndarray
    status: np.ndarray
    message: tuple

    plots = {"marks": "out_of_plane_figure", "growth": "growth_figure"}

    @property
    def unstable(self):
        """Where a deviation from the periodic motion grows, by the multipliers; bool, shape (n,)."""
        return self.growth > _SLOW

    def summary(self):
        """One line: how many tests last in the plane, how many leave it, and where that changes z."""
        told = counted(self.status)
        later = int((self.unstable & (self.status == Status.STAYS_IN_PLANE)).sum())
        later = f"; {later} of those that stay would leave in a longer test" if later else ""
        return f"OutOfPlane of {len(self.status)} sine tests in three dimensions: {told}{later}"

    def table(self):
        """`pandas.DataFrame` with a row per test."""
        test = self.test
        columns = {
            "frequency [Hz]": test.frequency,
            "force [N]": test.force,
            "tap [m/s]": [np.nan if tap is None else tap.velocity for tap in test.tap],
            "roll [deg]": np.degrees(self.roll),
            "yaw [deg]": np.degrees(self.yaw),
            "change of z [%]": 100 * self.change,
            "growth [1/s]": self.growth,
            "status": self.status,
        }
        return frame(columns)


@dataclass(frozen=True, eq=False, repr=False)
class SpaceRecord(Record):
    """`Record` of a test in three dimensions; of what a file can keep it has the planar channels.

    Attributes
    ----------
    states : ndarray, shape (n, 15)
        As in `rigsim.model.spatial`, sample by sample.
    """

    states: np.ndarray = None

    def replace(self, **changes):
        """A planar `Record` of the same channels, with some fields changed."""
        return Record(**{one.name: getattr(self, one.name) for one in fields(Record)} | changes)

    def summary(self):
        """One line that adds the largest roll and yaw."""
        roll, yaw, _ = np.degrees(spatial.angles(self.states))
        return f"{super().summary()}; roll up to {abs(roll).max():.2g}, yaw up to {abs(yaw).max():.2g} degrees"


def in_space(test, i):
    """`SpaceRecord` of a test of a `SineTest`; what `SineTest.in_space` gives."""
    planar, rig = test.record(i), test.parameters[i]
    if test.status[i] == Status.FLEW_APART:
        raise ValueError(f"i = {i} flew apart in the plane; expected a test that lasted")
    shaken = _Shaken(rig, test.force[i], test.frequency[i], test.tap[i], test.duration, test.start)
    shaken.step = min(shaken.step, 1 / planar.sample_rate)  # samples are found between steps, along straight lines
    steps, kept = test.duration / shaken.step, []
    given = f"duration = {test.duration:g} s in three dimensions"
    affordable(given, seconds=steps * _STEP, memory=_KEPT * _WINDOW / shaken.step, instead="a shorter test")
    last, *_ = shaken.run(spatial.turned(shaken.start, ROLL, YAW), False, kept)
    if not np.isfinite(last):
        raise ValueError(f"i = {i} goes past its wires' reach in three dimensions; expected a test that lasts")
    time, *columns = np.concatenate(kept).T
    states = np.column_stack([np.interp(test.time[0] + planar.time, time, column) for column in columns])
    tilt, mass = spatial.angles(states)[2], spatial.axial_position(rig, states)
    known = {"parameters": rig, "step": shaken.step, "tilt": tilt, "states": states}
    return SpaceRecord(planar.force, states[:, 0], mass, planar.sample_rate, planar.hold, **known)


def planar_only(rigs):
    """What whoever reads planar results of these `RigParameters` must be told, in words; none for two taut sets."""
    rigs, told = tuple(rigs), []
    if any(p.wire_sets == 1 for p in rigs):
        told.append("a mass on one wire set may yaw")
    if any(p.gap for p in rigs):
        told.append("without tension a mass may roll")
    return f"in the plane only: {' and '.join(told)}, see SineTest.out_of_plane()" if told else ""


def planar_word(rigs):
    """The same, to be added to a summary."""
    return f"; {told}" if (told := planar_only(rigs)) else ""


def out_of_plane(test, *, progress=False, executor=None, checkpoint=None):
    """`OutOfPlane` of a `SineTest`; what `SineTest.out_of_plane` gives."""
    rigs, n = test.parameters, len(test.frequency)
    check_force("test", test.shakers, ("current",))
    step = {p: _longest_step(p, *spatial.pack([p])) for p in set(rigs)}
    steps = sum(test.duration * max(1 / step[p], _SAMPLES * f) for p, f in zip(rigs, test.frequency, strict=True))
    given = f"duration = {test.duration:g} s in three dimensions for {n} rigs"
    affordable(given, seconds=steps * _STEP, instead="fewer rigs or a shorter test", shared=executor or checkpoint)
    parted = test.status == Status.FLEW_APART
    periods = np.array([_periods(test, i) for i in range(n)])
    chunks = [
        {"rigs": rigs[part], "force": test.force[part], "frequency": test.frequency[part], "taps": test.tap[part],
         "duration": test.duration, "start": test.start, "periods": periods[part], "skip": parted[part]}
        for part in split(n, _CHUNK)
    ]  # fmt: skip
    options = {"progress": progress, "executor": executor, "checkpoint": checkpoint, "label": "tests in space"}
    done = join(run_chunks(_run_chunk, chunks, threads=True, **options))
    told = [_verdict(*row) for row in zip(parted, *(done[k] for k in ("roll", "yaw", "change", "growth")), strict=True)]
    status, message = zip(*told, strict=True)
    return OutOfPlane(test, **done, status=np.array(status), message=message)


def _periods(test, i):
    """Periods of the force after which a test's motion repeats, 0 where it does not or no motion is planar."""
    _, _, left, right = np.reshape(test.parameters[i].wire_stiffness, (-1, 4)).T
    if not np.array_equal(left, right):
        return 0
    if test.status[i] == Status.SUBHARMONIC:
        orders = np.arange(2, 6) / test.subharmonic[i, 1]
        whole = np.flatnonzero(np.abs(orders - np.rint(orders)) < 0.02)
        return int(whole[0]) + 2 if whole.size else 0
    return int(test.status[i] == Status.SETTLED)


def _verdict(parted, roll, yaw, change, growth):
    told = f"roll reaches {roll:.2g} rad, yaw {yaw:.2g} rad"
    if growth > _SLOW:
        told += f", a deviation from the periodic motion grows at {growth:.3g}/s"
    if parted:
        return Status.FLEW_APART, "the planar test flew apart"
    if not np.isfinite(change):
        return Status.FLEW_APART, "past its wires' reach in three dimensions"
    if max(roll, yaw) <= GROWN:
        return Status.STAYS_IN_PLANE, told
    return (Status.OPTIMISTIC if change > CHANGED else Status.LEAVES_THE_PLANE), f"{told}; z changes by {change:.2%}"


def _longest_step(parameters, rigs, wires):
    """Step (s) that takes a radian of the fastest mode, in the plane or out of it, near the installed position."""
    deviations = np.concatenate([spatial.planar_state(rest_position(parameters)), np.eye(spatial.OUT).ravel()])
    rates = spatial.rates(deviations, rigs[0], wires[0])[spatial.SIZE :].reshape(spatial.OUT, -1)
    return 1 / max(2 / longest_step(parameters), np.abs(np.linalg.eigvals(rates)).max())


def _run_chunk(chunk):
    """Run each test in space, and in the plane where a deviation grew; arrays over the tests."""
    names = ("roll", "yaw", "shift", "relative", "change", "multipliers", "growth")
    lost = np.nan, np.nan, np.nan, np.nan + 0j, np.nan, np.full(spatial.OUT, np.nan + 0j), np.nan
    columns = ("rigs", "force", "frequency", "taps", "periods", "skip")
    rows = [
        lost if skip else _Shaken(p, force, f, tap, chunk["duration"], chunk["start"]).row(periods)
        for p, force, f, tap, periods, skip in zip(*(chunk[name] for name in columns), strict=True)
    ]
    return {name: np.array(values) for name, values in zip(names, zip(*rows, strict=True), strict=True)}


class _Shaken:
    """One test in three dimensions."""

    def __init__(self, parameters, force, frequency, tap, duration, start):
        self.p, self.f, self.tap, self.duration = parameters, frequency, tap, duration
        packed = spatial.pack([parameters])
        self.rig, self.wires = (array[0] for array in packed)
        self.step = min(_longest_step(parameters, *packed), 1 / (_SAMPLES * frequency))
        at = rest_position(parameters) if start == "rest" else static_equilibrium(parameters).coordinates
        self.start = spatial.planar_state(at)
        self.drive = spatial.drive(force, frequency)

    def row(self, periods):
        """Roll, yaw, shift, z's line, its change, multipliers and growth."""
        last, end, *largest = self.run(spatial.turned(self.start, ROLL, YAW), planar=False)
        change, guided = 0.0, last
        # ~(<=), not >: what flew apart in space is NaN
        if not max(largest[:2]) <= GROWN:
            guided, end, *_ = self.run(self.start.copy(), planar=True)
            change = abs(last - guided) / abs(guided)
        multipliers, growth = np.full(spatial.OUT, np.nan + 0j), np.nan
        if periods:
            multipliers, growth = self.multipliers(end, periods, guided)
        return *largest, last, change, multipliers, growth

    def run(self, state, planar, kept=None):
        """Shake to the end: z's line over the last second (m), the end's state, largest roll, yaw (rad), shift (m).

        Into the list ``kept`` go time and states of the last second, as arrays of 16 columns.
        """
        cuts = 0.0, self.duration - _WINDOW, self.duration
        largest, window, reach = np.zeros(3), [], largest_tilt(self.p)
        for low, high, drive in spatial.stretches(self.drive[0], self.f, self.tap, self.p.m, *cuts):
            steps = max(1, int(np.ceil((high - low) / self.step)))
            h = (high - low) / steps
            if kept is not None and low >= self.duration - _WINDOW:
                kept.append(np.array([[low, *state]]))
            for first in range(0, steps, _SLICE):
                look()
                trace = np.empty((min(_SLICE, steps - first), spatial.SIZE))
                spatial.march(state, low + first * h, h, len(trace), self.rig, self.wires, drive, planar, trace)
                roll, yaw, tilt = spatial.angles(trace)
                if not np.abs([roll, yaw, tilt]).max() < reach:
                    return np.nan + 0j, state, np.nan, np.nan, np.nan
                largest = np.maximum(largest, np.abs([roll, yaw, trace[:, 3]]).max(axis=1))
                if low >= self.duration - _WINDOW:
                    time = low + h * (first + 1 + np.arange(len(trace)))
                    window.append(np.column_stack([time, trace[:, 0] - spatial.axial_position(self.p, trace)]))
                    if kept is not None:
                        kept.append(np.column_stack([time, trace]))
        return self.line(*np.concatenate(window).T), state, *largest

    def line(self, time, z, periods=1):
        """Complex amplitude at f of z (m), fitted with its harmonics and parts over the last whole periods."""
        length = 2 * time[-1] - time[-2] - time[0]  # half open, so that no sample of the periods is counted twice
        whole = np.floor(length * self.f / periods * (1 + 1e-9)) * periods / self.f
        inside = time > time[-1] - whole * (1 - 1e-9)
        phase = 2 * np.pi * self.f / periods * np.outer(time[inside], np.arange(_HARMONICS * periods + 1))
        columns = np.column_stack([np.cos(phase), np.sin(phase[:, 1:])])
        found = np.linalg.lstsq(columns, z[inside], rcond=None)[0]
        return complex(found[periods], -found[_HARMONICS * periods + periods])

    def multipliers(self, end, periods, line):
        """Floquet multipliers (6,) out of the plane about the planar motion near a test's end, and their growth (1/s).

        NaN where Newton's method finds no periodic motion whose line of z is that of the test.
        """
        lost = np.full(spatial.OUT, np.nan + 0j), np.nan
        period = periods / self.f
        steps = int(np.ceil(2 * period / self.step))
        x, before = spatial.planar_numbers(end), 0.0
        for _ in range(_ROUNDS):
            look()
            after = self.after(x, period, steps)
            missed = (after - x) / _SIZES
            size = np.abs(missed).max()
            if size < 1e-9 or not size < 1e3:
                break
            if not size < before / 10:  # a derivative serves as long as it does well
                ends = np.array([self.after(one, period, steps) for one in x + 1e-5 * np.diag(_SIZES)])
                moved = (ends - after).T / _SIZES[:, None] / 1e-5
            x, before = x + _SIZES * np.linalg.solve(np.eye(8) - moved, missed), size
        if not size < 1e-9:
            return lost
        state = np.concatenate([spatial.planar_state(x[:4], x[4:]), np.eye(spatial.OUT).ravel()])
        trace = np.empty((steps, state.size))
        spatial.march(state, self.duration, period / steps, steps, self.rig, self.wires, self.drive, True, trace)
        time = self.duration + period / steps * np.arange(1, steps + 1)
        found = self.line(time, trace[:, 0] - spatial.axial_position(self.p, trace), periods)
        if abs(found - line) > 0.02 * abs(line):
            return lost
        multipliers = np.linalg.eigvals(state[spatial.SIZE :].reshape(spatial.OUT, -1).T)
        return multipliers, np.log(np.abs(multipliers).max()) / period

    def after(self, x, period, steps):
        """Planar coordinates and rates (8,) a period after the test's end."""
        state = spatial.planar_state(x[:4], x[4:])
        h, nothing = period / steps, np.empty((0, spatial.SIZE))
        spatial.march(state, self.duration, h, steps, self.rig, self.wires, self.drive, True, nothing)
        return spatial.planar_numbers(state)
