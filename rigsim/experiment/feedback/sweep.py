"""Sweeps of amplitude at fixed frequencies, many rigs side by side: hold, read, adjust the target, go on.

Each frequency is a generator that yields what its loop is to do next and is sent what was read; all of them are
stepped together, and none knows of the others.
"""

from dataclasses import dataclass

import numpy as np

from ...campaign.stop import look
from ...results import Status
from ..lines import fit_sines
from .balance import misfit, refitted, stepped
from .gains import designed, multipliers, transitions
from .loop import Loop

LINES = 10  # multiples of the frequency that are read
CONTROLLED = 10  # of them, those that the target has
INVASIVE = 0.01  # of F, largest line of the feedback off the fundamental that counts as none
_MOST = 6  # targets tried for a motion
_NEAR, _CLOSER = 0.02, 3  # of the amplitude that is asked for, how near is near enough, and tries for no more than that
_DRIFT, _LOST = 2e-3, 0.2  # change of z between the window's halves: of a held motion at most, of a lost one at least
_RAMP = 0.2  # s in which a target and its gains are changed to the next
_FLOQUET = 128  # steps a period for the multipliers of the open rig
_BLOCK = 500  # samples between two looks at the keyboard


@dataclass(frozen=True, eq=False)
class Setting:
    """What a loop does: follow target lines (CONTROLLED + 1, 2) with a force F cos, complex F, and gains (4,)."""

    lines: np.ndarray
    force: complex
    gains: np.ndarray


def amplitude_sweep(model, frequency, amplitudes, design):
    """Generator of `Setting`, sent a `reading` each; returns the points, a dict each."""
    at = np.zeros((CONTROLLED + 1, 2), dtype=complex), np.zeros(CONTROLLED + 1, dtype=complex), 0j
    points, gains, lost = [], None, ""
    for amplitude in amplitudes:
        lines, added = stepped(model, frequency, *at[:2], amplitude)
        gains, radius = designed(model, lines[:, 0] - lines[:, 1], frequency, start=gains, **design)
        point = {"amplitude": amplitude, "gains": gains, "loop": radius, "segments": 0}
        if lost or radius >= 1:
            message = lost or f"the loop as designed has a multiplier of {radius:.3g}; expected below 1"
            points.append(point | _nothing() | {"status": Status.UNTRIED.name, "message": message})
            continue
        for attempt in range(1, _MOST + 1):
            read = yield Setting(lines, (at[2] + added) / held(frequency / design["sample_rate"]), gains)
            verdict, z = _verdict(read), abs(np.subtract(*read["lines"][1, :2]))
            there = abs(z - amplitude) < _NEAR * amplitude or attempt >= _CLOSER
            if verdict[0] in (Status.LOST, Status.FLEW_APART) or (verdict[0] is Status.HELD and there):
                break
            at = _known(read)
            lines, added = stepped(model, frequency, *at[:2], amplitude)
        points.append(point | read | {"segments": attempt, "status": verdict[0].name, "message": verdict[1]})
        at = _known(read)
        if verdict[0] in (Status.LOST, Status.FLEW_APART):
            lost = f"the loop had lost the motion of {1e3 * amplitude:.3g} mm"
    return _with_stability(model, frequency, points)


def _known(read):
    """What the next step starts from: controlled lines of the motion and of the feedback, and the force's first."""
    return read["lines"][: CONTROLLED + 1, :2], read["lines"][: CONTROLLED + 1, 3], read["lines"][1, 2]


def _verdict(read):
    told = (
        f"feedback's largest line off the fundamental {read['invasive']:.2%} of F, "
        f"z drifts by {read['drift']:.2g} between half windows"
    )
    if read["limited"] > 0:
        told += f"; the force is at its limit in {read['limited']:.1%} of the samples"
    if np.isfinite(read["parted"]):
        return Status.FLEW_APART, f"past its wires' reach at t = {read['parted']:.4g} s"
    if not read["drift"] < _LOST:
        return Status.LOST, told
    if read["drift"] < _DRIFT + read["blur"]:
        return (Status.HELD if read["invasive"] < INVASIVE else Status.INVASIVE), told
    return Status.STILL_DRIFTING, told


def _with_stability(model, frequency, points):
    """The points, with the multipliers of the open rig about each that was held.

    They are those of the model with a suspension that is fitted to the motions held at this frequency.
    """
    lines = {i: point["lines"][:, :2] for i, point in enumerate(points) if point["status"] == Status.HELD.name}
    fitted = refitted(model, frequency, list(lines.values())) if lines else model
    for i, point in enumerate(points):
        point |= {"multipliers": np.full(4, np.nan + 0j), "misfit": np.nan}
        point["suspension"] = np.array([fitted.c, fitted.k1, fitted.k3])
        if i in lines:
            steps, _ = transitions(fitted, lines[i][:, 0] - lines[i][:, 1], frequency, _FLOQUET)
            found = multipliers(steps).astype(complex)
            point["multipliers"], point["misfit"] = found[np.argsort(-abs(found))], misfit(model, frequency, lines[i])
    return points


def _nothing():
    """What a motion that was not tried has of a reading; no trace."""
    return {"lines": np.full((LINES + 1, 4), np.nan + 0j)} | dict.fromkeys(("invasive", "drift", "begin"), np.nan)


def reading(time, signals, frequency, rate, noise):
    """Lines of a window (samples, 4) of xs, x, force and feedback over its whole periods, as a dict."""
    whole = np.floor((time[-1] - time[0]) * frequency * (1 + 1e-9)) / frequency
    inside = time > time[-1] - (1 - 1e-9) * whole
    lines = _lines(time[inside], signals[inside], frequency)
    lines[:, 2:] *= held(np.arange(LINES + 1) * frequency / rate)[:, None]
    others = np.abs(lines[np.arange(LINES + 1) != 1, 3])
    half = np.floor(np.floor(whole * frequency * (1 + 1e-9)) / 2) / frequency
    parts = time <= time[0] + half * (1 + 1e-9), time >= time[-1] - half * (1 + 1e-9)
    first, last = (np.subtract(*_lines(time[part], signals[part, :2], frequency)[1]) for part in parts)
    # What the noise of the sensors alone makes of the drift, three standard deviations of it.
    blur = 3 * np.hypot(*noise) * np.sqrt(8 / (half * rate)) / abs(first + last) * 2
    return {
        "lines": lines,
        "invasive": float(others.max() / abs(lines[1, 2])),
        "drift": float(abs(last - first) / abs(first + last) * 2),
        "blur": float(blur),
    }


def held(turns):
    """What a line of held samples acts as, over itself, at frequencies over the rate: less, and half a sample late."""
    return np.sinc(turns) * np.exp(-1j * np.pi * turns)


def _lines(time, signals, frequency):
    """Mean and lines (LINES + 1, channels)."""
    multiples = frequency * np.arange(1, LINES + 1)
    lines, left = fit_sines(time, signals, multiples)
    turn = np.exp(2j * np.pi * multiples * time[0])[:, None]
    mean = signals[0] - left[0] - (lines * turn).real.sum(axis=0)
    return np.concatenate([mean[None].astype(complex), lines])


def segment(settle, average):
    """Lengths (s) of what is done for one reading: change the target, let it settle, and read.

    Whole periods of frequencies from 5/``average`` on, as many as the last part has, last ``average`` or more.
    """
    return _RAMP, settle, 1.2 * average


def run_sweeps(rigs, sweeps, frequency, lengths, noise, **bench):
    """Points of all sweeps, a list of dicts each; ``lengths`` are those of a `segment`, ``bench`` arguments of `Loop`.

    ``noise`` is (share of a target's rms, m).
    """
    loop, rate = Loop(rigs, **bench), bench["rate"]
    ramp, quiet, window = (int(np.ceil(length * rate)) for length in lengths)
    n, points, sent = len(sweeps), [None] * len(sweeps), [None] * len(sweeps)
    rest = Setting(np.zeros((CONTROLLED + 1, 2), dtype=complex), 0j, np.zeros(4))
    old, new = [rest] * n, [rest] * n
    while True:
        for i in range(n):
            old[i] = new[i]
            try:
                new[i] = sweeps[i].send(sent[i]) if points[i] is None else rest
            except StopIteration as done:
                points[i], new[i] = done.value, rest
        if all(done is not None for done in points):
            return points
        spread = _spread(new, noise)
        begin, kept = loop.done, []
        for first in range(0, ramp + quiet + window, _BLOCK):
            look()
            count = min(_BLOCK, ramp + quiet + window - first)
            time = (loop.done + np.arange(count)) / rate
            share = np.clip((first + 1 + np.arange(count)) / ramp, 0.0, 1.0)
            target, forward = _follow(old, new, share, 2 * np.pi * frequency * time[:, None])
            gains = np.stack([setting.gains for setting in new], axis=1)
            readings, force, feedback = loop.run(target, forward, gains, spread)
            kept.append(np.stack([*np.moveaxis(readings, 1, 0), force, feedback], axis=2))
        signals = np.concatenate(kept)[ramp + quiet :]
        time = (begin + ramp + quiet + np.arange(window)) / rate
        for i in range(n):
            if points[i] is None:
                read = reading(time, signals[:, i], frequency[i], rate, spread[:, i])
                limited = float(np.mean(abs(signals[:, i, 2]) >= bench["limit"]))
                sent[i] = read | {
                    "limited": limited,
                    "parted": loop.parted[i],
                    "begin": time[0],
                    "trace": signals[:, i, :3].T.copy(),
                }


def _spread(settings, noise):
    """Standard deviation of the sensors' noise (2, n)."""
    share, floor = noise
    power = np.array([0.5 * (abs(setting.lines[1:]) ** 2).sum(axis=0) for setting in settings]).T
    return np.sqrt(share**2 * power + floor**2)


def _follow(old, new, share, phase):
    """Target (samples, 2, n) and force (samples, n) on the way from old to new settings."""
    turns = np.exp(1j * phase)  # (samples, n)
    target, forward = np.zeros((len(share), 2, len(new))), np.empty(phase.shape)
    for i, (one, two) in enumerate(zip(old, new, strict=True)):
        powers = turns[:, i, None] ** np.arange(CONTROLLED + 1)
        mixed = one.lines + share[:, None, None] * (two.lines - one.lines)
        target[:, :, i] = (powers[:, :, None] * mixed).real.sum(axis=1)
        forward[:, i] = ((one.force + share * (two.force - one.force)) * turns[:, i]).real
    return target, forward
