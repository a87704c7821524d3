"""The stabilisation diagram shows each pole once, by what it shares with the order before."""

import numpy as np

from rigsim.identification.order import model_order
from tests.identification.cubic import cubic_record


def test_every_pole_is_drawn_once_and_the_order_is_marked():
    found = model_order(cubic_record(duration=10, noise=0.01))
    figure = found.plot()
    poles, values = figure.axes
    drawn = [line for line in poles.lines if not line.get_label().startswith("_")]
    assert sum(line.get_xdata().size for line in drawn) == found.frequency.size
    (stable,) = [line for line in drawn if line.get_label() == "frequency, damping and shape"]
    np.testing.assert_array_equal(stable.get_xdata(), found.frequency[found.stable])
    np.testing.assert_array_equal(stable.get_ydata(), found.order[found.stable])
    kept, left = (line.get_xdata() for line in values.lines[:2])
    np.testing.assert_array_equal(np.concatenate([kept, left]), found.singular_values[: kept.size + left.size])
    assert kept.size == found.chosen == 4 and values.get_xscale() == "log"
    assert "order 4 marked" in figure.alt and "11.7" in figure.alt and "[Hz]" in poles.get_xlabel()
