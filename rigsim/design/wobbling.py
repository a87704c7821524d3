"""Why a rig wobbles: how it hangs, rocks and answers a sine test, over what a builder decides and gets wrong.

Statics and frequencies are those of the rig in three dimensions, with wires that differ or sit where they should not,
beside closed forms for equal ones. The tests are made at points of the rig's own detached curve: left alone at its
equilibrium, the rig should settle on the lowest solution of the theory, and after a tap on the highest.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from .. import checks
from ..campaign.cost import affordable
from ..campaign.run import join, run_chunks, split
from ..campaign.stop import look
from ..experiment.sine_test import sine_test
from ..experiment.steady import WINDOW, read_or_parted, sampling
from ..model import spatial
from ..model.by_hand import RIGID, wobble_by_hand
from ..model.excitation import Tap
from ..model.mounted import Mounting, hung, modes_in_space, mounted, moved
from ..model.planar import largest_tilt
from ..parameters import rig_of
from ..results import Result, Status, frame
from ..theory.amplitude import frequency_response
from ..theory.detached import detached_curves

ERRORS = ("long_wire", "clocked_set", "skewed_set")
_FIELDS = ("LG", "set_half_spacing", "set_centre", "gravity", "rocking_damping", "wire_damping")
QUANTITIES = {  # what it is, the unit that people are shown, and how many of it an SI unit is
    "LG": ("offset of the centre of mass LG", "mm", 1e3),
    "stretch": ("stretch of the wires d - d0", "µm", 1e6),
    "set_half_spacing": ("half the spacing of the sets", "mm", 1e3),
    "set_centre": ("the sets' middle from P", "mm", 1e3),
    "gravity": ("gravity", "m/s²", 1.0),
    "rocking_damping": ("rocking damping", "µN m s/rad", 1e6),
    "wire_damping": ("damping of a wire", "N s/m", 1.0),
    "spread": ("stiffness of wires, plus or minus", "%", 100.0),
    "long_wire": ("one wire too long by", "µm", 1e6),
    "clocked_set": ("one set turned about the axis by", "°", 180 / np.pi),
    "skewed_set": ("one set turned about the vertical by", "°", 180 / np.pi),
}
STARTS, WHERE = ("left alone", "tapped"), ("in the plane", "in space")
_NEAR = 0.15  # largest relative distance of z from the solution that a test should end on
_CHUNK, _SLICE = 2, 2000  # rigs a thread takes at a time; steps between two looks
_STEP, _PLANAR = 5e-6, 8e-3  # seconds: a step in space, and a second of a planar test
_SAMPLES = 40  # steps a period of the force at least
_USUAL = 5e-5  # s, the step of a planar test, in which readings are sampled
_SEED = (0.0, 0.0, 0.0, 0.0, 2e-6, 1e-6, 0.0)  # roll and yaw (rad) that a test in space begins with


@dataclass(frozen=True, eq=False, repr=False)
class WobblingMap(Result):
    """Rigs that hang, rock and are tested, over one or two quantities; see `wobbling_map`. There are n rigs.

    Attributes
    ----------
    parameters : RigParameters
    over : dict of str to (k,) array
        SI units; the rigs are in the order of `numpy.ndindex` over them.
    rigs : tuple of RigParameters
    mountings : tuple of Mounting
    force : float or None
        N.
    tilt, yaw, roll : (n,) array
        At rest (rad).
    frequency : (n, 5) array
        Of the modes "rocking", "yaw", "roll", "bounce" and "sway" at rest (Hz).
    by_hand : (n, 6) array
        The same of equal wires, well mounted, by closed forms: tilt (rad), then frequencies (Hz).
    tests : (n, m) array
        Where each rig is tested (Hz), within its detached curve; NaN where it has none.
    kept : (n, 2, m, 2) array
        1 where a test settled where it should and 0 where not; left alone or tapped, and in the plane or in space. NaN
        where there was no test: none was asked for or there is no detached curve; in the plane no set is mounted wrong.
    status : (n,) array of Status
        FOUND, or NOT_FOUND where no stable place of rest was found: none at all, or it yaws off the one in the plane.
    message : tuple of str
        Why not; or why there was no test.
    """

    parameters: object
    over: dict
    rigs: tuple
    mountings: tuple
    force: float | None
    tilt: np.ndarray
    yaw: np.ndarray
    roll: np.ndarray
    frequency: np.ndarray
    by_hand: np.ndarray
    tests: np.ndarray
    kept: np.ndarray
    status: np.ndarray
    message: tuple

    plots = {"map": "wobbling_figure"}

    @property
    def survives(self):
        """Share of tests that settled where they should, (n, 2, 2): left alone or tapped, in the plane or in space."""
        tried = np.isfinite(self.kept)
        with np.errstate(invalid="ignore"):
            return np.where(tried, self.kept, 0.0).sum(axis=2) / tried.sum(axis=2)

    def summary(self):
        """One line: how many rigs over what, their tilts and slowest rocking, and the tests that came out right."""
        names = " and ".join(self.over)
        lost = int((self.status == Status.NOT_FOUND).sum())
        told = f"WobblingMap of {len(self.rigs)} rigs over {names}"
        if lost < len(self.rigs):
            low, high = np.nanmin(abs(self.tilt)), np.nanmax(abs(self.tilt))
            slowest = np.nanmin(self.frequency[:, :2])
            told += f": tilt {np.degrees(low):.2g} to {np.degrees(high):.2g} deg, rocking or yaw from {slowest:.3g} Hz"
        right = self.kept[..., 1]
        if np.isfinite(right).any():
            told += f"; in space {int(np.nansum(right))} of {int(np.isfinite(right).sum())} tests end where they should"
        return told + (f"; {lost} without a stable place of rest that was found" if lost else "")

    def table(self):
        """`pandas.DataFrame` with a row a rig: what varies, rest and modes beside the closed forms, and tests (%)."""
        places = np.array(list(itertools.product(*self.over.values())))
        columns = {f"{name} [{QUANTITIES[name][1]}]": QUANTITIES[name][2] * values
                   for name, values in zip(self.over, places.T, strict=True)}  # fmt: skip
        columns |= {"tilt [deg]": np.degrees(self.tilt), "by hand [deg]": np.degrees(self.by_hand[:, 0])}
        for j, name in enumerate(RIGID):
            columns |= {f"{name} [Hz]": self.frequency[:, j], f"{name} by hand [Hz]": self.by_hand[:, j + 1]}
        for (i, start), (j, where) in itertools.product(enumerate(STARTS), enumerate(WHERE)):
            if np.isfinite(self.kept[:, i, :, j]).any():
                columns[f"{start}, {where} [%]"] = 100 * self.survives[:, i, j]
        return frame(columns | {"status": self.status, "message": self.message})


def wobbling_map(
    parameters, over, force=None, *, fixed=None, points=3, tap=None, duration=4.0, seed=2014, progress=False,
    executor=None, checkpoint=None,
):  # fmt: skip
    """How rigs hang and rock, and whether tests on their detached curves come out, over one or two quantities.

    Parameters
    ----------
    parameters : RigParameters
        What does not vary stays; one wire set or two.
    over : dict of str to array_like
        One quantity or two, and the values (SI units) of each: "LG", "stretch" (d - d0, by d0), "set_half_spacing",
        "set_centre", "gravity", "rocking_damping", "wire_damping"; "spread", the largest change of a wire's stiffness
        as a share of it; "long_wire" (m), "clocked_set", "skewed_set" (rad), see `rigsim.model.mounted.Mounting`.
    force : float, optional
        Amplitude (N) of sine tests at ``points`` of each rig's widest detached curve; without one there are no tests.
    fixed : dict of str to float, optional
        Others of these quantities, the same for all rigs: ``{"long_wire": 1e-5}``.
    points : int
        Frequencies a rig is tested at, evenly within its curve; each four times, 2 s of one core in all.
    tap : Tap, optional
        Of the tapped tests; by default 0.5 m/s at 1 s. It has to be over a second before the test is.
    duration : float
        Of each test (s), from equilibrium.
    seed : int
        Of the wires' stiffnesses, where they spread: each between 1 - spread and 1 + spread times its own, one draw
        that grows with the spread.
    progress, executor, checkpoint
        See `rigsim.experiment.sine_test.sine_test`.

    Returns
    -------
    WobblingMap

    Raises
    ------
    ValueError
        If an input is not allowed, or one of the rigs cannot be built.

    Examples
    --------
    >>> wobbling_map(RigParameters(wire_sets=1), {"stretch": [3e-6, 3e-5]}, 3.18).table()  # doctest: +SKIP
    """
    parameters, (progress, executor, checkpoint) = rig_of(parameters), checks.running(progress, executor, checkpoint)
    over = _quantities("over", over, most=2)
    fixed = {} if fixed is None else _quantities("fixed", fixed, most=len(QUANTITIES), each=1)
    if twice := sorted(set(over) & set(fixed)):
        raise ValueError(f"fixed = {twice[0]} is in over, too; expected each quantity once")
    force = None if force is None else checks.positive("force", force, "N")
    points, seed = checks.integer("points", points, low=1, high=100), checks.seed("seed", seed)
    tap = Tap() if tap is None else checks.instance("tap", tap, Tap, "a Tap or None")
    duration = checks.real("duration", duration, "s", low=tap.time + tap.duration + WINDOW, high=1e4)
    rigs = [
        _built(parameters, {name: float(v[0]) for name, v in fixed.items()} | dict(zip(over, place, strict=True)), seed)
        for place in itertools.product(*(values.tolist() for values in over.values()))
    ]
    seconds = 0.05 if force is None else 2 * points * duration * (_STEP * 1e4 + _PLANAR)
    affordable(
        f"a map of {len(rigs)} rigs", seconds=len(rigs) * seconds, instead="fewer", shared=executor or checkpoint
    )
    asked = {"force": force, "points": points, "tap": tap, "duration": duration}
    chunks = [{"rigs": rigs[part]} | asked for part in split(len(rigs), _CHUNK)]
    options = {"progress": progress, "executor": executor, "checkpoint": checkpoint, "label": "pairs of rigs"}
    done = join(run_chunks(_run_chunk, chunks, threads=True, **options))
    status = np.array([Status[name] for name in done.pop("status")])
    message = tuple(str(text) for text in done.pop("message"))
    return WobblingMap(parameters, over, *zip(*rigs, strict=True), force, **done, status=status, message=message)


def _quantities(name, given, most, each=None):
    """Checked quantities, a dict of name to (k,) array."""
    if not isinstance(given, dict) or not 1 <= len(given) <= most:
        expected = f"a dict of 1 to {most} of {', '.join(QUANTITIES)}"
        raise ValueError(f"{name} = {checks.shown(given)} is not allowed; expected {expected}")
    return {
        checks.one_of(f"quantity in {name}", key, tuple(QUANTITIES)): checks.array(f"{name}: {key}", values, size=each)
        for key, values in given.items()
    }


def _built(parameters, values, seed):
    """The `RigParameters` and `Mounting` of a place in the map."""
    given = ", ".join(f"{name} = {value:g}" for name, value in values.items())
    try:
        changes = {name: value for name, value in values.items() if name in _FIELDS}
        if "stretch" in values:
            changes["d0"] = parameters.d - values["stretch"]
        if "spread" in values:
            spread = checks.real("spread", values["spread"], low=0.0, high=0.99)
            draw = np.random.default_rng(seed).uniform(-1, 1, parameters.wire_stiffness.size)
            changes["k"] = tuple((parameters.wire_stiffness * (1 + spread * draw)).tolist())
        rig = parameters.replace(**changes)
        return rig, Mounting(**{name: value for name, value in values.items() if name in ERRORS})
    except ValueError as error:
        raise ValueError(f"the rig of {given} cannot be built: {error}") from None


def _run_chunk(chunk):
    """Hang each rig, find its modes and test it; arrays over the rigs."""
    rows = [_row(*rig, **{name: value for name, value in chunk.items() if name != "rigs"}) for rig in chunk["rigs"]]
    names = ("tilt", "yaw", "roll", "frequency", "by_hand", "tests", "kept", "status", "message")
    return {name: np.array(values) for name, values in zip(names, zip(*rows, strict=True), strict=True)}


def _row(parameters, mounting, force, points, tap, duration):
    tests, kept = np.full(points, np.nan), np.full((2, points, 2), np.nan)
    by_hand = np.array(list(wobble_by_hand(parameters).values()))
    try:
        state = hung(parameters, mounting)
        modes = modes_in_space(parameters, mounting, state)
    except ValueError as error:
        lost = np.nan, np.nan, np.nan, np.full(len(RIGID), np.nan), by_hand, tests, kept
        return *lost, Status.NOT_FOUND.name, str(error)
    by_name = dict(zip(modes.names, modes.frequency, strict=True))
    roll, yaw, tilt = spatial.angles(state)
    message = ""
    if force is not None:
        curves = () if parameters.gap else detached_curves(parameters, force)
        message = "" if curves else "not tested: theory has no detached curve here"
        if curves:
            curve = max(curves, key=lambda one: one.high - one.low)
            tests = curve.low + (curve.high - curve.low) * np.arange(1, points + 1) / (points + 1)
            kept = _tested(parameters, mounting, state, modes, force, tests, tap, duration)
    frequency = np.array([by_name[name] for name in RIGID])
    return tilt, yaw, roll, frequency, by_hand, tests, kept, Status.FOUND.name, message


def _tested(parameters, mounting, state, modes, force, frequency, tap, duration):
    """Whether each test settles where it should, (2, m, 2); see `WobblingMap.kept`."""
    theory = frequency_response(parameters, force, frequency).relative[:, [0, 2]].T  # lowest and highest
    kept, m = np.full((2, frequency.size, 2), np.nan), frequency.size
    if not mounting:
        taps = [None] * m + [tap] * m
        planar = sine_test(parameters, force, np.tile(frequency, 2), taps, duration, start="equilibrium")
        for i in range(2):
            part = slice(i * m, (i + 1) * m)
            kept[i, :, 0] = _right(planar.relative[part], planar.status[part], theory[i])
    shaken = _Shaken(parameters, mounting, modes, force, frequency.max(), duration)
    for i, j in np.ndindex(2, m):
        line, status = shaken.test(moved(state, np.array(_SEED)), frequency[j], tap if i else None)
        kept[i, j, 1] = _right(line, status, theory[i, j])
    return kept


def _right(line, status, theory):
    """1.0 where a test's motion is periodic, or still on its way to be, and its z near that of the theory, else 0.0."""
    with np.errstate(invalid="ignore"):
        near = np.abs(line - theory) <= _NEAR * np.abs(theory)
    return np.asarray(near & ((status == Status.SETTLED) | (status == Status.STILL_DRIFTING)), dtype=float)


class _Shaken:
    """Sine tests of one rig in three dimensions, as it is mounted."""

    def __init__(self, parameters, mounting, modes, force, highest, duration):
        self.p, self.force, self.duration = parameters, force, duration
        self.rig, self.wires = mounted(parameters, mounting)
        # A radian of the fastest mode, or, on soft rigs, a part of the force's period.
        self.step = 1 / max(2 * np.pi * modes.frequency.max(), _SAMPLES * highest)

    def test(self, state, f, tap):
        """z's line at f (m) over the last second, and its status."""
        last, spacing = self.duration - WINDOW, sampling(f, _USUAL) * _USUAL
        for low, high, drive in spatial.stretches(self.force, f, tap, self.p.m, 0.0, last):
            _, parted = self.march(state, low, high, drive, int((high - low) / self.step) + 1)
            if not np.isnan(parted):
                break
        time = last + spacing * np.arange(1, round(WINDOW / spacing) + 1)
        trace = np.empty((time.size, spatial.SIZE))
        if np.isnan(parted):
            trace, parted = self.march(state, last, time[-1], spatial.drive(self.force, f), time.size)
        window = np.column_stack([trace[:, 0], spatial.axial_position(self.p, trace)])
        lines, _, _, _, status, _ = read_or_parted(time, window, f, parted)
        return lines[2], Status[status]

    def march(self, state, low, high, drive, samples):
        """Move a state in place; its ``samples`` at equal times up to ``high`` (s), and when it parted (s), or NaN."""
        trace, each = np.empty((samples, spatial.SIZE)), int(np.ceil((high - low) / samples / self.step * (1 - 1e-12)))
        h, most = (high - low) / (samples * each), max(1, _SLICE // each)
        for first in range(0, samples, most):
            look()
            part, begin = trace[first : first + most], low + first * each * h
            spatial.march(state, begin, h, len(part) * each, self.rig, self.wires, drive, False, part)
            if not np.abs(spatial.angles(part)).max() < largest_tilt(self.p):
                return trace, begin + len(part) * each * h
        return trace, np.nan
