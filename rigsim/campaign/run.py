"""Chunks of a large problem, and how they are run.

How a problem is cut belongs to the problem, not to whoever runs it: a chunk of rigs shares one compiled loop, and
other neighbours would change the last bits. So the same chunks go to every executor and the results are the same.
"""

import os
import time
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, ProcessPoolExecutor, ThreadPoolExecutor, wait
from contextlib import ExitStack, closing
from functools import partial
from itertools import islice

import numpy as np

from .. import checks
from .checkpoint import Checkpoint, fingerprint
from .code import code_fingerprint
from .progress import reporting
from .stop import SLICE, Lease, Leased, Stop, Stopped, look, undisturbed

_PATIENCE = 1.0  # s for chunks in hand to look up, where the work is stopped


def split(count, size):
    """Cut ``count`` points into chunks of at most ``size``, as equal as can be: slices in order, without gaps."""
    count, size = checks.integer("count", count, low=1), checks.integer("size", size, low=1)
    number = -(-count // size)
    edges = [count * index // number for index in range(number + 1)]
    return [slice(low, high) for low, high in zip(edges, edges[1:], strict=False)]


def join(results):
    """Put the results of `run_chunks`, a dict of arrays a chunk, behind each other along their first axis: one dict."""
    return {name: np.concatenate([result[name] for result in results]) for name in results[0]}


def run_chunks(
    work, chunks, *, description=None, executor=None, progress=False, checkpoint=None, label="", threads=False
):
    """Call ``work`` on every chunk.

    Ctrl-C, or a `stop.Stop` that is heeded here, ends it as soon as every chunk in hand has looked up.

    Parameters
    ----------
    work : callable
        ``work(chunk)`` returns a dict of arrays. A function of a module, so that other processes can find it.
    chunks : sequence
        What the calls get, one each.
    description : object
        What else decides the results and is not in the chunks; see `checkpoint.fingerprint` for what it may hold.
    executor : concurrent.futures.Executor, optional
        Runs the calls; by default they run here, one after the other, or in ``threads``.
    progress : bool or callable
        See `progress.reporting`.
    checkpoint : str or path-like, optional
        File that keeps every finished chunk; given again, it spares what it holds. Processes that are given the same
        share the work. One that is damaged is renamed, with a warning, and begun anew.
    label : str
        Text beside the progress bar.
    threads : bool
        Without an executor, a thread for each processor: for compiled work, which leaves the interpreter to the others.

    Returns
    -------
    list of dict of str to numpy.ndarray
        In the order of ``chunks``, the same to the last bit for every executor, interrupted or not.

    Raises
    ------
    ValueError
        If the checkpoint is of another problem, begun by other code, or no checkpoint.
    OSError
        If it cannot be written; what was finished before is kept in it.
    RuntimeError
        If a chunk ends the process that computes it, twice.
    """
    chunks, results = list(chunks), {}
    own = ThreadPoolExecutor(os.cpu_count()) if threads and executor is None else None
    run = partial(_run, work, chunks, executor or own, partial(reporting, progress, len(chunks), label), results)
    try:
        if checkpoint is None:
            return run(_Memory)
        key = fingerprint(work.__module__, work.__qualname__, chunks, description)
        with Checkpoint(checkpoint, key, code_fingerprint(work)) as store:
            return run(store)
    except (KeyboardInterrupt, Stopped) as stopped:
        done = f"{len(results)} of {len(chunks)} {label or 'parts'} were done"
        stopped.add_note(
            f"{done}; nothing is kept, for which the call takes checkpoint= a file name"
            if checkpoint is None
            else f"{done} and are kept in {os.fspath(checkpoint)}; the same call goes on from there"
        )
        raise
    finally:
        if own:
            own.shutdown(wait=False)  # a thread that still compiles looks up after that, and nobody waits for it


class _Memory:
    """What a run does with its chunks where no file keeps them: as `checkpoint.Checkpoint`."""

    load = staticmethod(lambda numbers: {})
    claim = staticmethod(lambda numbers, most: (list(islice(numbers, most)), []))
    save = staticmethod(lambda number, arrays: None)


def _run(work, chunks, executor, reports, results, store):
    """Run the chunks that neither ``results`` (dict of number to dict of arrays) nor the store has; return all."""
    waiting = dict.fromkeys(range(len(chunks)))  # in order; quick to take from

    def fetch(numbers):
        found = store.load(numbers)
        results.update(found)
        for number in found:
            del waiting[number]
        report(len(results))

    def take(most):
        """At most ``most`` chunks to begin; what others have finished meanwhile is fetched."""
        mine, finished = store.claim(waiting, most)
        for number in mine:
            del waiting[number]
        if finished:
            fetch(finished)
        return mine

    with reports() as report:
        fetch(range(len(chunks)))
        while len(results) < len(chunks):
            with closing(_finished(work, chunks, take, executor)) as finished:
                for number, arrays in finished:
                    arrays = {name: np.asarray(array) for name, array in arrays.items()}
                    store.save(number, arrays)
                    results[number] = arrays
                    report(len(results))
            if len(results) < len(chunks):  # others have the rest in hand
                look()
                time.sleep(SLICE)
    return [results[number] for number in range(len(chunks))]


def _finished(work, chunks, take, executor):
    """Yield (number, result) of the chunks that ``take`` gives, as they get done."""
    if executor is None:
        while mine := take(1):
            look()
            yield mine[0], work(chunks[mine[0]])
        return
    apart = not isinstance(executor, ThreadPoolExecutor)
    stop = Lease() if apart else Stop()
    call = Leased(work, stop) if apart else partial(_heeding, work, stop)
    hand, room = {}, 2 * getattr(executor, "_max_workers", len(chunks))
    with ExitStack() as pools:
        try:
            while lost := (yield from _pooled(call, chunks, take, executor, room, hand)):
                # One of these may have ended its process: each by itself shows which.
                executor, suspects = pools.enter_context(_like(executor)), iter(lost)
                one_by_one = lambda most, left=suspects: list(islice(left, most))  # noqa: E731
                if alone := (yield from _pooled(call, chunks, one_by_one, executor, 1, hand)):
                    raise RuntimeError(
                        f"chunk {alone[0]} (of {len(chunks)}) ends the process that computes it; expected that it "
                        "has memory enough"
                    )
        finally:  # after an error or Ctrl-C nothing more is begun, and what runs ends
            stop.ask()
            wait([future for future in hand.values() if future and not future.cancel()], timeout=_PATIENCE)
            if apart:
                stop.close()


def _heeding(work, stop, chunk):
    with stop.heeded():
        look()
        return work(chunk)


def _pooled(call, chunks, take, executor, room, hand):
    """Yield (number, result), never more than ``room`` in hand; return the numbers in hand when a process was lost.

    ``hand`` is a dict of number to future, of what is being computed.
    """
    try:
        while True:
            look()
            mine = take(room - len(hand)) if len(hand) < room else []
            hand |= dict.fromkeys(mine)
            with undisturbed():
                for number in mine:
                    hand[number] = executor.submit(call, chunks[number])
            if not hand:
                return []
            wait(hand.values(), timeout=SLICE, return_when=FIRST_COMPLETED)
            for number in [number for number, future in hand.items() if future.done()]:
                result = hand[number].result()
                del hand[number]
                yield number, result
    except BrokenExecutor:
        lost = list(hand)
        hand.clear()
        return lost


def _like(executor):
    """A pool of processes as the given one was, which is broken."""
    options = {name: getattr(executor, f"_{name}", None) for name in ("max_workers", "mp_context", "initializer")}
    return ProcessPoolExecutor(**options, initargs=getattr(executor, "_initargs", ()))
