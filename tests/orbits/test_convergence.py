"""What harmonics are worth: errors that fall, special points that come to their places, and kinds that are missed."""

import numpy as np
import pytest

from rigsim import RigParameters, harmonics_worth, periodic_orbits

RIG = RigParameters()


@pytest.fixture(scope="module")
def worth():
    return harmonics_worth(RIG, 3.18, (30, 80), (1, 3, 5, 7))


def test_every_pair_of_harmonics_takes_most_of_the_error(worth):
    assert list(worth.harmonics) == [1, 3, 5, 7] and worth.reference == 17
    assert (worth.error[:-1] / worth.error[1:] > 10).all() and (worth.error > 0).all()
    np.testing.assert_allclose(worth.error[0], [0.1358, 0.0562, 0.0746], rtol=1e-3)
    np.testing.assert_allclose(worth.error[2], [2.30e-4, 1.74e-4, 2.48e-4], rtol=5e-3)


def test_special_points_come_to_their_places(worth):
    np.testing.assert_allclose(worth.shift[:3], [6.5797, 0.0972, 7.99e-4], rtol=2e-3)
    assert worth.shift[3] < 1e-5
    places = {
        harmonics: [
            (point.kind, point.frequency)
            for branch in periodic_orbits(RIG, 3.18, (30, 80), harmonics)
            for point in branch.special_points
        ]
        for harmonics in (1, 3, 17)
    }
    for row, harmonics in enumerate((1, 3)):
        assert worth.points[row] == len(places[harmonics])
        gaps = [min(abs(f - g) for name, g in places[harmonics] if name == kind) for kind, f in places[17]]
        assert worth.shift[row] == pytest.approx(max(gaps), rel=1e-9)


def test_pieces_and_points_are_counted(worth):
    assert worth.pieces.tolist() == [3, 3, 3, 3] and worth.points.tolist() == [6, 5, 5, 5]


def test_a_kind_of_point_that_few_harmonics_do_not_have_is_infinitely_far():
    worth = harmonics_worth(RIG, 20.0, (30, 80), (1, 2, 3))
    assert np.isinf(worth.shift).all()  # where the period doubles
    assert worth.pieces.tolist() == [len(periodic_orbits(RIG, 20.0, (30, 80), count)) for count in (1, 2, 3)]
    np.testing.assert_allclose(worth.error[0], worth.error[1], rtol=1e-9)  # even lines are none on symmetric orbits
