"""How long work tells that it is alive."""

from contextlib import contextmanager


@contextmanager
def reporting(progress, total, unit):
    """Yield ``report(done)`` for the length of a job.

    Parameters
    ----------
    progress : bool or callable
        True shows a bar (tqdm's, a widget in a notebook), False nothing; a callable is called as
        ``progress(done, total)``.
    total : int
        Size of the whole job.
    unit : str
        What is counted.
    """
    if callable(progress):
        yield lambda done: progress(done, total)
    elif not progress:
        yield lambda done: None
    else:
        from tqdm.auto import tqdm

        with tqdm(total=total, unit=f" {unit}") as bar:
            yield lambda done: bar.update(done - bar.n)
