"""The overlay takes the frequencies that a sine test can read, and no others."""

import pytest

from rigsim import RigParameters, sine_test, virtual_experiment


def test_the_lowest_frequency_is_that_of_the_sine_test():
    wanted = r"frequency\[0\] = 1.5 Hz is not allowed; expected .* 2 "
    for run in (virtual_experiment, sine_test):
        with pytest.raises(ValueError, match=wanted):
            run(RigParameters(), 3.18, [1.5])
