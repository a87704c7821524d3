"""What cannot be afforded is refused within a second, before anything is allocated; what can be is not."""

import re
import subprocess
import sys
import time
import tracemalloc

import numpy as np
import pytest

import rigsim
from rigsim import RigParameters, attractors, basins, identify, periodic_orbits, random_test, sine_test, tap_map
from rigsim.campaign import cost

RIG = RigParameters()
GIGABYTE = 1e9


@pytest.fixture(scope="module")
def record():
    """Two minutes of a test, as it may have been measured."""
    rigsim.static_equilibrium(RIG)  # compiled at its first use
    rng = np.random.default_rng(1)
    return rigsim.Record(*rng.standard_normal((3, 120_000)), 1000.0)


ABSURD = [
    (lambda r: sine_test(RIG, 3.18, 30.0, duration=1e9), "duration = 1e.09 s in steps of 5e-05 s", "days"),
    (lambda r: sine_test(RIG, 3.18, 30.0, duration=1e9, checkpoint="points.db"), "duration = 1e.09 s", "days"),
    (lambda r: sine_test(RIG, 3.18, np.broadcast_to(30.0, 1_000_000)), "duration = 3 s", "GB"),
    (lambda r: sine_test(RIG, 3.18, 30.0, step=1e-9), "step = 1e-09 s is shorter than is of use", ""),
    (lambda r: random_test(RIG, step=1e-9), "step = 1e-09 s is shorter than is of use", ""),
    (lambda r: random_test(RIG, duration=1e9), "duration = 1e.09 s at 2000 Hz", "GB"),
    (lambda r: random_test(RIG, duration=1e8, sample_rate=1.0), "duration = 1e.08 s at 1 Hz", "days"),
    (lambda r: identify(r, block_rows=5000), "block_rows = 5000", "GB"),
    (lambda r: identify(rigsim.Record(*r.channels.values(), 1e8), band=(2, 4e7)), "band = 2 to 4e.07 Hz", "GB"),
    (lambda r: rigsim.existence_chart(RIG, 3.18, "m", "c", points=(100_000, 100_000)), "points = .100000", "GB"),
    (lambda r: rigsim.tolerance_study(RIG, 3.18, {"m": "1 %"}, samples=10**12), "samples = 1000000000000", "GB"),
    (lambda r: rigsim.tolerance_study(RIG, 3.18, {"m": "1 %"}, 10**8, harmonics=5), "samples = 1", "GB|days"),
    (lambda r: basins(RIG, 3.18, 30.0, pixels=100_000), r"pixels\^2 \+ samples", "GB"),
    (lambda r: basins(RIG, 3.18, 30.0, samples=10**9), r"pixels\^2 \+ samples", "GB|days"),
    (lambda r: attractors(RIG, 3.18, 30.0, starts=10**9), "starts = 1e.09", "GB"),
    (lambda r: tap_map(RIG, 3.18, 30.0, instants=10**8), "instants x velocity", "GB"),
    (lambda r: rigsim.integrity(RIG, 3.18, 30.0, samples=10**9), "samples at 1 frequencies", "GB|days"),
    (lambda r: rigsim.frequency_response(RIG, 3.18, np.broadcast_to(30.0, 10**8)), "frequency of 100000000", "GB"),
    (lambda r: rigsim.subharmonic_motions(RIG, 3.18, starts=10**9), "starts", "GB|days"),
    (lambda r: periodic_orbits(RIG, 3.18, harmonics=5000), "harmonics = 5000 .*from 1 to 200", ""),
    (lambda r: rigsim.harmonics_worth(RIG, 3.18, harmonics=(1, 5000)), "harmonics = 5000 .*from 1 to 190", ""),
    (
        lambda r: rigsim.response_sheet(RIG, (1e-3, 80)),
        "band.0. = 0.001 Hz is not allowed; .* from 0.00556 to 556000",
        "",
    ),
    (lambda r: periodic_orbits(RIG, 3.18, (5, 1e6)), "band.1. = 1000000 Hz is not allowed", ""),
    (lambda r: rigsim.static_equilibrium(RIG).sweep(10**9), "points = 1000000000", ""),
]


@pytest.mark.parametrize(("call", "named", "told"), ABSURD, ids=lambda value: value if isinstance(value, str) else "")
def test_the_absurd_is_refused_before_it_begins(call, named, told, record, monkeypatch):
    monkeypatch.setattr(cost, "free_memory", lambda: 16 * GIGABYTE)
    tracemalloc.start()
    begun = time.perf_counter()
    try:
        with pytest.raises(ValueError) as caught:
            call(record)
        took, peak = time.perf_counter() - begun, tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    message = str(caught.value)
    assert re.search(named, message) and "expected" in message and "\n" not in message, message
    assert re.search(told, message), message
    assert took < 1 and peak < 1e8, f"{took:.2f} s, {peak / 1e6:.0f} MB"


class BegunError(Exception):
    pass


# What people do, on a machine with little memory: it gets as far as the work itself.
REASONABLE = [
    ("rigsim.experiment.sine_test.run_chunks", lambda r: sine_test(RIG, 3.18, np.linspace(5, 80, 5000), duration=60)),
    ("rigsim.experiment.sine_test.run_chunks", lambda r: sine_test(RIG, 3.18, 30.0, duration=3600)),
    ("rigsim.experiment.random_test.RigSpace", lambda r: random_test(RIG, duration=3600)),
    ("rigsim.experiment.random_test.RigSpace", lambda r: random_test(RIG, step=1e-7)),
    ("rigsim.identification.identify.extended_model", lambda r: identify(r, block_rows=200)),
    ("rigsim.design.charts.judge_varied", lambda r: rigsim.existence_chart(RIG, 3.18, "m", "c", points=(1000, 1000))),
    ("rigsim.design.tolerances.run_chunks", lambda r: rigsim.tolerance_study(RIG, 3.18, {"m": "1 %"}, 2_000_000)),
    ("rigsim.attraction.basins.attractors", lambda r: basins(RIG, 3.18, 30.0, pixels=1000, samples=100_000)),
    ("rigsim.attraction.taps.attractors", lambda r: tap_map(RIG, 3.18, 70.0, instants=500)),
    ("rigsim.theory.amplitude.solve", lambda r: rigsim.frequency_response(RIG, 3.18, np.linspace(5, 80, 2_000_000))),
    ("rigsim.orbits.subharmonics.run_chunks", lambda r: rigsim.subharmonic_motions(RIG, 3.18, starts=20_000)),
    ("rigsim.attraction.integrity.attractors", lambda r: rigsim.integrity(RIG, 3.18, np.linspace(20, 50, 100))),
]


@pytest.mark.parametrize(("work", "call"), REASONABLE, ids=[work for work, _ in REASONABLE])
def test_the_reasonable_is_begun(work, call, record, monkeypatch):
    def begun(*arguments, **options):
        raise BegunError

    monkeypatch.setattr(cost, "free_memory", lambda: 2 * GIGABYTE)
    monkeypatch.setattr(work, begun)
    with pytest.raises(BegunError):
        call(record)


def test_an_estimate_says_what_it_was_held_against(monkeypatch):
    monkeypatch.setattr(cost, "free_memory", lambda: 1.1 * GIGABYTE)
    with pytest.raises(
        ValueError, match=r"^rows = 9 is not allowed: it needs about 3.2 GB of memory, and 1.1 GB are free; exp"
    ):
        cost.affordable("rows = 9", memory=3.2e9, instead="fewer rows")
    with pytest.raises(ValueError, match="takes about 40 days of one core, and the most that is begun is a week, or"):
        cost.affordable("rows = 9", seconds=40 * 24 * 3600.0, instead="fewer rows")
    cost.affordable("rows = 9", seconds=40 * 24 * 3600.0, instead="fewer rows", shared=True)
    with pytest.raises(ValueError, match="takes about 32 years of one core, and the most that is begun is 100 weeks"):
        cost.affordable("rows = 9", seconds=1e9, instead="fewer rows", shared=True)
    cost.affordable("rows = 9", memory=1e9, seconds=6e5, instead="fewer rows")


@pytest.mark.parametrize("version", [1, 2])
def test_a_containers_limit_counts(tmp_path, version):
    folder = tmp_path if version == 2 else tmp_path / "memory"
    folder.mkdir(exist_ok=True)
    names = ("memory.max", "memory.current") if version == 2 else ("memory.limit_in_bytes", "memory.usage_in_bytes")
    cache = "inactive_file" if version == 2 else "total_inactive_file"
    for name, text in zip(
        (*names, "memory.stat"), ("4000000000\n", "3000000000\n", f"anon 7\n{cache} 500000000\n"), strict=True
    ):
        (folder / name).write_text(text)
    assert cost._control_group(str(tmp_path)) == 1.5e9
    (folder / names[0]).write_text("max\n" if version == 2 else "9223372036854771712\n")
    assert cost._control_group(str(tmp_path)) == np.inf
    assert cost._control_group(str(tmp_path / "none")) == np.inf


@pytest.mark.skipif(sys.platform == "win32", reason="there is no ulimit")
def test_ulimit_counts():
    code = (
        "import resource\nfrom rigsim.campaign.cost import free_memory\n"
        "resource.setrlimit(resource.RLIMIT_AS, (2 * 10**9, 2 * 10**9))\nprint(free_memory())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert 0 < float(done.stdout) < 2e9


def test_this_machine_has_memory():
    assert 1e8 < cost.free_memory() < 1e14
