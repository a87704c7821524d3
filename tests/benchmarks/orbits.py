"""Every curve of periodic orbits of the paper's rig at 3.18 N, exact law, 7 harmonics, 5 to 120 Hz.

Unit: one call of numpy.linalg.eigvals on the 1501 companion matrices of the cubic (5a).
"""

import functools

import numpy as np
from response import companions
from run import fastest

from rigsim import RigParameters, periodic_orbits

FORCE, BAND = 3.18, (5, 120)


def measure():
    """Rows (name, value, unit, ratio)."""
    rig = RigParameters()
    matrices = companions(rig, FORCE, np.linspace(5, 80, 1501))
    find = functools.partial(periodic_orbits, rig, FORCE, BAND, harmonics=7)
    seeds = functools.partial(find, search="seeds")
    branches = find()
    assert [branch.closed for branch in branches] == [False, True]
    branches[0].stable, branches[0].special_points, branches[0].shoot(0)  # compiled
    unit = fastest(lambda: np.linalg.eigvals(matrices))
    timed = {
        "unit: eigvals of companion matrices": unit,
        "periodic_orbits, from single-term seeds": fastest(seeds),
        "the same with stability of every orbit": fastest(lambda: [branch.stable for branch in seeds()]),
        "the same with special points located": fastest(lambda: [branch.special_points for branch in seeds()]),
        "periodic_orbits, complete search": fastest(find),
        "the same with stability of every orbit, complete": fastest(lambda: [branch.stable for branch in find()]),
        "one orbit by shooting, with its monodromy": fastest(lambda: branches[1].shoot(10)),
    }
    rows = [(name, 1e3 * seconds, "ms", seconds / unit) for name, seconds in timed.items()]
    return [*rows, ("orbits on the curves", sum(branch.frequency.size for branch in branches), "", None)]
