"""A search other than ours: shooting in time from many starts, on random rigs; what it finds must be on the curves."""

import numpy as np
import pytest

from rigsim import OscillatorParameters, periodic_orbits
from rigsim.orbits.shooting import shoot_orbit
from rigsim.orbits.verdict import passing

_SAME = 1e-3  # relative distance of lines of z at the forcing frequency


def random_rig(generator):
    """Non-dimensional, from weak to strong absorbers."""
    mu, zeta_s, zeta = (10 ** generator.uniform(*reach) for reach in ((-1.5, -0.3), (-2, -1), (-2.3, -0.8)))
    return OscillatorParameters.from_nondimensional(
        mu, zeta_s, zeta, generator.uniform(0, 0.6), 10 ** generator.uniform(-2, 0.3)
    )


def met_by_shooting(rig, frequency, starts, generator):
    """Lines of z of every orbit that random starts lead to, each once."""
    omega = 2 * np.pi * frequency
    sizes = 10 ** generator.uniform(-1, 1.2, (starts, 1)) * np.array([1, 1, omega, omega])
    met = []
    for state in sizes * generator.standard_normal((starts, 4)):
        shot = shoot_orbit(rig, 1.0, frequency, state, "cubic", iterations=25)
        line = shot.relative[1] if shot.converged else np.nan
        if np.isfinite(line) and not any(abs(line - known) < _SAME * abs(known) for known in met):
            met.append(line)
    return met


def compared(seed, frequencies, starts):
    """(orbits met, those of them that are on no curve) of one random rig."""
    generator = np.random.default_rng(seed)
    rig = random_rig(generator)
    band = 0.4 / (2 * np.pi), 1.7 / (2 * np.pi)
    curves = periodic_orbits(rig, 1.0, band, law="cubic")
    count, lost = 0, []
    for frequency in np.geomspace(band[0] * 1.01, band[1] * 0.99, frequencies):
        known = [line for branch in curves for _, line, _ in passing(branch, frequency)]
        for line in met_by_shooting(rig, frequency, starts, generator):
            count += 1
            if not any(abs(line - other) < _SAME * abs(other) for other in known):
                lost.append((seed, float(frequency), complex(line)))
    return count, lost


@pytest.mark.parametrize("seed", [1, 4])
def test_shooting_finds_nothing_that_the_curves_lack(seed):
    count, lost = compared(seed, 4, 40)
    assert count >= 4 and not lost


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(15))
def test_many_starts_find_nothing_that_the_curves_lack(seed, tell):
    count, lost = compared(seed, 20, 400)
    tell(f"random rig {seed}: 400 shooting starts at each of 20 frequencies met {count} orbits, {len(lost)} unknown")
    assert not lost
