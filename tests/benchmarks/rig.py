"""The multi-body rig: a sweep of 71 frequencies, from rest and tapped, 3 s each, and a 100 s random test.

Unit: Chipmunk's own step of as many free bodies (two a rig), without forces, springs or recording.
"""

import time

import numpy as np
import pymunk

from rigsim import RigParameters, Tap, random_test, sine_test

RIGS, STEP, DURATION = 142, 5e-5, 3.0


def bare_step(bodies, steps=20_000):
    """Seconds of one step of a Space that holds free bodies."""
    space = pymunk.Space()
    for _ in range(bodies):
        space.add(pymunk.Body(1.0, 1.0))
    begun = time.perf_counter()
    for _ in range(steps):
        space.step(STEP)
    return (time.perf_counter() - begun) / steps


def measure():
    """Rows (name, value, unit, ratio)."""
    rig, frequency = RigParameters(), np.tile(np.linspace(10, 80, RIGS // 2), 2)
    taps = [None] * (RIGS // 2) + [Tap()] * (RIGS // 2)
    sine_test(rig, 3.18, 30.0, duration=1)  # compiles
    unit_sweep, unit_single = bare_step(2 * RIGS), bare_step(2)
    begun = time.perf_counter()
    sine_test(rig, 3.18, frequency, tap=taps, duration=DURATION, step=STEP)
    sweep = time.perf_counter() - begun
    begun = time.perf_counter()
    random_test(rig)
    record = time.perf_counter() - begun
    rig_steps = RIGS * DURATION / STEP
    return [
        (f"unit: bare step, {2 * RIGS} bodies, per rig", 1e6 * unit_sweep / RIGS, "us", 1.0),
        (
            f"sweep of {RIGS} rigs, a rig and step",
            1e6 * sweep / rig_steps,
            "us",
            sweep / rig_steps / (unit_sweep / RIGS),
        ),
        (f"sweep of {RIGS} rigs in all, spectra included", sweep, "s", None),
        ("unit: bare step, 2 bodies", 1e6 * unit_single, "us", 1.0),
        ("random test of 100 s, a step", 1e6 * record / (100 / STEP), "us", record / (100 / STEP) / unit_single),
        ("random test of 100 s in all", record, "s", None),
    ]
