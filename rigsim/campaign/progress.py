"""The ``progress=`` keyword of long work."""

from contextlib import contextmanager


@contextmanager
def reporting(progress, total, label=""):
    """What long work calls as ``report(done)`` whenever more of its ``total`` parts are done.

    Parameters
    ----------
    progress : bool or callable
        True shows a bar (in a notebook a widget), False nothing; a callable is called as ``progress(done, total)``.
    total : int
        Number of parts.
    label : str
        Text beside the bar.

    Yields
    ------
    callable
        Takes the number of parts done so far.

    Raises
    ------
    ValueError
        If ``progress`` is neither a bool nor callable.
    """
    if callable(progress):
        yield lambda done: progress(done, total)
    elif progress is False:
        yield lambda done: None
    elif progress is True:
        from tqdm.auto import tqdm  # only here, since it loads widgets

        with tqdm(total=total, desc=label or None) as bar:
            yield lambda done: bar.update(done - bar.n)
    else:
        raise ValueError(f"progress = {progress!r} is not allowed; expected True, False or a callable(done, total)")
