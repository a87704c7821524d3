"""Every curve of periodic orbits of the paper's rig at 3.18 N, exact law, 7 harmonics, 5 to 120 Hz.

Unit: one call of numpy.linalg.eigvals on the 1501 companion matrices of the cubic (5a).
"""

import numpy as np
from response import companions
from run import fastest

from rigsim import RigParameters, periodic_orbits

FORCE, BAND = 3.18, (5, 120)


def measure():
    """Rows (name, value, unit, ratio)."""
    rig = RigParameters()
    matrices = companions(rig, FORCE, np.linspace(5, 80, 1501))
    branches = periodic_orbits(rig, FORCE, BAND, harmonics=7)
    assert [branch.closed for branch in branches] == [False, True]
    branches[0].stable, branches[0].special_points, branches[0].shoot(0)  # compiled

    def with_stability():
        return [branch.stable for branch in periodic_orbits(rig, FORCE, BAND, harmonics=7)]

    def with_special_points():
        return [branch.special_points for branch in periodic_orbits(rig, FORCE, BAND, harmonics=7)]

    unit = fastest(lambda: np.linalg.eigvals(matrices))
    timed = {
        "unit: eigvals of companion matrices": unit,
        "periodic_orbits, all pieces": fastest(lambda: periodic_orbits(rig, FORCE, BAND, harmonics=7)),
        "periodic_orbits, with stability of every orbit": fastest(with_stability),
        "periodic_orbits, with special points located": fastest(with_special_points),
        "one orbit by shooting, with its monodromy": fastest(lambda: branches[1].shoot(10)),
    }
    rows = [(name, 1e3 * seconds, "ms", seconds / unit) for name, seconds in timed.items()]
    return [*rows, ("orbits on the curves", sum(branch.frequency.size for branch in branches), "", None)]
