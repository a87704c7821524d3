"""Orbits held against the motions that integration leads to."""

import pytest

from rigsim import RigParameters, Status, periodic_orbits

RIG = RigParameters()


def test_where_the_curves_have_every_motion_it_says_so():
    verdict = periodic_orbits(RIG, 3.18, (15, 45), 9).verdict([20.0, 30.0], starts=48)
    assert verdict.status is Status.FOUND and "every motion met" in verdict.summary()
    assert [(one.orbits, one.stable) for one in verdict] == [(1, 1), (3, 2)]


def test_a_motion_that_the_curves_lack_is_told_and_followed():
    found = periodic_orbits(RIG, 3.18, (20, 60), 9)
    verdict = found.verdict([40.0], starts=64)
    assert verdict.status is Status.DOUBTFUL and "subharmonic 1/2" in verdict.message
    (more,) = verdict.orbits[len(found) :]
    assert more.period == 2 and more.closed
    assert more.frequency.min() == pytest.approx(33.43, abs=0.02)


def test_curves_without_their_detached_piece_are_found_wanting():
    """Of a piece that was taken away the stable motion is met, and its curve found again."""
    from dataclasses import replace

    whole = periodic_orbits(RIG, 3.18, (15, 58), 9)
    (piece,) = [b for b in whole if b.closed]
    verdict = replace(whole, members=tuple(b for b in whole if not b.closed)).verdict([30.0])
    assert verdict.status is Status.DOUBTFUL
    assert verdict.orbits[-1].frequency.max() == pytest.approx(piece.frequency.max(), abs=1e-6)


def test_where_no_orbit_is_stable_it_looks_by_itself():
    """At 500 N nothing of period one lasts over part of the band."""
    found = periodic_orbits(RIG, 500.0, (40, 60), 27, search="seeds")
    low, high = found.without_stable[0]
    assert 40 <= low < high <= 60
    at = [one.frequency for one in found.verdict(starts=8)]
    assert 0.5 * (low + high) in at and len(at) == 8 + len(found.without_stable) and at == sorted(at)
    assert not any(b.stable[(b.frequency > low) & (b.frequency < high)].any() for b in found)
    assert periodic_orbits(RIG, 3.18, (15, 45), 7).without_stable == ()


def test_a_motion_that_cannot_be_followed_is_told(monkeypatch):
    def refuse(*arguments, **options):
        raise ValueError("no orbit")

    monkeypatch.setattr("rigsim.orbits.verdict.continue_orbit", refuse)
    found = periodic_orbits(RIG, 3.18, (20, 60), 9)
    verdict = found.verdict([40.0])
    assert "with 9 harmonics no curve was found through 'subharmonic 1/2' at 40 Hz" in verdict.message
    assert len(verdict.orbits) == len(found) and verdict.status is Status.DOUBTFUL
