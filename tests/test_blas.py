"""The same bits whatever the environment says of threads."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from threadpoolctl import ThreadpoolController

from rigsim.blas import one_blas_thread

ROOT = Path(__file__).resolve().parent.parent
SETTINGS = [("1", "1"), ("2", "1"), ("7", "2")]
# What a result holds, as bytes: every array in it, and the text of the rest.
CALLS = {
    "identify": "identify(random_test(rig, duration=20), block_rows=60, order=6)",
    "orbits": "list(periodic_orbits(rig, 3.18, (20, 60), 27))",
    "strong orbits": "list(periodic_orbits(OscillatorParameters(4.0, 1e4, 3.0, 0.4, 0.05, 300.0, 1e8), 60.0, (5, 30)))",
    "scenario": "list(force_scenario(rig, 7))",
    "attractors": "attractors(rig, 3.18, 40.0, starts=64)",
    "sweep": "sine_test(rig, 3.18, [20.0, 40.0, 60.0], duration=1)",
    "response": "frequency_response(rig, 3.18, np.linspace(5, 80, 3000)).multipliers",
    "converged margins": "margins(rig, 3.18, names=('d0', 'force'), harmonics=5)",
}
_SCRIPT = """
import dataclasses, hashlib
import numpy as np
from rigsim import *
rig = RigParameters()

def feed(digest, value):
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        digest.update(value.tobytes())
    elif dataclasses.is_dataclass(value):
        feed(digest, [getattr(value, field.name) for field in dataclasses.fields(value)])
    elif isinstance(value, dict):
        feed(digest, list(value.values()))
    elif isinstance(value, (list, tuple, np.ndarray)):
        for part in value:
            feed(digest, part)
    else:
        digest.update(repr(value).encode())

for call in {calls!r}:
    digest = hashlib.sha256()
    feed(digest, eval(call))
    print(digest.hexdigest())
"""


def digests(threads, numba_threads, calls):
    names = "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"
    settings = dict.fromkeys(names, threads) | {"NUMBA_NUM_THREADS": numba_threads, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", _SCRIPT.format(calls=calls)],
        env={**os.environ, **settings}, cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout.split()


@pytest.mark.full
def test_same_bits_whatever_the_environment_says_of_threads():
    first, *others = [digests(*settings, list(CALLS.values())) for settings in SETTINGS]
    assert len(first) == len(CALLS)
    for other in others:
        assert dict(zip(CALLS, other, strict=True)) == dict(zip(CALLS, first, strict=True))


def threads():
    return {library["num_threads"] for library in ThreadpoolController().select(user_api="blas").info()}


@pytest.mark.skipif(threads() == {1}, reason="BLAS has one thread from the start")
def test_others_threads_come_back_when_the_last_call_ends():
    before = threads()

    @one_blas_thread
    def inner():
        return threads()

    @one_blas_thread
    def outer():
        return inner(), threads()

    assert outer() == ({1}, {1}) and threads() == before

    @one_blas_thread
    def failing():
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        failing()
    assert threads() == before
