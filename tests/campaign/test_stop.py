"""Long work is stopped from outside within two seconds, wherever it runs, and says what is kept."""

import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from rigsim.campaign.run import run_chunks
from rigsim.campaign.stop import Lease, Leased, Stop, Stopped, look, sliced, undisturbed

HEARD = 2.0  # s


def test_work_that_heeds_no_stop_is_never_stopped():
    look()
    Stop().ask()
    look()


def test_a_stop_ends_what_heeds_it_and_what_heeds_another_within():
    outer = Stop()
    with outer.heeded():
        inner = Stop()
        with inner.heeded():
            look()
            outer.ask()
            with pytest.raises(Stopped):
                look()
            assert inner.asked
        with pytest.raises(Stopped):
            look()
    look()


def test_an_inner_stop_leaves_the_outer_work_alone():
    with Stop().heeded():
        inner = Stop()
        with inner.heeded():
            inner.ask()
            with pytest.raises(Stopped):
                look()
        look()


def test_what_shall_not_be_disturbed_is_finished_before_ctrl_c_is_heard():
    before, done = signal.getsignal(signal.SIGINT), []
    with pytest.raises(KeyboardInterrupt):
        with undisturbed():
            signal.raise_signal(signal.SIGINT)
            done.append(1)
        done.append(2)
    assert done == [1] and signal.getsignal(signal.SIGINT) is before
    with undisturbed():
        done.append(3)
    assert done == [1, 3] and signal.getsignal(signal.SIGINT) is before


def test_slices_cover_everything_once_and_look_before_each():
    assert [list(range(7))[part] for part in sliced(7, 3)] == [[0, 1, 2], [3, 4, 5], [6]]
    assert list(sliced(0, 3)) == []
    stop, seen = Stop(), []
    with stop.heeded(), pytest.raises(Stopped):
        for part in sliced(7, 3):
            seen.append(part)
            stop.ask()
    assert seen == [slice(0, 3)]


def endless(chunk):
    """Work that only a stop can end; a tenth of it is quick."""
    while chunk % 10:
        time.sleep(0.01)
        look()
    return {"done": np.array([chunk])}


@pytest.mark.parametrize("pool", [None, ThreadPoolExecutor, ProcessPoolExecutor])
def test_chunks_are_stopped_in_threads_and_processes(tmp_path, pool):
    stop, raised = Stop(), []

    def campaign():
        with stop.heeded(), pytest.raises(Stopped) as caught:
            run_chunks(endless, [10, 1, 2, 3], executor=executor, threads=True, checkpoint=tmp_path / "c")
        raised.append(caught.value)

    executor = pool and pool(2)
    thread = threading.Thread(target=campaign)
    thread.start()
    time.sleep(1)
    assert thread.is_alive()
    begun = time.monotonic()
    stop.ask()
    thread.join(10)
    if executor:
        executor.shutdown()
    assert time.monotonic() - begun < HEARD
    (note,) = raised[0].__notes__
    assert note == f"1 of 4 parts were done and are kept in {tmp_path / 'c'}; the same call goes on from there"


def test_without_a_checkpoint_it_says_that_nothing_is_kept():
    def work(chunk):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        run_chunks(work, [0, 1], label="spaces of rigs")
    assert caught.value.__notes__ == [
        "0 of 2 spaces of rigs were done; nothing is kept, for which the call takes checkpoint= a file name"
    ]


def test_a_lease_tells_other_processes_and_leaves_nothing_behind():
    lease = Lease()
    folder = Path(lease.path).parent
    assert Leased(lambda chunk: look() or chunk, lease)(3) == 3
    looking = Leased(lambda chunk: look() or chunk, lease)
    lease.ask()
    with pytest.raises(Stopped):
        looking(3)
    lease.close()
    assert not folder.exists()
    assert looking(3) == 3  # as on another machine, whose files nobody may judge by


LONG = {
    "sine tests": "sine_test(rig, 3.18, np.linspace(10, 80, 200), duration=300)",
    "three dimensions": "sine_test(rig, 3.18, np.linspace(10, 80, 600), duration=1).out_of_plane()",
    "a random test": "random_test(rig, duration=3000)",
    "an identification": "identify(random_test(rig, duration=300))",
    "single-term stability": "frequency_response(rig, 3.18, np.linspace(5, 80, 2_000_000)).stable",
    "basins": "basins(rig, 3.18, 40.0, pixels=1000)",
    "integrity": "integrity(rig, 3.18, np.linspace(20, 50, 100))",
    "subharmonics": "subharmonic_motions(rig, 3.18, np.linspace(20, 120, 400))",
    "orbits of a strong rig": "[periodic_orbits(rig, force, (5, 60)) for force in np.linspace(40, 60, 50)]",
    "a response sheet": "[response_sheet(rig, (5, 120), (0.1, high)) for high in np.linspace(8, 30, 50)]",
    "a converged scenario over a number": "force_scenario(rig, 9).over('d0', np.linspace(33.9e-3, 33.99e-3, 4000))",
    "a tolerance study": "tolerance_study(rig, 3.18, {'d0': 1e-6}, samples=2_000_000)",
    "a converged tolerance study": "tolerance_study(rig, 3.18, {'d0': 1e-6}, samples=20_000, harmonics=7)",
    "a map of wobbling": "wobbling_map(rig, {'LG': np.linspace(0, 5e-3, 300)}, 3.18)",
    "an existence chart": "existence_chart(rig, 3.18, 'c', 'cs', points=(2000, 2000))",
    "a design": "[design_for_detached_curve(rig, 3.18, ('force', 'c', 'cs'), seed=seed) for seed in range(9)]",
}
_SCRIPT = """
import numpy as np
from rigsim import *
rig = RigParameters()
print("begun", flush=True)
try:
    {call}
except KeyboardInterrupt:
    print("stopped", flush=True)
"""


@pytest.mark.soak
@pytest.mark.parametrize("call", LONG.values(), ids=LONG)
def test_ctrl_c_ends_every_long_call(call):
    """At any moment: early, while it may still be importing, and in the midst of the work.

    Python drops what is raised in a callback, as it has many while modules are imported. So a second Ctrl-C follows
    where the first was not heard within half the time, as people do.
    """
    for after in (0.7, 3.1):
        process = subprocess.Popen(
            [sys.executable, "-c", _SCRIPT.format(call=call)], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
        try:
            assert process.stdout.readline() == "begun\n"
            time.sleep(after)
            assert process.poll() is None, "a call that is over cannot be stopped"
            begun = time.monotonic()
            process.send_signal(signal.SIGINT)
            again = threading.Timer(HEARD / 2, process.send_signal, [signal.SIGINT])
            again.start()
            said = process.stdout.readline()
            heard = time.monotonic() - begun
            again.cancel()
            assert said == "stopped\n" and heard < HEARD
            process.wait(60)
        finally:
            process.kill()
            process.communicate()
