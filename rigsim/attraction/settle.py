"""States run period by period until a trap holds them, in chunks on every core."""

import math

import numpy as np

from ..campaign.run import join, run_chunks, split
from ..campaign.stop import look
from ..compiled import compiled
from .flow import march

_CHUNK = 128  # states that one thread takes at a time
_SLICE = 1_000_000  # of them times steps between two looks, some 0.1 s


def until_trapped(found, states, patience, *, label="states", **options):
    """Run states (n, 4) until the traps of the `Attractors` found hold them, or for ``patience`` periods.

    A dict: ``label`` the motion that each state leads to, -1 where none, ``periods`` how many it took, ``states`` the
    ends. Chunks run by `rigsim.campaign.run.run_chunks`, whose the options are, by default on a thread a core.
    """
    common = {"numbers": found.flow.numbers, "steps": found.flow.steps, "patience": patience}
    common |= {"points": found.points, "metrics": found.metrics, "owner": found.owner}
    chunks = [common | {"states": states[part]} for part in split(len(states), _CHUNK)]
    return join(run_chunks(_settle_chunk, chunks, label=label, threads=True, **options))


def _settle_chunk(chunk):
    y, steps, patience = np.ascontiguousarray(chunk["states"].T), chunk["steps"], chunk["patience"]
    h = 2 * math.pi / chunk["numbers"][-1] / steps
    arrays = chunk["points"], chunk["metrics"], chunk["owner"]
    label, periods = np.full(y.shape[1], -1), np.full(y.shape[1], patience)
    slice_ = max(1, _SLICE // (y.shape[1] * steps))
    for first in range(0, patience + 1, slice_):
        look()
        left = np.flatnonzero(label < 0)
        if not left.size:
            break
        states = np.ascontiguousarray(y[:, left])
        trapped, after = _settle(states, chunk["numbers"], h, steps, *arrays, min(slice_, patience - first))
        y[:, left], label[left] = states, trapped
        periods[left[trapped >= 0]] = first + after[trapped >= 0]
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
