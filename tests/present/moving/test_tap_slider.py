"""The slider over taps says where each one leads, as the map does."""

import numpy as np
import pytest

from rigsim import RigParameters, tap_map, tap_slider


def test_slider_agrees_with_the_map():
    taps = tap_map(RigParameters(), 3.18, 30.0, velocity=np.linspace(0, 0.4, 9), instants=4, starts=64)
    moving = tap_slider(taps, 0.5, velocity=taps.velocity, periods=6)
    wanted = [f"This tap leads to '{taps.attractors.names[i]}'." for i in taps.label[:, 2]]
    assert list(moving.notes) == wanted and len(set(wanted)) == 2
    assert "0 to " in moving.alt and "lead to high" in moving.alt
    # No tap at all: the path stays where it is.
    still = moving.panels[1].curves[0][0]
    assert np.ptp(still.x) < 1e-3 and np.ptp(still.y) < 1e-4
    assert 'type="range"' in moving._repr_html_()
    with pytest.raises(ValueError, match="instant = 2"):
        tap_slider(taps, 2)
