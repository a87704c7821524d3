"""The multi-body rig: a sweep of 71 frequencies, from rest and tapped, 3 s each, and a 100 s random test.

Unit: a bare compiled leapfrog of the same force law and damping, of as many rigs, without Chipmunk, taps or recording.
"""

import time

import numpy as np
import pymunk

from rigsim import RigParameters, Tap, random_test, sine_test
from rigsim.compiled import compiled
from rigsim.model.planar import centre_damping, conservative_forces, mass_matrix, pack, rest_position

RIGS, STEP, DURATION = 142, 5e-5, 3.0


@compiled
def leapfrog(q, v, rigs, wires, mass, force, omega, h, steps):
    """Move ``q`` and ``v`` (n, 4), in place, under F cos(omega t) on each frame."""
    kick, damping = np.empty(4), np.empty((4, 4))
    for step in range(steps):
        for i in range(len(rigs)):
            for j in range(4):
                q[i, j] += v[i, j] * h
            conservative_forces(q[i], rigs[i], wires[i], kick)
            kick[0] += force * np.cos(omega[i] * step * h)
            centre_damping(q[i], v[i], rigs[i], wires[i], mass[i], h, damping, kick)
            for j in range(4):
                v[i, j] += kick[j] * h / mass[i, j]


def bare(rig, count, steps):
    """Seconds a rig and step of the unit, the least of three."""
    rigs, wires = pack([rig] * count)
    mass = np.tile(np.diag(mass_matrix(rig)), (count, 1))
    omega, took = 2 * np.pi * np.linspace(10, 80, count), []
    leapfrog(np.tile(rest_position(rig), (count, 1)), np.zeros((count, 4)), rigs, wires, mass, 3.18, omega, STEP, 1)
    for _ in range(3):
        q, v = np.tile(rest_position(rig), (count, 1)), np.zeros((count, 4))
        begun = time.perf_counter()
        leapfrog(q, v, rigs, wires, mass, 3.18, omega, STEP, steps)
        took.append(time.perf_counter() - begun)
    return min(took) / (count * steps)


def chipmunk_step(bodies, steps=20_000):
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
    unit, alone = bare(rig, RIGS, 20_000), bare(rig, 1, 400_000)
    begun = time.perf_counter()
    sine_test(rig, 3.18, frequency, tap=taps, duration=DURATION, step=STEP)
    sweep = time.perf_counter() - begun
    begun = time.perf_counter()
    random_test(rig)
    record = time.perf_counter() - begun
    each, step = sweep / (RIGS * DURATION / STEP), record / (100 / STEP)
    return [
        (f"unit: bare leapfrog of {RIGS} rigs, a rig and step", 1e6 * unit, "us", 1.0),
        (f"sweep of {RIGS} rigs, spectra included, a rig and step", 1e6 * each, "us", each / unit),
        (f"sweep of {RIGS} rigs in all", sweep, "s", None),
        ("Chipmunk's own step of their free bodies, a rig", 1e6 * chipmunk_step(2 * RIGS) / RIGS, "us", None),
        ("unit: bare leapfrog of one rig, a step", 1e6 * alone, "us", 1.0),
        ("random test of 100 s, a step", 1e6 * step, "us", step / alone),
        ("random test of 100 s in all", record, "s", None),
    ]
