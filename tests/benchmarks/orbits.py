"""Every curve of periodic orbits of the paper's rig at 3.18 N, exact law, 7 harmonics, 5 to 120 Hz.

Unit: one call of numpy.linalg.eigvals on the 1501 companion matrices of the cubic (5a).
"""

import functools

import numpy as np
from response import companions
from run import fastest

from rigsim import RigParameters, force_scenario, periodic_orbits, response_sheet

FORCE, BAND = 3.18, (5, 120)


def memory(sheet):
    """MB held by its slices and lines."""
    exploration = sheet.exploration
    arrays = [array for lines in exploration.lines for _, line in lines for array in (line.points, line.tangents)]
    arrays += [array for loci in exploration.loci for one in loci for array in (one.points, one.tangents)]
    return sum(array.nbytes for array in arrays) / 1e6


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
    sheet = response_sheet(rig, BAND, (0.1, 8.0), 7)
    timed |= {
        "response_sheet, 0.1 to 8 N, with events": fastest(lambda: response_sheet(rig, BAND, (0.1, 8.0), 7).events, 1),
        "its contour at 3.18 N": fastest(lambda: sheet.at(FORCE)),
        "force_scenario, converged": fastest(lambda: force_scenario(rig, 7), 1),
    }
    rows = [(name, 1e3 * seconds, "ms", seconds / unit) for name, seconds in timed.items()]
    return [
        *rows,
        ("orbits on the curves", sum(branch.frequency.size for branch in branches), "", None),
        ("memory of the sheet", memory(sheet), "MB", None),
    ]
