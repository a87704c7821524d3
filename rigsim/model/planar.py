"""The rig in its vertical plane: one compiled force law, and the statics and linear modes that follow from it.

Coordinates q = (xs, X, Y, tilt): the frame along its guide, the cylinder's centre of mass,
and its tilt (counter-clockwise). P, where the wires' lines meet, lies LG behind the centre of
mass on the axis, so x = X - LG cos(tilt). Every wire is a spring from a frame pin to a pin on the
cylinder with a length hidden behind the plane: zero for up and down wires, d for left and right
ones, so that l = sqrt(r^2 + hidden^2) over the in-plane vector r between the pins, and the potential
energy is the sum of k (l - d0)^2/2. All forces, tangents and dampers are gradients of these l.
"""

from dataclasses import dataclass, replace

import numpy as np

from .. import checks
from ..compiled import compiled
from ..parameters import RigParameters, rig_of
from ..results import Result, frame
from .modes import largest_to_one, modes_of

RIG = np.dtype([(name, float) for name in (
    "ms", "ks", "cs", "m", "inertia", "c", "LG", "d0", "gravity", "wire_damping", "rocking_damping", "slack",
)], align=True)  # fmt: skip
# along, across: pin on the cylinder from its centre of mass; anchor_x, anchor_y: pin on the frame from its origin.
# Left and right wires have the same pins in the plane: they are one of their joint stiffness, ``count`` of them.
WIRE = np.dtype(
    [(name, float) for name in ("along", "across", "anchor_x", "anchor_y", "hidden", "k", "count")], align=True
)

COORDINATES = ("frame", "axial", "bounce", "rocking")


def pack(parameters):
    """Rigs (n,) and wires (n, 6) as the structured arrays that compiled loops read; `ValueError` if one is no rig.

    Three wires of each set: up, down, and left and right together. Rigs of one set have three of zero stiffness.
    """
    rigs = np.zeros(len(parameters), dtype=RIG)
    wires = np.zeros((len(parameters), 6), dtype=WIRE)
    for i, p in enumerate(parameters):
        p = rig_of(p)
        rigs[i] = (p.ms, p.ks, p.cs, p.m, p.inertia, p.c, p.LG, p.d0, p.gravity, p.wire_damping, p.rocking_damping,
                   p.tension_only)  # fmt: skip
        wires["hidden"][i] = p.d  # also of the absent wires, whose length must not vanish
        reach = p.Rm + p.d
        for j, a in enumerate(p.set_positions):
            up, down, left, right = p.wire_stiffness[4 * j : 4 * j + 4]
            wires[i, 3 * j] = (a - p.LG, p.Rm, a, reach, 0, up, 1)
            wires[i, 3 * j + 1] = (a - p.LG, -p.Rm, a, -reach, 0, down, 1)
            wires[i, 3 * j + 2] = (a - p.LG, 0, a, 0, p.d, left + right, 2)
    return rigs, wires


@compiled
def _wire(q, cos, sin, wire):
    """In-plane vector from frame pin to mass pin, lever arm from the centre of mass, and length."""
    arm_x = cos * wire.along - sin * wire.across
    arm_y = sin * wire.along + cos * wire.across
    r_x = q[1] + arm_x - q[0] - wire.anchor_x
    r_y = q[2] + arm_y - wire.anchor_y
    length = np.sqrt(r_x * r_x + r_y * r_y + wire.hidden * wire.hidden)
    return r_x, r_y, arm_x, arm_y, length


@compiled
def conservative_forces(q, rig, wires, out):
    """Generalised forces of springs, wires and gravity, -dV/dq, into ``out`` (4,); N and N m."""
    cos, sin = np.cos(q[3]), np.sin(q[3])
    out[0] = -rig.ks * q[0]
    out[1] = 0.0
    out[2] = -rig.m * rig.gravity
    out[3] = 0.0
    for wire in wires:
        r_x, r_y, arm_x, arm_y, length = _wire(q, cos, sin, wire)
        stretch = length - rig.d0
        if rig.slack != 0.0 and stretch < 0.0:
            continue
        pull = -wire.k * stretch / length
        f_x, f_y = pull * r_x, pull * r_y
        out[0] -= f_x
        out[1] += f_x
        out[2] += f_y
        out[3] += arm_x * f_y - arm_y * f_x


@compiled
def count_slack(q, rig, wires, tally):
    """Tell a ``tally`` (8,) of a step to q: steps with a slack wire, times a wire went slack, and which are so now."""
    if rig.slack == 0.0:
        return
    cos, sin, any_slack = np.cos(q[3]), np.sin(q[3]), 0.0
    for j in range(6):
        _, _, _, _, length = _wire(q, cos, sin, wires[j])
        now = 1.0 if wires[j].k > 0.0 and length < rig.d0 else 0.0
        if now > tally[2 + j]:
            tally[1] += wires[j].count
        tally[2 + j] = now
        any_slack = max(any_slack, now)
    tally[0] += any_slack


@compiled
def damping_matrix(q, rig, wires, out):
    """Viscous damping matrix at q into ``out`` (4, 4): each damper c g g^T over the gradient g of its length."""
    cos, sin = np.cos(q[3]), np.sin(q[3])
    g = np.empty(4)
    out[:] = 0.0
    out[0, 0] = rig.cs
    out[3, 3] = rig.rocking_damping
    # The axial damper acts at P: z = xs - X + LG cos(tilt).
    g[0], g[1], g[2], g[3] = 1.0, -1.0, 0.0, -rig.LG * sin
    _add_damper(rig.c, g, out)
    if rig.wire_damping != 0.0:
        for wire in wires:
            r_x, r_y, arm_x, arm_y, length = _wire(q, cos, sin, wire)
            if wire.k == 0.0 or (rig.slack != 0.0 and length < rig.d0):
                continue
            g[0], g[1], g[2] = -r_x / length, r_x / length, r_y / length
            g[3] = (arm_x * r_y - arm_y * r_x) / length
            _add_damper(rig.wire_damping * wire.count, g, out)


@compiled
def _add_damper(c, g, out):
    for i in range(4):
        for j in range(4):
            out[i, j] += c * g[i] * g[j]


@compiled
def centre_damping(q, v, rig, wires, mass, h, damping, force):
    """Add the damping of the mean of old and new velocity: force <- M dv/h with (M + h C/2) dv = h (force - C v).

    Without dampers in the wires C is diagonal but for the axial damper's c g g^T, which the Sherman-Morrison formula
    inverts; ``damping`` (4, 4) is room for the general case.
    """
    if rig.wire_damping != 0.0:
        damping_matrix(q, rig, wires, damping)
        _centre_any_damping(v, mass, h, damping, force)
    else:
        _centre_axial_damping(q, v, rig, mass, h, force)


@compiled
def _centre_axial_damping(q, v, rig, mass, h, force):
    """`centre_damping` without dampers in the wires."""
    half, lever = h / 2, -rig.LG * np.sin(q[3])  # g = (1, -1, 0, lever)
    stretching = rig.c * (v[0] - v[1] + lever * v[3])
    # What a unit of force at xs, X and the tilt adds without the axial damper, and what these forces add.
    frame, axial = 1.0 / (mass[0] + half * rig.cs), 1.0 / mass[1]
    rocking = 1.0 / (mass[3] + half * rig.rocking_damping)
    first = frame * (force[0] - rig.cs * v[0] - stretching)
    second = axial * (force[1] + stretching)
    fourth = rocking * (force[3] - rig.rocking_damping * v[3] - lever * stretching)
    share = half * rig.c * (first - second + lever * fourth)
    share /= 1.0 + half * rig.c * (frame + axial + lever * lever * rocking)
    force[0] = mass[0] * (first - share * frame)
    force[1] = mass[1] * (second + share * axial)
    force[3] = mass[3] * (fourth - share * lever * rocking)


@compiled
def _centre_any_damping(v, mass, h, system, force):
    """`centre_damping` by elimination; ``system`` holds C and is overwritten."""
    for i in range(4):
        for j in range(4):
            force[i] -= system[i, j] * v[j]
            system[i, j] *= h / 2
        system[i, i] += mass[i]
    # Gaussian elimination without pivoting: the matrix is symmetric positive definite.
    for i in range(4):
        for r in range(i + 1, 4):
            factor = system[r, i] / system[i, i]
            if factor != 0.0:
                for j in range(i, 4):
                    system[r, j] -= factor * system[i, j]
                force[r] -= factor * force[i]
    for i in range(3, -1, -1):
        for j in range(i + 1, 4):
            force[i] -= system[i, j] * force[j]
        force[i] /= system[i, i]
    for i in range(4):
        force[i] *= mass[i]


@compiled
def tangent_stiffness(q, rig, wires, out):
    """Second derivative of the potential energy at q into ``out`` (4, 4)."""
    cos, sin = np.cos(q[3]), np.sin(q[3])
    out[:] = 0.0
    out[0, 0] = rig.ks
    jacobian = np.zeros((2, 4))
    for wire in wires:
        r_x, r_y, arm_x, arm_y, length = _wire(q, cos, sin, wire)
        if rig.slack != 0.0 and length < rig.d0:
            continue
        along = wire.k * rig.d0 / length**3
        across = wire.k * (1.0 - rig.d0 / length)
        jacobian[0] = np.array([-1.0, 1.0, 0.0, -arm_y])
        jacobian[1] = np.array([0.0, 0.0, 1.0, arm_x])
        stretching = r_x * jacobian[0] + r_y * jacobian[1]
        for i in range(4):
            for j in range(4):
                out[i, j] += along * stretching[i] * stretching[j]
                out[i, j] += across * (jacobian[0, i] * jacobian[0, j] + jacobian[1, i] * jacobian[1, j])
        out[3, 3] -= across * (r_x * arm_x + r_y * arm_y)


@dataclass(frozen=True, eq=False, repr=False)
class StaticEquilibrium(Result):
    """Where the suspended mass hangs under gravity.

    Attributes
    ----------
    parameters : RigParameters
    tilt : float
        Counter-clockwise (rad).
    sag : float
        How far P has come down (m).
    coordinates : ndarray, shape (4,)
        xs, X, Y (m) and tilt (rad).
    """

    parameters: RigParameters
    tilt: float
    sag: float
    coordinates: np.ndarray

    plots = {"rig": "rig_figure", "statics": "statics_figure", "pymunk": "debug_figure"}

    def summary(self):
        """One line with tilt and sag."""
        return f"StaticEquilibrium: tilt {np.degrees(self.tilt):.4f} deg, P {1e6 * self.sag:.3f} um down"

    def sweep(self, points=25):
        """How rigs like this one hang, on one wire set and on two, over their wires' stretch and their mass's offset.

        A `pandas.DataFrame` with a row a rig, ``points`` a sweep (2 to 10 000): "over" (None for the rig itself,
        "stretch" d - d0, which goes below zero if this rig's does, "offset" LG), "sets", "value [m]", "tilt [deg]"
        without its sign, and the "lower [Hz]" and "upper [Hz]" of the two frequencies at which the mass rocks and
        bounces; NaN where there is no stable equilibrium or the rig cannot be built.
        """
        p, points = self.parameters, checks.integer("points", points, low=2, high=10_000)
        changes = [(None, np.nan, {})]
        lowest = min(0.1, (p.d - p.d0) / 3e-6 or 0.1)
        stretch = np.geomspace(lowest, 33, points) * 3e-6 if lowest > 0 else (p.d - p.d0) * np.linspace(2, -2, points)
        changes += [("stretch", s, {"d0": p.d - s}) for s in stretch]
        changes += [("offset", LG, {"LG": LG}) for LG in np.linspace(p.Lm / 100, 0.45 * p.Lm, points)]
        rows = [
            (over, rig.wire_sets, value, *_hangs(rig, change))
            for rig in (p.single_set(), p.double_set())
            for over, value, change in changes
        ]
        return frame(rows, ["over", "sets", "value [m]", "tilt [deg]", "lower [Hz]", "upper [Hz]"])


def _hangs(parameters, changes):
    """Tilt (deg), and the two frequencies at which the mass rocks and bounces (Hz), NaN where there is none."""
    tilt, pair = np.nan, (np.nan, np.nan)
    try:
        parameters = parameters.replace(**changes)
        tilt = abs(np.degrees(static_equilibrium(parameters).tilt))
        modes = linear_modes(parameters)
        pair = modes.frequency[[name in ("rocking", "bounce") for name in modes.names]]
    except ValueError:
        pass  # no such rig, no equilibrium, or a mode that does not oscillate
    return tilt, *pair


def static_equilibrium(parameters):
    """`StaticEquilibrium` under gravity, the stable one, followed from the weightless rig as gravity is turned on.

    A buckled rig (d0 > d, wires that push) has two: that of z = xs - x > 0, where the mass rests behind the middle, is
    taken, followed from z = `RigParameters.gap`; on one set a tilt may tighten the wires until they pull again, and
    leave a single one, near the middle. Both are places of rest in the plane: out of it a roll stretches wires as well
    as z does, so that there is a ring of them, z and roll, and the tests of a buckled rig do not stay in the plane
    (`SineTest.out_of_plane`). A slack one (d0 > d, ``tension_only``) floats without its weight, so
    it is followed from the rig of d0 = d as the wires grow longer: it hangs on upper wires, by the slack d0 - d low.

    Parameters
    ----------
    parameters : RigParameters

    Raises
    ------
    ValueError
        If the mass tilts past its wires' reach (`largest_tilt`) or sags by more than a wire's length d, the followed
        equilibrium ends, or nothing pulls a slack rig to one.
    """
    rigs, wires = pack([parameters])
    q, slack = rest_position(parameters), parameters.tension_only and parameters.gap > 0
    if slack and parameters.gravity == 0:
        raise ValueError(
            f"gravity = 0 m/s^2 leaves the mass on slack wires, d0 - d = {parameters.d0 - parameters.d:.3g} m, without "
            'a place of rest; expected gravity above 0, d0 of at most d, or the start "rest"'
        )
    if slack:
        q = static_equilibrium(parameters.replace(d0=parameters.d)).coordinates
    else:
        q[1] -= parameters.gap
    load, increment, reach = 0.0, 0.25, largest_tilt(parameters)
    # Newton from the last equilibrium, with shorter load steps where one set's tilt hardens.
    while load < 1.0:
        trial = min(load + increment, 1.0)
        if slack:
            rigs["d0"] = parameters.d + trial * (parameters.d0 - parameters.d)
        else:
            rigs["gravity"] = parameters.gravity * trial
        found = _newton(q, rigs, wires)
        if found is not None and abs(found[3] - q[3]) < 0.5:
            q, load, increment = found, trial, 2 * increment
        else:
            increment /= 2
        sag = parameters.LG * np.sin(q[3]) - q[2]
        if increment < 1e-6 or abs(q[3]) > reach or abs(sag) > parameters.d:
            raise ValueError(
                f"gravity = {parameters.gravity:g} m/s^2 with m = {parameters.m:g} kg and LG = {parameters.LG:g} m "
                f"takes the mass past its wires' reach: tilt {np.degrees(q[3]):.3g} deg, sag {sag:.3g} m at {load:.0%} "
                f"of the load; expected a tilt below {np.degrees(reach):.3g} deg, a sag below d = {parameters.d:g} m"
            )
    return StaticEquilibrium(parameters, float(q[3]), float(sag), q)


def largest_tilt(parameters):
    """Reach of the wires (rad): at this tilt the up and down wires touch the cylinder, arccos(Rm/(Rm + d))."""
    return float(np.arccos(parameters.Rm / (parameters.Rm + parameters.d)))


def rest_position(parameters):
    """Coordinates (4,) of the rig with its wires unsagged and P on the axis."""
    return np.array([0.0, parameters.LG, 0.0, 0.0])


def _newton(start, rig, wires):
    """Equilibrium near ``start``, or None where Newton's method ends elsewhere than in a minimum of energy."""
    q, force, stiffness = start.copy(), np.empty(4), np.empty((4, 4))
    # Metres and radians made comparable: the pins' reach turns tilt into displacement.
    reach = np.sqrt(rig["inertia"][0] / rig["m"][0])
    scale = np.array([1.0, 1.0, 1.0, 1 / reach])
    for _ in range(60):
        conservative_forces(q, rig[0], wires[0], force)
        tangent_stiffness(q, rig[0], wires[0], stiffness)
        values, vectors = np.linalg.eigh(stiffness * np.outer(scale, scale))
        # Without pretension and weight the axial motion is neutral: no reason to refuse.
        stable = values[0] > -1e-13 * values[-1]
        if not stable and np.abs(force * scale).max() < 1e-12 * rig["ks"][0] * reach:
            return None
        # Modified Newton: curvature by modulus, so that a step always goes downhill.
        curvature = np.maximum(np.abs(values), 1e-9 * values[-1])
        step = scale * (vectors @ ((vectors.T @ (force * scale)) / curvature))
        step *= min(1.0, 0.2 / max(np.abs(step / scale).max() / reach, 1e-300))
        q += step
        if np.abs(step / scale).max() < 1e-15 * reach:
            break
    return q if stable and np.abs(step / scale).max() < 1e-9 * reach else None


def mass_matrix(parameters):
    """Diagonal mass matrix over (xs, X, Y, tilt), shape (4, 4)."""
    return np.diag([parameters.ms, parameters.m, parameters.m, parameters.inertia])


def linear_modes(parameters):
    """`Modes` of the rig about its static equilibrium.

    Shapes are over (xs, X, Y, tilt); named "frame", "axial", "bounce" and "rocking" by the motion of the
    sets' middle, which is P unless ``set_centre`` says otherwise.

    Parameters
    ----------
    parameters : RigParameters

    Raises
    ------
    ValueError
        If there is no stable equilibrium, or a mode is overdamped.
    """
    rigs, wires = pack([parameters])
    about = static_equilibrium(parameters)
    q = about.coordinates
    stiffness, damping = np.empty((4, 4)), np.empty((4, 4))
    tangent_stiffness(q, rigs[0], wires[0], stiffness)
    damping_matrix(q, rigs[0], wires[0], damping)
    # Named as seen from the sets' middle: a pendulum about it rocks, however far off the centre of mass lies.
    about_it = np.eye(4)
    about_it[1:3, 3] = (parameters.LG - parameters.set_centre) * np.array([-np.sin(q[3]), np.cos(q[3])])
    matrices = (about_it.T @ matrix @ about_it for matrix in (mass_matrix(parameters), damping, stiffness))
    modes = modes_of(*matrices, names=COORDINATES)
    return replace(modes, shape=largest_to_one(modes.shape @ about_it.T), about=about)


def longest_step(parameters):
    """Longest stable step 2/omega of the leapfrog (s), wherever the rig is near its axis.

    A wire's in-plane tangent stiffness never exceeds k, and its pretension k (d - d0) resists the tilt by the
    arm of its pin across the axis; wires that push (d0 > d) do not resist it. The largest eigenvalue of M^-1 K with
    both bounds every natural frequency.
    """
    _, wires = pack([parameters])
    bound = np.diag([parameters.ks, 0.0, 0.0, 0.0])
    for wire in wires[0]:
        arm_x, arm_y = wire["along"], wire["across"]
        jacobian = np.array([[-1.0, 1.0, 0.0, -arm_y], [0.0, 0.0, 1.0, arm_x]])
        bound += wire["k"] * jacobian.T @ jacobian
        bound[3, 3] += wire["k"] * max(0.0, parameters.d - parameters.d0) * abs(arm_y)
    half = np.sqrt(np.diag(mass_matrix(parameters)))
    return 2 / np.sqrt(np.linalg.eigvalsh(bound / np.outer(half, half))[-1])
