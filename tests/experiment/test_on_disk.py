"""Channels that are too long for memory are on disk, and nothing else is different."""

import numpy as np
import pytest

from rigsim.experiment import on_disk
from rigsim.experiment.record import Record

CHANNELS = np.random.default_rng(0).normal(size=(3, 5000)) * 1e-3


@pytest.fixture
def small_memory(monkeypatch):
    monkeypatch.setattr(on_disk, "_LONG", 1000)


@pytest.mark.parametrize("name", ["record.csv", "record.csv.gz", "record.nc"])
def test_a_long_record_is_read_to_disk(tmp_path, small_memory, name):
    Record(*CHANNELS, 2000).save(tmp_path / name)
    record = Record.load(tmp_path / name)
    for own, channel in zip((record.force, record.shaker, record.mass), CHANNELS, strict=True):
        assert on_disk.on_disk(own) is not None
        assert not own.flags.writeable
        np.testing.assert_array_equal(own, channel)
        on_disk.let_go(own)
        np.testing.assert_array_equal(own, channel)
    assert on_disk.on_disk(record.replace(hold="linear").force) is not None
    np.testing.assert_array_equal(record.realigned(reverse=("mass",)).mass, -CHANNELS[2])


def test_units_are_turned_to_si_on_disk(tmp_path, small_memory):
    rows = "\n".join(f"{force:.17g},{shaker:.17g},{mass:.17g}" for force, shaker, mass in CHANNELS.T)
    (tmp_path / "own.csv").write_text(f"force,shaker,mass\n{rows}\n")
    units = {"force": "N", "shaker": "mm", "mass": "mm"}
    record = Record.load(tmp_path / "own.csv", "zero", units=units, sample_rate=2000)
    np.testing.assert_array_equal(record.mass, CHANNELS[2] * 1e-3)


def test_a_short_record_is_in_memory(tmp_path):
    Record(*CHANNELS, 2000).save(tmp_path / "record.nc")
    record = Record.load(tmp_path / "record.nc")
    assert on_disk.on_disk(record.force) is None


def test_what_a_user_mapped_to_be_read_is_kept_where_it_is(tmp_path):
    (tmp_path / "all.bin").write_bytes(CHANNELS.tobytes())
    mapped = np.memmap(tmp_path / "all.bin", float, "r", shape=CHANNELS.shape)
    record = Record(*mapped, 2000)
    assert np.shares_memory(record.shaker, mapped)
    writeable = np.memmap(tmp_path / "all.bin", float, "r+", shape=CHANNELS.shape)
    assert not np.shares_memory(Record(*writeable, 2000).shaker, writeable)


def test_a_room_grows_beyond_what_was_expected(small_memory):
    for expected in (3, 2000):
        room = on_disk.Room(expected)
        for part in np.split(CHANNELS[0], [1, 4, 2500]):
            room.add(part)
        np.testing.assert_array_equal(room.whole(), CHANNELS[0])
    assert on_disk.Room(2000).whole().size == 0
