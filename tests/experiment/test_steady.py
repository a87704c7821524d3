"""Verdicts on made-up motions."""

import numpy as np
import pytest

from rigsim.experiment.steady import read_window, sampling
from rigsim.results import Status

F = 20.0
TIME = 2 + np.arange(4001) / 4000
T = TIME - TIME[0]


def line(f, amplitude, decay=0.0):
    return np.real(amplitude * np.exp((2j * np.pi * f - decay) * TIME + decay * TIME[0]))


def read(*extra, f=F, mean=1e-4):
    """Verdict on xs = 1 mm at 30 degrees and z = 2 mm at -60 degrees, plus what else moves the mass."""
    shaker = line(f, 1e-3 * np.exp(1j * np.pi / 6))
    z = line(f, 2e-3 * np.exp(-1j * np.pi / 3)) + line(3 * f, 1e-4) + mean + sum(extra, np.zeros_like(TIME))
    return read_window(TIME, np.column_stack([shaker, shaker - z]), f)


@pytest.mark.parametrize("f", [2.0, 3.7, 20.0, 53.21, 150.0])
def test_a_settled_motion(f):
    fundamental, distortion, below, drift, (status, message) = read(f=f)
    shaker, z = 1e-3 * np.exp(1j * np.pi / 6), 2e-3 * np.exp(-1j * np.pi / 3)
    np.testing.assert_allclose(fundamental, [shaker, shaker - z, z], rtol=1e-9)
    np.testing.assert_allclose(distortion, [0, 1e-4 / abs(shaker - z), 0.05], atol=1e-9)
    assert below[0] < 1e-9
    assert drift < 1e-9
    assert status == Status.SETTLED
    assert "drifts by" in message


@pytest.mark.parametrize("order", [2, 3, 4, 5])
@pytest.mark.parametrize("ratio", [0.03, 0.5, 3.0])
@pytest.mark.parametrize("f", [20.0, 45.7])
def test_a_subharmonic_motion(order, ratio, f):
    """Also where the line below f is the larger one, and its own harmonics come with it."""
    part = line(f / order, 2e-3 * ratio * 1j) + line((order + 1) * f / order, 5e-4 * ratio)
    fundamental, _, below, drift, (status, message) = read(part, f=f)
    assert status == Status.SUBHARMONIC
    assert below[0] == pytest.approx(ratio, rel=1e-6)
    assert below[1] == pytest.approx(order)
    assert f"period {order}/f" in message
    assert drift < 1e-3
    assert abs(fundamental[2]) == pytest.approx(2e-3, rel=1e-6)


def test_a_transient_that_dies_is_still_drifting():
    *_, (status, message) = read(line(11.7, 6e-4, decay=3.0))
    assert status == Status.STILL_DRIFTING
    assert "shake for longer" in message


def test_a_slow_change_of_the_fundamental_is_still_drifting():
    *_, drift, (status, _) = read(line(F, 2e-4, decay=1.0))
    assert drift > 1e-3
    assert status == Status.STILL_DRIFTING


@pytest.mark.parametrize(("growth", "status"), [(0.9e-3, Status.SETTLED), (1.1e-3, Status.STILL_DRIFTING)])
def test_a_thousandth_between_half_windows_is_the_limit(growth, status):
    """A line that grows evenly by two parts over the window grows by one from half to half."""
    grown = line(F, 2e-3 * np.exp(-1j * np.pi / 3)) * 2 * growth * T
    *_, drift, (found, message) = read(grown)
    assert drift == pytest.approx(growth, rel=0.02)
    assert found == status and f"drifts by {drift:.2g}" in message


@pytest.mark.parametrize(("kept", "status"), [(0.94, Status.NOT_PERIODIC), (0.86, Status.STILL_DRIFTING)])
def test_a_line_that_loses_a_tenth_from_half_to_half_is_dying(kept, status):
    decay = -2 * np.log(kept)
    assert read(line(F * 0.618, 3e-4, decay=decay))[-1][0] == status


def test_a_subharmonic_motion_that_still_changes_is_drifting():
    part = line(F / 3, 4e-4 * 1j)
    *_, drift, (status, message) = read(part, line(F, 2e-4, decay=1.0))
    assert drift > 1e-3 and status == Status.STILL_DRIFTING and "shake for longer" in message


def test_a_lasting_line_that_is_no_part_of_f_is_not_periodic():
    *_, (status, message) = read(line(F * 0.618, 3e-4))
    assert status == Status.NOT_PERIODIC
    assert "12.360 Hz of 15" in message


def test_a_lasting_line_above_f_counts_too():
    *_, below, _, (status, message) = read(line(66.6, 3e-4))
    assert status == Status.NOT_PERIODIC and "66.6" in message
    assert below[0] < 0.02


@pytest.mark.parametrize(("amplitude", "status"), [(0.015, Status.SETTLED), (0.025, Status.NOT_PERIODIC)])
def test_the_bound_is_two_per_cent_of_z(amplitude, status):
    assert read(line(F * 1.618, 2e-3 * amplitude))[-1][0] == status


def test_a_large_offset_is_no_line():
    assert read(mean=1.0)[-1][0] == Status.SETTLED


def test_samples_of_any_frequency_fall_on_those_of_low_ones():
    """Ten harmonics below four fifths of the half rate where the step allows it, and every instant a common one."""
    for step in (5e-5, 1.3e-5, 1e-4):
        usual = sampling(2.0, step)
        assert usual == max(1, int(2.5e-4 / step))
        for f in (2.0, 80.0, 160.0, 161.0, 240.0, 1 / (40 * step)):
            every = sampling(f, step)
            assert usual % every == 0 and (every == 1 or 1 / (every * step) >= 25 * f * (1 - 1e-9))
    assert [sampling(f, 5e-5) for f in (160.0, 161.0, 500.0)] == [5, 1, 1]
