"""Curves that single-term theory does not know are found through slices of the response sheet, and shooting agrees."""

import numpy as np
import pytest

from rigsim import OscillatorParameters, RigParameters, folds, force_scenario, periodic_orbits

RIG = RigParameters()
# A strong absorber with a detached asymmetric curve, and one with a curve that enters through the band's lower end.
ASYMMETRIC = OscillatorParameters(0.82362433, 14940.677, 1.9316948, 0.017896099, 0.011843468, 10.681161, 6.7662314e8)
ENTERING = OscillatorParameters(0.20524148, 30408.519, 4.3585228, 0.015799454, 0.0095536581, 12.075819, 4.1370077e10)


def reach(branch):
    return branch.frequency.min(), branch.frequency.max()


@pytest.mark.parametrize(
    ("force", "law", "expected"),
    [
        (1.36, "exact", (63.006, 66.332)),
        (1.36, "cubic", (62.769, 66.647)),
        (1.355, "exact", None),
        (1.37, "cubic", None),
    ],
)
def test_the_outer_curve_is_found_from_its_converged_birth_on(force, law, expected):
    main, outer = periodic_orbits(RIG, force, (5, 120), law=law)
    assert not main.closed and outer.closed and outer.symmetric
    if expected:
        assert reach(outer) == pytest.approx(expected, abs=1e-3)
    for i in (0, outer.frequency.size // 3):
        shot = outer.shoot(i)
        assert shot.converged and abs(shot.relative[1] / outer.relative[i, 1] - 1) < 1e-5
    assert len(periodic_orbits(RIG, force, (5, 120), law=law, search="seeds")) == 1


@pytest.mark.parametrize(("force", "law"), [(1.3518, "exact"), (1.3490, "cubic")])
def test_there_is_none_just_below_its_birth(force, law):
    assert len(periodic_orbits(RIG, force, (5, 120), law=law)) == 1


@pytest.mark.parametrize(("force", "law"), [(1.3524, "exact"), (1.3496, "cubic")])
def test_a_curve_between_two_slices_is_found(force, law):
    """1e-4 of the force above its birth it is narrower than any slices are apart."""
    _, outer = periodic_orbits(RIG, force, (5, 120), law=law)
    assert outer.closed and np.ptp(outer.frequency) < 0.7


def test_a_detached_asymmetric_curve_is_found():
    for band in ((8, 40), (11, 17)):
        found = periodic_orbits(ASYMMETRIC, 11.633987, band, 15)
        (island,) = [b for b in found if not b.symmetric and b.closed]
        assert reach(island) == pytest.approx((11.4732, 16.5477), abs=1e-3) and 0 < island.stable.mean() < 1
        shot = island.shoot(int(np.flatnonzero(island.stable)[0]))
        assert shot.converged and shot.stable


def test_a_curve_that_enters_through_the_band_s_end_is_found():
    found = periodic_orbits(ENTERING, 3.6595604, (9.189, 40))
    assert any(reach(b) == pytest.approx((9.189, 10.167), abs=2e-3) for b in found if not b.symmetric)


@pytest.mark.parametrize("force", [16.0, 50.0])
def test_what_is_found_does_not_depend_on_the_band(force):
    """Asymmetric curves are there, too, where they branch off outside the band."""

    def at_40(band):
        return sum(
            int(((b.frequency[:-1] - 40) * (b.frequency[1:] - 40) <= 0).sum())
            for b in periodic_orbits(RIG, force, band)
        )

    assert at_40((20, 60)) == at_40((5, 80))


def test_mirror_images_are_not_told_twice():
    found = periodic_orbits(RIG, 20.0, (30, 80), harmonics=15)
    lines = [np.sort(abs(b.relative[0])) for b in found if not b.symmetric]
    assert len(lines) == 2  # one that branches off, and a detached one
    island = found[-1]
    assert island.closed and island.shoot(int(np.flatnonzero(island.stable)[3])).stable


def test_two_folds_closer_than_a_step_are_folds_of_the_one_curve():
    """1e-6 above the birth of a hysteresis, where the curve was traced twice and its folds were missed."""
    rig = OscillatorParameters(
        0.170822988, 28351.103160, 12.843474092, 0.00351736263, 0.0536446225, 96.722304191, 138396092.0
    )
    birth = force_scenario(rig)[0]
    assert birth.kind == "hysteresis birth"
    for near in (1e-6, 1e-5, 1e-4, 1e-3):
        force = birth.force * (1 + near)
        (branch,) = periodic_orbits(rig, force, (0.75 * birth.frequency, 1.03 * birth.frequency), 1, "cubic")
        exact = [fold.frequency for fold in folds(rig, force)]
        assert sorted(branch.frequency[list(branch.folds)]) == pytest.approx(exact, rel=1e-8)
