"""The whole response, unstable motions too, from a test under feedback (control-based continuation).

At each frequency the amplitude of z is stepped up. The shaker's force is a cosine plus the feedback of a digital
controller that makes xs and x follow a periodic target. Whatever the feedback adds at other multiples of the frequency
is read, and the target moved until that is below 1 % of the force; the motion is then one of the rig without feedback,
stable or not, under the force's line at the frequency. So force is measured over amplitude, through both folds: a
slice of the response sheet, of which the response curve at any force is a contour.
"""

import numpy as np

from ... import checks
from ...campaign.cost import affordable
from ...campaign.run import join, run_chunks, split
from ...model.chipmunk import STARTS, check_step
from ...parameters import oscillator_of, rig_of
from ...results import Status
from .balance import largest_amplitude
from .gains import FEEDBACKS
from .result import FeedbackTest, HeldMotion
from .sweep import LINES, amplitude_sweep, run_sweeps, segment

_CHUNK = 16  # frequencies side by side: the problem's own grain, so that results do not depend on the executor
_ROOM = 1.02  # over the amplitude that one harmonic of the model expects at the force
_LIMIT = 4.0  # times the force wanted: what the shaker can give
_SAMPLE, _STEP, _READ = 1.2e-4, 4e-7, 0.15  # seconds a sample of a chunk, a step of a rig, and a motion's design


def feedback_test(
    parameters, force, frequency, amplitude=None, design=None, *, points=24, feedback="both", sample_rate=2000, delay=1,
    noise=0.0, noise_floor=0.0, seed=2014, settle=0.4, average=1.0, start="equilibrium", step=5e-5,
    limit=None, progress=False, executor=None, checkpoint=None,
):  # fmt: skip
    """`FeedbackTest`: motions of the multi-body rig held by feedback, amplitude by amplitude at each frequency.

    Parameters
    ----------
    parameters : RigParameters
        The rig on the bench. Nothing of it is told to the controller but what ``design`` says.
    force : float
        N, up to which the sweeps reach, on the far side of both folds.
    frequency : float or array_like, shape (n,)
        Hz; from 5 periods in ``average`` to a twentieth of the sample rate.
    amplitude : array_like, optional
        Amplitudes of z (m) to be held, in this order; by default ``points`` of them, evenly spaced from zero (which is
        left out) to what one harmonic of the model expects at the force.
    design : OscillatorParameters, optional
        The model: as identified on the bench. By default, the rig's own Eq. (2).
    points : int
        Amplitudes at each frequency, 4 to 1000.
    feedback : {"both", "mass", "relative"}
        Signals with gains of their own: xs and x; x alone; or z alone.
    sample_rate : float
        Of the controller (Hz); the force is held from sample to sample.
    delay : int
        Samples from a reading to the force that it leads to, 1 to 20.
    noise, noise_floor : float
        White noise of the sensors: share of the rms of each signal's target (at most 0.1), and m (at most 1e-4). The
        controller and the reader see it, the motion does so through the controller.
    seed : int
        Of the noise.
    settle, average : float
        s after a target was changed (in 0.2 s), before lines are read; and over which they are, in whole periods.
    start : {"equilibrium", "rest"}
    step : float
        Integration step (s); shortened to divide a sample.
    limit : float, optional
        What the shaker can give (N), by default four times ``force``; a motion during which it does says so.
    progress, executor, checkpoint
        See `rigsim.sine_test`.

    Returns
    -------
    FeedbackTest
        Where no gains of the design hold a motion, it is "untried", and a motion that got lost ends its sweep; see
        `HeldMotion` for what each status stands on.

    Raises
    ------
    ValueError
        If an argument is not allowed, or the step is unstable.

    Notes
    -----
    Found on the default rig, with its own Eq. (2) as design and up to 4 N: "both" holds every motion asked for from 6
    to 80 Hz, if the shaker gives the 27 N that the way to the upper fold takes there (``limit``). "mass" and "relative"
    hold the middle branch too, with multipliers of up to 1 instead of 0.6, and leave single motions untried. A design
    whose k3 is 10 % off, c 30 % or ks 5 %, changes the middle branch at 3.18 N by less than 0.03 %; with k3 20 % off
    sweeps get lost. With 0.5 % noise a few motions in a hundred stay "invasive", where F is least: their feedback is
    mostly noise. A single wire set wobbles, and many of its motions are still drifting. The rig's bounce and rocking,
    near 1 kHz and undamped, do not feel the loop: their multipliers stay 1.
    """
    progress, executor, checkpoint = checks.running(progress, executor, checkpoint)
    rig, force = rig_of(parameters), checks.positive("force", force, "N")
    model = oscillator_of(rig if design is None else design, "design")
    delay, points = checks.integer("delay", delay, low=1, high=20), checks.integer("points", points, low=4, high=1000)
    feedback, start = checks.one_of("feedback", feedback, tuple(FEEDBACKS)), checks.one_of("start", start, STARTS)
    sample_rate = checks.real("sample_rate", sample_rate, "Hz", low=100.0, high=1e6)
    settle = checks.real("settle", settle, "s", low=0.0, high=1e3)
    average = checks.real("average", average, "s", low=0.1, high=1e3)
    noise = (
        checks.real("noise", noise, low=0.0, high=0.1),
        checks.real("noise_floor", noise_floor, "m", low=0, high=1e-4),
    )
    limit = _LIMIT * force if limit is None else checks.real("limit", limit, "N", low=force)
    seed, step = checks.seed("seed", seed), checks.positive("step", step, "s")
    check_step([rig], step)
    frequency = np.unique(checks.array("frequency", frequency, "Hz", low=5 / average, high=sample_rate / (2 * LINES)))
    if amplitude is None:
        share = np.arange(1, points + 1) / points
        asked = [_ROOM * largest_amplitude(model, f, force) * share for f in frequency]
    else:
        asked = [checks.array("amplitude", amplitude, "m", low=0.0, low_open=True, high=rig.d)] * len(frequency)
    lengths = segment(settle, average)
    _refuse_endless(len(frequency), len(asked[0]), sum(lengths), sample_rate, step, executor or checkpoint)
    bench = {"rate": sample_rate, "delay": delay, "limit": limit, "start": start, "step": step}
    run = {"rig": rig, "model": model, "feedback": feedback, "lengths": lengths, "noise": noise, "bench": bench}
    chunks = [
        {
            "frequency": frequency[part],
            "asked": np.array(asked[part]),
            "seeds": [(seed, i) for i in range(len(frequency))[part]],
        }
        | run
        for part in split(len(frequency), _CHUNK)
    ]
    options = {"progress": progress, "executor": executor, "checkpoint": checkpoint, "label": "frequencies"}
    done = join(run_chunks(_run_chunk, chunks, **options))
    members = tuple(
        _member(dict(zip(done, values, strict=True)), sample_rate, rig) for values in zip(*done.values(), strict=True)
    )
    return FeedbackTest(members, rig, model, force, feedback, sample_rate, delay, noise, sum(lengths))


def _refuse_endless(frequencies, points, segment_time, rate, step, shared):
    samples = 2 * points * segment_time * rate  # twice as many targets as motions
    seconds = frequencies * (samples * (_SAMPLE / _CHUNK + _STEP / (rate * step)) + points * _READ)
    traces = 3 * 8 * frequencies * points * segment_time * rate
    given = f"{points} amplitudes at {frequencies} frequencies with {segment_time:g} s each"
    affordable(given, memory=2 * traces, seconds=seconds, instead="fewer of them, or shorter ones", shared=shared)


def _run_chunk(chunk):
    """Points of the frequencies of a chunk, one after the other: arrays over them, words as NumPy's text."""
    rate, delay = chunk["bench"]["rate"], chunk["bench"]["delay"]
    design = {"sample_rate": rate, "delay": delay, "feedback": chunk["feedback"]}
    pairs = list(zip(chunk["frequency"], chunk["asked"], strict=True))
    sweeps = [amplitude_sweep(chunk["model"], f, asked, design) for f, asked in pairs]
    random = [np.random.default_rng(seed) for seed in chunk["seeds"]]
    rigs = [chunk["rig"]] * len(sweeps)
    lengths, noise = chunk["lengths"], chunk["noise"]
    found = run_sweeps(rigs, sweeps, chunk["frequency"], lengths, noise, random=random, **chunk["bench"])
    window = int(np.ceil(lengths[-1] * rate))
    points = [{"frequency": f} | point for (f, _), points in zip(pairs, found, strict=True) for point in points]
    names = ("frequency", "amplitude", "lines", "invasive", "drift", "gains", "loop", "multipliers", "suspension",
             "misfit", "segments", "status", "message", "begin")  # fmt: skip
    nothing = np.full((3, window), np.nan)
    traces = [point.get("trace", nothing) for point in points]
    return {name: np.array([point[name] for point in points]) for name in names} | {"trace": np.array(traces)}


def _member(point, sample_rate, rig):
    """`HeldMotion` of a point's arrays."""
    shaker, mass, force, feedback = point.pop("lines").T
    trace, status, message = point.pop("trace"), Status[str(point.pop("status"))], str(point.pop("message"))
    numbers = {name: value.item() if value.ndim == 0 else value for name, value in point.items()}
    known = None if status is Status.UNTRIED else trace[[2, 0, 1]]
    return HeldMotion(
        shaker=shaker, mass=mass, force=force, feedback=feedback, status=status, message=message, trace=known,
        sample_rate=sample_rate, parameters=rig, **numbers,
    )  # fmt: skip
