"""Running a notebook on this interpreter."""

import os
import sys

import nbformat
from jupyter_client.kernelspec import KernelSpec
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError
from nbconvert.filters.ansi import strip_ansi

WORKERS = 2  # notebooks that run at a time
_CELL_TIMEOUT = 900  # s; a cell that takes longer hangs


class ReportError(RuntimeError):
    """One or more notebooks failed; one line for each names the notebook, the cell and what was raised."""


def read_notebook(path):
    """The notebook in a file; raise a `ReportError` if there is none."""
    try:
        return nbformat.read(path, as_version=4)
    except Exception as error:  # nbformat lets through whatever its JSON and schema libraries raise
        raise ReportError(f"{path.name} is no notebook: {str(error).splitlines()[0]}") from None


class _OwnKernel(AsyncKernelManager):
    """Any notebook runs on this interpreter, whatever kernels the machine has installed."""

    @property
    def kernel_spec(self):
        quiet = ["--log-level=ERROR", "--HistoryManager.enabled=False"]
        argv = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}", *quiet]
        return KernelSpec(argv=argv, display_name="Python", language="python")


def run_notebook(notebook, path, bar):
    """Execute the notebook in place; raise a `ReportError` of one line if a cell fails."""
    at = {}
    client = NotebookClient(
        notebook,
        kernel_manager_class=_OwnKernel,
        kernel_name="python3",
        timeout=_CELL_TIMEOUT,
        store_widget_state=False,
        resources={"metadata": {"path": str(path.parent)}},
        on_cell_start=lambda cell, cell_index: at.update(index=cell_index),
        on_cell_executed=lambda cell, cell_index, execute_reply: bar.update(),
    )
    # The kernels share the cores; without a word each would claim them all.
    threads = str(max(1, (os.cpu_count() or 1) // WORKERS))
    defaults = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), threads)
    try:
        client.execute(env={**defaults, **os.environ})
    except (CellExecutionError, CellTimeoutError, DeadKernelError) as error:
        if isinstance(error, CellExecutionError):
            what = f"{error.ename}: {error.evalue}"
        elif isinstance(error, CellTimeoutError):
            what = f"no end after {_CELL_TIMEOUT} s"
        else:
            what = "the kernel died"
        number = sum(cell.cell_type == "code" for cell in notebook.cells[: at.get("index", 0) + 1])
        line = strip_ansi(what).strip().replace("\n", " ")
        raise ReportError(f"{path.name}, code cell {number}: {line}") from None
