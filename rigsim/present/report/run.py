"""Running a notebook on this interpreter, in a kernel that ends with it."""

import asyncio
import atexit
import contextlib
import os
import signal
import sys
import tempfile
import threading
from pathlib import Path

import nbformat
from jupyter_client.kernelspec import KernelSpec
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError
from nbconvert.filters.ansi import strip_ansi

WORKERS = 2  # notebooks that run at a time
_CELL_TIMEOUT = 900  # s; a cell that takes longer hangs
_GRACE, _LAST = 0.3, 1.2  # s that a cancelled kernel has to put its things in order, and all kernels to be gone


class ReportError(RuntimeError):
    """One or more notebooks failed; one line for each names the notebook, the cell and what was raised."""


def read_notebook(path):
    """The notebook in a file; raise a `ReportError` if there is none."""
    try:
        return nbformat.read(path, as_version=4)
    except Exception as error:  # nbformat lets through whatever its JSON and schema libraries raise
        raise ReportError(f"{path.name} is no notebook: {_line(error)}") from None


class _OwnKernel(AsyncKernelManager):
    """Any notebook runs on this interpreter, whatever kernels the machine has installed."""

    @property
    def kernel_spec(self):
        quiet = ["--log-level=ERROR", "--HistoryManager.enabled=False"]
        argv = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}", *quiet]
        return KernelSpec(argv=argv, display_name="Python", language="python")

    def signal_group(self, number):
        """Send a signal to the kernel and what it has started, if they run."""
        process = getattr(self.provisioner, "process", None)
        if process is not None and process.poll() is None:
            with contextlib.suppress(OSError):
                if os.name == "nt":
                    process.kill()
                else:
                    os.killpg(process.pid, number)


async def run_notebook(notebook, path, bar):
    """Execute the notebook in place; raise a `ReportError` of one line if a cell fails, or none can be run.

    If the task is cancelled, the kernel and all that it has started are gone when this ends, in less than a second.
    """
    try:
        # What kernels are reached by, and what they say while they start: not where Jupyter of this user keeps its own.
        with (
            tempfile.TemporaryDirectory(prefix="rigsim-", ignore_cleanup_errors=True) as folder,
            tempfile.TemporaryFile(dir=folder) as said,
        ):
            await _run(notebook, path, bar, _OwnKernel(connection_file=str(Path(folder, "kernel.json"))), said)
    except OSError as error:
        raise ReportError(f"{path.name}: no kernel can be started: {_line(error)}") from None


async def _run(notebook, path, bar, kernel, said):
    at = {}
    client = NotebookClient(
        notebook,
        km=kernel,
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
        await client.async_execute(env={**defaults, **os.environ}, stderr=said)
        await kernel.shutdown_kernel()
    except (CellExecutionError, CellTimeoutError, DeadKernelError, RuntimeError) as error:
        if asyncio.current_task().cancelling():  # what the kernel makes of its end
            raise asyncio.CancelledError from None
        if isinstance(error, CellExecutionError):
            what = f"{error.ename}: {error.evalue}"
        elif isinstance(error, CellTimeoutError):
            what = f"no end after {_CELL_TIMEOUT} s"
        elif "index" in at:
            what = "the kernel died"
        else:
            said.seek(0)
            last = said.read().decode("utf-8", "replace").strip().rpartition("\n")[2]
            raise ReportError(f"{path.name}: the kernel did not start: {last or _line(error)}") from None
        number = sum(cell.cell_type == "code" for cell in notebook.cells[: at.get("index", 0) + 1])
        raise ReportError(f"{path.name}, code cell {number}: {_line(strip_ansi(what))}") from None
    finally:
        if asyncio.current_task().cancelling():
            kernel.signal_group(signal.SIGINT)
            await asyncio.sleep(_GRACE)
        atexit.unregister(client._cleanup_kernel)  # which a start that was cancelled leaves there
        kernel.signal_group(getattr(signal, "SIGKILL", signal.SIGTERM))
        if kernel.has_kernel:
            await kernel.shutdown_kernel(now=True)
        if client.kc is not None:
            client.kc.stop_channels()


def _line(text):
    return str(text).strip().replace("\n", " ") or type(text).__name__


def run_apart(coroutine):
    """Result of a coroutine, run in a thread of its own; if this one is interrupted, the coroutine is cancelled.

    A caller in a notebook has a loop already, and a loop in the main thread would keep Ctrl-C to itself.
    """
    loop = asyncio.SelectorEventLoop()
    task = loop.create_task(coroutine)

    done = threading.Event()  # to wait for: joining a thread may believe it ended when a signal comes

    def work():
        asyncio.set_event_loop(loop)
        with contextlib.suppress(BaseException):  # the task keeps it
            loop.run_until_complete(task)
        left = asyncio.all_tasks(loop)  # such as nbclient's watch on a kernel
        for one in left:
            one.cancel()
        loop.run_until_complete(asyncio.gather(*left, return_exceptions=True))
        loop.close()
        done.set()

    threading.Thread(target=work, daemon=True).start()
    try:
        while not done.wait(1):  # in turns, since Windows hears of no Ctrl-C within one
            pass
    except BaseException:
        with contextlib.suppress(RuntimeError):  # it has just ended
            loop.call_soon_threadsafe(task.cancel)
        done.wait(_LAST)
        raise
    return task.result()
