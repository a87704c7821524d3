"""Campaigns that other processes run: what tests kill, cancel, damage and share.

``campaigns.py run FILE PAUSE LOG COUNT POOL`` runs one, ``campaigns.py end SIGNAL TIMES FILE POOL SEED`` ends one so
often, at random instants, and finishes it; a line of JSON says how it went.
"""

import json
import os
import random
import signal
import sqlite3
import sys
import threading
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from contextlib import closing, suppress

import numpy as np

from rigsim.campaign.packing import unpack
from rigsim.campaign.run import run_chunks

COUNT, SIZE = 60, 200


def slow(chunk):
    """Numbers that depend on the chunk; who computes it leaves a line."""
    number, pause, log = chunk
    time.sleep(pause)
    if log:
        with open(log, "a") as file:
            file.write(f"{number}\n")
    return {"value": np.random.default_rng(number).normal(size=SIZE), "number": np.array([number])}


def chunks(pause=0.0, log=None, count=COUNT):
    """What the campaign is cut into."""
    return [(number, pause, log) for number in range(count)]


def right(results, count=COUNT):
    """Whether these are the campaign's results, to the last bit."""
    return len(results) == count and all(
        result["value"].tobytes() == np.random.default_rng(number).normal(size=SIZE).tobytes()
        and result["number"].tolist() == [number]
        for number, result in enumerate(results)
    )


def run(file, pause, log, count, pool):
    """Run a campaign, alone or in a pool of two processes."""
    parts = chunks(float(pause), log or None, int(count))
    if pool == "processes":
        with ProcessPoolExecutor(2) as executor:
            return run_chunks(slow, parts, checkpoint=file, executor=executor)
    if pool == "cluster":
        return run_in_cluster(parts, file)
    return run_chunks(slow, parts, checkpoint=file)


def run_in_cluster(parts, file):
    """Run it on a Dask cluster of two workers, one of which is killed after a second."""
    from distributed import Client, LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        (first, *_) = client.run(os.getpid).values()
        killer = threading.Timer(1.0, os.kill, (first, signal.SIGKILL))
        killer.start()
        results = run_chunks(slow, parts, checkpoint=file, executor=client.get_executor())
        killer.join()
    return results


def kept(file):
    """Numbers of the chunks in a file, each as it should be."""
    if not os.path.exists(file):
        return set()
    with closing(sqlite3.connect(file)) as database:
        rows = database.execute("SELECT number, form, arrays FROM chunk").fetchall()
    for number, form, content in rows:
        value = np.random.default_rng(number).normal(size=SIZE)
        assert unpack(form, content)["value"].tobytes() == value.tobytes(), f"chunk {number} is another"
    return {number for number, _, _ in rows}


def end(how, times, file, pool, seed):
    """Begin a campaign, end it at a random instant, ``times`` over; every time what was finished is kept."""
    count, chance, before, slowest = 40 * int(times), random.Random(seed), set(), 0.0
    left = 0
    for _ in range(int(times)):
        child = os.fork()
        if not child:
            os.setpgid(0, 0)
            ended(file, count, pool)
        with suppress(OSError):  # whoever comes first, as shells do it
            os.setpgid(child, child)
        time.sleep(chance.uniform(0.0, 0.15))
        begun = time.monotonic()
        if how == "SIGINT":
            os.kill(child, signal.SIGINT)
        else:  # nobody is left to end what it began
            os.killpg(child, getattr(signal, how))
        heard = True
        while not (gone := os.waitpid(child, os.WNOHANG))[0]:
            if how == "SIGINT" and time.monotonic() - begun > 1:  # Python drops one that comes while it forks
                os.kill(child, signal.SIGINT)
                time.sleep(0.5)
                heard = False
            time.sleep(0.002)
        status = gone[1]
        # Of other signals, processes that nobody waits for stay listed; a second Ctrl-C ends Python's wait for a pool.
        left += how == "SIGINT" and in_group(child) and heard
        slowest = max(slowest, time.monotonic() - begun)
        assert os.WIFSIGNALED(status) or os.WEXITSTATUS(status) in (0, 130), "it failed by itself"
        now = kept(file)
        assert before <= now, f"lost {before - now}"
        before = now
    parts = run(file, 0.002, None, count, pool)
    print(json.dumps({"right": right(parts, count), "kept": len(before), "slowest": slowest, "left": left}), flush=True)


def in_group(group):
    """Whether a process of a group is left after a second; none is then."""
    for _ in range(50):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return False
        time.sleep(0.02)
    os.killpg(group, signal.SIGKILL)
    return True


def ended(file, count, pool):
    """What the child does, until it is ended: it may not go on after this."""
    try:
        run(file, 0.002, None, count, pool)
    except KeyboardInterrupt:
        sys.exit(130)  # as Python ends, with all that it began
    sys.exit(0)


if __name__ == "__main__":
    warnings.simplefilter("error" if sys.argv[1] == "end" else "always")
    if sys.argv[1] == "run":
        results = run(*sys.argv[2:])
        print(json.dumps({"right": right(results, int(sys.argv[5]))}), flush=True)
    else:
        end(*sys.argv[2:])
