"""The multi-body rig in Chipmunk, through pymunk: the only door to it.

Each rig is two bodies of one `pymunk.Space`: the frame, which a guide lets move along x only
(no moment can turn it and the guide carries its weight, so it needs no constraint), and the
cylinder. `Space` does the stepping; the loop around it is compiled and calls the very functions that
``pymunk.batch.get_space_bodies``, ``set_space_bodies`` and ``Space.step`` call, because three calls from
Python cost more than a hundred rigs. Their names are private to pymunk and its memory is shared, so other versions than
the one that was tried are refused, and every Space is read and written through the public calls too before it moves.

Chipmunk's step moves positions (p += v h) and then velocities by the force it was given. That force is
evaluated here at p + v h and t + h, with damping centred between the old and the new velocity, and the
first velocity is that of half a step later: so velocities live at half steps and the step is a leapfrog
of second order.
"""

import warnings
from dataclasses import dataclass

import numpy as np
import pymunk
from numba import types
from numba.core.types import WrapperAddressProtocol
from numba.experimental import function_type  # noqa: F401  (registers how such a function is passed)

from ..compiled import compiled
from .planar import (
    centre_damping,
    conservative_forces,
    count_slack,
    largest_tilt,
    longest_step,
    pack,
    rest_position,
    static_equilibrium,
)
from .shaker import check_drives, given, pack_drives, pushed

PYMUNK = "7.3.1"
_SHORTEST = 1e-4  # of the longest stable step
STARTS = ("rest", "equilibrium")


def _foreign_functions():
    if pymunk.version != PYMUNK:
        raise ImportError(f"pymunk {pymunk.version} is not allowed; the multi-body rig expects pymunk=={PYMUNK}")
    from pymunk import batch
    from pymunk._chipmunk_cffi import ffi, lib

    return batch, ffi, lib


batch, ffi, lib = _foreign_functions()
_FIELDS = batch.BodyFields
_READ = _FIELDS.POSITION | _FIELDS.ANGLE | _FIELDS.VELOCITY | _FIELDS.ANGULAR_VELOCITY
_WRITE = _FIELDS.FORCE | _FIELDS.TORQUE
_LAID_OUT_OTHERWISE = f"pymunk {PYMUNK} lays out its bodies otherwise than rigsim's compiled loop expects"
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
        self._buffer = batch.Buffer()
        # One number to spare: Chipmunk grows a full array, and this one is not its own.
        self._room = np.zeros(bodies * numbers + 1)
        self.values = self._room[:-1].reshape(bodies, numbers)
        self.fields = fields
        self._buffer.set_float_buf(self._room)
        self._data = ffi.new("pmBatchedData *")
        self._data.fields = fields.value
        self._data.floatArray = self._buffer._float_arr
        self._data.intArray = self._buffer._int_arr
        count = ffi.addressof(self._buffer._float_arr, "num")
        self.count = np.frombuffer(ffi.buffer(count, ffi.sizeof("int")), dtype=np.intc)
        address = int(ffi.cast("uintptr_t", self._data))
        self.handles = int(ffi.cast("uintptr_t", ffi.addressof(lib, iterator))), address, self.count

    def public(self, space):
        """The numbers of the bodies of a Space as pymunk itself reads them."""
        buffer = batch.Buffer()
        batch.get_space_bodies(space, self.fields, buffer)
        return np.frombuffer(buffer.float_buf())

    def differs(self, space):
        """Whether these numbers are others than the public ones."""
        return self.count[0] != self.values.size or not np.array_equal(self.values.ravel(), self.public(space))


@dataclass(frozen=True, eq=False)
class Motion:
    """Sampled motion of n rigs, each measured from its position of rest; arrays of shape (samples, n)."""

    shaker: np.ndarray  # xs (m)
    mass: np.ndarray  # x of P (m)
    tilt: np.ndarray  # rad
    force: np.ndarray  # on the frame (N)
    voltage: np.ndarray  # at the shaker's coil (V); 0 where there is no drive
    limited: np.ndarray  # (n,) bool: whether the drive was at its limit, at the end
    parted: np.ndarray  # (n,): when the rig flew apart or tilted past its wires' reach (s), else NaN; held from then
    slack: np.ndarray  # (n, 2), since the start: share of time with a slack wire, and how often one went slack


def check_step(parameters, step):
    """Raise `ValueError` for a step (s) that is too long for the stiffest of the rigs, or shorter than is of use."""
    limit = min(longest_step(p) for p in set(parameters))
    if not 0 < step < limit:
        raise ValueError(f"step = {step:g} s is unstable; expected above 0 and below 2/omega = {limit:.3g} s")
    if step < _SHORTEST * limit:  # rounding outgrows the error of the step
        raise ValueError(f"step = {step:g} s is shorter than is of use; expected {_SHORTEST * limit:.3g} s or more")


class RigSpace:
    """Many rigs side by side in one `pymunk.Space`, stepped together.

    ``parameters`` are one a rig, ``step`` is in s, and ``start`` one of `STARTS`: wires unsagged, or the static
    equilibrium; at rest either way. ``drives`` are the `ShakerDrive` of each, None where the force is prescribed.

    Raises
    ------
    ValueError
        If the step is too long for the stiffest rig to be stable, or a rig has no equilibrium to start from.
    RuntimeError
        If compiled code and pymunk's public calls do not agree on what the bodies hold.
    """

    def __init__(self, parameters, step, start, drives=None):
        self._rigs, self._wires = pack(parameters)
        drives = [None] * len(parameters) if drives is None else drives
        check_step(parameters, step)
        check_drives(drives, parameters, step)
        self._drives, self._circuits = pack_drives(drives, parameters)
        self.step = step
        self._LG = self._rigs["LG"]
        self._mass = np.stack([self._rigs[name] for name in ("ms", "m", "m", "inertia")], axis=1)
        self._flown = _FLOWN_WIRE_LENGTHS * np.array([p.d for p in parameters])
        self._reach = np.array([largest_tilt(p) for p in parameters])
        self._parted = np.full(len(parameters), np.nan)
        self._slack = np.repeat([[0.0] * 2 + [1.0] * 6], len(parameters), axis=0)  # slack from the start is no event
        self.done = 0  # steps
        self._parameters = tuple(parameters)
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
        self._address = int(ffi.cast("uintptr_t", self._space._space))
        self._read = _Batch(_READ, len(bodies), _READ_SIZE, "pmSpaceBodyGetIteratorFuncBatched")
        self._write = _Batch(_WRITE, len(bodies), _WRITE_SIZE, "pmSpaceBodySetIteratorFuncBatched")
        self._try_out(bodies)

    def _try_out(self, bodies):
        """Read the bodies, and write forces, as the loop will; refuse if pymunk's public calls tell otherwise."""
        both = self._read, self._write
        # The sizes first: Chipmunk would grow an array that is too short, and these are not its own.
        if any(one.public(self._space).size != one.values.size for one in both):
            raise RuntimeError(_LAID_OUT_OTHERWISE)
        _each_body(_EACH_BODY, self._address, self._read.handles)
        self._write.values[:] = np.arange(1.0, self._write.values.size + 1).reshape(-1, _WRITE_SIZE)
        _each_body(_EACH_BODY, self._address, self._write.handles)
        told = [(*body.position, body.angle, *body.velocity, body.angular_velocity) for body in bodies]
        order = not np.array_equal(self._read.values, told)
        if order or any(one.differs(self._space) for one in both):
            raise RuntimeError(_LAID_OUT_OTHERWISE)
        self._write.values[:] = 0.0
        _each_body(_EACH_BODY, self._address, self._write.handles)

    @property
    def handed(self):
        """What `leapfrog` takes first, for compiled code that calls it; who does so counts its steps in ``done``."""
        bodies = self._address, self._read.handles, self._read.values, self._write.handles, self._write.values
        return (
            _EACH_BODY, _STEP, *bodies,
            self._rigs, self._wires, self._mass, self._flown, self._reach, self._drives, self._circuits, self._slack,
            self._parted,
        )  # fmt: skip

    def debug_draw(self, axes, i=0):
        """Draw rig ``i`` as it stands now into Matplotlib axes, through pymunk's own `matplotlib_util.DrawOptions`.

        pymunk draws shapes and constraints, and a `RigSpace` has none: a copy of the two bodies is given them, up and
        down wires as springs, and is never stepped. It is laid out in tenths of a millimetre, since pymunk's dots have
        a size of their own; the axes are marked in millimetres. pymunk calls DrawOptions deprecated; it is in the
        version that rigsim is bound to. Without Matplotlib an `ImportError` says so.
        """
        from pymunk.matplotlib_util import DrawOptions

        p, unit, wires = self._parameters[i], 1e4, self._wires[i]
        drawn, (frame, cylinder) = pymunk.Space(), (pymunk.Body(1.0, 1.0), pymunk.Body(1.0, 1.0))
        for copy, body in zip((frame, cylinder), tuple(self._space.bodies)[2 * i : 2 * i + 2], strict=True):
            copy.position, copy.angle = unit * body.position, body.angle
        half, top = unit * (p.Lm / 2 + abs(p.LG)), unit * (p.Rm + p.d)
        corners = [(half, top), (-half, top), (-half, -top), (half, -top)]
        bars = [pymunk.Segment(frame, *ends, 0.0) for ends in zip(corners, corners[1:], strict=False)]
        springs = [
            pymunk.DampedSpring(
                frame, cylinder, (unit * wire["anchor_x"], unit * wire["anchor_y"]),
                (unit * wire["along"], unit * wire["across"]), unit * p.d0, float(wire["k"]), 0.0,
            )
            for wire in wires[(wires["k"] > 0) & (wires["hidden"] == 0)]
        ]  # fmt: skip
        drawn.add(frame, cylinder, pymunk.Poly.create_box(cylinder, (unit * p.Lm, unit * 2 * p.Rm)), *bars, *springs)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            drawn.debug_draw(DrawOptions(axes))
        for axis, name in ((axes.xaxis, "x [mm]"), (axes.yaxis, "y [mm]")):
            axis.set_major_formatter(lambda place, _: f"{place / 10:g}")
            axis.set_label_text(name)
        axes.set_aspect("equal")
        axes.autoscale_view()

    def advance(self, frame_force, tap_force, sample_every, nominal=None):
        """Take as many steps as there are kicks, and return the `Motion` at every ``sample_every``-th.

        Forces at each kick (N), the first of all that of t = 0: ``frame_force`` (steps, n) or (steps, 1) on the frames,
        ``tap_force`` (steps, n) on the masses. ``steps`` is a multiple of ``sample_every``. ``nominal`` (steps, n) or
        (steps, 1), of rigs with a drive: the complex force asked of it in the middle of the step after each kick (N).
        """
        steps, n = tap_force.shape
        positions, sent = np.empty((steps // sample_every, 4, n)), np.empty((steps // sample_every, 2, n))
        nominal = np.zeros((1, 1), dtype=complex) if nominal is None else nominal
        forces = (np.ascontiguousarray(each) for each in (frame_force, tap_force, nominal))
        leapfrog(
            *self.handed, *forces, self.step, self.done, sample_every, positions, sent,
        )  # fmt: skip
        self.done += steps
        xs, X, _, tilt = np.moveaxis(positions, 1, 0)
        sent, limited = np.moveaxis(sent, 1, 0), self._circuits["limited"] > 0
        slack = self._slack[:, :2] / [max(self.done, 1), 1]
        x = X - self._LG * np.cos(tilt)
        return Motion(xs, x, tilt, *sent, limited, self._parted.copy(), slack)


@compiled(nogil=True)
def leapfrog(
    each_body, space_step, space, read_handles, read, write_handles, write,
    rigs, wires, mass, flown, reach, drives, circuits, slack, parted, frame_force, tap_force, nominal,
    h, done, sample_every, positions, sent,
):  # fmt: skip
    """Take the steps of `RigSpace.advance`.

    Chipmunk's step drifts, then kicks, so the kick of time t is prepared before the step to t. The first
    kick, of half a step, comes from rest: that step drifts nowhere and ends at t = 0.
    """
    q, v, force = np.empty(4), np.empty(4), np.empty(4)
    damping = np.empty((4, 4))
    steps, n = tap_force.shape
    columns = min(frame_force.shape[1], 2) - 1  # 0 where all frames share one
    asked, last = min(nominal.shape[1], 2) - 1, len(nominal) - 1
    _each_body(each_body, space, read_handles)
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
                count_slack(q, rigs[i], wires[i], slack[i])
                wanted = nominal[min(k, last), i * asked]
                force[0] += pushed(drives[i], circuits[i], frame_force[k, i * columns], wanted, v[0], h)
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
        _each_body(each_body, space, write_handles)
        space_step(space, h)
        _each_body(each_body, space, read_handles)
        if k % sample_every == 0:
            for i in range(n):
                frame, cylinder = read[2 * i], read[2 * i + 1]
                positions[k // sample_every, 0, i] = frame[0]
                for j in range(3):
                    positions[k // sample_every, 1 + j, i] = cylinder[j]
                sent[k // sample_every, 0, i], sent[k // sample_every, 1, i] = given(
                    drives[i], circuits[i], frame_force[k, i * columns]
                )


@compiled
def _each_body(each_body, space, handles):
    """Have Chipmunk hand every body to a batch's iterator, from the batch's beginning."""
    iterator, address, count = handles
    count[0] = 0
    each_body(space, iterator, address)
