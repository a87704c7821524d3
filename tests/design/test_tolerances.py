"""Tolerance studies: shares against a closed form, seeds, and what is refused."""

import numpy as np
import pytest

from rigsim.design.count import existence_forces
from rigsim.design.tolerances import share, tolerance_study
from rigsim.design.variation import replaced
from rigsim.parameters import RigParameters
from rigsim.theory.detached import detached_curves

RIG = RigParameters()
TOLERANCES = {"d0": 1e-6, "cs": "5 %", "force": "2 %"}


def test_the_share_is_the_length_inside_the_range_of_forces():
    ((low, _),) = existence_forces(RIG)
    study = tolerance_study(RIG, 3.18, {"force": 0.5}, samples=4000)
    expected = (3.68 - low) / 1.0
    assert abs(study.share.value - expected) < 4 * np.sqrt(expected * (1 - expected) / 4000)
    np.testing.assert_array_equal(study.kept, study.values["force"] > low)
    np.testing.assert_allclose(study.distance, np.log(study.values["force"] / low), atol=1e-9)
    assert study.exact["force"].value == 1.0  # the only one: exact, the rig is nominal
    normal = tolerance_study(RIG, 3.18, {"force": 0.5}, samples=4000, distribution="normal")
    assert abs(normal.values["force"].std() / 0.25 - 1) < 0.05


def test_intervals_cover_the_truth_as_often_as_they_say():
    trials = np.random.default_rng(5).random((2000, 300))
    for truth in (0.05, 0.5, 0.97):
        intervals = [share(trial < truth) for trial in trials]
        covered = np.mean([one.low <= truth <= one.high for one in intervals])
        assert 0.93 < covered < 0.975
    assert share(np.ones(10, dtype=bool)).high == 1.0 and share(np.ones(10, dtype=bool)).low < 0.8


def test_every_rig_is_judged_as_the_folds_judge_it():
    study = tolerance_study(RIG, 3.18, TOLERANCES, samples=60, seed=3)
    for i, kept in enumerate(study.kept):
        rig, force = replaced(RIG, 3.18, {name: float(values[i]) for name, values in study.values.items()})
        assert kept == ("inner" in [curve.kind for curve in detached_curves(rig, force)])
    assert 0 < study.kept.sum() < 60


def test_the_same_seed_gives_the_same_study():
    one, two, other = (tolerance_study(RIG, 3.18, TOLERANCES, samples=500, seed=seed) for seed in (1, 1, 2))
    assert all(np.array_equal(one.values[name], two.values[name]) for name in TOLERANCES)
    assert repr(one.share) == repr(two.share) and np.array_equal(one.kept, two.kept)
    assert not np.array_equal(one.values["d0"], other.values["d0"])


def test_the_shaker_damping_matters_most_at_the_papers_force():
    study = tolerance_study(RIG, 3.18, TOLERANCES, samples=2000)
    assert study.ranking[0] == "cs" and study.exact["cs"].low > study.share.high
    assert study.alone["d0"].value == 1.0 and study.alone["cs"].high < 0.9
    assert 0.7 < study.share.value < 0.9
    assert list(study.table().index) == list(study.ranking) and "cs" in study.summary()
    assert tolerance_study(RIG, 4.5, TOLERANCES, samples=500).share.value == 1.0


def test_slack_wires_count_as_lost():
    study = tolerance_study(RIG, 4.5, {"d0": 6e-6}, samples=400)
    assert not study.kept[study.values["d0"] > RIG.d].any() and study.kept.any()


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"samples": 0}, "samples = 0 is not allowed"),
        ({"distribution": "flat"}, "distribution = 'flat' is not allowed"),
        ({"kind": "all"}, "kind = 'all' is not allowed"),
        ({"force": 0}, "force = 0 N is not allowed"),
        ({"tolerances": {"Rm": 1}}, "quantity = 'Rm' is not allowed"),
    ],
)
def test_what_is_not_allowed_is_named(changes, message):
    with pytest.raises(ValueError, match=message):
        tolerance_study(**({"parameters": RIG, "force": 3.18, "tolerances": {"force": 0.1}} | changes))
