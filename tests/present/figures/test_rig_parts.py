"""The rig's parts are where the model has them."""

import numpy as np
import pytest

from rigsim.model.planar import pack, rest_position, static_equilibrium
from rigsim.parameters import RigParameters
from rigsim.present.figures.rig_parts import rig_parts

RIG = RigParameters()
SINGLE = RIG.single_set()


def test_wires_in_the_drawing_are_as_long_as_in_the_model():
    for rig in (
        RIG,
        SINGLE,
        RIG.replace(set_centre=RIG.LG),
        RIG.replace(d=0.05, d0=0.0499, Rm=0.006, LG=-0.002, set_half_spacing=0.004),
    ):
        rng = np.random.default_rng(3)
        q = rest_position(rig) + rng.normal(size=(5, 4)) * [1e-3, 1e-3, 1e-3, 0.1]
        for at, wires in zip(q, rig_parts(rig, q)["wires"], strict=True):
            np.testing.assert_allclose(lengths_drawn(wires), lengths_of_wires(rig, at), rtol=1e-12)
    at_rest = rig_parts(RIG, rest_position(RIG))["wires"]
    np.testing.assert_allclose(lengths_drawn(at_rest), [RIG.d] * 4, rtol=1e-12)


def lengths_drawn(wires):
    assert np.isnan(wires[2::3]).all(), "one wire is not joined to the next"
    return np.linalg.norm(wires[1::3] - wires[::3], axis=-1)


def lengths_of_wires(rig, q):
    """Lengths of the up and down wires, set by set, written down a second time with complex numbers."""
    result = []
    for a in rig.set_positions:
        for side in (1, -1):
            pin = q[1] + 1j * q[2] + np.exp(1j * q[3]) * (a - rig.LG + 1j * side * rig.Rm)
            result.append(abs(pin - (q[0] + a + 1j * side * (rig.Rm + rig.d))))
    return result


def test_the_cylinder_keeps_its_size_and_turns_about_P_by_the_exaggerated_tilt():
    q = static_equilibrium(SINGLE).coordinates
    for factor in (1.0, 5.0):
        parts = rig_parts(SINGLE, q, factor)
        mass, (P,), (G,) = parts["mass"], parts["P"], parts["G"]
        sides = np.linalg.norm(np.roll(mass, -1, axis=0) - mass, axis=1)
        np.testing.assert_allclose(sides, [SINGLE.Lm, 2 * SINGLE.Rm] * 2, rtol=1e-12)
        np.testing.assert_allclose(mass.mean(axis=0), G, atol=1e-15)
        assert np.linalg.norm(G - P) == pytest.approx(SINGLE.LG)
        assert np.arctan2(*(G - P)[::-1]) == pytest.approx(factor * q[3])
    np.testing.assert_allclose(rig_parts(SINGLE, q)["G"][0], q[1:3], atol=1e-15)


def test_the_frame_holds_its_pins_and_moves_with_xs():
    rest = rig_parts(RIG, rest_position(RIG))
    moved = rig_parts(RIG, rest_position(RIG) + [0.002, 0, 0, 0])
    np.testing.assert_allclose(moved["frame"] - rest["frame"], [[0.002, 0]] * 8, atol=1e-15)
    np.testing.assert_array_equal(moved["mass"], rest["mass"])
    frame_pins = rest["pins"][:4]
    np.testing.assert_allclose(abs(frame_pins[:, 1]), RIG.Rm + RIG.d)
    assert all(np.isclose(rest["frame"][:, 1], y).any() for y in frame_pins[:, 1]), "pins lie on the frame's inner edge"
    np.testing.assert_allclose(rest["hidden"][:, 0], RIG.set_positions)
    assert len(pack([SINGLE])[1][0]) == 6 and rig_parts(SINGLE, rest_position(SINGLE))["pins"].shape == (4, 2)
