"""`Attractor` says what its lines hold: the line that gives a longer period away, and the path they add up to."""

import numpy as np
import pytest

from rigsim.attraction.motions import Attractor


def motion(period, relative, f=30.0):
    relative = np.array(relative, dtype=complex)
    lines = np.arange(relative.size) * f / period, 0 * relative, -relative, relative
    return Attractor(0, "other", period, np.zeros((period, 4)), 1.0, *lines, np.full(4, 0.5), symmetric=False)


@pytest.mark.parametrize(
    ("period", "relative", "expected"),
    [
        (3, [9, 1, -4j, 7, 8], (20.0, 4.0)),  # neither the mean nor what f has
        (3, [9, -3, 2j, 7, 8], (10.0, 3.0)),
        (2, [9, 2, 7, 8], (15.0, 2.0)),
        (1, [9, 7, 8], None),
    ],
)
def test_the_giveaway_is_the_strongest_line_below_the_force_s(period, relative, expected):
    assert motion(period, relative).giveaway == (expected and pytest.approx(expected))


def test_the_path_is_the_sum_of_the_lines_over_one_period():
    z, velocity = motion(2, [0.25, 1, 2j]).path
    time = np.linspace(0, 2 / 30, 400)
    slow, fast = 30 * np.pi, 60 * np.pi
    np.testing.assert_allclose(z, 0.25 + np.cos(slow * time) - 2 * np.sin(fast * time), atol=1e-12)
    np.testing.assert_allclose(velocity, -slow * np.sin(slow * time) - 2 * fast * np.cos(fast * time), atol=1e-9)
