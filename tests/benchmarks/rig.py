"""The multi-body rig: a sweep of 71 frequencies, from rest and tapped, 3 s each, and a 100 s random test.

Unit: a bare compiled leapfrog of the same force law and damping, one rig after the other on one processor, which keeps
nothing but where it ends: no Chipmunk, no tap, no recording, no lines.
"""

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pymunk

from rigsim import RigParameters, Tap, random_test, sine_test
from rigsim.compiled import compiled
from rigsim.model.planar import centre_damping, conservative_forces, mass_matrix, pack, rest_position

RIGS, STEP, DURATION = 142, 5e-5, 3.0


@compiled
def leapfrog(q, v, rig, wires, mass, amplitude, omega, h, steps):
    """Move ``q`` and ``v`` (4,), in place, under F cos(omega t) on the frame."""
    force, damping = np.empty(4), np.empty((4, 4))
    for step in range(steps):
        for i in range(4):
            q[i] += v[i] * h
        conservative_forces(q, rig, wires, force)
        force[0] += amplitude * np.cos(omega * step * h)
        centre_damping(q, v, rig, wires, mass, h, damping, force)
        for i in range(4):
            v[i] += force[i] * h / mass[i]


def bare(rig, frequency, steps):
    """Seconds of the unit, a rig and step."""
    rigs, wires = pack([rig])
    mass = np.diag(mass_matrix(rig)).copy()
    begun = time.perf_counter()
    for omega in 2 * np.pi * frequency:
        leapfrog(rest_position(rig), np.zeros(4), rigs[0], wires[0], mass, 3.18, omega, STEP, steps)
    return (time.perf_counter() - begun) / (len(frequency) * steps)


def chipmunk_step(bodies, steps=20_000):
    """Seconds of one step of a Space that holds free bodies."""
    space = pymunk.Space()
    for _ in range(bodies):
        space.add(pymunk.Body(1.0, 1.0))
    begun = time.perf_counter()
    for _ in range(steps):
        space.step(STEP)
    return (time.perf_counter() - begun) / steps


def seconds(function, *arguments, **options):
    """Of one call."""
    begun = time.perf_counter()
    function(*arguments, **options)
    return time.perf_counter() - begun


def measure():
    """Rows (name, value, unit, ratio): the least of three rounds each, unit and test in turn."""
    rig, frequency = RigParameters(), np.tile(np.linspace(10, 80, RIGS // 2), 2)
    sweep = {"tap": [None] * (RIGS // 2) + [Tap()] * (RIGS // 2), "duration": DURATION, "step": STEP}
    sine_test(rig, 3.18, 30.0, duration=1)  # compiles
    bare(rig, frequency[:1], 1)
    rounds = []
    for _ in range(3):
        with ThreadPoolExecutor(1) as one:
            alone = seconds(sine_test, rig, 3.18, frequency, executor=one, **sweep)
        every = seconds(sine_test, rig, 3.18, frequency, **sweep)
        rounds.append((bare(rig, frequency, 20_000), alone, every, seconds(random_test, rig)))
    unit, alone, every, record = np.min(rounds, axis=0)
    space = seconds(sine_test(rig, 3.18, frequency, **sweep).out_of_plane)
    a_step, record_step = alone / (RIGS * DURATION / STEP), record / (100 / STEP)
    return [
        ("unit: bare leapfrog, a rig and step", 1e6 * unit, "us", 1.0),
        (f"sweep of {RIGS} rigs, spectra included, one thread, a rig and step", 1e6 * a_step, "us", a_step / unit),
        ("the same in all", alone, "s", None),
        ("the same as users run it, a thread a processor", every, "s", None),
        ("which of them last in three dimensions, against that", space, "s", space / every),
        ("Chipmunk's own step of as many free bodies, a rig", 1e6 * chipmunk_step(2 * RIGS) / RIGS, "us", None),
        ("random test of 100 s, a step", 1e6 * record_step, "us", record_step / unit),
        ("the same in all", record, "s", None),
    ]
