"""The planar force law against an energy written separately, and the statics and modes that follow from it."""

import numpy as np
import pytest
import scipy.optimize
from hypothesis import given, settings
from hypothesis import strategies as st

from rigsim.experiment.random_test import simulate
from rigsim.model.planar import (
    centre_damping,
    conservative_forces,
    damping_matrix,
    largest_tilt,
    linear_modes,
    longest_step,
    mass_matrix,
    pack,
    rest_position,
    static_equilibrium,
    tangent_stiffness,
)
from rigsim.parameters import RigParameters

RIG = RigParameters()
ONE_SET = RIG.single_set()


def wire_lengths(p, q):
    """Every wire's length for complex coordinates too: rotated pin to frame pin, the hidden side out of the plane."""
    xs, X, Y, tilt = q
    for a in p.set_positions:
        for side in (1, -1, 0, 0):
            along, across = a - p.LG, side * p.Rm
            pin_x = X + np.cos(tilt) * along - np.sin(tilt) * across
            pin_y = Y + np.sin(tilt) * along + np.cos(tilt) * across
            frame_y = side * (p.Rm + p.d)
            hidden = 0.0 if side else p.d
            yield np.sqrt((pin_x - xs - a) ** 2 + (pin_y - frame_y) ** 2 + hidden**2)


def energy(p, q):
    stretches = np.array([length - p.d0 for length in wire_lengths(p, q)])
    if p.tension_only:
        stretches = np.where(stretches.real > 0, stretches, 0)
    return p.ks * q[0] ** 2 / 2 + p.m * p.gravity * q[2] + (p.wire_stiffness * stretches**2).sum() / 2


def gradient(function, q):
    """By complex steps, exact to rounding."""
    return np.array([function(q + 1e-30j * np.eye(4)[i]).imag / 1e-30 for i in range(4)])


def compiled(function, p, q):
    rigs, wires = pack([p])
    out = np.empty(4 if function is conservative_forces else (4, 4))
    function(np.array(q, dtype=float), rigs[0], wires[0], out)
    return out


@st.composite
def rigs(draw):
    number = lambda low, high: draw(st.floats(low, high))  # noqa: E731
    sets = draw(st.sampled_from([1, 2]))
    d, Lm = number(0.005, 0.1), number(0.01, 0.1)
    k = tuple(number(1.0, 1e5) for _ in range(4 * sets)) if draw(st.booleans()) else number(1.0, 1e5)
    LG = number(-0.4, 0.4) * Lm
    centre = draw(st.sampled_from([0.0, 0.3, 0.9])) * LG
    return RigParameters(
        ms=number(0.05, 1),
        ks=number(0, 1) * 1e5 + 1,
        cs=number(0, 10),
        m=number(1e-3, 0.1),
        c=number(0, 0.1),
        k=k,
        d=d,
        d0=d * number(0.5, 1.0),
        Lm=Lm,
        Rm=number(0.001, 0.02),
        LG=LG,
        wire_sets=sets,
        set_half_spacing=number(0, 1) * (Lm / 2 - abs(LG)) if sets == 2 and draw(st.booleans()) else None,
        set_centre=centre,
        gravity=number(0, 20),
        wire_damping=draw(st.sampled_from([0.0, 3.0])),
        rocking_damping=draw(st.sampled_from([0.0, 1e-4])),
        tension_only=draw(st.booleans()),
    )


@st.composite
def rigs_and_states(draw):
    p = draw(rigs())
    small = st.floats(-0.3, 0.3)
    return p, rest_position(p) + np.array([draw(small) * p.d, draw(small) * p.d, draw(small) * p.d, draw(small)])


@given(rigs_and_states())
def test_forces_are_minus_the_gradient_of_the_energy(case):
    p, q = case
    size = p.wire_stiffness.sum() * p.d * np.array([1, 1, 1, p.Lm + p.Rm]) + p.ks * abs(q[0])
    error = compiled(conservative_forces, p, q) + gradient(lambda at: energy(p, at), q)
    assert (abs(error) < 1e-13 * size).all()


@settings(max_examples=60)
@given(rigs_and_states())
def test_tangent_stiffness_is_the_derivative_of_the_force(case):
    p, q = case
    stretch = np.array(list(wire_lengths(p, q))) - p.d0
    step = 1e-5 * p.d
    if p.tension_only and abs(stretch).min() < 10 * step:  # at the very corner of the law there is no derivative
        return
    scale = np.array([1, 1, 1, 1 / (p.Lm + p.Rm)])  # tilt as the displacement of the far end
    columns = [
        (compiled(conservative_forces, p, q - d) - compiled(conservative_forces, p, q + d)) / (2 * step)
        for d in step * np.diag(scale)
    ]
    stiffness = compiled(tangent_stiffness, p, q) * np.outer(scale, scale)
    size = p.wire_stiffness.sum() + p.ks
    np.testing.assert_allclose(stiffness, stiffness.T, rtol=1e-12, atol=1e-14 * size)
    np.testing.assert_allclose(stiffness, scale[:, None] * np.transpose(columns), atol=1e-6 * size)


@settings(max_examples=60)
@given(rigs_and_states(), st.tuples(*[st.floats(-1, 1)] * 4).map(np.array))
def test_damping_takes_the_power_of_each_damper(case, rate):
    p, q = case
    damping = compiled(damping_matrix, p, q)
    np.testing.assert_allclose(damping, damping.T, rtol=1e-12, atol=1e-16)
    scaled = damping * np.outer([1, 1, 1, 100], [1, 1, 1, 100])
    assert np.linalg.eigvalsh(scaled)[0] >= -1e-12 * np.trace(scaled)
    # Each damper's lengthening rate along the motion, by a complex step in time.
    moved = q + 1e-30j * rate
    lengths = np.array(list(wire_lengths(p, moved)))
    working = (p.wire_stiffness > 0) & ~(p.tension_only & (lengths.real < p.d0))
    wires = p.wire_damping * ((lengths.imag[working] / 1e-30) ** 2).sum()
    axial = (moved[0] - (moved[1] - p.LG * np.cos(moved[3]))).imag / 1e-30
    power = p.cs * rate[0] ** 2 + p.c * axial**2 + p.rocking_damping * rate[3] ** 2 + wires
    assert rate @ damping @ rate == pytest.approx(power, rel=1e-9, abs=1e-15)


def test_wires_are_counted_up_down_left_right_set_by_set():
    """A wire alone pulls where it should: the up wire of the second set lifts, and turns the body by its arm."""
    for wire, lifts in enumerate([1, -1, 0, 0, 1, -1, 0, 0]):
        k = np.zeros(8)
        k[wire] = 1e4
        p = RIG.replace(k=tuple(k), gravity=0)
        force = compiled(conservative_forces, p, rest_position(p))
        tension = 1e4 * (p.d - p.d0)
        arm = p.set_positions[wire // 4] - p.LG
        np.testing.assert_allclose(force, [0, 0, lifts * tension, lifts * tension * arm], atol=1e-15)


@settings(max_examples=60)
@given(rigs())
def test_the_equilibrium_balances_and_is_a_minimum_of_energy(p):
    try:
        found = static_equilibrium(p)
    except ValueError as error:
        assert "past its wires' reach" in str(error)
        return
    q = found.coordinates
    weight = p.m * p.gravity + p.wire_stiffness.sum() * (p.d - p.d0)
    size = (weight + 1e-9 * p.wire_stiffness.sum() * p.d) * np.array([1, 1, 1, p.Lm + p.Rm])
    assert (abs(gradient(lambda at: energy(p, at), q)) < 1e-6 * size).all()
    scale = np.array([1, 1, 1, 1 / (p.Lm + p.Rm)])
    values = np.linalg.eigvalsh(compiled(tangent_stiffness, p, q) * np.outer(scale, scale))
    assert values[0] > -1e-12 * values[-1]
    assert abs(found.tilt) <= largest_tilt(p)
    assert found.sag == pytest.approx(p.LG * np.sin(q[3]) - q[2], abs=1e-15)


def test_a_minimiser_that_knows_only_the_energy_finds_the_same_equilibrium():
    q = static_equilibrium(ONE_SET).coordinates
    scale = np.array([1e-6, 1e-6, 1e-6, 1e-2])
    found = scipy.optimize.minimize(
        lambda u: 1e6 * energy(ONE_SET, rest_position(ONE_SET) + scale * u), np.zeros(4), method="Nelder-Mead",
        options={"xatol": 1e-6, "fatol": 1e-12, "maxiter": 5000, "maxfev": 5000},
    )  # fmt: skip
    assert rest_position(ONE_SET)[3] + scale[3] * found.x[3] == pytest.approx(q[3], rel=1e-4)


def test_tilt_of_two_sets_and_of_one():
    assert abs(np.degrees(static_equilibrium(RIG).tilt)) < 1e-3
    single = static_equilibrium(ONE_SET)
    assert np.degrees(single.tilt) == pytest.approx(-2.11, abs=0.005)
    assert "tilt -2.11" in single.summary()


def test_one_sets_linear_tilt_is_twice_too_large():
    p = ONE_SET
    tension = p.wire_stiffness[0] * (p.d - p.d0)
    rocking_stiffness = 2 * tension * p.Rm * (p.Rm + p.d) / p.d
    # The linear stiffness is the weightless rig's tangent in tilt about P.
    rigs, wires = pack([p])
    tangent = np.empty((4, 4))
    tangent_stiffness(rest_position(p), rigs[0], wires[0], tangent)
    about_P = np.array([0, 0, p.LG, 1])  # turning about P moves the centre of mass up by LG
    assert about_P @ tangent @ about_P == pytest.approx(rocking_stiffness, rel=1e-9)
    linear = -p.m * p.gravity * p.LG / rocking_stiffness
    assert np.degrees(linear) == pytest.approx(-4.256, abs=1e-3)
    assert linear / static_equilibrium(p).tilt == pytest.approx(2, rel=0.02)
    # Hardening: a thousandth of the weight tilts by the linear value, and tilt over weight falls from there.
    weights = np.array([1e-3, 0.1, 0.3, 1.0, 3.0])
    tilts = np.array([static_equilibrium(p.replace(gravity=9.81 * w)).tilt for w in weights])
    assert tilts[0] == pytest.approx(1e-3 * linear, rel=1e-4)
    assert (np.diff(tilts / weights) > 0).all() and (tilts < 0).all()


def test_without_gravity_nothing_sags_and_without_pretension_nothing_is_refused():
    for p in (RIG, ONE_SET, RIG.replace(d0=RIG.d), ONE_SET.replace(d0=RIG.d)):
        np.testing.assert_allclose(
            static_equilibrium(p.replace(gravity=0)).coordinates, rest_position(p), rtol=0, atol=1e-15
        )


@pytest.mark.parametrize(
    "p",
    [RIG.replace(m=5000), ONE_SET.replace(m=500), ONE_SET.replace(m=0.5, k=20.0)],
    ids=["two sets", "one set", "one slack set"],
)
def test_a_mass_too_heavy_for_its_wires_is_named(p):
    with pytest.raises(ValueError, match=r"gravity = 9.81 m/s\^2 with m = .* kg and LG = 0.003125 m .*expected a tilt"):
        static_equilibrium(p)


LONG = ONE_SET.replace(Lm=0.1, LG=0.048, Rm=0.02)  # hangs steeply long before it sags


@pytest.mark.parametrize(("p", "limit"), [(LONG, "tilt"), (RIG, "sag"), (ONE_SET.replace(LG=1e-5), "sag")])
def test_the_heaviest_mass_that_is_held_is_at_the_wires_reach(p, limit):
    """Either limit alone refuses, and refuses nothing that it need not."""
    held, refused = 100.0, 1000.0
    for _ in range(20):
        middle = (held + refused) / 2
        try:
            found = static_equilibrium(p.replace(m=middle))
        except ValueError:
            refused = middle
        else:
            held = middle
    parts = abs(found.tilt) / largest_tilt(p), found.sag / p.d
    assert parts[limit == "sag"] == pytest.approx(1, abs=1e-3) and parts[limit == "tilt"] < 0.9


def test_the_wires_reach_is_where_they_touch_the_cylinder():
    tilt = largest_tilt(RIG)
    outwards = np.array([-np.sin(tilt), np.cos(tilt)])
    wire = np.array([0, RIG.Rm + RIG.d]) - RIG.Rm * outwards
    assert wire @ outwards == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize(("p", "names"), [(RIG, ["axial", "frame", "bounce", "rocking"]),
                                          (ONE_SET, ["axial", "rocking", "frame", "bounce"])])  # fmt: skip
def test_mode_names_and_shapes(p, names):
    modes = linear_modes(p)
    assert list(modes.names) == names
    mass = np.diag(mass_matrix(p))
    for name, shape in zip(modes.names, modes.shape, strict=True):
        share = mass * abs(shape) ** 2 / (mass @ abs(shape) ** 2)
        assert share[["frame", "axial", "bounce", "rocking"].index(name)] > 0.5


def test_two_sets_have_the_modes_of_the_oscillator():
    modes = linear_modes(RIG)
    np.testing.assert_allclose(modes.frequency[:2], [11.7186, 55.6518], rtol=2e-5)
    np.testing.assert_allclose(modes.damping[:2], [0.0339, 0.0918], rtol=2e-3)
    # Bounce: up and down wires stretch, left and right ones act by their tension.
    per_wire = RIG.k * (1 + 1 - RIG.d0 / RIG.d)
    assert modes.frequency[2] == pytest.approx(np.sqrt(4 * per_wire / RIG.m) / (2 * np.pi), rel=0.1)


@pytest.mark.parametrize("p", [RIG, ONE_SET], ids=["two sets", "one set"])
def test_modes_are_what_the_rig_sings_after_a_small_knock(p):
    """Free vibration in the Space, undamped, read by its strongest lines."""
    p = p.replace(c=0, cs=0)
    force = np.zeros(16000)
    force[0] = 1e-2
    record = simulate(p, force, 8000, start="equilibrium", step=1.25e-4 / 5)
    signals = {"frame": record.shaker, "axial": record.mass, "rocking": record.tilt}
    modes = dict(zip(linear_modes(p).names, linear_modes(p).frequency, strict=True))
    window = np.hanning(force.size)
    for name, signal in signals.items():
        f = modes[name]
        grid = f * (1 + np.linspace(-0.02, 0.02, 201))
        line = abs(np.exp(-2j * np.pi * np.outer(grid, record.time)) @ ((signal - signal.mean()) * window))
        assert grid[line.argmax()] == pytest.approx(f, rel=2e-3), name


@settings(max_examples=40)
@given(rigs())
def test_the_step_limit_is_below_that_of_the_fastest_mode(p):
    stiffness = compiled(tangent_stiffness, p, rest_position(p))
    half = np.sqrt(np.diag(mass_matrix(p)))
    fastest = np.sqrt(np.linalg.eigvalsh(stiffness / np.outer(half, half))[-1])
    assert longest_step(p) <= 2 / fastest * (1 + 1e-12)


def test_only_rigs_are_packed():
    with pytest.raises(ValueError, match="expects RigParameters"):
        pack([RIG, RIG.oscillator])


def test_closed_form_damping_is_the_elimination_s():
    """The same rig with dampers of next to nothing in its wires takes the general way."""
    rig = RIG.replace(rocking_damping=3e-6)
    found = []
    for damped in (rig, rig.replace(wire_damping=1e-300)):
        rigs, wires = pack([damped])
        force, mass = np.array([1.0, -2.0, 0.5, 1e-3]), np.diag(mass_matrix(damped)).copy()
        q, v = rest_position(rig) + [1e-3, 2e-3, 1e-6, 0.05], np.array([0.3, -0.2, 0.1, 4.0])
        centre_damping(q, v, rigs[0], wires[0], mass, 5e-5, np.empty((4, 4)), force)
        found.append(force)
    np.testing.assert_allclose(found[0], found[1], rtol=1e-12)


def test_what_tilts_a_rig_is_the_weights_arm_from_the_sets_middle():
    """Sets in the cylinder's middle: no tilt on one set or two. Half way there: half the arm, on a wider pair."""
    for p in (RIG, ONE_SET):
        balanced, half = p.replace(set_centre=p.LG), p.replace(set_centre=p.LG / 2)
        assert abs(static_equilibrium(balanced).tilt) < 1e-12 < abs(static_equilibrium(half).tilt)
        # the same cylinder, seen from a P that lies in the sets' middle
        seen = p.replace(LG=p.LG / 2, set_half_spacing=None if p.wire_sets == 1 else half.half_spacing)
        assert static_equilibrium(half).tilt == pytest.approx(static_equilibrium(seen).tilt, rel=1e-9)
        assert linear_modes(half.replace(c=0)).frequency == pytest.approx(linear_modes(seen.replace(c=0)).frequency)
        assert linear_modes(half).names == linear_modes(p).names
    wide = RIG.replace(set_centre=RIG.LG)
    rocking = lambda p: dict(zip(linear_modes(p).names, linear_modes(p).frequency, strict=True))["rocking"]  # noqa: E731
    beam = np.sqrt(4 * wide.k * wide.half_spacing**2 / wide.inertia) / (2 * np.pi)  # upright wires, at both ends
    assert rocking(wide) == pytest.approx(beam, rel=1e-3)
