"""Maps of how rigs wobble: what they hold is what the parts give, and what is wrong with a rig shows in its tests."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from rigsim import RigParameters, Status, Tap, detached_curves, sine_test, static_equilibrium, wobbling_map
from rigsim.design.wobbling import QUANTITIES, RIGID, _Shaken
from rigsim.model.by_hand import wobble_by_hand
from rigsim.model.mounted import Mounting, hung, modes_in_space
from rigsim.theory.amplitude import frequency_response

RIG = RigParameters()
ONE_SET = RIG.single_set()
FORCE = 3.18


@pytest.fixture(scope="module")
def tested():
    """One set, over its stretch: where the low side of the detached curve is lost, and where it is back."""
    return wobbling_map(ONE_SET, {"stretch": [3e-6, 1e-5]}, FORCE, points=2)


def test_a_map_holds_what_its_parts_give():
    over = {"LG": [-0.002, 0.003], "stretch": [2e-6, 4e-6, 2e-5]}
    found = wobbling_map(ONE_SET, over)
    assert len(found.rigs) == 6 and not np.isfinite(found.kept).any() and set(found.status) == {Status.FOUND}
    for i, (a, b) in enumerate(np.ndindex(2, 3)):
        rig = ONE_SET.replace(LG=over["LG"][a], d0=ONE_SET.d - over["stretch"][b])
        assert found.rigs[i] == rig and found.mountings[i] == Mounting()
        assert found.tilt[i] == pytest.approx(static_equilibrium(rig).tilt, rel=1e-9)
        modes = modes_in_space(rig, Mounting(), hung(rig, Mounting()))
        assert [modes.frequency[modes.names.index(name)] for name in RIGID] == pytest.approx(found.frequency[i])
        assert list(wobble_by_hand(rig).values()) == pytest.approx(found.by_hand[i])
    table = found.table()
    assert table["LG [mm]"].tolist() == [-2, -2, -2, 3, 3, 3]
    assert table["tilt [deg]"].to_numpy() == pytest.approx(np.degrees(found.tilt))


def test_tests_are_made_on_the_curve_and_judged_by_theory(tested):
    for rig, frequency, kept in zip(tested.rigs, tested.tests, tested.kept, strict=True):
        (curve,) = detached_curves(rig, FORCE)
        assert frequency == pytest.approx(curve.low + (curve.high - curve.low) * np.array([1, 2]) / 3)
        taps = [None] * 2 + [Tap()] * 2
        test = sine_test(rig, FORCE, np.tile(frequency, 2), taps, 4.0, start="equilibrium")
        theory = np.concatenate(frequency_response(rig, FORCE, frequency).relative[:, [0, 2]].T)
        near = abs(test.relative - theory) < 0.15 * abs(theory)
        right = near & np.isin(test.status, (Status.SETTLED, Status.STILL_DRIFTING))
        assert kept[..., 0].ravel().tolist() == right.tolist()


@pytest.mark.parametrize("tap", [None, Tap()])
def test_tests_in_space_are_those_of_a_sine_test_out_of_the_plane(tap):
    """Two integrations: the map's, as the rig is mounted, and that which follows a planar test."""
    planar = sine_test(RIG, FORCE, [30.0, 45.0], tap, 4.0, start="equilibrium")
    space = planar.out_of_plane()
    state = hung(RIG, Mounting())
    shaken = _Shaken(RIG, Mounting(), modes_in_space(RIG, Mounting(), state), FORCE, 45.0, 4.0)
    for i, f in enumerate((30.0, 45.0)):
        line, status = shaken.test(state.copy(), f, tap)
        assert abs(line - space.relative[i]) < 2e-3 * abs(line) and status == planar.status[i]


def test_two_sets_keep_both_branches_in_space_and_one_set_loses_the_low_one(tested):
    two = wobbling_map(RIG, {"stretch": [3e-6]}, FORCE, points=2)
    assert (two.kept == 1).all() and "4 of 4 tests" in two.summary()
    alone, tapped = tested.survives[0]
    assert alone.max() < 1 and tapped[0] == 1
    assert (tested.survives[1] == 1).all(), "three times the stretch"


def test_faults_take_the_rig_out_of_the_plane_and_are_tested_in_space_only():
    found = wobbling_map(
        RIG, {"long_wire": [0.0, 1e-5]}, FORCE, fixed={"clocked_set": 0.0175, "spread": 0.05}, points=1
    )
    assert found.mountings[1] == Mounting(1e-5, 0.0175) and np.isnan(found.kept[..., 0]).all()
    assert np.isfinite(found.kept[..., 1]).all()
    assert np.degrees(found.roll[0]) == pytest.approx(0.5, rel=0.1) and (found.frequency > 0).all()
    stiffness = found.rigs[0].wire_stiffness / RIG.k
    assert 0 < abs(stiffness - 1).max() < 0.05 and found.rigs[0].k == found.rigs[1].k
    other = wobbling_map(RIG, {"spread": [0.05, 0.1]}, seed=1)
    assert other.rigs[0].k != found.rigs[0].k
    np.testing.assert_allclose(other.rigs[1].wire_stiffness - RIG.k, 2 * (other.rigs[0].wire_stiffness - RIG.k))


def test_where_theory_has_no_curve_nothing_is_tested_and_that_is_said():
    found = wobbling_map(RIG, {"stretch": [-3e-6, 1e-4]}, FORCE)
    assert np.isnan(found.tests).all() and set(found.message) == {"not tested: theory has no detached curve here"}
    assert np.isnan(found.by_hand[0]).all() and (found.status == Status.FOUND).all()


def test_a_rig_that_yaws_off_its_place_of_rest_has_none():
    """One set whose wires push: its tilt pulls the upright ones taut, and nothing holds it across."""
    found = wobbling_map(ONE_SET, {"stretch": [-3e-6, 3e-6]})
    assert list(found.status) == [Status.NOT_FOUND, Status.FOUND] and np.isnan(found.tilt[0])
    assert "unstable" in found.message[0] and found.summary().endswith(
        "; 1 without a stable place of rest that was found"
    )


def test_executors_and_checkpoints_change_nothing(tmp_path, tested):
    ask = {"parameters": ONE_SET, "over": {"stretch": [3e-6, 1e-5]}, "force": FORCE, "points": 2}
    told = []
    with ThreadPoolExecutor(2) as pool:
        found = wobbling_map(
            **ask, executor=pool, checkpoint=tmp_path / "map", progress=lambda *done: told.append(done)
        )
    again = wobbling_map(**ask, checkpoint=tmp_path / "map")
    for one in (found, again):
        for name in ("tilt", "frequency", "tests", "kept"):
            np.testing.assert_array_equal(getattr(one, name), getattr(tested, name))
    assert told[-1] == (1, 1)


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"over": {}}, "over = {} is not allowed; expected a dict of 1 to 2 of LG, stretch"),
        ({"over": {"k1": [1.0]}}, "quantity in over = 'k1' is not allowed"),
        ({"over": {"LG": [0.02]}}, "the rig of LG = 0.02 cannot be built: LG = 0.02 m is not allowed"),
        ({"over": {"spread": [1.0]}}, "the rig of spread = 1 cannot be built: spread = 1 is not allowed"),
        ({"fixed": {"LG": 0.001}}, "fixed = LG is in over, too"),
        ({"duration": 2.0}, "duration = 2 s is not allowed"),
        ({"parameters": RIG.oscillator}, "expected RigParameters"),
    ],
)
def test_what_is_not_allowed_is_named(changes, message):
    with pytest.raises(ValueError, match=message) as caught:
        wobbling_map(**({"parameters": RIG, "over": {"LG": [0.0]}} | changes))
    assert "\n" not in str(caught.value)


def lines(axes):
    return {line.get_label(): line.get_xydata() for line in axes.lines}


def test_a_map_over_one_quantity_is_drawn_as_lines(tested):
    tilt, rocking, kept = tested.plot().axes
    np.testing.assert_allclose(lines(tilt)["tilt at rest"], np.column_stack([[3, 10], np.degrees(-tested.tilt)]))
    np.testing.assert_allclose(lines(rocking)["yaw"][:, 1], tested.frequency[:, 1])
    np.testing.assert_allclose(lines(kept)["left alone, in space"][:, 1], 100 * tested.survives[:, 0, 1])
    assert kept.get_xlabel() == "stretch of the wires d - d0 [µm]" and "[°]" in tilt.get_ylabel()
    assert "[Hz]" in rocking.get_ylabel() and "[%]" in kept.get_ylabel()
    assert len(wobbling_map(RIG, {"LG": [0.0, 0.001]}).plot(modes=["rocking"]).axes) == 2


def test_a_map_over_two_quantities_is_drawn_as_maps():
    balanced = wobbling_map(ONE_SET, {"LG": [0.0, 0.001], "stretch": [3e-6, 6e-6]}).plot()
    shown = balanced.axes[0].collections[0].get_array()
    assert not np.ma.getmaskarray(shown).any() and (shown[:, 0] == shown.min()).all()
    found = wobbling_map(ONE_SET, {"LG": [0.001, 0.003], "stretch": [-3e-6, 3e-6, 6e-6]})
    figure = found.plot()
    tilt, slowest = (axes.collections[0].get_array() for axes in figure.axes[:2])
    expected = np.degrees(abs(found.tilt)).reshape(2, 3).T
    np.testing.assert_allclose(tilt.filled(np.nan), expected)
    np.testing.assert_allclose(slowest.filled(np.nan), found.frequency[:, :3].min(axis=1).reshape(2, 3).T)
    assert figure.axes[0].get_xlabel() == "offset of the centre of mass LG [mm]"
    with pytest.raises(ValueError, match="modes = 'nod' is not allowed"):
        found.plot(modes=["nod"])


def test_every_quantity_can_be_varied():
    values = {"set_half_spacing": [0.002], "set_centre": [0.001], "gravity": [1.62], "rocking_damping": [1e-6],
              "wire_damping": [1.0], "skewed_set": [0.01]}  # fmt: skip
    for name, value in values.items():
        found = wobbling_map(RIG, {name: value})
        assert found.status[0] == Status.FOUND and QUANTITIES[name][1] in found.table().columns[0]
