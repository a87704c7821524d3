"""Room on disk for channels that are too long for memory: arrays of a file that is nowhere else and goes with them.

They are `numpy.memmap`s, so all that reads arrays reads them, and the system keeps in memory what it has room for.
"""

import mmap
import tempfile

import numpy as np

_LONG = 4_000_000  # samples, from which on a channel is on disk


class Room:
    """Samples of a channel that come in pieces, about ``expected`` of them."""

    def __init__(self, expected):
        self._file = tempfile.TemporaryFile(prefix="rigsim-") if expected >= _LONG else None  # noqa: SIM115  it stays
        self._array, self.size = np.empty(0 if self._file else expected), 0

    def add(self, values):
        """The next ones."""
        end = self.size + values.size
        if self._file:
            self._file.write(np.ascontiguousarray(values, dtype=float))  # which says in words that a disk is full
        else:
            if end > self._array.size:
                self._array.resize(end + end // 4, refcheck=False)
            self._array[self.size : end] = values
        self.size = end

    def whole(self):
        """All of them, an array of its own."""
        if self._file and self.size:
            self._file.flush()
            return np.memmap(self._file, float, "r+")
        self._array.resize(self.size, refcheck=False)
        return self._array


def on_disk(array):
    """The `numpy.memmap` that an array is, or is all of without a right to write; None if it is in memory."""
    for one in (array, array.base):
        if isinstance(one, np.memmap) and one.mode in ("r", "r+"):
            return one
    return None


def let_go(*arrays):
    """Take what was read of arrays on disk from memory; where the platform cannot, it stays until room is needed."""
    for one in map(on_disk, arrays):
        if one is not None and hasattr(mmap, "MADV_DONTNEED"):
            one._mmap.madvise(mmap.MADV_DONTNEED)
