"""Long records are read in pieces, each mended by itself, under one rig that is likeliest for all of them."""

import numpy as np
import pytest

from rigsim.experiment.record import Record
from rigsim.identification import pieces
from rigsim.identification.identify import identify
from rigsim.identification.physical import NAMES
from rigsim.parameters import RigParameters
from rigsim.results import Status
from tests.identification.cubic import cubic_record

P = RigParameters().oscillator
TRUE = np.array([getattr(P, name) for name in NAMES])
BAND = (2, 80)


@pytest.fixture
def short(monkeypatch):
    """Pieces of 10 s, so that a record of 40 s is long."""
    monkeypatch.setattr(pieces, "_LONG", 50_000)
    monkeypatch.setattr(pieces, "_PIECE", 20_000)


def with_channels(record, **channels):
    return record.replace(parameters=None, seed=None, **channels)


def pulls(found):
    return (found.errors.value - TRUE) / found.errors.half_width


def test_what_is_in_pieces_is_as_good_as_the_whole(monkeypatch):
    record = cubic_record(duration=40, noise=0.01)
    whole = identify(record)
    monkeypatch.setattr(pieces, "_LONG", 50_000)
    monkeypatch.setattr(pieces, "_PIECE", 20_000)
    told = []
    found = identify(record, progress=lambda done, total: told.append((done, total)))
    assert found.status is Status.IDENTIFIED
    assert (np.abs(found.errors.value - whole.errors.value) < 0.5 * whole.errors.standard_error).all()
    np.testing.assert_allclose(found.errors.standard_error, whole.errors.standard_error, rtol=0.15)
    np.testing.assert_allclose(found.errors.bound, whole.errors.bound, rtol=0.15)
    assert (np.abs(pulls(found)) < 1.5).all()
    assert found.record.force.size == 20_000
    assert told[-1] == (14, 14)
    assert max(done for done, _ in told) == 14


def test_a_clean_record_is_read_to_rounding(short):
    found = identify(cubic_record(duration=40))
    np.testing.assert_allclose(found.errors.value, TRUE, rtol=1e-6)


def test_pieces_whose_errors_hang_on_their_values_are_not_averaged_by_them(short):
    """At 5 % noise m, c, k1 and k3 of a piece are off together by 20 %, and the smaller the surer they seem."""
    scale = []
    for seed in range(4):
        found = identify(cubic_record(duration=60, noise=0.05, seed=seed))
        scale.append((found.errors.value[3:] / TRUE[3:] - 1) / (found.errors.standard_error[3:] / TRUE[3:]))
    assert np.abs(np.mean(scale)) < 1.5


@pytest.mark.parametrize("duration", [5, 40])
def test_a_piece_begins_where_a_test_does_if_that_is_near(short, duration):
    n, test = 40_000 * 2, 19_000
    record = Record(*np.random.default_rng(0).normal(size=(3, n)), 2000, joints=(0, test, 2 * test))
    cut = sorted((one.start, one.stop) for one in pieces.pieces(record, 40, BAND, 4))
    assert cut == [(0, test), (test, 2 * test), (2 * test, 60_000), (60_000, n)]
    assert pieces.piece(record, slice(10_000, 50_000)).joints == (0, 9_000, 28_000)


def test_a_short_record_and_one_that_no_piece_tells_of_are_read_at_once(short):
    record = cubic_record(duration=20)
    assert pieces.pieces(record, 40, BAND, 4) == [slice(0, 40_000)]
    time = np.arange(80_000) / 2000
    sweep = np.sin(2 * np.pi * (5 + time / 4) * time)  # in a piece of 10 s it is at a few hertz
    record = with_channels(cubic_record(duration=40), force=sweep)
    assert len(pieces.pieces(record, 40, BAND, 40)) == 1


def test_where_the_rig_rests_there_is_nothing_to_read(short):
    record = cubic_record(duration=30)
    resting = {name: np.concatenate([np.zeros(30_000), channel]) for name, channel in record.channels.items()}
    found = identify(with_channels(record, **resting))
    np.testing.assert_allclose(found.errors.value, TRUE, rtol=1e-5)
    assert "the rig rests from 0 to 11.25 s" in found.message
    assert found.status is Status.IDENTIFIED


def test_what_is_wrong_with_one_piece_is_told_of_it(short):
    record = cubic_record(duration=40, noise=0.001)
    lost = {name: np.delete(getattr(record, name), slice(50_000, 50_007)) for name in ("shaker", "mass")}
    found = identify(with_channels(record, force=record.force[:-7], **lost))
    assert (np.abs(pulls(found)) < 1.5).all()
    assert "7 samples" in found.message
    assert "of 3 pieces" in found.message or "of 4 pieces" in found.message


def test_another_clock_is_seen_from_piece_to_piece(short):
    record = cubic_record(duration=80, noise=0.001)
    at = np.arange(record.force.size) * (1 - 2e-5)
    moved = {name: np.interp(at, np.arange(record.force.size), getattr(record, name)) for name in ("shaker", "mass")}
    found = identify(with_channels(record, **moved))
    assert (np.abs(pulls(found)) < 1.5).all()
    assert "ppm" in found.message


def test_a_piece_of_no_rig_is_left_out_and_doubted(short):
    record = cubic_record(duration=40, noise=0.001)
    broken = record.mass.copy()
    broken[45_000:59_000] = np.random.default_rng(1).normal(size=14_000) * broken.std()
    found = identify(with_channels(record, mass=broken))
    assert found.status is Status.DOUBTFUL
    assert "pieces were left out (20 to 30 s" in found.message
    assert (np.abs(pulls(found)) < 1.5).all()


def test_a_rig_that_changes_from_piece_to_piece_disagrees_with_itself(short):
    rigs = RigParameters(), RigParameters().replace(d0=RigParameters().d0 - 3e-7)  # k1 is 10 % larger
    parts = [cubic_record(rig, duration=20, noise=0.001, seed=seed) for seed, rig in enumerate(rigs)]
    found = identify(Record.joined([with_channels(part) for part in parts]))
    assert found.status is Status.DOUBTFUL
    assert found.errors.disagreement[NAMES.index("k1")] > 3
