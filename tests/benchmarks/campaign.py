"""5000 points on this machine: in threads, in processes, and on a Dask cluster of which a worker is killed.

Each is a sine test of 3 s, tapped or not, over frequency and force, and all give the same bits. Unit: the threads.
"""

import os
import signal
import tempfile
import threading
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from pathlib import Path

import numpy as np
from rig import seconds

from rigsim import RigParameters, Tap, sine_test

POINTS = 5000
_KILLED = 20.0  # s after the beginning


def campaign(executor=None, checkpoint=None):
    """`SineTest` of all points."""
    frequency, force = np.meshgrid(np.linspace(10, 80, POINTS // 10), np.linspace(1.0, 5.0, 5))
    frequency, force = (np.tile(values.ravel(), 2) for values in (frequency, force))
    taps = [None] * (POINTS // 2) + [Tap()] * (POINTS // 2)
    return sine_test(RigParameters(), force, frequency, taps, executor=executor, checkpoint=checkpoint)


def on_a_cluster(file):
    """Seconds and result of the campaign on two workers, one of which is killed, and a second on what is left."""
    from distributed import Client, LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        (first, *_) = client.run(os.getpid).values()
        killer = threading.Timer(_KILLED, os.kill, (first, signal.SIGKILL))
        killer.start()
        begun = time.perf_counter()
        found = campaign(client.get_executor(), file)
        took = time.perf_counter() - begun
        killer.join()
    return took, found


def measure():
    """Rows (name, value, unit, ratio)."""
    sine_test(RigParameters(), 3.18, 30.0, duration=1)  # compiles
    begun = time.perf_counter()
    alone = campaign()
    threads = time.perf_counter() - begun
    rows = [(f"{POINTS} points in threads", threads, "s", 1.0)]
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        took = seconds(lambda: _same(campaign(pool), alone))
    rows.append(("in processes, the same bits", took, "s", took / threads))
    with suppress(ImportError), tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "campaign.sqlite"
        took, found = on_a_cluster(file)
        _same(found, alone)
        rows.append(("on a Dask cluster, a worker killed, the same bits", took, "s", took / threads))
        again = seconds(campaign, None, file)
        rows.append(("read from its checkpoint", again, "s", again / threads))
        rows.append(("size of the checkpoint", file.stat().st_size / 2**20, "MiB", None))
    return rows


def _same(found, alone):
    for name in ("shaker", "mass", "relative", "tilt", "distortion", "traces"):
        if getattr(found, name).tobytes() != getattr(alone, name).tobytes():
            raise AssertionError(f"{name} is another than in threads")
