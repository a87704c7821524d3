"""The multi-body rig in Chipmunk, through pymunk: the only door to it.

Each rig is two bodies of one `pymunk.Space`: the frame, which a guide lets move along x only
(no moment can turn it and the guide carries its weight, so it needs no constraint), and the
cylinder. `Space` does the stepping; the loop around it is compiled and calls the very functions that
``pymunk.batch.get_space_bodies``, ``set_space_bodies`` and ``Space.step`` call, because three calls from
Python cost more than a hundred rigs. Their addresses have private names, so one version of pymunk is allowed, every
`RigSpace` reads its bodies back through the public interface, and a test steps rigs by public calls alone.

Chipmunk's step moves positions (p += v h) and then velocities by the force it was given. That force is
evaluated here at p + v h and t + h, with damping centred between the old and the new velocity, and the
first velocity is that of half a step later: so velocities live at half steps and the step is a leapfrog
of second order.
"""

from dataclasses import dataclass

import numpy as np
import pymunk
import pymunk.batch
from numba import types
from numba.core.types import WrapperAddressProtocol
from numba.experimental import function_type  # noqa: F401  (registers how such a function is passed)
from pymunk._chipmunk_cffi import ffi, lib

from ..compiled import compiled
from .planar import (
    centre_damping,
    conservative_forces,
    largest_tilt,
    longest_step,
    pack,
    rest_position,
    static_equilibrium,
)

STARTS = ("rest", "equilibrium")
VERSION = "7.3.1"
if pymunk.version != VERSION:  # memory is handed over by private names, see `_Batch`
    raise ImportError(
        f"pymunk = {pymunk.version} is not allowed; expected {VERSION}, the version rigsim was tried with"
    )
_FIELDS = pymunk.batch.BodyFields
_READ = _FIELDS.POSITION | _FIELDS.ANGLE | _FIELDS.VELOCITY | _FIELDS.ANGULAR_VELOCITY
_WRITE = _FIELDS.FORCE | _FIELDS.TORQUE
_READ_SIZE, _WRITE_SIZE = 6, 3  # numbers a body, in Chipmunk's order

# Chipmunk's own checks abort the process on a NaN: a rig that flies apart is parked long before. No part of a
# sound rig moves by more than a few wire lengths in a step.
_FLOWN_WIRE_LENGTHS = 100.0


class _ChipmunkFunction(WrapperAddressProtocol):
    """A C function of pymunk's library that compiled code can be handed and call."""

    def __init__(self, name, *arguments):
        self._address = int(ffi.cast("uintptr_t", ffi.addressof(lib, name)))
        self._signature = types.void(*arguments)

    def __wrapper_address__(self):
        return self._address

    def signature(self):
        return self._signature


_EACH_BODY = _ChipmunkFunction("cpSpaceEachBody", types.intp, types.intp, types.intp)
_STEP = _ChipmunkFunction("cpSpaceStep", types.intp, types.float64)


class _Batch:
    """A `pymunk.batch.Buffer` over a NumPy array, and the addresses compiled code needs to use it."""

    def __init__(self, fields, bodies, numbers, iterator):
        self._buffer = pymunk.batch.Buffer()
        # One number to spare: Chipmunk grows a full array, and this one is not its own.
        self._room = np.zeros(bodies * numbers + 1)
        self.values = self._room[:-1].reshape(bodies, numbers)
        self._buffer.set_float_buf(self._room)
        self._data = ffi.new("pmBatchedData *")
        self._data.fields = fields.value
        self._data.floatArray = self._buffer._float_arr
        self._data.intArray = self._buffer._int_arr
        count = ffi.addressof(self._buffer._float_arr, "num")
        self.count = np.frombuffer(ffi.buffer(count, ffi.sizeof("int")), dtype=np.intc)
        self.address = int(ffi.cast("uintptr_t", self._data))
        self._iterator = ffi.addressof(lib, iterator)
        self.iterator = int(ffi.cast("uintptr_t", self._iterator))

    def check(self, space):
        """Hold what compiled loops will read against pymunk's public interface: count, sizes and values.

        Raises
        ------
        RuntimeError
            If they differ: the private names mean something else than they did.
        """
        public = pymunk.batch.Buffer()
        pymunk.batch.get_space_bodies(space, _READ, public)
        expected = np.frombuffer(public.float_buf(), dtype=float)
        # The sizes first: Chipmunk would grow an array that is too short, and this one is not its own.
        if expected.size == self.values.size:
            self.count[0] = 0
            lib.cpSpaceEachBody(space._space, self._iterator, self._data)
        if self.count[0] != expected.size or not np.array_equal(self.values.ravel(), expected):
            raise RuntimeError(
                f"pymunk {pymunk.version} hands over {self.values.size} numbers of {len(space.bodies)} bodies where its "
                f"public interface has {expected.size}, or others: its memory is not laid out as rigsim takes it to be"
            )


@dataclass(frozen=True, eq=False)
class Motion:
    """Sampled motion of n rigs, each measured from its position of rest.

    Attributes
    ----------
    shaker, mass, tilt : ndarray, shape (samples, n)
        xs and x of P (m), tilt (rad).
    parted : ndarray of float, shape (n,)
        When the rig flew apart or tilted past its wires' reach (s), NaN if it did not; it is held from there on.
    """

    shaker: np.ndarray
    mass: np.ndarray
    tilt: np.ndarray
    parted: np.ndarray


def check_step(parameters, step):
    """Refuse a step (s) that is too long for the stiffest of the rigs.

    Raises
    ------
    ValueError
        If it is.
    """
    limit = min(longest_step(p) for p in set(parameters))
    if not 0 < step < limit:
        raise ValueError(f"step = {step:g} s is unstable; expected above 0 and below 2/omega = {limit:.3g} s")


class RigSpace:
    """Many rigs side by side in one `pymunk.Space`, stepped together.

    Parameters
    ----------
    parameters : sequence of RigParameters
        One a rig.
    step : float
        s.
    start : {"rest", "equilibrium"}
        Wires unsagged, or the static equilibrium; at rest either way.

    Raises
    ------
    ValueError
        If the step is too long for the stiffest rig to be stable, or a rig has no equilibrium to start from.
    """

    def __init__(self, parameters, step, start):
        self._rigs, self._wires = pack(parameters)
        check_step(parameters, step)
        self.step = step
        self._LG = self._rigs["LG"]
        self._mass = np.stack([self._rigs[name] for name in ("ms", "m", "m", "inertia")], axis=1)
        self._flown = _FLOWN_WIRE_LENGTHS * np.array([p.d for p in parameters])
        self._reach = np.array([largest_tilt(p) for p in parameters])
        self._parted = np.full(len(parameters), np.nan)
        self._done = 0
        self._space = pymunk.Space()
        at = {p: rest_position(p) if start == "rest" else static_equilibrium(p).coordinates for p in set(parameters)}
        bodies = []
        for p in parameters:
            xs, X, Y, tilt = at[p]
            frame, cylinder = pymunk.Body(p.ms, float("inf")), pymunk.Body(p.m, p.inertia)
            frame.position, cylinder.position, cylinder.angle = (xs, 0.0), (X, Y), tilt
            bodies += [frame, cylinder]
        self._space.add(*bodies)
        self._space.step(0.0)  # lets pymunk check the bodies; no time passes
        self._read = _Batch(_READ, len(bodies), _READ_SIZE, "pmSpaceBodyGetIteratorFuncBatched")
        self._read.check(self._space)
        self._write = _Batch(_WRITE, len(bodies), _WRITE_SIZE, "pmSpaceBodySetIteratorFuncBatched")

    def advance(self, frame_force, tap_force, sample_every):
        """Take as many steps as there are kicks, and return the motion at every ``sample_every``-th.

        Parameters
        ----------
        frame_force : ndarray, shape (steps, n) or (steps, 1)
            Force on the frames (N) at each kick; the first kick of all is that of t = 0.
        tap_force : ndarray, shape (steps, n)
            Force on the masses (N) at each kick.
        sample_every : int
            Steps a sample; ``steps`` is a multiple of it. Positions are those at the kick.

        Returns
        -------
        Motion
        """
        steps, n = tap_force.shape
        positions = np.empty((steps // sample_every, 4, n))
        _advance(
            _EACH_BODY, _STEP, int(ffi.cast("uintptr_t", self._space._space)),
            self._read.iterator, self._read.address, self._read.count, self._read.values,
            self._write.iterator, self._write.address, self._write.count, self._write.values,
            self._rigs, self._wires, self._mass, self._flown, self._reach, self._parted,
            np.ascontiguousarray(frame_force), np.ascontiguousarray(tap_force),
            self.step, self._done, sample_every, positions,
        )  # fmt: skip
        self._done += steps
        xs, X, _, tilt = np.moveaxis(positions, 1, 0)
        return Motion(xs, X - self._LG * np.cos(tilt), tilt, self._parted.copy())


@compiled(nogil=True)
def _advance(
    each_body, space_step, space,
    read_iterator, read_address, read_count, read,
    write_iterator, write_address, write_count, write,
    rigs, wires, mass, flown, reach, parted, frame_force, tap_force, h, done, sample_every, positions,
):  # fmt: skip
    """The leapfrog. Chipmunk's step drifts, then kicks, so the kick of time t is prepared before the step to t.

    The first kick, of half a step, comes from rest: that step drifts nowhere and ends at t = 0.
    """
    q, v, force = np.empty(4), np.empty(4), np.empty(4)
    damping = np.empty((4, 4))
    steps, n = tap_force.shape
    read_count[0] = 0
    each_body(space, read_iterator, read_address)
    for k in range(steps):
        first = done + k == 0
        for i in range(n):
            frame, cylinder = read[2 * i], read[2 * i + 1]
            v[0], v[1], v[2], v[3] = frame[3], cylinder[3], cylinder[4], cylinder[5]
            q[0], q[1], q[2], q[3] = frame[0], cylinder[0], cylinder[1], cylinder[2]
            for j in range(4):
                q[j] += v[j] * h  # where Chipmunk's drift will take it
            if np.isnan(parted[i]) and not (abs(q[0]) + abs(q[1]) + abs(q[2]) < flown[i] and abs(q[3]) < reach[i]):
                parted[i] = (done + k) * h
            if np.isnan(parted[i]):
                conservative_forces(q, rigs[i], wires[i], force)
                force[0] += frame_force[k, i % frame_force.shape[1]]
                force[1] += tap_force[k, i]  # through the centre of mass: no torque
                if first:
                    for j in range(4):
                        force[j] *= 0.5
                else:
                    centre_damping(q, v, rigs[i], wires[i], mass[i], h, damping, force)
            else:
                for j in range(4):
                    force[j] = -mass[i, j] * v[j] / h
            write[2 * i, 0] = force[0]
            write[2 * i + 1, 0], write[2 * i + 1, 1], write[2 * i + 1, 2] = force[1], force[2], force[3]
        write_count[0] = 0
        each_body(space, write_iterator, write_address)
        space_step(space, h)
        read_count[0] = 0
        each_body(space, read_iterator, read_address)
        if k % sample_every == 0:
            for i in range(n):
                frame, cylinder = read[2 * i], read[2 * i + 1]
                positions[k // sample_every, 0, i] = frame[0]
                for j in range(3):
                    positions[k // sample_every, 1 + j, i] = cylinder[j]
