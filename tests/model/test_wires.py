"""The wires' force along the axis: limits, symmetry, and the three-dimensional geometry behind Eq. (1)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigsim.model.wires import axial_force, axial_stiffness, cubic_law_error, spring_of, suspension_force
from rigsim.parameters import RigParameters

RIG = RigParameters()
displacements = st.floats(-0.1, 0.1)
lengths = st.builds(lambda d, ratio: {"d": d, "d0": d * ratio}, st.floats(1e-3, 1.0), st.floats(0.01, 1.0))
stiffnesses = st.lists(st.floats(1.0, 1e6), min_size=8, max_size=8).map(tuple)


def wires_in_space(rig, z):
    """Axial pull of every wire, from the frame pin at radius Rm + d to the mass pin at radius Rm, moved back by z."""
    total = 0.0
    for set_position, stiffness in zip(rig.set_positions, rig.wire_stiffness.reshape(-1, 4), strict=True):
        for angle, k in zip(np.radians([90, 270, 0, 180]), stiffness, strict=True):
            outwards = np.array([0.0, np.cos(angle), np.sin(angle)])
            frame = np.array([set_position, 0, 0]) + (rig.Rm + rig.d) * outwards
            mass = np.array([set_position - z, 0, 0]) + rig.Rm * outwards
            wire = frame - mass
            total += (k * (np.linalg.norm(wire) - rig.d0) * wire / np.linalg.norm(wire))[0]
    return total


@given(displacements, lengths, stiffnesses)
def test_exact_law_is_the_sum_of_the_wires_in_space(z, lengths, k):
    rig = RIG.replace(k=k, **lengths)
    # judged against the tension, which cancels nearly all of the stiffness of a wire as long as it is unstretched
    size = sum(k) * np.hypot(z, rig.d)
    assert suspension_force(z, rig) == pytest.approx(wires_in_space(rig, z), rel=1e-12, abs=1e-14 * size)


@given(displacements, lengths, stiffnesses, st.sampled_from(["exact", "cubic"]))
def test_both_laws_are_odd_and_restoring(z, lengths, k, law):
    rig = RIG.replace(k=k, **lengths)
    force = suspension_force([z, -z], rig, law)
    assert force[0] == -force[1]
    assert force[0] * z >= 0


@pytest.mark.parametrize("law", ["exact", "cubic"])
def test_slope_at_zero_is_k1_and_curvature_k3(law):
    z = np.array([1e-7, 2e-3])
    force = suspension_force(z, RIG, law)
    assert force[0] / z[0] == pytest.approx(RIG.k1, rel=2e-7)
    assert (force[1] - RIG.k1 * z[1]) / z[1] ** 3 == pytest.approx(RIG.k3, rel=3e-3)


@pytest.mark.parametrize("law", ["exact", "cubic"])
@pytest.mark.parametrize("d0", [RIG.d0, RIG.d, 0.5 * RIG.d])
def test_the_stiffness_is_the_slope_of_the_force(law, d0):
    """Also where the wires are as long as they are unstretched, which leaves nothing at zero."""
    spring = spring_of(RIG.replace(d0=d0), law)
    for z in (0.0, 1e-4, -3e-3, 0.05):
        slope = (axial_force(spring, z + 1e-7) - axial_force(spring, z - 1e-7)) / 2e-7
        assert axial_stiffness(spring, z) == pytest.approx(slope, rel=1e-6, abs=1e-3)


def test_far_out_the_exact_law_is_that_of_straight_springs():
    assert suspension_force(1e3, RIG) == pytest.approx(8 * RIG.k * (1e3 - RIG.d0), rel=1e-8)


@given(st.floats(0.01, 0.06), lengths, stiffnesses)
def test_error_of_the_cubic_law_is_the_next_taylor_term(ratio, lengths, k):
    rig = RIG.replace(k=k, **lengths)
    z = ratio * rig.d
    term = 3 / 8 * sum(k) * rig.d0 * z**5 / rig.d**5
    difference = suspension_force(z, rig, "cubic") - suspension_force(z, rig)
    # the term after it is 5/6 ratio^2 of this one; below it, rounding of the forces themselves
    assert difference == pytest.approx(term, rel=0.9 * ratio**2, abs=1e-14 * abs(suspension_force(z, rig)))
    assert cubic_law_error(z, rig) == pytest.approx(difference / suspension_force(z, rig), rel=1e-9)


def test_error_is_even_zero_at_zero_and_grows():
    error = cubic_law_error([0.0, 1e-3, -1e-3, 5e-3], RIG)
    assert error[0] == 0 < error[1] == error[2] < error[3]


def test_cubic_law_takes_either_kind_of_parameters():
    z = np.linspace(-1e-3, 1e-3, 5)
    np.testing.assert_array_equal(
        suspension_force(z, RIG, "cubic"), suspension_force(z, RIG.oscillator, "cubic"), strict=True
    )


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda: suspension_force(0.001, RIG.oscillator, "exact"), "no wires"),
        (lambda: cubic_law_error(0.001, RIG.oscillator), "no wires"),
        (lambda: suspension_force(0.001, RIG, "linear"), "law = 'linear'"),
        (lambda: suspension_force([0.0, np.nan], RIG), r"z\[1\] = nan m"),
        (lambda: suspension_force(0.001, 28.2, "cubic"), "parameters = 28.2"),
    ],
)
def test_bad_input_is_named(call, named):
    with pytest.raises(ValueError, match=named):
        call()
