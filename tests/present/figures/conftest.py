"""A sine test that every figure of sine tests draws, and no warnings while they do."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from rigsim.experiment.sine_test import sine_test
from rigsim.model.excitation import Tap
from rigsim.parameters import RigParameters
from rigsim.results import Status


@pytest.fixture(scope="package")
def test():
    """Three from rest and three tapped; the status of two of them replaced, as every kind must be drawn."""
    test = sine_test(RigParameters(), 3.18, [30.0, 48.0, 66.0] * 2, [None] * 3 + [Tap()] * 3)
    status = test.status.copy()
    status[4], status[5] = Status.SUBHARMONIC, Status.FLEW_APART
    gone = {
        name: np.where(status == Status.FLEW_APART, np.nan, getattr(test, name))
        for name in ("shaker", "mass", "relative")
    }
    distortion = np.where(status[:, None] == Status.FLEW_APART, np.nan, test.distortion)
    return replace(test, status=status, distortion=distortion, **gone)


@pytest.fixture(autouse=True)
def no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield
