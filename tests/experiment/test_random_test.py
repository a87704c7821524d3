"""Time histories under sampled forces: sample conventions against SciPy's linear systems, and reproducibility."""

import numpy as np
import pytest
import scipy.signal

from rigsim.experiment.random_test import random_test, simulate
from rigsim.model.oscillator import matrices
from rigsim.model.planar import static_equilibrium
from rigsim.parameters import RigParameters

RIG = RigParameters()
# The same k1 from long, soft wires: k3 falls by four orders of magnitude, and without gravity the rig is linear.
LINEAR = RIG.replace(k=RIG.k1 / 4, d0=RIG.d / 2, gravity=0, c=0.1)


def linear_system(parameters):
    """State space of Eqs. (3a, b) without k3: force on the shaker to [xs, x]."""
    mass, damping, stiffness = matrices(parameters)
    inverse, zero = np.linalg.inv(mass), np.zeros((2, 2))
    A = np.block([[zero, np.eye(2)], [-inverse @ stiffness, -inverse @ damping]])
    return A, np.concatenate([[0, 0], inverse[:, 0]])[:, None], np.eye(2, 4), np.zeros((2, 1))


@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_a_linear_rig_answers_as_the_linear_system_under_either_hold(hold):
    rate = 500.0  # coarse, so that a force half a sample early or late would show
    force = np.random.default_rng(1).normal(0, 0.1, 1000)
    record = simulate(LINEAR, force, rate, hold, step=5e-5)
    _, expected, _ = scipy.signal.lsim(linear_system(LINEAR), force, record.time, interp=hold == "linear")
    for found, wanted in zip((record.shaker, record.mass), expected.T, strict=True):
        assert abs(found - wanted).max() < 2e-4 * abs(wanted).max()


@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_a_sample_is_taken_before_its_force_acts(hold):
    first = simulate(RIG.replace(gravity=0), [1.0, 0.0, 0.0, 0.0], 2000, hold)
    assert first.shaker[0] == 0 < first.shaker[1]
    last = simulate(RIG.replace(gravity=0), [0.0, 0.0, 0.0, 1.0], 2000, hold)
    # held to the right, the last sample never acts; run to, it acts before its instant
    assert (abs(last.shaker).max() == 0) == (hold == "zero")


@pytest.mark.parametrize("rms", [1.115, 0.3])
def test_the_force_has_the_exact_rms_and_is_white(rms):
    record = random_test(RIG, rms=rms, duration=2)
    assert np.sqrt(np.mean(record.force**2)) == pytest.approx(rms, rel=1e-15)
    assert record.force.size == 4000
    correlation = np.correlate(record.force, record.force, "full")[4000:4050] / (4000 * rms**2)
    assert abs(correlation).max() < 4 / np.sqrt(4000)
    assert abs(scipy.stats.kurtosis(record.force)) < 0.3


def test_the_same_seed_gives_the_same_bits():
    one, two, other = (random_test(RIG, duration=0.6, seed=seed) for seed in (5, 5, 6))
    for name in ("force", "shaker", "mass", "tilt"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert (one.force != other.force).all()
    assert one.seed == 5 and one.start == "equilibrium" and one.hold == "zero" and one.parameters == RIG


def test_it_starts_in_equilibrium_unless_told_otherwise():
    single = RIG.single_set()
    assert random_test(single, duration=0.1).tilt[0] == static_equilibrium(single).tilt
    assert random_test(single, duration=0.1, start="rest").tilt[0] == 0


@pytest.mark.parametrize("sample_rate", [2000, 1999, 2048, 44100 / 7, 2e5, 1e4])
@pytest.mark.parametrize("step", [5e-5, 1e-4])
def test_the_step_divides_the_sample_interval(sample_rate, step):
    record = simulate(RIG, np.ones(20), sample_rate, step=step)
    substeps = 1 / (sample_rate * record.step)
    assert substeps == pytest.approx(round(substeps), rel=1e-12)
    assert record.step <= step * (1 + 1e-9)
    assert record.step > step / 2 or round(substeps) == 1
    # A whole divisor is taken as it is, not halved by rounding.
    if sample_rate in (2000, 1e4):
        assert record.step == pytest.approx(step, rel=1e-12)


def test_the_motion_does_not_depend_on_the_sample_rate():
    slow = simulate(RIG, np.ones(200), 1000, step=5e-5)
    fast = simulate(RIG, np.ones(400), 2000, step=5e-5)
    np.testing.assert_allclose(slow.mass, fast.mass[::2], rtol=0, atol=1e-12 * abs(slow.mass).max())


def test_long_records_are_made_in_blocks_without_seams():
    force = np.random.default_rng(1).normal(size=2500)
    seen = []
    whole = simulate(RIG, force, 4000, step=1e-4, progress=lambda done, of: seen.append((done, of)))
    part = simulate(RIG, force[:1500], 4000, step=1e-4)
    np.testing.assert_array_equal(part.mass, whole.mass[:1500])
    assert seen[-1] == (2500, 2500) and len(seen) >= 3


def test_a_force_that_flings_the_rig_apart_is_named():
    with pytest.raises(ValueError, match=r"force of up to 1e\+09 N .* at t = .* s; expected a weaker force"):
        simulate(RIG, [0.0, 1e9, 0.0, 0.0], 2000)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"force": [1.0, np.nan]}, r"force\[1\] = nan N"),
        ({"force": [1.0]}, "force has 1 elements; expected at least 2"),
        ({"force": [[1.0, 2.0]]}, "force has 2 dimensions"),
        ({"sample_rate": 0}, "sample_rate = 0 Hz"),
        ({"hold": "band-limited"}, "hold = 'band-limited' is not allowed; expected one of 'zero', 'linear'"),
        ({"start": "moving"}, "start = 'moving'"),
        ({"step": -1e-5}, "step = -1e-05 s"),
        ({"step": 1.0}, "step = 0.0005 s is unstable; expected above 0 and below"),
        ({"parameters": RIG.oscillator}, "the multi-body rig expects RigParameters"),
        ({"parameters": RIG.single_set().replace(m=500), "start": "equilibrium"}, "past its wires' reach"),
    ],
)
def test_bad_input_to_simulate_is_named(changes, named):
    with pytest.raises(ValueError, match=named):
        simulate(**{"parameters": RIG, "force": [1.0, 2.0], "sample_rate": 2000} | changes)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"rms": -1}, "rms = -1 N"),
        ({"duration": 0}, "duration = 0 s"),
        ({"duration": 1e-4}, "number of samples = 0 is not allowed"),
        ({"seed": -1}, "seed = -1"),
        ({"seed": 0.5}, "seed = 0.5"),
        ({"sample_rate": np.inf}, "sample_rate = inf Hz"),
    ],
)
def test_bad_input_to_random_test_is_named(changes, named):
    with pytest.raises(ValueError, match=named):
        random_test(RIG, **changes)
