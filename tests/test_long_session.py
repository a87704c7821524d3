"""One process for a long day: memory stays where it is, whatever is called how often."""

import gc
import os
from itertools import cycle, islice

import numpy as np
import pytest

import rigsim
from rigsim import OscillatorParameters, RigParameters, Tap

CALLS, WARM = 2000, 200
GROWTH = 20e6  # bytes


def resident():
    gc.collect()
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def calls(folder):
    """Cheap calls of every room, right and mistaken ones, that take numbers from the turn they are made in."""
    rig = RigParameters()
    free = OscillatorParameters(4.0, 1e4, 3.0, 0.4, 0.05, 300.0, 1e8)
    record = rigsim.random_test(rig, duration=5)

    def files(turn):
        record.save(folder / "record.csv")
        record.save(folder / "record.nc")
        rigsim.Record.load(folder / "record.csv")
        rigsim.Record.load(folder / "record.nc")

    def mistake(turn):
        for call in (
            lambda: rigsim.sine_test(rig, "3.18", 20.0),
            lambda: rigsim.identify(record, order=5),
            lambda: rigsim.Record.load(folder / "none.csv"),
            lambda: rigsim.existence_chart(rig, 3.18, "c", "c"),
        ):
            with pytest.raises((ValueError, OSError)):
                call()

    def kept(turn):
        path = folder / f"campaign-{turn % 3}.sqlite"
        rigsim.sine_test(rig, 3.18, 30.0 + turn % 3, duration=1, checkpoint=path)

    def drawn(turn):
        rigsim.frequency_response(rig, 2.0 + turn % 5, np.linspace(5, 80, 300)).plot().svg()

    return [
        lambda turn: rigsim.frequency_response(rig, 1.0 + turn % 7, np.linspace(5, 80, 500)).pieces,
        lambda turn: rigsim.detached_curves(rig, 1.0 + turn % 7),
        lambda turn: rigsim.force_scenario(free),
        lambda turn: rigsim.existence_chart(rig, 3.18, "c", "cs", points=(15, 15)),
        lambda turn: rigsim.tolerance_study(rig, 3.18, {"d0": 1e-6}, samples=500, seed=turn),
        lambda turn: rigsim.periodic_orbits(rig, 3.18, (40, 60), 3 + 2 * (turn % 3)),
        lambda turn: rigsim.attractors(rig, 3.18, 20.0 + turn % 30, starts=16),
        lambda turn: rigsim.sine_test(rig, 3.18, [20.0, 40.0], Tap(time=0.2), duration=1),
        lambda turn: rigsim.identify(record, block_rows=20),
        lambda turn: rigsim.linear_modes(rig.replace(LG=1e-3 * (1 + turn % 5))),
        files, mistake, kept, drawn,
    ]  # fmt: skip


@pytest.mark.soak
def test_two_thousand_mixed_calls_leave_memory_as_it_was(tmp_path, tell):
    for turn, call in enumerate(islice(cycle(calls(tmp_path)), CALLS)):
        call(turn)
        if turn == WARM:
            before = resident()
    grown = resident() - before
    tell(f"{CALLS} mixed calls in one process: {grown / 1e6:+.1f} MB after the first {WARM}")
    assert grown < GROWTH
