"""The error of an orbit by the lines it neglects, and the harmonics that are chosen by it."""

import numpy as np
import pytest

from rigsim import OscillatorParameters, RigParameters, continue_orbit, periodic_orbits

RIG = RigParameters()


@pytest.mark.parametrize(("force", "harmonics"), [(3.18, 3), (3.18, 7), (50.0, 13)])
def test_the_estimate_is_the_true_error(force, harmonics):
    """Against the same orbits of four times as many harmonics, found by shooting."""
    branch = periodic_orbits(RIG, force, (20, 60), harmonics)[0]
    for i in np.linspace(1, branch.frequency.size - 2, 7).astype(int):
        shot = branch.shoot(i)
        lines = np.zeros(max(len(shot.relative), branch.relative.shape[1]), dtype=complex)
        lines[: len(shot.relative)] = shot.relative
        lines[: branch.relative.shape[1]] -= branch.relative[i]
        true = np.linalg.norm(lines) / np.linalg.norm(shot.relative)
        if true > 1e-7:  # what shooting knows
            assert 0.2 < branch.error[i] / true < 5


@pytest.mark.parametrize("force", [3.18, 20.0, 50.0])
def test_automatic_harmonics_meet_the_tolerance(force):
    found = periodic_orbits(RIG, force, (20, 60))
    assert max(branch.error.max() for branch in found) < 2e-6 and "in error" not in " ".join(b.message for b in found)
    assert found.harmonics == found[0].harmonics >= 9


def test_too_few_harmonics_are_told():
    assert "more harmonics are needed" in periodic_orbits(RIG, 50.0, (20, 60), 3)[0].message
    assert "more harmonics" not in periodic_orbits(RIG, 3.18, (20, 60), 7)[0].message


def test_a_strong_sink_keeps_its_only_attractor():
    """Nine harmonics call it unstable, beside an asymmetric branch that does not exist."""
    sink = OscillatorParameters.from_nondimensional(
        0.36513263677584473, 0.02544503544871208, 0.14163687844770495, 0.0, 43.794696609032464
    )
    at = 0.6192 / (2 * np.pi)
    found = periodic_orbits(sink, 1.0, (0.9 * at, 1.1 * at), law="cubic")
    crossing = [(b.symmetric, b.stable[i]) for b in found for i in np.flatnonzero(np.diff(np.sign(b.frequency - at)))]
    assert crossing == [(True, True)]


@pytest.mark.parametrize("share", [0.4, 0.5, 0.6, 0.7, 0.8])
def test_a_known_orbit_is_followed_wherever_the_band_ends(share):
    entering = OscillatorParameters(
        0.20524148, 30408.519, 4.3585228, 0.015799454, 0.0095536581, 12.075819, 4.1370077e10
    )
    force, at = 3.6595604, 9.28106516
    for branch in periodic_orbits(entering, force, (9.189, 12), 15):
        for i in np.flatnonzero(np.diff(np.sign(branch.frequency - at)))[:2]:
            followed = continue_orbit(entering, force, branch.frequency[i], branch.relative[i], (9.189 * share, 40), 15)
            assert followed.message and followed.frequency.min() >= 9.189 * share * (1 - 1e-9)
