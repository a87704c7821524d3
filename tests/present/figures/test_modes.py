"""Mode shapes drawn on the rig are the model's."""

import numpy as np
import pytest

from rigsim.model.oscillator import oscillator_modes
from rigsim.model.planar import linear_modes, static_equilibrium
from rigsim.parameters import RigParameters
from rigsim.present.figures.rig_parts import rig_parts

RIG = RigParameters()


def test_mode_shapes_are_the_models_and_as_large_as_asked():
    modes, q = linear_modes(RIG), static_equilibrium(RIG).coordinates
    figure = modes.plot(largest=3e-3)
    rest = rig_parts(RIG, q)
    for axes, name, frequency, shape in zip(figure.axes, modes.names, modes.frequency, modes.shape, strict=True):
        assert f"{name} {frequency:.4g} Hz" in axes.get_title() and f"{name} {frequency:.4g} Hz" in figure.alt
        frame, mass = (1e-3 * patch.get_xy()[:-1] for patch in axes.patches[2:])
        moved = max(
            np.linalg.norm(mass - rest["mass"], axis=1).max(), np.linalg.norm(frame - rest["frame"], axis=1).max()
        )
        assert moved == pytest.approx(3e-3, rel=0.05)
        along = mass[1] - mass[0]
        drawn = [
            frame[0, 0] - rest["frame"][0, 0],
            *(mass.mean(axis=0) - q[1:3]),
            np.arctan2(along[1], along[0]) - q[3],
        ]
        scale = np.linalg.norm(drawn) / np.linalg.norm(shape.real)
        np.testing.assert_allclose(np.abs(drawn), np.abs(scale * shape.real), atol=0.02 * np.abs(drawn).max())


def test_modes_without_a_rig_and_without_a_size_are_refused():
    with pytest.raises(ValueError, match="no rig to be drawn on"):
        oscillator_modes(RIG).plot()
    with pytest.raises(ValueError, match="largest = 0"):
        linear_modes(RIG).plot(largest=0)
