"""Rigs as they were mounted, and the closed forms: against the planar rig, equations linear out of it, and energies."""

import numpy as np
import pytest

from rigsim import RigParameters, linear_modes, static_equilibrium
from rigsim.model import spatial
from rigsim.model.by_hand import RIGID, wobble_by_hand
from rigsim.model.mounted import Mounting, hung, modes_in_space, mounted, moved

RIG = RigParameters()
ONE_SET = RIG.single_set()
WRONG = {
    "long wire": Mounting(long_wire=1e-5),
    "short wire": Mounting(long_wire=-1e-5),
    "clocked set": Mounting(clocked_set=np.radians(1)),
    "skewed set": Mounting(skewed_set=np.radians(1)),
    "all": Mounting(3e-6, 0.01, -0.02),
}
RIGS = {"two sets": RIG, "one set": ONE_SET, "off P": RIG.replace(set_centre=0.002, set_half_spacing=0.004),
        "unequal": RIG.replace(k=tuple(np.linspace(3e4, 5e4, 8)))}  # fmt: skip


def frequencies(parameters, mounting=None):
    mounting = mounting or Mounting()
    modes = modes_in_space(parameters, mounting, hung(parameters, mounting))
    return dict(zip(modes.names, modes.frequency, strict=True))


LONG = RIG.replace(d0=RIG.d + 3e-6)


@pytest.mark.parametrize("rig", [RIG, ONE_SET, RIGS["off P"], LONG, LONG.replace(tension_only=True)])
def test_a_rig_without_faults_hangs_and_swings_as_in_the_plane_and_linearly_out_of_it(rig):
    found = frequencies(rig)
    at = static_equilibrium(rig)
    np.testing.assert_array_equal(hung(rig, Mounting()), spatial.planar_state(at.coordinates))
    modes = linear_modes(rig.replace(c=0, cs=0))
    for name, frequency in zip(modes.names, modes.frequency, strict=True):
        assert found[name] == pytest.approx(frequency, rel=1e-7), name
    rigs, wires = spatial.pack([rig])
    deviations = np.concatenate([hung(rig, Mounting()), np.eye(spatial.OUT).ravel()])
    rates = spatial.rates(deviations, rigs[0], wires[0])[spatial.SIZE :].reshape(spatial.OUT, -1)
    lateral = np.sort(abs(np.linalg.eigvals(rates)))[::2] / (2 * np.pi)
    # In its well a buckled rig has no tension: what holds its roll, a tenth of a hertz, is next to nothing.
    assert sorted(found[name] for name in ("sway", "roll", "yaw")) == pytest.approx(lateral, rel=1e-7, abs=1e-4)


def energy(parameters, mounting, state):
    """Of wires, shaker spring and weight (J), by turning pins as vectors: Rodrigues' formula, no rotation matrix."""
    rig, wires = mounted(parameters, mounting)
    w, *vector = state[4:8] / np.linalg.norm(state[4:8])
    pins = wires[:, 3:6]
    once = 2 * np.cross(vector, pins)
    ends = state[1:4] + pins + w * once + np.cross(vector, once)
    stretch = np.linalg.norm(ends - wires[:, :3] - [state[0], 0, 0], axis=1) - rig["d0"]
    return wires[:, 6] @ stretch**2 / 2 + rig["ks"] * state[0] ** 2 / 2 + rig["m"] * rig["gravity"] * state[2]


@pytest.mark.parametrize("mounting", [Mounting(), *WRONG.values()], ids=["none", *WRONG])
@pytest.mark.parametrize("rig", RIGS.values(), ids=RIGS)
def test_it_rests_where_the_energy_is_least(rig, mounting):
    state = hung(rig, mounting)
    lowest = energy(rig, mounting, state)
    nudges = np.random.default_rng(1).normal(size=(100, 7)) * [1e-7, 1e-6, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4]
    assert min(energy(rig, mounting, moved(state, by)) for by in nudges) > lowest
    size = np.array([1e-6] * 4 + [1e-4] * 3)
    slope = [energy(rig, mounting, moved(state, s * h)) for h in np.diag(size) for s in (1, -1)]
    curved = np.abs(np.reshape(slope, (7, 2)) - lowest).max(axis=1)
    assert (np.abs(np.diff(np.reshape(slope, (7, 2)), axis=1)[:, 0]) < 0.02 * curved + 1e-15).all()


def test_a_long_wire_and_a_turned_set_are_what_they_say():
    """A wire longer by e is as taut as one whose d0 is; turned pins keep their distances; the other set stays."""
    _, right = mounted(RIG, Mounting())
    _, long = mounted(RIG, Mounting(long_wire=1e-5))
    ends = right[:, 3:6] + [RIG.LG, 0, 0]
    lengths = [np.linalg.norm(ends - wires[:, :3], axis=1) for wires in (right, long)]
    np.testing.assert_allclose(lengths[0], RIG.d, rtol=1e-12)
    np.testing.assert_allclose(lengths[0] - lengths[1], [1e-5, *[0] * 7], atol=1e-15)
    for name, axis in (("clocked_set", [1, 0, 0]), ("skewed_set", [0, 1, 0])):
        _, turned = mounted(RIG, Mounting(**{name: 0.1}))
        np.testing.assert_array_equal(turned[4:], right[4:])
        centre = np.array([RIG.set_positions[0], 0, 0])
        a, b = right[:4, :3] - centre, turned[:4, :3] - centre
        np.testing.assert_allclose(np.linalg.norm(b, axis=1), RIG.Rm + RIG.d, rtol=1e-12)
        np.testing.assert_allclose(a @ axis, b @ axis, atol=1e-17)
        across = np.linalg.norm(np.cross(a, axis), axis=1) > 1e-9
        assert np.arcsin(np.cross(a, b)[across] @ axis / (RIG.Rm + RIG.d) ** 2) == pytest.approx(0.1)


def test_a_set_turned_against_the_other_rolls_the_mass_half_way():
    roll, yaw, _ = spatial.angles(hung(RIG, WRONG["clocked set"]))
    assert np.degrees(roll) == pytest.approx(0.5, rel=1e-3) and abs(yaw) < 1e-6
    alone, _, _ = spatial.angles(hung(ONE_SET, WRONG["clocked set"]))
    assert np.degrees(alone) == pytest.approx(1, rel=2e-3)


def test_ten_micrometres_too_much_of_one_wire_cost_two_fifths_of_k1():
    """Of eight wires stretched by 3 um, 24 um in all: 10 um less."""
    held = {"ms": 1e3, "ks": 1e9}
    right, wrong = (frequencies(RIG.replace(**held), one)["axial"] for one in (Mounting(), WRONG["long wire"]))
    assert (wrong / right) ** 2 == pytest.approx(14 / 24, rel=0.01)


def test_faults_without_a_place_of_rest_are_named():
    with pytest.raises(ValueError, match="long wire = 0.02 m is not allowed"):
        Mounting(long_wire=0.02)
    with pytest.raises(ValueError, match="clocked set = 1 rad is not allowed"):
        Mounting(clocked_set=1)


def errors_by_hand(rig):
    """Relative errors of the closed forms, by name."""
    by_hand, found = wobble_by_hand(rig), frequencies(rig)
    errors = {name: by_hand[name] / found[name] - 1 for name in RIGID}
    return errors | {"tilt": by_hand["tilt"] / static_equilibrium(rig).tilt - 1}


@pytest.mark.parametrize("stretch", [1e-6, 3e-6, 3e-5])
@pytest.mark.parametrize("half", [0.001, 0.003, 0.008])
@pytest.mark.parametrize("share", [-0.8, 0.1, 0.5, 0.8])
def test_closed_forms_of_two_sets_are_good_to_a_thousandth_or_two(stretch, half, share):
    LG = share * min(half, 0.0125 - half)
    rig = RIG.replace(d0=RIG.d - stretch, set_half_spacing=half, LG=LG)
    errors = errors_by_hand(rig)
    assert max(map(abs, errors.values())) < 2e-3, errors
    moved_sets = errors_by_hand(rig.replace(LG=LG + 0.002, set_centre=0.002))
    assert max(map(abs, moved_sets.values())) < 2e-3, moved_sets


@pytest.mark.parametrize("stretch", [1e-6, 3e-6, 1e-5, 3e-5])
@pytest.mark.parametrize("LG", [-0.008, 0.0005, 0.003125, 0.01])
@pytest.mark.parametrize("gravity", [1.62, 9.81])
def test_closed_forms_of_one_set_are_good_to_what_they_say(stretch, LG, gravity):
    rig = ONE_SET.replace(d0=RIG.d - stretch, LG=LG, gravity=gravity)
    assert abs(static_equilibrium(rig).tilt) < 0.07
    errors = errors_by_hand(rig)
    most = {"tilt": 0.04, "rocking": 0.025, "roll": 0.015}
    for name, error in errors.items():
        assert abs(error) < most.get(name, 0.003), errors


def test_linear_closed_form_of_one_set_tilts_twice_as_far():
    """Without the tightening, m g LG / (2 T Rm (Rm + d)/d): what the notebook calls the formula."""
    tension = ONE_SET.k * (RIG.d - RIG.d0)
    linear = RIG.m * 9.81 * RIG.LG / (2 * tension * RIG.Rm * (RIG.Rm + RIG.d) / RIG.d)
    assert linear / -wobble_by_hand(ONE_SET)["tilt"] == pytest.approx(1.95, abs=0.1)
    assert np.isnan(list(wobble_by_hand(RIG.replace(d0=RIG.d + 1e-6)).values())).all()
