"""States run period by period until a trap holds them, in chunks on every core."""

import math
import os
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext

import numpy as np

from ..campaign.run import join, run_chunks, split
from ..compiled import compiled
from .flow import march

_CHUNK = 128  # states that one thread takes at a time


def until_trapped(found, states, patience, *, executor=None, label="states", **options):
    """Run states (n, 4) until the traps of the `Attractors` found hold them, or for ``patience`` periods.

    A dict: ``label`` the motion that each state leads to, -1 where none, ``periods`` how many it took, ``states`` the
    ends. Chunks run by `rigsim.campaign.run.run_chunks`, whose the options are, by default on a thread a core.
    """
    common = {"numbers": found.flow.numbers, "steps": found.flow.steps, "patience": patience}
    common |= {"points": found.points, "metrics": found.metrics, "owner": found.owner}
    chunks = [common | {"states": states[part]} for part in split(len(states), _CHUNK)]
    # Compiled loops leave the interpreter to the other threads.
    with ThreadPoolExecutor(os.cpu_count()) if executor is None else nullcontext(executor) as workers:
        return join(run_chunks(_settle_chunk, chunks, executor=workers, label=label, **options))


def _settle_chunk(chunk):
    y = np.ascontiguousarray(chunk["states"].T)
    h = 2 * math.pi / chunk["numbers"][-1] / chunk["steps"]
    arrays = chunk["points"], chunk["metrics"], chunk["owner"]
    label, periods = _settle(y, chunk["numbers"], h, chunk["steps"], *arrays, chunk["patience"])
    return {"label": label, "periods": periods, "states": y.T}


@compiled(nogil=True)
def _settle(y, numbers, h, steps, points, metrics, owner, patience):
    """Run states ``y`` (4, n), in place, period by period until trapped; who trapped them, and when."""
    n = y.shape[1]
    label, periods = np.full(n, -1), np.full(n, patience)
    place = np.arange(n)  # which state a column of ``running`` is
    running = y.copy()
    gap, no_tap = np.empty(4), np.empty(0)
    for period in range(patience + 1):
        left = 0
        for i in range(n):
            trapped = -1
            for k in range(owner.size):
                for a in range(4):
                    gap[a] = running[a, i] - points[k, a]
                square = 0.0
                for a in range(4):
                    for b in range(4):
                        square += gap[a] * metrics[k, a, b] * gap[b]
                if square < 1.0:
                    trapped = owner[k]
                    break
            if trapped < 0:
                place[left] = place[i]
                running[:, left] = running[:, i]
                left += 1
            else:
                label[place[i]], periods[place[i]] = trapped, period
                y[:, place[i]] = running[:, i]
        n = left
        if n == 0 or period == patience:
            break
        march(running, n, numbers, 0.0, h, steps, no_tap, 0.0, 0.0)
    for i in range(n):
        y[:, place[i]] = running[:, i]
    return label, periods
