"""Lines of orbits against Eqs. (3a, b) written out again, with the wires' force from many more samples."""

import numpy as np
import pytest

from rigsim import OscillatorParameters, RigParameters, periodic_orbits

RIG = RigParameters()


def left_over(branch, samples=4096):
    """Largest line that the orbits leave of Eqs. (3a, b), the wires' from many samples; over the force."""
    p, order = branch.parameters, np.arange(branch.relative.shape[1])
    phase = np.exp(2j * np.pi * np.outer(order, np.arange(samples)) / samples)
    z = (branch.relative @ phase).real
    if branch.law == "exact":
        spring = p.wire_stiffness.sum() * z * (1 - p.d0 / np.hypot(z, p.d))
    else:
        spring = p.k1 * z + p.k3 * z**3
    lines = np.fft.rfft(spring)[:, : order.size] * np.where(order == 0, 1, 2) / samples
    omega = 2 * np.pi * branch.frequency[:, None] / branch.period * order
    lines = lines + 1j * omega * p.c * branch.relative
    drive = np.where(order == branch.period, branch.force, 0)
    shaker = (p.ks + 1j * omega * p.cs - omega**2 * p.ms) * branch.shaker + lines - drive
    return max(abs(shaker).max(), abs(-(omega**2) * p.m * branch.mass - lines).max()) / branch.force


@pytest.mark.parametrize(("force", "band"), [(3.18, (5, 120)), (20.0, (30, 80))])
@pytest.mark.parametrize("harmonics", [1, 2, 3, 5])
def test_nothing_is_aliased_under_the_cubic_law(force, band, harmonics):
    for branch in periodic_orbits(RIG, force, band, harmonics, "cubic"):
        assert left_over(branch) < 1e-13


@pytest.mark.parametrize(("force", "band"), [(3.18, (5, 120)), (20.0, (30, 80))])
@pytest.mark.parametrize(("harmonics", "aliased"), [(1, 1e-9), (2, 1e-9), (3, 1e-9), (5, 1e-11)])
def test_next_to_nothing_is_aliased_under_the_exact_law(force, band, harmonics, aliased):
    """From the seventh power of z on, where there is one harmonic."""
    for branch in periodic_orbits(RIG, force, band, harmonics, "exact"):
        assert left_over(branch) < aliased


@pytest.mark.parametrize("law", ["cubic", "exact"])
def test_orbits_of_two_periods_obey_the_equations_too(law):
    (doubled,) = periodic_orbits(RIG, 20.0, (30, 80), 9, law, period=2)
    assert doubled.period == 2 and doubled.relative.shape[1] == 2 * 9 + 1 and abs(doubled.relative[:, 1]).max() > 1e-5
    assert left_over(doubled) < 1e-11


@pytest.mark.parametrize(
    "values",
    [
        (1.0, 1.0, 0.0410081595912507, 0.2815657862887755, 0.000637370979239629, 0.010464408724688682, 2.1344281226),
        (1.0, 1.0, 0.014769248457585031, 0.2092718246898, 0.004558004551271689, 0.01350241132611468, 0.442394887766),
        (1.0, 1.0, 0.0369286407246314, 0.1044700404937504, 0.002118761994390573, 0.0032916981661571306, 0.1983803442),
    ],
)
def test_solutions_far_from_an_orbit_are_led_to_it_by_fewer_harmonics(values):
    """From some of these Newton's method finds no orbit of nine harmonics at once, but of three, five and so on."""
    p = OscillatorParameters(*values)
    for branch in periodic_orbits(p, 1.0, (0.15 / (2 * np.pi), 2 / (2 * np.pi)), 9, "cubic"):
        assert "no orbit was found" not in f"{branch.status} {getattr(branch, 'message', '')}"
        assert left_over(branch) < 1e-12
