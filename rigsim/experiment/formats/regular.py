"""Opening what a reader is given: a regular file, and the same one to the end."""

import os
import stat
from contextlib import contextmanager


@contextmanager
def opened(path):
    """The regular file at ``path``, open for bytes, and its size.

    Nothing waits for a pipe or a device: they are refused. `ValueError` if it is no regular file, `OSError` if it
    cannot be read or changes before the block ends.
    """
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    try:
        handle = os.open(path, flags)
        try:
            before = os.fstat(handle)
            if not stat.S_ISREG(before.st_mode):
                raise ValueError(f"{path} is not a regular file; expected one")
        except BaseException:
            os.close(handle)
            raise
        with os.fdopen(handle, "rb") as file:
            yield file, before.st_size
            after = os.fstat(file.fileno())
    except OSError as error:
        if error.errno is None or error.filename is not None:
            raise
        raise OSError(error.errno, error.strerror, os.fspath(path)) from None
    if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns):
        raise OSError(f"{path} changed while it was read")
