"""How rigs hang, drawn from what the model gives for one wire set and two."""

import numpy as np
import pytest

from rigsim.model.planar import linear_modes, static_equilibrium
from rigsim.parameters import RigParameters

RIG = RigParameters()
SINGLE = RIG.single_set()


def lines(axes):
    return {line.get_label(): line.get_xydata() for line in axes.lines}


def statics(rig, **options):
    return static_equilibrium(rig).plot("statics", **options)


def test_statics_hold_what_the_model_gives_for_one_set_and_two():
    figure = statics(RIG, points=7)
    tilt, offset_tilt, rocking, _ = figure.axes[:4]
    for rig, name in ((SINGLE, "one wire set"), (RIG, "two wire sets")):
        stretch, degrees = lines(tilt)[name][4]
        changed = rig.replace(d0=rig.d - 1e-6 * stretch)
        assert degrees == pytest.approx(abs(np.degrees(static_equilibrium(changed).tilt)))
        modes = linear_modes(changed)
        pair = sorted(f for f, mode in zip(modes.frequency, modes.names, strict=True) if mode in ("rocking", "bounce"))
        assert [lines(rocking)[label][4, 1] for label in (name, f"{name}, higher mode")] == pytest.approx(pair)
        offset, degrees = lines(offset_tilt)[name][2]
        changed = rig.replace(LG=1e-3 * offset)
        assert degrees == pytest.approx(abs(np.degrees(static_equilibrium(changed).tilt)))
    assert "[°]" in tilt.get_ylabel() and "[Hz]" in rocking.get_ylabel() and "[µm]" in rocking.get_xlabel()
    assert "2.1 degrees" in figure.alt and "25.3" in figure.alt


def test_statics_start_from_either_rig():
    two, one = (statics(rig, points=3) for rig in (RIG, SINGLE))
    for a, b in zip(two.axes[:4], one.axes[:4], strict=True):
        for name in ("one wire set", "two wire sets"):
            np.testing.assert_allclose(lines(a)[name], lines(b)[name], rtol=1e-6)


def test_rigs_that_cannot_be_are_marked():
    fixed = RIG.replace(set_half_spacing=0.009)  # beyond the cylinder once LG exceeds 3.5 mm
    axes = statics(fixed, points=8).axes[1]
    offset, tilt = lines(axes)["two wire sets"].T
    np.testing.assert_array_equal(np.isnan(tilt), offset > 3.5)
    np.testing.assert_allclose(lines(axes)["two wire sets: none found"][:, 0], offset[offset > 3.5])


def test_bad_input_is_named():
    with pytest.raises(ValueError, match="points = 1"):
        statics(RIG, points=1)


def test_statics_of_a_slack_rig_go_on_below_no_stretch_at_all():
    slack = RIG.replace(d0=RIG.d + 3e-6, tension_only=True)
    tilt = statics(slack, points=9).axes[0]
    stretch, degrees = lines(tilt)["two wire sets"].T
    assert tilt.get_xscale() == "linear" and stretch == pytest.approx(np.linspace(-6, 6, 9))
    for i in (0, 6):
        changed = slack.replace(d0=RIG.d - 1e-6 * stretch[i])
        assert degrees[i] == pytest.approx(abs(np.degrees(static_equilibrium(changed).tilt)))
