"""Parameter sets: the paper's tables, the two scalings against each other, and what is refused."""

import dataclasses

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from rigsim import OscillatorParameters, RigParameters
from rigsim.parameters import Nondimensional, oscillator_of

RIG = RigParameters()


def test_defaults_are_tables_1_and_2():
    printed = {
        "ms": 0.154, "ks": 1.88e4, "cs": 9.86, "m": 0.0052, "k": 4e4, "c": 0.026,
        "d": 0.034, "d0": 0.033997, "Lm": 0.025, "Rm": 0.004, "LG": 0.025 / 8, "gravity": 9.81,
    }  # fmt: skip
    assert {name: getattr(RIG, name) for name in printed} == printed
    assert RIG.wire_sets == 2 and not RIG.tension_only
    assert RIG.wire_damping == RIG.rocking_damping == 0


def test_stiffnesses_are_those_of_equation_2():
    """k1 as the text prints it; k3 is 1.38396e8, not the printed 1.382e8."""
    assert RIG.k1 == pytest.approx(28.235, abs=5e-4)
    assert RIG.k3 == pytest.approx(1.38396e8, rel=5e-6)
    assert RIG.oscillator == OscillatorParameters(0.154, 1.88e4, 9.86, 0.0052, 0.026, RIG.k1, RIG.k3)
    assert oscillator_of(RIG) == oscillator_of(RIG.oscillator) == RIG.oscillator


def test_stiffnesses_are_derivatives_of_the_exact_force():
    """Eq. (2) against differences of Eq. (1) in extended precision."""
    k, d, d0, h = (np.longdouble(value) for value in (RIG.k, RIG.d, RIG.d0, 1e-4))

    def force(z):
        return 8 * k * z * (1 - d0 / np.sqrt(z * z + d * d))

    z = h * np.arange(1, 4)
    odd = np.stack([z, z**3, z**5], axis=1).astype(float)
    slope, cube, _ = np.linalg.solve(odd / odd.max(axis=0), force(z).astype(float)) / odd.max(axis=0)
    assert slope == pytest.approx(RIG.k1, rel=1e-9)
    assert cube == pytest.approx(RIG.k3, rel=1e-6)


def test_nondimensional_is_table_5():
    group = RIG.nondimensional(3.18)
    assert round(group.mu, 3) == 0.034
    assert int(group.zeta_s * 1000) / 1000 == 0.091  # truncated in the paper, not rounded
    assert round(group.zeta, 3) == 0.007
    assert round(group.Omega0, 3) == 0.211
    assert round(group.gamma, 3) == 0.006


def test_nondimensional_equations_are_the_dimensional_ones():
    """Eqs. (4a, b) times their scales give Eqs. (3a, b) at an arbitrary state."""
    p, force = RIG.oscillator, 3.18
    g = p.nondimensional(force)
    x0, w_s = force / p.ks, np.sqrt(p.ks / p.ms)
    xs, vs, a_s, z, vz, az, f = np.random.default_rng(1).normal(size=7) * [1e-4, 1e-2, 1, 1e-3, 1e-1, 10, 1]
    ys, dys, ddys, w, dw, ddw = (
        xs / x0,
        vs / (x0 * w_s),
        a_s / (x0 * w_s**2),
        z / x0,
        vz / (x0 * w_s),
        az / (x0 * w_s**2),
    )
    suspension = p.c * vz + p.k1 * z + p.k3 * z**3
    residual_a = p.ms * a_s + p.cs * vs + p.ks * xs + suspension - f
    residual_b = p.m * a_s - p.m * az - suspension
    scaled_b = ddw + 2 * g.zeta * dw + g.Omega0**2 * w + g.gamma * w**3 - ddys
    scaled_a = (1 + g.mu) * ddys + 2 * g.zeta_s * dys + ys - g.mu * ddw - f / force
    assert -residual_b / (p.m * x0 * w_s**2) == pytest.approx(scaled_b, rel=1e-12)
    # Eq. (4a) is (3a) with the suspension's force taken from (3b).
    assert (residual_a + residual_b) / force == pytest.approx(scaled_a, rel=1e-12)


size = st.floats(1e-3, 1e3)


@hypothesis.given(st.builds(Nondimensional, *[size] * 5), size, size, size)
def test_scaling_there_and_back(group, ms, ks, force):
    back = OscillatorParameters.from_nondimensional(
        *dataclasses.astuple(group), ms=ms, ks=ks, force=force
    ).nondimensional(force)
    np.testing.assert_allclose(dataclasses.astuple(back), dataclasses.astuple(group), rtol=1e-12)


@pytest.mark.parametrize("k", [4e4, tuple(np.linspace(1e4, 8e4, 8))])
def test_single_set_is_as_stiff(k):
    rig = RIG.replace(k=k)
    single = rig.single_set()
    assert single.wire_sets == 1 and single.set_positions == (0.0,)
    assert single.k1 == pytest.approx(rig.k1, rel=1e-12)
    assert single.k3 == pytest.approx(rig.k3, rel=1e-12)
    assert single.single_set() is single


def test_sets_lie_on_the_cylinder_about_P():
    assert RIG.set_positions == pytest.approx((-0.009375, 0.009375))
    assert RIG.replace(LG=-RIG.LG).set_positions == RIG.set_positions
    assert RIG.replace(set_half_spacing=0.003).set_positions == (-0.003, 0.003)
    assert RIG.set_positions[1] + RIG.LG == pytest.approx(RIG.Lm / 2)


def test_the_sets_middle_may_lie_anywhere_on_the_cylinder():
    middle = RIG.replace(set_centre=RIG.LG)
    assert middle.set_positions == pytest.approx((RIG.LG - RIG.Lm / 2, RIG.LG + RIG.Lm / 2))
    assert middle.single_set().set_positions == (RIG.LG,)
    end = RIG.replace(set_centre=RIG.LG - RIG.Lm / 2)
    assert end.half_spacing == 0 and end.set_positions == (end.set_centre,) * 2
    assert RIG.replace(set_centre=-0.002).half_spacing == pytest.approx(0.0125 - 0.005125)
    assert RIG.replace(set_centre=0.001, set_half_spacing=0.003).set_positions == pytest.approx((-0.002, 0.004))
    assert middle.k1 == RIG.k1 and middle.single_set().double_set() == middle


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ms": 0}, "ms = 0 kg is not allowed; expected a finite number above 0"),
        ({"ks": -1}, "ks = -1 N/m is not allowed"),
        ({"cs": -1e-9}, "cs = -1e-09 N s/m is not allowed; expected a finite number of at least 0"),
        ({"m": float("nan")}, "m = nan kg is not allowed"),
        ({"c": float("inf")}, "c = inf N s/m is not allowed"),
        (
            {"LG": 0.012500001},
            "LG = 0.012500001 m is not allowed; P must lie on the cylinder, abs(LG) < Lm/2 = 0.0125 m",
        ),
        (
            {"set_half_spacing": 0.009375001},
            "set_half_spacing = 0.009375001 m is not allowed; expected a number from 0 to 0.009375 m",
        ),
        ({"LG": 0.0125}, "LG = 0.0125 m is not allowed"),
        ({"LG": -0.02}, "LG = -0.02 m is not allowed"),
        ({"wire_sets": 3}, "wire_sets = 3 is not allowed"),
        ({"wire_sets": 1.5}, "wire_sets = 1.5 is not allowed"),
        ({"set_half_spacing": 0.0094}, "set_half_spacing = 0.0094 m is not allowed"),
        ({"set_half_spacing": -0.001}, "set_half_spacing = -0.001 m is not allowed"),
        ({"wire_sets": 1, "set_half_spacing": 0.001}, "set_half_spacing = 0.001 m is not allowed with wire_sets = 1"),
        (
            {"set_centre": 0.0157},
            "set_centre = 0.0157 m is not allowed; expected a number from -0.009375 to 0.015625 m",
        ),
        ({"set_centre": None}, "set_centre = None is not a number"),
        (
            {"set_centre": 0.003125, "set_half_spacing": 0.0126},
            "set_half_spacing = 0.0126 m is not allowed; expected a number from 0 to 0.0125 m",
        ),
        ({"k": -4e4}, "k[0] = -40000 N/m is not allowed"),
        ({"k": 0}, "k = 0 N/m is not allowed"),
        ({"k": [4e4] * 4}, "k has 4 values; expected 1 or 8"),
        ({"k": [4e4] * 7 + [float("nan")]}, "k[7] = nan N/m is not allowed"),
        ({"tension_only": "yes"}, "tension_only = 'yes' is not allowed"),
        ({"mass": 1}, "field of RigParameters = 'mass' is not allowed"),
        ({"gravity": -9.81}, "gravity = -9.81 m/s^2 is not allowed"),
    ],
)
def test_bad_rig_is_refused_in_one_line(changes, message):
    with pytest.raises(ValueError) as caught:
        RIG.replace(**changes)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)
    if "mass" not in changes:
        with pytest.raises(ValueError):
            RigParameters(**changes)


@pytest.mark.parametrize("name", [field.name for field in dataclasses.fields(OscillatorParameters)])
def test_bad_oscillator_is_refused(name):
    for value in (-1.0, float("nan"), "x"):
        with pytest.raises(ValueError, match=f"^{name} = "):
            RIG.oscillator.replace(**{name: value})


def test_force_must_be_above_zero():
    for force in (0, -3.18, float("nan")):
        with pytest.raises(ValueError, match=r"force = .* N is not allowed; expected a finite number above 0 N"):
            RIG.nondimensional(force)


def test_other_kinds_are_no_parameters():
    with pytest.raises(ValueError, match="expected RigParameters or OscillatorParameters"):
        oscillator_of({"ms": 0.154})


def test_sets_are_frozen_values():
    with pytest.raises(dataclasses.FrozenInstanceError):
        RIG.ms = 1
    assert RIG.replace(c=0.03) != RIG == RIG.replace(c=0.026)
    assert hash(RIG) == hash(RigParameters())
    with pytest.raises(ValueError):
        RIG.wire_stiffness[0] = 1


def test_tables_name_units_and_meanings():
    table = RIG.table()
    assert table.loc["cs", "value"] == 9.86 and table.loc["cs", "unit"] == "N s/m"
    assert table["meaning"].str.len().min() > 5
    assert "0.154" in RIG._repr_html_()
