"""Figures of the rig: drawn to scale from its parameters, its force law, its statics."""

import warnings

import numpy as np
import pytest

from rigsim.model.planar import linear_modes, pack, rest_position, static_equilibrium
from rigsim.model.wires import cubic_law_error, suspension_force
from rigsim.parameters import RigParameters
from rigsim.present.figures.rig import (
    modes_figure,
    rig_figure,
    rig_parts,
    rigs_figure,
    statics_figure,
    wire_law_figure,
)

RIG = RigParameters()
SINGLE = RIG.single_set()


@pytest.fixture(autouse=True)
def no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def lines(axes):
    return {line.get_label(): line.get_xydata() for line in axes.lines}


def texts(figure):
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def test_wires_in_the_drawing_are_as_long_as_in_the_model():
    for rig in (RIG, SINGLE, RIG.replace(d=0.05, d0=0.0499, Rm=0.006, LG=-0.002, set_half_spacing=0.004)):
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
    assert len(pack([SINGLE])[1][0]) == 8 and rig_parts(SINGLE, rest_position(SINGLE))["pins"].shape == (4, 2)


def test_figure_of_the_rig_has_dimensions_units_and_words():
    figure = rig_figure(RIG)
    (axes,) = figure.axes
    assert axes.get_aspect() == 1 and axes.get_xlabel() == "x (mm)" and axes.get_ylabel() == "y (mm)"
    written = " ".join(texts(figure))
    for text in ("25 mm", "8 mm", "34 mm", "3.125 mm", "18.75 mm", "9.81 m/s²"):
        assert text in written
    np.testing.assert_allclose(lines(axes)["pins"], 1e3 * rig_parts(RIG, rest_position(RIG))["pins"])
    assert "25 mm long" in figure.alt and "two wire sets, 18.8 mm apart" in figure.alt


def test_pair_of_rigs_says_how_much_tilt_is_exaggerated():
    at = [static_equilibrium(p).coordinates for p in (SINGLE, RIG)]
    figure = rigs_figure([SINGLE, RIG], at, exaggeration=5)
    assert [axes.get_title() for axes in figure.axes] == ["One wire set (Fig. 1b)", "Two wire sets (Fig. 2)"]
    assert any(text == f"tilt {np.degrees(at[0][3]):.3g}°, drawn 5 times as large" for text in texts(figure))
    assert "tilted by -2.11 degrees" in figure.alt
    drawn = lines(figure.axes[0])["wires in the plane"]
    np.testing.assert_allclose(drawn, 1e3 * rig_parts(SINGLE, at[0], 5)["wires"])


def test_nothing_of_the_rig_is_drawn_outside_its_axes():
    for rig in (RIG, SINGLE, RigParameters(d=0.02, d0=0.0199, Rm=0.01, Lm=0.05, LG=-0.01)):
        figure = rig_figure(rig)
        figure.draw_without_rendering()
        (axes,) = figure.axes
        page = figure.bbox
        for text in axes.texts:
            box = text.get_window_extent()
            assert page.x0 <= box.x0 and box.x1 <= page.x1 and page.y0 <= box.y0 and box.y1 <= page.y1, text.get_text()
        low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
        for points in (1e3 * part for part in rig_parts(rig, rest_position(rig)).values()):
            known = points[np.isfinite(points).all(axis=1)]
            assert (known >= low).all() and (known <= high).all()


def test_mode_shapes_are_the_models_and_as_large_as_asked():
    modes, q = linear_modes(RIG), static_equilibrium(RIG).coordinates
    figure = modes_figure(RIG, largest=3e-3)
    rest = rig_parts(RIG, q)
    for axes, name, frequency, shape in zip(figure.axes, modes.names, modes.frequency, modes.shape, strict=True):
        assert f"{name} {frequency:.4g} Hz" in axes.get_title() and f"{name} {frequency:.4g} Hz" in figure.alt
        frame, mass = (1e-3 * patch.get_xy()[:-1] for patch in axes.patches[2:])
        moved = max(
            np.linalg.norm(mass - rest["mass"], axis=1).max(), np.linalg.norm(frame - rest["frame"], axis=1).max()
        )
        assert moved == pytest.approx(3e-3, rel=0.05)
        along = mass[1] - mass[0]
        drawn = [
            frame[0, 0] - rest["frame"][0, 0],
            *(mass.mean(axis=0) - q[1:3]),
            np.arctan2(along[1], along[0]) - q[3],
        ]
        scale = np.linalg.norm(drawn) / np.linalg.norm(shape.real)
        np.testing.assert_allclose(np.abs(drawn), np.abs(scale * shape.real), atol=0.02 * np.abs(drawn).max())


def test_wire_law_holds_both_laws_their_error_and_the_range_reached():
    figure = wire_law_figure(RIG, reached=(0.2e-3, 2.7e-3))
    force, error = figure.axes
    z, exact = lines(force)["Eq. (1), exact"].T
    np.testing.assert_allclose(exact, suspension_force(z / 1e3, RIG))
    np.testing.assert_allclose(lines(force)["Eq. (2), cubic"][:, 1], RIG.k1 * z / 1e3 + RIG.k3 * (z / 1e3) ** 3)
    z, percent = lines(error)["error of Eq. (2)"].T
    np.testing.assert_allclose(percent, 100 * cubic_law_error(z / 1e3, RIG))
    assert error.get_xscale() == error.get_yscale() == "log"
    assert "(mm)" in error.get_xlabel() and "(%)" in error.get_ylabel() and "(N)" in force.get_ylabel()
    band = next(patch for patch in error.patches if patch.get_label() == "amplitudes in the test")
    assert (band.get_x(), band.get_x() + band.get_width()) == pytest.approx((0.2, 2.7))
    assert f"at most {100 * cubic_law_error(2.7e-3, RIG):.2g} %" in figure.alt


def test_statics_hold_what_the_model_gives_for_one_set_and_two():
    figure = statics_figure(RIG, points=7)
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
    assert "(°)" in tilt.get_ylabel() and "(Hz)" in rocking.get_ylabel() and "(µm)" in rocking.get_xlabel()
    assert "2.1 degrees" in figure.alt and "25.3" in figure.alt


def test_statics_start_from_either_rig():
    two, one = (statics_figure(rig, points=3) for rig in (RIG, SINGLE))
    for a, b in zip(two.axes[:4], one.axes[:4], strict=True):
        for name in ("one wire set", "two wire sets"):
            np.testing.assert_allclose(lines(a)[name], lines(b)[name], rtol=1e-6)


def test_rigs_that_cannot_be_are_marked():
    fixed = RIG.replace(set_half_spacing=0.009)  # beyond the cylinder once LG exceeds 3.5 mm
    axes = statics_figure(fixed, points=8).axes[1]
    offset, tilt = lines(axes)["two wire sets"].T
    np.testing.assert_array_equal(np.isnan(tilt), offset > 3.5)
    np.testing.assert_allclose(lines(axes)["two wire sets: none found"][:, 0], offset[offset > 3.5])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rig_figure(RIG, [0, 0, 0]), "coordinates has 3 elements"),
        (lambda: rig_figure(RIG, np.zeros(5)), "coordinates has 5 elements; expected 4"),
        (lambda: rig_figure(RIG.oscillator), "no shape to draw"),
        (lambda: rig_figure(RIG, exaggeration=0), "exaggeration = 0"),
        (lambda: rigs_figure([RIG, SINGLE], titles=["one"]), "titles has 1 elements for 2 rigs"),
        (lambda: rigs_figure([]), "0 elements for 0 rigs"),
        (lambda: wire_law_figure(RIG, reached=(2e-3, 1e-3)), "reached"),
        (lambda: modes_figure(RIG, largest=0), "largest = 0"),
        (lambda: wire_law_figure(RIG, largest=-1), "largest = -1"),
        (lambda: statics_figure(RIG.oscillator), "no shape to draw"),
        (lambda: statics_figure(RIG, points=1), "points = 1"),
    ],
)
def test_bad_input_is_named(make, message):
    with pytest.raises(ValueError, match=message):
        make()
