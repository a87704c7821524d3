"""Offline reports: run the numbered notebooks and write each as one HTML file that needs nothing else.

What nbconvert's own HTML would load from elsewhere is done here at export: maths becomes MathML, figures stay inline
SVG, style and scripts are part of the page.
"""

import os
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from tqdm.auto import tqdm

from .pages import index_page, notebook_page
from .run import WORKERS, ReportError, read_notebook, run_notebook


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

    Examples
    --------
    >>> build_reports(["03"], output="reports")  # doctest: +SKIP
    (PosixPath('reports/03_detached_curves.html'), PosixPath('reports/index.html'))
    """
    every = sorted(Path(notebooks).glob("[0-9][0-9]_*.ipynb"))
    if not every:
        raise ValueError(f"notebooks = {str(notebooks)!r} holds no numbered notebook; expected NN_name.ipynb")
    chosen = every if not names else sorted({_find(name, every) for name in names})
    output = Path(output)
    output.mkdir(parents=True, exist_ok=True)
    written, failures = {}, {}
    with tqdm(desc="cells", unit="cell", disable=not progress or None, file=sys.stderr, leave=False) as bar:

        def build(path):
            begun = time.perf_counter()
            notebook = read_notebook(path)
            bar.total = (bar.total or 0) + sum(cell.cell_type == "code" for cell in notebook.cells)
            run_notebook(notebook, path, bar)
            seconds = time.perf_counter() - begun
            return _write(output / f"{path.stem}.html", notebook_page(notebook, path, every, seconds)), seconds

        with ThreadPoolExecutor(WORKERS) as executor:
            futures = {executor.submit(build, path): path for path in chosen}
            try:
                for future in as_completed(futures):
                    path = futures[future]
                    try:
                        written[path], seconds = future.result()
                        line = f"{path.stem}: {seconds:.0f} s, {written[path]}"
                    except ReportError as error:
                        failures[path] = str(error)
                        line = f"{path.stem}: failed"
                    if progress:
                        tqdm.write(line, file=sys.stderr)
            except BaseException:
                executor.shutdown(wait=False, cancel_futures=True)
                raise
    index = _write(output / "index.html", index_page(every, output, failures))
    if failures:
        raise ReportError("\n".join(failures[path] for path in sorted(failures)))
    return (*(written[path] for path in chosen), index)


def _find(name, every):
    stem = Path(name).stem
    for path in every:
        if stem == path.stem or stem == path.stem[:2]:
            return path
    raise ValueError(f"names has {name!r}; expected one of {', '.join(path.stem for path in every)}")


def _write(path, text):
    """Write the file whole or not at all."""
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=".part")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise
    return path
