"""The rig drawn to scale from its parameters, at rest and as it hangs."""

import numpy as np
import pytest

from rigsim.model.planar import rest_position, static_equilibrium
from rigsim.parameters import RigParameters
from rigsim.present.figures.rig_parts import rig_parts

RIG = RigParameters()
SINGLE = RIG.single_set()


def lines(axes):
    return {line.get_label(): line.get_xydata() for line in axes.lines}


def texts(figure):
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def test_figure_of_the_rig_has_dimensions_units_and_words():
    figure = RIG.plot()
    (axes,) = figure.axes
    assert axes.get_aspect() == 1 and axes.get_xlabel() == "x [mm]" and axes.get_ylabel() == "y [mm]"
    written = " ".join(texts(figure))
    for text in ("25 mm", "8 mm", "34 mm", "3.125 mm", "18.75 mm", "9.81 m/s²"):
        assert text in written
    np.testing.assert_allclose(lines(axes)["pins"], 1e3 * rig_parts(RIG, rest_position(RIG))["pins"])
    assert "25 mm long" in figure.alt and "two wire sets, 18.8 mm apart" in figure.alt


def test_sets_off_P_are_drawn_where_they_are_and_said():
    rig = RIG.replace(set_centre=RIG.LG)
    figure = rig.plot()
    assert "two wire sets, 25 mm apart, their middle 3.12 mm from P" in figure.alt and "middle" not in RIG.plot().alt
    assert "sets' middle\n3.125 mm" in texts(figure)
    drawn = lines(figure.axes[0])["wires in the plane"]
    assert np.unique(drawn[np.isfinite(drawn[:, 0]), 0]) == pytest.approx([-9.375, 15.625])


def test_pair_of_rigs_says_how_much_tilt_is_exaggerated():
    at = [static_equilibrium(p) for p in (SINGLE, RIG)]
    figure = at[0].plot(beside=at[1], exaggeration=5)
    assert [axes.get_title() for axes in figure.axes] == ["One wire set (Fig. 1b)", "Two wire sets (Fig. 2)"]
    assert any(text == f"tilt {np.degrees(at[0].tilt):.3g}°, drawn 5 times as large" for text in texts(figure))
    assert "tilted by -2.11 degrees" in figure.alt
    drawn = lines(figure.axes[0])["wires in the plane"]
    np.testing.assert_allclose(drawn, 1e3 * rig_parts(SINGLE, at[0].coordinates, 5)["wires"])


def test_nothing_of_the_rig_is_drawn_outside_its_axes():
    for rig in (
        RIG,
        SINGLE,
        RIG.replace(set_centre=RIG.LG),
        SINGLE.replace(set_centre=-0.005),
        RigParameters(d=0.02, d0=0.0199, Rm=0.01, Lm=0.05, LG=-0.01),
    ):
        figure = rig.plot()
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


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: RIG.plot(beside=RIG.oscillator), "no shape to draw"),
        (lambda: RIG.plot(exaggeration=0), "exaggeration = 0"),
        (lambda: RIG.plot(beside=SINGLE, titles="one"), "titles has 1 elements for 2 rigs"),
        (lambda: RIG.plot("statics"), "what = 'statics'"),
        (lambda: RIG.oscillator.plot(), "OscillatorParameters has no figure"),
    ],
)
def test_bad_input_is_named(make, message):
    with pytest.raises(ValueError, match=message):
        make()
