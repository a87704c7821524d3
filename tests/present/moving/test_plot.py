"""Figures that move: what is drawn is what was given, to a tenth of a point; bad input is named."""

import json
import re

import numpy as np
import pytest

from rigsim.present.figures.svg import unique_ids
from rigsim.present.moving.paths import _line
from rigsim.present.moving.plot import Curve, MovingPlot, Panel
from rigsim.present.moving.shapes import Shape, animate

X = np.linspace(10.0, 80.0, 400)
VALUES = np.array([1.0, 2.0, 4.0])


def plot(**options):
    groups = [
        [Curve(X, value * X, label="line")] + [Curve(X, X, "unstable")] * (value > 1) for value in VALUES.tolist()
    ]
    panel = Panel(groups, "f (Hz)", "x (mm)", yscale="log", xlim=(10, 80), ylim=(1, 1000))
    return MovingPlot("Force", VALUES, "N", panel, alt='Growth & "more"', **options)


def parts(moving):
    html = moving._repr_html_()
    data = json.loads(re.search(r'<script type="application/json">(.*?)</script>', html)[1])
    return html, data


def vertices(text):
    """Absolute points of a path of whole-number steps, one array for each of its pieces."""
    result = []
    for piece in text.split("M")[1:]:
        start, _, steps = piece.rstrip("z").partition("l")
        numbers = [list(map(int, re.findall(r"-?\d+", each))) for each in (start, steps)]
        result.append(np.cumsum(np.reshape(numbers[0] + numbers[1], (-1, 2)), axis=0))
    return result


def axes_box(html):
    x, y, width, height = (
        float(number)
        for number in re.search(r'<rect x="(.*?)" y="(.*?)" width="(.*?)" height="(.*?)"/>', html).groups()
    )
    return x, y, width, height


def test_paths_hold_the_data():
    html, data = parts(plot())
    left, top, width, height = axes_box(html)
    for value, text in zip(VALUES, data["paths"][0], strict=True):
        (points,) = vertices(text)
        x = 10 + 70 * (points[:, 0] / 10 - left) / width
        y = 10 ** (3 * (1 - (points[:, 1] / 10 - top) / height))
        # 0.1 pt is 0.02 Hz here, and the height of the axes three decades of some 200 pt.
        np.testing.assert_allclose(y, value * x, rtol=0.006)
        assert x[0] == pytest.approx(10, abs=0.05) and x[-1] == pytest.approx(80, abs=0.05)
        assert len(points) < 100, "points on a nearly straight line are merged"


def test_curves_come_and_go():
    _, data = parts(plot())
    assert [bool(text) for text in data["paths"][1]] == [False, True, True]


def test_first_picture_needs_no_script():
    html, data = parts(plot(start=2))
    shown = re.findall(r'<path class="moves" d="([^"]*)"', html)
    assert shown == [texts[2] for texts in data["paths"]]
    assert "4.00 N</output>" in html and 'value="2"' in html


def test_slider_is_named_and_text_is_escaped():
    html, data = parts(plot(notes=["one", "</script><b>", "three"], caption="a < b"))
    assert "<label>Force <input" in html and 'aria-valuetext="1.00 N"' in html
    assert 'aria-label="Growth &amp; &quot;more&quot;"' in html or "aria-label='Growth &amp; \"more\"'" in html
    assert data["notes"][1] == "</script><b>" and html.count("</script>") == 2
    assert "a &lt; b" in html


def test_same_object_same_text_other_object_other_ids():
    first, second = plot()._repr_html_(), plot()._repr_html_()
    assert first == second
    other = plot(caption="x", digits=4)._repr_html_()
    ids = [set(re.findall(r'\bid="([^"]*)"', html)) for html in (first, other)]
    assert ids[0] and not ids[0] & ids[1]
    assert set(re.findall(r"url\(#([^)]*)\)", first)) <= ids[0]
    assert set(re.findall(r'href="#([^"]*)"', first)) <= ids[0]


def test_gaps_and_what_a_logarithm_cannot_show_interrupt_the_line():
    y = np.where((X > 30) & (X < 40), np.nan, np.where(X > 60, -1.0, 5.0))
    panel = Panel([[Curve(X, y)], [Curve(X, 2 * y)]], "x", "y", yscale="log")
    _, data = parts(MovingPlot("a", [1, 2], "", panel, alt="gaps"))
    assert len(vertices(data["paths"][0][0])) == 2


def test_what_does_not_move_is_written_once():
    panel = Panel([[Curve(X, X)]] * 2, "x", "y", fixed=[Curve([20], [20], "point", "rig")])
    html, data = parts(MovingPlot("a", [1, 2], "", panel, alt="still"))
    assert data["paths"] == [] and 'class="moves"' not in html and html.count("a30 30 0 1 0 60 0") == 1


def test_animation_draws_millimetres_to_scale():
    time = np.linspace(0, 0.01, 5)
    square = np.array([[0, 0], [0.01, 0], [0.01, 0.01], [0, 0.01]])
    moving = square + 0.001 * np.arange(5)[:, None, None]
    rig = animate(time, [Shape(moving, "outline"), Shape(square)], alt="square", seconds=2)
    html, data = parts(rig)
    (texts,) = data["paths"]
    assert len(texts) == 5 and all(text.endswith("z") for text in texts)
    spans = [np.ptp(vertices(text)[0], axis=0) for text in texts]
    assert all(abs(width - height) <= 1 for width, height in spans), "equal scales on both axes"
    assert "Played 200 times slower than real time." in html and ">Play</button>" in html
    assert data["texts"][-1] == "10.0 ms"


def test_steps_add_up_without_drift():
    points = np.cumsum(np.random.default_rng(1).integers(-5, 6, (200, 2)), axis=0)
    moved = np.any(np.diff(points, axis=0, prepend=points[:1] + 1) != 0, axis=1)
    np.testing.assert_array_equal(vertices(_line(points.tolist()))[0], points[moved])


def test_unique_ids_follow_their_references():
    text = '<svg><g id="a"/><use xlink:href="#a"/><path clip-path="url(#a)"/><a href="page.html">x</a></svg>'
    assert unique_ids(text, "p-").count("p-a") == 3 and 'href="page.html"' in unique_ids(text, "p-")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Curve([1, 2], [1]), "2 x and 1 y"),
        (lambda: Curve([1], [1], "dotted"), "kind = 'dotted'"),
        (lambda: MovingPlot("a", [1, 2], "N", Panel([[]], "x", "y"), alt=""), "1 lists of curves; expected 2"),
        (lambda: MovingPlot("a", [1], "N", [], alt=""), "panels is empty"),
        (lambda: plot(notes=["one"]), "notes has 1"),
        (lambda: plot(start=3), "start = 3"),
        (lambda: plot(seconds=0), "seconds = 0"),
        (lambda: MovingPlot("Force", [np.nan], "N", Panel([[]], "x", "y"), alt=""), r"Force\[0\]"),
        (lambda: animate([0, 1], [Shape(np.zeros((3, 4, 2)))], alt=""), r"\(3, 4, 2\); expected \(2, n, 2\)"),
    ],
)
def test_bad_input_is_named(make, message):
    with pytest.raises(ValueError, match=message):
        make()
