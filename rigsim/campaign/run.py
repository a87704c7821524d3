"""Chunks of a large problem, and how they are run.

How a problem is cut belongs to the problem, not to whoever runs it: a chunk of rigs shares one compiled loop, and
other neighbours would change the last bits. So the same chunks go to every executor and the results are the same.
"""

import os
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import closing, nullcontext
from functools import partial

import numpy as np

from .. import checks
from .checkpoint import Checkpoint, fingerprint
from .code import code_fingerprint
from .progress import reporting
from .stop import SLICE, Lease, Leased, Stop, Stopped, look

_PATIENCE = 2.0  # s for chunks in hand to look up, where the work is stopped


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
        File that keeps every finished chunk; given again, it spares what it holds.
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
    """
    chunks, results = list(chunks), {}
    own = ThreadPoolExecutor(os.cpu_count()) if threads and executor is None else None
    run = partial(_run, work, chunks, executor or own, partial(reporting, progress, len(chunks), label), results)
    try:
        with own or nullcontext():
            if checkpoint is None:
                return run(lambda number, arrays: None)
            key = fingerprint(work.__module__, work.__qualname__, chunks, description)
            with Checkpoint(checkpoint, key, code_fingerprint(work)) as store:
                results.update(store.load())
                return run(store.save)
    except (KeyboardInterrupt, Stopped) as stopped:
        done = f"{len(results)} of {len(chunks)} {label or 'parts'} were done"
        stopped.add_note(
            f"{done}; nothing is kept, for which the call takes checkpoint= a file name"
            if checkpoint is None
            else f"{done} and are kept in {os.fspath(checkpoint)}; the same call goes on from there"
        )
        raise


def _run(work, chunks, executor, reports, results, save):
    """Run the chunks that ``results`` (dict of number to dict of arrays) lacks; return all in order."""
    waiting = [number for number in range(len(chunks)) if number not in results]
    with reports() as report, closing(_finished(work, chunks, waiting, executor)) as finished:
        report(len(results))
        for number, arrays in finished:
            arrays = {name: np.asarray(array) for name, array in arrays.items()}
            save(number, arrays)
            results[number] = arrays
            report(len(results))
    return [results[number] for number in range(len(chunks))]


def _finished(work, chunks, waiting, executor):
    """Yield (number, result) as the chunks get done."""
    if executor is None:
        for number in waiting:
            look()
            yield number, work(chunks[number])
        return
    apart = not isinstance(executor, ThreadPoolExecutor)
    stop = Lease() if apart else Stop()
    call = Leased(work, stop) if apart else partial(_heeding, work, stop)
    numbers = {}
    try:
        numbers.update((executor.submit(call, chunks[number]), number) for number in waiting)
        while numbers:
            look()
            done, _ = wait(numbers, timeout=SLICE, return_when=FIRST_COMPLETED)
            for future in done:
                yield numbers.pop(future), future.result()
    finally:  # after an error or Ctrl-C nothing more is begun, and what runs ends
        stop.ask()
        wait([future for future in numbers if not future.cancel()], timeout=_PATIENCE)
        if apart:
            stop.close()


def _heeding(work, stop, chunk):
    with stop.heeded():
        look()
        return work(chunk)
