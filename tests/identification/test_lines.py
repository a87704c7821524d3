"""Lines of thinned channels against those of whole ones, and what first states can do against plain least squares."""

import numpy as np
import pytest

from rigsim.identification.lines import Freed, Gathered, Lines
from rigsim.identification.simulate import Run, simulate
from tests.identification.cubic import cubic_record
from tests.identification.test_simulate import REST, RIG, VALUES, reach_of

RATE, BAND = 2000.0, (2, 80)


def of_whole(lines, channels):
    """The same lines, by one transform a block of all samples."""
    found = []
    time = (np.arange(lines.size) + lines.size / lines.window.size / 2) / lines.size
    for begin in lines.begins:
        block = np.zeros(lines.size)
        inside = channels[max(begin, 0) : begin + lines.size]
        block[max(-begin, 0) : max(-begin, 0) + inside.size] = inside
        found.append(np.fft.rfft(block * np.sin(np.pi * time))[lines.kept])
    return np.array(found)


@pytest.mark.parametrize(("band", "samples"), [(BAND, 40_000), (BAND, 9_999), ((2, 900), 20_000), ((1, 30), 60_001)])
def test_lines_are_those_of_all_samples(band, samples):
    lines = Lines(RATE, samples, band)
    noise = np.random.default_rng(1).normal(size=(samples, 2))
    for output, channel in enumerate(noise.T):
        whole = of_whole(lines, channel)
        off = np.abs(lines(noise)[..., output] - whole)
        inside = (lines.begins >= 0) & (lines.begins + lines.size <= samples)
        # The gain that is divided out is that of a line, and the window lets a little of its neighbours in.
        assert off[inside].max() < 5e-3 * np.abs(whole).std()
        assert off.max() < 0.2 * np.abs(whole).std()  # where the record ends the filter sees zeros


def test_nothing_folds_into_the_band():
    """Of a tone beyond it, wherever that is, little more than what the window lets through is seen."""
    time = np.arange(40_000) / RATE
    lines = Lines(RATE, time.size, BAND)
    inside = np.abs(lines(np.sin(2 * np.pi * 40 * time))).max()
    for hertz in np.arange(310, 1000, 17.3):
        assert np.abs(lines(np.sin(2 * np.pi * hertz * time))[2:-2]).max() < 1e-4 * inside


def derivatives(record, begins):
    run = Run(record.force, RATE, "zero", begins)
    states = np.repeat(REST, len(begins), axis=0)
    return run, simulate(RIG, VALUES, run, states, reach_of(record), range(7))[1]


@pytest.mark.parametrize("begins", [(0,), (0, 3000, 3100)])
def test_the_rest_is_that_of_least_squares(begins):
    record = cubic_record(duration=8)
    run, columns = derivatives(record, begins)
    noise = np.array([1e-6, 3e-6])
    freed = Freed(run, [columns[part][..., 7:] for part in run.parts()], noise)
    channels = np.random.default_rng(2).normal(size=(16_000, 2, 3)) + 5.0
    rest, steps = freed(channels), freed.states(channels[..., 0])
    for number, part in enumerate(run.parts()):
        own = np.concatenate([columns[part][..., 7:], np.ones((part.stop - part.start, 1, 1)) * np.eye(2)], axis=-1)
        own = (own / noise[:, None]).reshape(-1, 6)
        scale = np.linalg.norm(own, axis=0)
        flat = (channels[part] / noise[:, None]).reshape(len(own), -1)
        found = np.linalg.lstsq(own / scale, flat, rcond=None)[0]
        expected = (flat - own / scale @ found).reshape(-1, 2, 3) * noise[:, None]
        np.testing.assert_allclose(rest[part], expected, atol=1e-9)
        np.testing.assert_allclose(steps[number], (found[:, 0] / scale[:])[:4], rtol=1e-7)


@pytest.mark.parametrize("begins", [(0,), (0, 3000, 3100)])
def test_columns_that_come_in_pieces_are_the_same(begins):
    record = cubic_record(duration=8)
    run, columns = derivatives(record, begins)
    freed = Freed(run, [columns[part][..., 7:] for part in run.parts()], np.array([1e-6, 3e-6]))
    lines = Lines(RATE, 16_000, BAND)
    gathered = Gathered(lines, begins, 2, 7)
    for part in run.parts():
        for begin in range(part.start, part.stop, 700):
            piece = slice(begin, min(begin + 700, part.stop))
            gathered.add(piece, columns[piece][..., :7], freed.alive(piece))
    found, steps = gathered.rest(freed)
    expected = lines(freed(columns[..., :7]))
    np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_allclose(freed.lines(lines, columns[..., :7]), expected, atol=1e-10 * np.abs(expected).max())
    moved = np.stack([freed.states(columns[..., place]) for place in range(7)], axis=-1)
    np.testing.assert_allclose(steps, moved, atol=1e-8 * np.abs(moved).max())
