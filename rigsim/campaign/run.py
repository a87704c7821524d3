"""Chunks of a large problem, and how they are run.

How a problem is cut belongs to the problem, not to whoever runs it: a chunk of rigs shares one compiled loop, and
other neighbours would change the last bits. So the same chunks go to every executor and the results are the same.
"""

from concurrent.futures import as_completed

import numpy as np

from .. import checks
from .checkpoint import Checkpoint, fingerprint
from .code import code_fingerprint
from .progress import reporting


def split(count, size):
    """Cut ``count`` points into chunks of at most ``size``, as equal as can be: slices in order, without gaps."""
    count, size = checks.integer("count", count, low=1), checks.integer("size", size, low=1)
    number = -(-count // size)
    edges = [count * index // number for index in range(number + 1)]
    return [slice(low, high) for low, high in zip(edges, edges[1:], strict=False)]


def join(results):
    """Put the results of `run_chunks`, a dict of arrays a chunk, behind each other along their first axis: one dict."""
    return {name: np.concatenate([result[name] for result in results]) for name in results[0]}


def run_chunks(work, chunks, *, description=None, executor=None, progress=False, checkpoint=None, label=""):
    """Call ``work`` on every chunk.

    Parameters
    ----------
    work : callable
        ``work(chunk)`` returns a dict of arrays. A function of a module, so that other processes can find it.
    chunks : sequence
        What the calls get, one each.
    description : object
        What else decides the results and is not in the chunks; see `checkpoint.fingerprint` for what it may hold.
    executor : concurrent.futures.Executor, optional
        Runs the calls; by default they run here, one after the other.
    progress : bool or callable
        See `progress.reporting`.
    checkpoint : str or path-like, optional
        File that keeps every finished chunk; given again, it spares what it holds.
    label : str
        Text beside the progress bar.

    Returns
    -------
    list of dict of str to numpy.ndarray
        In the order of ``chunks``, the same to the last bit for every executor, interrupted or not.

    Raises
    ------
    ValueError
        If the checkpoint is of another problem, begun by other code, or no checkpoint.
    """
    chunks = list(chunks)
    if checkpoint is None:
        return _run(work, chunks, executor, progress, label, {}, lambda number, arrays: None)
    key = fingerprint(work.__module__, work.__qualname__, chunks, description)
    with Checkpoint(checkpoint, key, code_fingerprint(work)) as store:
        return _run(work, chunks, executor, progress, label, store.load(), store.save)


def _run(work, chunks, executor, progress, label, results, save):
    """Run the chunks that ``results`` (dict of number to dict of arrays) lacks; return all in order."""
    waiting = [number for number in range(len(chunks)) if number not in results]
    with reporting(progress, len(chunks), label) as report:
        report(len(results))
        for number, arrays in _finished(work, chunks, waiting, executor):
            results[number] = {name: np.asarray(array) for name, array in arrays.items()}
            save(number, results[number])
            report(len(results))
    return [results[number] for number in range(len(chunks))]


def _finished(work, chunks, waiting, executor):
    """Yield (number, result) as the chunks get done."""
    if executor is None:
        for number in waiting:
            yield number, work(chunks[number])
        return
    numbers = {executor.submit(work, chunks[number]): number for number in waiting}
    try:
        for future in as_completed(numbers):
            yield numbers[future], future.result()
    finally:  # after an error or Ctrl-C nothing more is begun
        for future in numbers:
            future.cancel()
