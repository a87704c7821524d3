"""Time histories of the multi-body rig: under any sampled force, and in the paper's random test."""

import math

import numpy as np

from .. import checks
from ..campaign.cost import affordable
from ..campaign.progress import reporting
from ..model.chipmunk import STARTS, RigSpace, check_step
from ..model.excitation import HOLDS, HeldForce
from ..model.shaker import ShakerDrive, check_drives
from ..parameters import rig_of
from .record import Record

_BLOCK = 1000  # samples between two looks at the clock and the keyboard
_BLOCK_STEPS = 1_000_000  # of which a block has no more either
_SAMPLE, _KICK, _STEP = 100, 60, 4e-7  # bytes a sample, bytes a step of a block, seconds a step


def simulate(
    parameters, force, sample_rate, hold="zero", start="rest", step=5e-5, *, drive=None, seed=None, progress=False
):
    """`Record` of the multi-body rig under a sampled force on its frame.

    Displacements are from the position of rest; sample k is taken before ``force[k]`` acts. With a voltage amplifier
    the force that is asked for is the voltage over R/Bl: the record's force is then what acted at that instant, and
    "band-limited", since a current does not jump. Where the voltage does, by ``hold`` "zero", its transients of L/R are
    not sampled, and `rigsim.identification.identify.identify` takes them for a delay: of the default coil at 2000 Hz ms
    is then 3 % off. A "linear" voltage leaves 0.3 % at 2000 Hz and 0.005 % at 8000 Hz.

    Parameters
    ----------
    parameters : RigParameters
    force : array_like, shape (n,)
        Force on the frame (N), one value a sample.
    sample_rate : float
        Samples a second (Hz).
    hold : {"zero", "linear"}
        What the force does between samples: keeps its value, or runs straight to the next.
    start : {"rest", "equilibrium"}
        Everything zero with wires unsagged and gravity on from t = 0, or the static equilibrium.
    step : float
        Longest integration step (s); the one used is T/ceil(T/step) for the sample interval T.
    drive : ShakerDrive, optional
        The shaker and its amplifier, with constant current or voltage; a controller needs a sine.
    seed : int, optional
        Noted in the record, where the force came from one.
    progress : bool or callable
        True shows a bar; a callable is told (samples done, samples in all).

    Raises
    ------
    ValueError
        If an argument is not allowed, the step is unstable or the mass goes past its wires' reach.
    """
    parameters, progress = rig_of(parameters), checks.progress(progress)
    force = checks.array("force", force, "N", min_size=2)
    sample_rate = checks.positive("sample_rate", sample_rate, "Hz")
    hold, start = checks.one_of("hold", hold, HOLDS), checks.one_of("start", start, STARTS)
    step, seed = checks.positive("step", step, "s"), None if seed is None else checks.seed("seed", seed)
    drive = _open_loop(drive)
    substeps = _affordable_substeps(parameters, f"force of {force.size} samples", force.size, sample_rate, step, drive)
    step, most = 1 / (sample_rate * substeps), max(1, min(_BLOCK, _BLOCK_STEPS // substeps))
    space = RigSpace([parameters], step, start, [drive])
    kicks = HeldForce(force, substeps, hold)
    shaker, mass, tilt, *sent = (np.empty(force.size) for _ in range(5 if drive else 3))
    with reporting(progress, force.size, "samples") as report:
        for first in range(0, force.size, most):
            block = slice(first, min(first + most, force.size))
            steps = (block.stop - first) * substeps
            asked = kicks.between(first * substeps, steps) if drive else None
            motion = space.advance(kicks.kicks(first * substeps, steps), np.zeros((steps, 1)), substeps, asked)
            if not np.isnan(motion.parted[0]):
                raise ValueError(
                    f"force of up to {np.abs(force).max():g} N takes the mass past its wires' reach at "
                    f"t = {motion.parted[0]:.4g} s; expected a weaker force or stiffer wires"
                )
            shaker[block], mass[block], tilt[block] = motion.shaker[:, 0], motion.mass[:, 0], motion.tilt[:, 0]
            for channel, values in zip(sent, (motion.force, motion.voltage), strict=False):
                channel[block] = values[:, 0]
            report(block.stop)
    known = {"tilt": tilt, "seed": seed, "start": start, "parameters": parameters, "step": step}
    known["slack"] = tuple(motion.slack[0]) if parameters.tension_only else None
    if drive:
        known["voltage"] = sent[1]
    if drive and drive.mode == "voltage":
        most = drive.max_voltage
        known["voltage"] = np.clip(drive.resistance / drive.force_factor * force, -most, most)  # from here on
        force, hold = sent[0], "band-limited"
    return Record(force, shaker, mass, sample_rate, hold, **known)


def _open_loop(drive):
    """The drive of a sampled force, checked."""
    drive = checks.instance("drive", drive, (ShakerDrive, type(None)), "a ShakerDrive or None")
    if drive and drive.mode not in ("current", "voltage"):
        raise ValueError(f"drive of constant {drive.mode} needs a sine; expected one of constant current or voltage")
    return drive


def _affordable_substeps(parameters, given, samples, sample_rate, step, drive):
    """Steps a sample interval, if they are neither too long nor too short, and that many can be afforded."""
    substeps = math.ceil(1 / (sample_rate * step) * (1 - 1e-12))
    check_step([parameters], 1 / (sample_rate * substeps))
    check_drives([drive], [parameters], 1 / (sample_rate * substeps))
    affordable(
        f"{given} at {sample_rate:g} Hz in steps of {step:g} s", instead="fewer samples or a longer step",
        memory=_SAMPLE * samples + _KICK * substeps, seconds=_STEP * samples * substeps,
    )  # fmt: skip
    return substeps


def random_test(
    parameters, rms=1.115, duration=100, sample_rate=2000, seed=2014, hold="zero", start="equilibrium", step=5e-5, *,
    drive=None, progress=False,
):  # fmt: skip
    """`Record` of the paper's random test: Gaussian force, white from sample to sample, scaled to the exact rms.

    Parameters
    ----------
    parameters : RigParameters
    rms : float
        Root mean square of the force that is asked for (N).
    duration : float
        s.
    sample_rate, hold, start, step, drive, progress
        See `simulate`.
    seed : int
        Of `numpy.random.default_rng`; the same seed gives the same record to the last bit.

    Raises
    ------
    ValueError
        If an argument is not allowed; see `simulate`.
    """
    parameters, progress = rig_of(parameters), checks.progress(progress)
    rms, step = checks.positive("rms", rms, "N"), checks.positive("step", step, "s")
    sample_rate = checks.positive("sample_rate", sample_rate, "Hz")
    duration = checks.positive("duration", duration, "s")
    samples = checks.integer("number of samples", round(duration * sample_rate), low=2)
    hold, start = checks.one_of("hold", hold, HOLDS), checks.one_of("start", start, STARTS)
    seed = checks.seed("seed", seed)
    drive = _open_loop(drive)
    _affordable_substeps(parameters, f"duration = {duration:g} s", samples, sample_rate, step, drive)
    force = np.random.default_rng(seed).standard_normal(samples)
    force *= rms / np.sqrt(np.mean(force**2))
    return simulate(parameters, force, sample_rate, hold, start, step, drive=drive, seed=seed, progress=progress)
