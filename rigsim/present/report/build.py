"""Offline reports: run the numbered notebooks and write each as one HTML file that needs nothing else.

What nbconvert's own HTML would load from elsewhere is done here at export: maths becomes MathML, figures stay inline
SVG, style and scripts are part of the page.
"""

import asyncio
import contextlib
import os
import sys
import tempfile
import time
from pathlib import Path

from tqdm.auto import tqdm

from .pages import index_page, notebook_page
from .run import WORKERS, ReportError, read_notebook, run_apart, run_notebook


def build_reports(names=None, notebooks="notebooks", output="reports", progress=True):
    """Run notebooks, two at a time, and write one self-contained page for each and an index.

    Parameters
    ----------
    names : sequence of str, optional
        Which notebooks: "03_detached_curves", "03_detached_curves.ipynb" or just "03". All numbered ones by default.
    notebooks, output : path
        The folder that holds ``NN_name.ipynb``, which is also where they run, and the one to write to.
    progress : bool
        Say on standard error which notebook is finished, and after how many seconds.

    Returns
    -------
    tuple of pathlib.Path
        The pages written, in the notebooks' order, the index last.

    Raises
    ------
    ValueError
        If the folder holds no numbered notebook, or none by a name given.
    ReportError
        If a notebook fails or its page would need another file. The others are written all the same, and a page of
        the failed one from an earlier run stays as it was.
    OSError
        If ``output`` cannot be written, as is found before the first notebook runs, or its disk is full.
    KeyboardInterrupt
        When interrupted: within 2 s, with no kernel left and no half page, and a note of what is kept.

    Examples
    --------
    >>> build_reports(["03"], output="reports")  # doctest: +SKIP
    (PosixPath('reports/03_detached_curves.html'), PosixPath('reports/index.html'))
    """
    every = sorted(Path(notebooks).glob("[0-9][0-9]_*.ipynb"))
    if not every:
        raise ValueError(f"notebooks = {str(notebooks)!r} holds no numbered notebook; expected NN_name.ipynb")
    chosen = every if not names else sorted({_find(name, every) for name in names})
    output, written, failures = Path(output), {}, {}
    make_folder(output)

    def write_index():
        return write(output / "index.html", index_page(every, output, failures))

    write_index()
    with tqdm(desc="cells", unit="cell", disable=not progress or None, file=sys.stderr, leave=False) as bar:

        async def build(path):
            begun = time.perf_counter()
            try:
                notebook = read_notebook(path)
                bar.total = (bar.total or 0) + sum(cell.cell_type == "code" for cell in notebook.cells)
                await run_notebook(notebook, path, bar)
                seconds = time.perf_counter() - begun
                written[path] = write(output / f"{path.stem}.html", notebook_page(notebook, path, every, seconds))
                line = f"{path.stem}: {seconds:.0f} s, {written[path]}"
            except ReportError as error:
                failures[path] = str(error)
                line = f"{path.stem}: failed"
            write_index()  # whatever comes, it leads to what is there
            if progress:
                tqdm.write(line, file=sys.stderr)

        try:
            run_apart(_in_turn(build, chosen))
        except KeyboardInterrupt as stop:
            stop.add_note(_kept(written, [path for path in chosen if path not in written]))
            raise
    if failures:
        raise ReportError("\n".join(failures[path] for path in sorted(failures)))
    return (*(written[path] for path in chosen), output / "index.html")


async def _in_turn(build, paths):
    """Build one after the other, a few at a time; all end if one raises or this is cancelled."""
    gate = asyncio.Semaphore(WORKERS)

    async def one(path):
        async with gate:
            await build(path)

    tasks = [asyncio.ensure_future(one(path)) for path in paths]
    try:
        await asyncio.gather(*tasks)
    finally:
        for task in tasks:
            if not task.cancelling():
                task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def _kept(written, left):
    """What an interrupted run has written, and how the rest is made."""
    pages = ", ".join(str(written[path]) for path in sorted(written))
    rest = " ".join(path.stem for path in left)
    return f"{f'{pages} written and kept' if pages else 'no page was written'}; 'report {rest}' makes the rest"


def _find(name, every):
    stem = Path(name).stem
    for path in every:
        if stem == path.stem or stem == path.stem[:2]:
            return path
    raise ValueError(f"names has {name!r}; expected one of {', '.join(path.stem for path in every)}")


def make_folder(path):
    """Make a folder and those above it; an OSError that names it says why not."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _unwritable(error, path) from None


def write(path, text):
    """Write the file whole or not at all."""
    temporary = None
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".page-", suffix=".part")
        with os.fdopen(handle, "w", encoding="utf-8", errors="replace") as file:
            file.write(text)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException as error:
        if temporary is not None:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
        raise (_unwritable(error, path) if isinstance(error, OSError) else error) from None
    return path


def _unwritable(error, path):
    return OSError(error.errno, error.strerror or str(error), str(path))
