"""Ten thousand random parameter sets classified: how many inner and outer detached curves each has.

Unit: the companion-matrix eigenvalues of Eq. (5a) at 1501 frequencies for one set, in one numpy.linalg.eigvals call.
That none is wrong is held by tests/design/test_count.py against certified roots in exact arithmetic.
"""

import numpy as np
from response import FORCE, companions
from run import fastest

from rigsim import RigParameters
from rigsim.design.count import judge

SETS = 10_000


def measure():
    """Rows (name, value, unit, ratio)."""
    rng = np.random.default_rng(2014)
    mu, zeta_s, zeta, gamma = 10 ** rng.uniform([-4, -4, -4, -6], [0, -0.3, -0.3, 2], (SETS, 4)).T
    sets = np.column_stack([mu, zeta_s, zeta, rng.uniform(0, 2, SETS), gamma])
    matrices = companions(RigParameters(), FORCE, np.linspace(5, 80, 1501))
    unit = fastest(lambda: np.linalg.eigvals(matrices))
    inner, outer = judge(sets)[0].T
    seconds = fastest(lambda: judge(sets), 2)
    return [
        ("unit: eigvals of companion matrices", 1e3 * unit, "ms", 1),
        ("one set classified", 1e3 * seconds / SETS, "ms", seconds / SETS / unit),
        ("sets a second, one core", SETS / seconds, "", None),
        (
            "of them with an inner curve, with an outer one",
            int((inner > 0).sum()),
            f"and {int((outer > 0).sum())}",
            None,
        ),
    ]
