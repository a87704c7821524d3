"""Single-term theory with a drive, against the multi-body rig, the linear circuit, and the constant-force theory."""

import numpy as np
import pytest

from rigsim import RigParameters, Tap, detached_curves, frequency_response, margins, sine_test
from rigsim.model.shaker import MODES, ShakerDrive
from rigsim.results import Status
from rigsim.theory.driven import driven_response

RIG = RigParameters()
VOLTAGE = ShakerDrive()


def test_a_prescribed_and_a_held_force_are_the_constant_force_of_the_paper():
    frequency = np.linspace(10, 80, 29)
    plain = frequency_response(RIG, 3.18, frequency)
    for mode in ("current", "force"):
        driven = driven_response(RIG, 3.18, frequency, ShakerDrive(mode))
        np.testing.assert_allclose(driven.relative, plain.relative, rtol=1e-12)
        np.testing.assert_allclose(driven.force[:, 0], 3.18, rtol=1e-9)
    # the force that acted is that of the frame's equation at each solution: an independent way back
    voltage = driven_response(RIG, 3.18, frequency, VOLTAGE)
    omega = 2 * np.pi * frequency[:, None]
    circuit = (voltage.voltage - 1j * omega * 10 * voltage.shaker) / (3 + 1j * omega * 3e-4)
    known = np.isfinite(voltage.relative)
    np.testing.assert_allclose(voltage.force[known], 10 * circuit[known], rtol=1e-9)
    np.testing.assert_allclose(voltage.voltage[known], 3.18 * 0.3, rtol=1e-9)
    assert set(voltage.count) == {1, 3}


@pytest.mark.parametrize("mode", MODES)
def test_the_rig_on_its_low_branch_is_what_the_theory_says_and_near_it_on_the_high_one(mode):
    """The wires' law and higher harmonics are the 3 % of the high branch; the drive adds nothing to that."""
    frequency, drive = np.array([36.0, 40.0, 44.0, 48.0]), ShakerDrive(mode)
    test = sine_test(RIG, 3.18, np.tile(frequency, 2), [None] * 4 + [Tap()] * 4, duration=6, drive=drive)
    theory = driven_response(RIG, 3.18, frequency, drive)
    assert (test.status == Status.SETTLED).all()
    for k in range(4):
        low, high = theory.relative[k, [0, 2]]
        assert abs(test.relative[k] / low - 1) < 1e-3
        assert abs(test.driven.force[k] / theory.force[k, 0] - 1) < 2e-4
        assert abs(test.driven.voltage[k] / theory.voltage[k, 0] - 1) < 3e-4
        assert abs(test.relative[4 + k] / high - 1) < 0.035
        assert abs(test.driven.force[4 + k] / theory.force[k, 2] - 1) < 0.035


def test_a_detached_curve_stands_no_more_back_emf_than_its_margin_in_cs():
    room = margins(RIG, 3.18, names=["cs"])["cs"].up
    assert room == pytest.approx(0.309, abs=1e-3) and VOLTAGE.damping > 100 * room
    for share, curves in ((0.9, 1), (1.1, 0)):
        factor = np.sqrt(share * room * VOLTAGE.resistance)
        drive = VOLTAGE.replace(force_factor=factor)
        equivalent, force = drive.equivalent(RIG, 3.18)
        assert equivalent.cs == pytest.approx(RIG.cs + share * room) and force == 3.18
        assert len(detached_curves(equivalent, 3.18)) == curves


def test_what_holds_at_frequency_0_holds_while_the_reactance_is_small():
    frequency = np.array([20.0, 50.0, 80.0])
    equivalent, force = VOLTAGE.equivalent(RIG, 3.18)
    slow = frequency_response(equivalent, abs(force), frequency).shaker[:, 0]
    whole = driven_response(RIG, 3.18, frequency, VOLTAGE).shaker[:, 0]
    reactance = 2 * np.pi * frequency * VOLTAGE.inductance / VOLTAGE.resistance
    assert (abs(abs(slow) / abs(whole) - 1) < reactance**2).all() and reactance[-1] < 0.06


def test_bad_input_is_named_and_summaries_say_what_is_seen():
    with pytest.raises(ValueError, match="drive = None is not allowed; expected a ShakerDrive"):
        driven_response(RIG, 3.18, [30.0], None)
    driven = driven_response(RIG, 3.18, [30.0, 56.0], VOLTAGE)
    assert "constant voltage" in repr(driven) and list(driven.table()["solutions"]) == [3, 3]
