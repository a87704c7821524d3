"""The ``progress=`` keyword of long work."""

from contextlib import contextmanager

from .. import checks
from .stop import look


@contextmanager
def reporting(progress, total, label=""):
    """What long work calls as ``report(done)`` whenever more of its ``total`` parts are done.

    ``progress`` is True for a bar (in a notebook a widget) with the text ``label`` beside it, False for nothing, or a
    callable, which is called as ``progress(done, total)``. Each report is a place where the work may be stopped.
    """
    progress = checks.progress(progress)

    def reported(tell):
        def report(done):
            look()
            tell(done)

        return report

    if callable(progress):
        yield reported(lambda done: progress(done, total))
    elif not progress:
        yield reported(lambda done: None)
    else:
        from tqdm.auto import tqdm  # only here, since it loads widgets

        with tqdm(total=total, desc=label or None) as bar:
            yield reported(lambda done: bar.update(done - bar.n))
