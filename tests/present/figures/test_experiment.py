"""Figures of sine tests: points are the tests' own, symbols say status and tap, lines stand where they are."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from rigsim.experiment.sine_test import sine_test
from rigsim.model.excitation import Tap
from rigsim.paper.virtual_experiment import overlay
from rigsim.parameters import RigParameters
from rigsim.present.figures.experiment import (
    amplitude_spectrum,
    branches_figure,
    distortion_figure,
    sine_test_figure,
    spectrum_figure,
)
from rigsim.results import Status
from rigsim.theory.amplitude import frequency_response

RIG = RigParameters()
AXES = ("shaker", "mass", "relative")


@pytest.fixture(scope="module")
def test():
    """Three from rest and three tapped; the status of two of them replaced, as every kind must be drawn."""
    test = sine_test(RIG, 3.18, [30.0, 48.0, 66.0] * 2, [None] * 3 + [Tap()] * 3)
    status = test.status.copy()
    status[4], status[5] = Status.SUBHARMONIC, Status.FLEW_APART
    gone = {name: np.where(status == Status.FLEW_APART, np.nan, getattr(test, name)) for name in AXES}
    distortion = np.where(status[:, None] == Status.FLEW_APART, np.nan, test.distortion)
    return replace(test, status=status, distortion=distortion, **gone)


@pytest.fixture(autouse=True)
def no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def points(axes):
    """Frequencies and heights drawn in data coordinates, over all markers, ascending."""
    data = [line.get_xydata() for line in axes.lines if line.get_transform() == axes.transData]
    data = np.concatenate(data)
    return data[np.lexsort(data.T[::-1])]


def sorted_pairs(frequency, amplitude):
    known = np.isfinite(amplitude)
    data = np.column_stack([frequency, amplitude])[known]
    return data[np.lexsort(data.T[::-1])]


def test_every_amplitude_is_drawn_once_and_a_lost_one_on_the_edge(test):
    figure = sine_test_figure(test)
    for axes, name in zip(figure.axes, AXES, strict=True):
        expected = sorted_pairs(test.frequency, 1e3 * abs(getattr(test, name)))
        np.testing.assert_allclose(points(axes), expected)
        (edge,) = [line for line in axes.lines if line.get_transform() != axes.transData]
        assert edge.get_xdata() == [66.0] and edge.get_label() == "flew apart, after a tap"
        assert axes.get_ylabel().endswith("(mm)") and axes.get_yscale() == "log"
    assert figure.axes[-1].get_xlabel() == "frequency (Hz)"
    assert "3 of them tapped" in figure.alt and "1 subharmonic" in figure.alt and "1 flew apart" in figure.alt


def test_symbols_tell_status_and_tap(test):
    figure = sine_test_figure(test)
    markers = {line.get_label(): (line.get_marker(), line.get_markerfacecolor()) for line in figure.axes[0].lines}
    for status in set(test.status):
        rest, tap = (markers.get(f"{status}, {how}") for how in ("from rest", "after a tap"))
        assert rest is None or rest[1] == "none"
        assert tap is None or tap[1] != "none"
    assert len({markers[label][0] for label in markers if "tap" in label}) == len(set(test.status[3:]))
    assert test.plot().alt == figure.alt, "SineTest.plot() is this figure"


def test_distortion_is_in_per_cent_against_five(test):
    figure = distortion_figure(test)
    for column, axes in enumerate(figure.axes):
        expected = sorted_pairs(test.frequency, 100 * test.distortion[:, column])
        np.testing.assert_allclose(points(axes), expected)
        assert any(np.all(np.equal(line.get_ydata(), 5)) for line in axes.lines)
    settled = test.status == Status.SETTLED
    assert f"relative z {100 * test.distortion[settled, 2].max():.2g} %" in figure.alt
    assert "(%)" in figure.axes[0].get_ylabel()


def test_spectrum_gives_lines_their_heights(test):
    record = test.record(0)
    for f in (30.0, 17.0):
        time = record.time
        signal = 3 + 2 * np.cos(2 * np.pi * f * time + 1) + 0.5 * np.sin(2 * np.pi * f / 3 * time)
        frequency, amplitude = amplitude_spectrum(record, signal, f)
        for line, height in ((f, 2), (f / 3, 0.5)):
            nearest = abs(frequency - line).argmin()
            assert frequency[nearest] == pytest.approx(line, rel=1e-3)
            assert amplitude[nearest] == pytest.approx(height, rel=0.002)
        assert amplitude[abs(frequency - f / 2).argmin()] < 1e-3
        assert amplitude[0] < 1e-3, "the mean is no line"


def test_spectra_of_tests_show_z_at_f(test):
    figure = spectrum_figure(test, [0, 3])
    grid = np.reshape(figure.axes, (2, 2))
    for (axes, tilt), i in zip(grid, (0, 3), strict=True):
        frequency, amplitude = axes.lines[0].get_data()
        assert amplitude[abs(frequency - 30).argmin()] == pytest.approx(1e3 * abs(test.relative[i]), rel=0.02)
        marks = {line.get_label(): line.get_xdata()[0] for line in axes.lines[1:]}
        assert marks == pytest.approx({"f": 30, "f/2": 15, "f/3": 10})
        assert axes.get_ylabel() == "z (mm)" and tilt.get_ylabel() == "tilt (°)"
        assert axes.get_xlim() == (0, 120) and "two wire sets" in axes.get_title("left")
    assert "tapped at 0.5 m/s" in figure.alt
    two = spectrum_figure([test, test], [0, 3])
    assert two.alt == figure.alt


def test_branches_hold_theory_the_rig_and_what_was_missed(test):
    low = sine_test(RIG, 3.18, [30.0, 66.0])
    found = overlay(RIG, low)
    figure = branches_figure(found, nominal=RIG.replace(cs=9.0))
    missing = found.missing()
    assert (30.0, "high") in missing, "no tap was tried"
    for axes, name in zip(figure.axes, AXES, strict=True):
        drawn = {line.get_label(): line.get_xydata() for line in axes.lines}
        rig = np.concatenate([xy for label, xy in drawn.items() if label.startswith("rig: ")])
        np.testing.assert_allclose(np.sort(rig[:, 1]), np.sort(1e3 * abs(getattr(low, name))))
        crosses = drawn["stable in theory, not reached"]
        theory = frequency_response(RIG, 3.18, [30.0])
        cross = crosses[[f == 30 and b == "high" for f, b in missing]]
        np.testing.assert_allclose(cross, [[30, 1e3 * abs(getattr(theory, name)[0, 2])]])
        assert axes.get_yscale() == "log" and axes.get_xlim()[0] < 10 < 80 < axes.get_xlim()[1]
        assert "nominal theory, stable" in drawn and "theory, unstable" in drawn
        assert axes.get_ylabel().endswith("(mm)")
    assert "low branch" in figure.alt and "not reached" in figure.alt
    assert found.plot().alt == branches_figure(found).alt


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda test: spectrum_figure(test, [9]), "i = 9"),
        (lambda test: spectrum_figure([test], [0, 1]), "1 elements for 2 indices"),
        (lambda test: spectrum_figure(test, []), "0 elements for 0 indices"),
        (lambda test: spectrum_figure(test, 0, highest=0), "highest = 0"),
        (lambda test: branches_figure(overlay(RIG, test), band=(50, 40)), r"band = \(50, 40\) Hz"),
    ],
)
def test_bad_input_is_named(test, make, message):
    with pytest.raises(ValueError, match=message):
        make(test)
