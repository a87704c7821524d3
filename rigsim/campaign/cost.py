"""What work will take, estimated before it starts, and refused where it cannot end well.

Estimates are coarse, within a factor of three on a machine of today, and only say what is out of reach: more memory
than is free, or more than a week of one core; a hundred weeks where an executor or a checkpoint shares them out.
"""

import math
import os
from pathlib import Path

WEEK = 7 * 24 * 3600.0  # s
_SHARED = 100  # weeks
_SPANS = ((365.25 * 24 * 3600, "years"), (24 * 3600, "days"), (3600, "hours"), (1, "s"))
_UNLIMITED = 1 << 60  # what control groups write where there is no limit is beyond it


def affordable(given, *, memory=0.0, seconds=0.0, instead, shared=False):
    """Refuse work that needs more memory (bytes) than is free, or more seconds of one core than a week has.

    ``given`` names the arguments that ask for it with their values, ``instead`` says what to ask for. ``shared`` if an
    executor or a checkpoint was given. Each `ValueError` says the estimate and what it was held against.
    """
    if memory > 2e7 and memory > (free := free_memory()):
        needed = f"needs about {_size(memory)} of memory, and {_size(free)} are free"
        raise ValueError(f"{given} is not allowed: it {needed}; expected {instead}")
    weeks = _SHARED if shared else 1
    if seconds > weeks * WEEK:
        limit = "a week, or a hundred weeks with executor= or checkpoint=" if weeks == 1 else f"{weeks} weeks"
        needed = f"takes about {_span(seconds)} of one core, and the most that is begun is {limit}"
        raise ValueError(f"{given} is not allowed: it {needed}; expected {instead}")


def free_memory():
    """Bytes that this process may still take: of the machine, of its control group and of its own limit."""
    return max(0.0, min(_machine(), _control_group(), _own_limit()))


def _machine():
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return next(1024.0 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    except (OSError, ValueError, StopIteration):
        pass
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return math.inf


def _control_group(root="/sys/fs/cgroup"):
    """What a container has left: the limit less what is in use and cannot be dropped; version 2, then version 1."""
    names = ("memory.max", "memory.current", "memory.stat", "inactive_file")
    older = ("memory.limit_in_bytes", "memory.usage_in_bytes", "memory.stat", "total_inactive_file")
    for folder, (limit, used, stat, cache) in ((root, names), (f"{root}/memory", older)):
        try:
            texts = [Path(folder, name).read_text(encoding="ascii").strip() for name in (limit, used, stat)]
            most = int(texts[0])
            dropped = next(int(line.split()[1]) for line in texts[2].splitlines() if line.startswith(cache + " "))
        except (OSError, ValueError, StopIteration):
            continue
        if most < _UNLIMITED:
            return float(most - int(texts[1]) + dropped)
    return math.inf


def _own_limit():
    """What ``ulimit -v`` leaves."""
    try:
        import resource

        most = resource.getrlimit(resource.RLIMIT_AS)[0]
        if most == resource.RLIM_INFINITY:
            return math.inf
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        return float(most - pages * os.sysconf("SC_PAGE_SIZE"))
    except (ImportError, OSError, ValueError):
        return math.inf


def _size(memory):
    return f"{memory / 1e9:.2g} GB" if memory > 1e8 else f"{memory / 1e6:.2g} MB"


def _span(seconds):
    length, unit = next(one for one in _SPANS if seconds >= one[0] or one[0] == 1)
    return f"{seconds / length:.2g} {unit}"
