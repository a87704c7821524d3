"""The ledger's rows: what the paper prints, and for each of them a function that computes it from the evidence."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..model.oscillator import oscillator_modes
from ..model.wires import cubic_law_error, suspension_force
from ..parameters import Nondimensional, OscillatorParameters, RigParameters
from ..results import Status
from ..theory.detached import detached_curves, force_scenario

# The paper's numbers as it prints them, the one place where they are written down: section -> symbol -> (text, unit).
PRINTED = {
    "Table 1": {
        "ms": ("0.154", "kg"), "ks": ("1.88e4", "N/m"), "cs": ("9.86", "N s/m"),
        "m": ("0.0052", "kg"), "k": ("4e4", "N/m"), "c": ("0.026", "N s/m"),
    },
    "Table 2": {
        "d": ("0.034", "m"), "d0": ("0.033997", "m"), "Lm": ("0.025", "m"), "Rm": ("0.004", "m"),
        "LG/Lm": ("0.125", ""),
    },
    "Eq. (2)": {"k1": ("28.235", "N/m"), "k3": ("1.382e8", "N/m^3")},
    "Tests": {
        "gravity": ("9.81", "m/s^2"), "random force, rms": ("1.115", "N"), "sample rate": ("2000", "Hz"),
        "length of the record": ("100", "s"), "force F": ("3.18", "N"), "length of a sine test": ("3", "s"),
    },
    "Fig. 3": {"mean k3": ("1.380e8", "N/m^3")},
    "Table 3": {
        "fn1": ("11.7186", "Hz"), "zeta1": ("0.0339", ""), "fn2": ("55.7434", "Hz"), "zeta2": ("0.0917", ""),
    },
    "Table 4": {
        "ms": ("0.1540", "kg"), "ks": ("1.8862e4", "N/m"), "cs": ("9.8642", "N s/m"),
        "m": ("0.0052", "kg"), "k1": ("28.2212", "N/m"), "c": ("0.0260", "N s/m"),
    },
    "Table 5": {
        "mu": ("0.034", ""), "zeta_s": ("0.091", ""), "zeta": ("0.007", ""), "Omega0": ("0.211", ""),
        "gamma": ("0.006", ""),
    },
    "Claims": {"error of Table 4": ("0.06", "%"), "harmonics": ("5", "%")},
}  # fmt: skip

_LIMIT = float(PRINTED["Claims"]["harmonics"][0]) / 100
_RANDOM_SETS = 2000


@dataclass(frozen=True)
class Number:
    """A printed number: ``compute(evidence)`` gives ours; ``cause``, text or a function too, says why they differ."""

    section: str
    item: str
    unit: str
    printed: str
    compute: Callable
    cause: str | Callable = ""


@dataclass(frozen=True)
class Claim:
    """A claim in words: ``compute(evidence)`` gives a verdict ("yes", "partly", "no") and what was found."""

    section: str
    claim: str
    compute: Callable
    cause: str | Callable = ""


def printed(section, symbol):
    """A printed number as a float."""
    return float(PRINTED[section][symbol][0])


def _numbers(section, compute, names=None, causes=None):
    """A `Number` for each symbol of a printed table; ``compute(evidence, symbol)``."""
    return [
        Number(
            section, (names or {}).get(symbol, symbol), unit, text, lambda e, s=symbol: compute(e, s),
            (causes or {}).get(symbol, ""),
        )
        for symbol, (text, unit) in PRINTED[section].items()
    ]  # fmt: skip


def _number(section, symbol, item, compute, cause=""):
    """A further way to compute a number that is printed once."""
    text, unit = PRINTED[section][symbol]
    return Number(section, item, unit, text, compute, cause)


def _percent(value, digits=2):
    return f"{100 * value:.{digits}g} %"


# Table 4's values as printed, with the computed k3: what the paper's own next steps started from.
def _printed_oscillator(e):
    values = {symbol: printed("Table 4", symbol) for symbol in PRINTED["Table 4"]}
    return OscillatorParameters(**values, k3=e.theory.k3)


def _with(e, **changes):
    """The rig's own oscillator with some of its numbers replaced by printed ones."""
    return e.rig.oscillator.replace(**changes)


# Tests and geometry


def _conditions(e, symbol):
    first = e.experiment.tests[0]
    return {
        "gravity": lambda: e.rig.gravity,
        "random force, rms": lambda: np.sqrt(np.mean(e.record.force**2)),
        "sample rate": lambda: e.record.sample_rate,
        "length of the record": lambda: e.record.duration,
        "force F": lambda: first.force[0],
        "length of a sine test": lambda: round(first.time[-1], 6),
    }[symbol]()


def _taylor(e):
    """Eq. (2) against a polynomial through Eq. (1) near z = 0."""
    z = 1e-2 * e.rig.d * np.cos(np.pi * (np.arange(16) + 0.5) / 16)
    powers = z[:, None] ** np.arange(1, 8, 2)
    scale = np.abs(powers).max(axis=0)
    fitted = np.linalg.lstsq(powers / scale, suspension_force(z, e.rig), rcond=None)[0] / scale
    cubic = e.rig.k3 * np.abs(z).max() ** 2
    error = max(abs(fitted[0] - e.rig.k1) / cubic, abs(fitted[1] / e.rig.k3 - 1))
    return "yes" if error < 1e-4 else "no", f"a polynomial through Eq. (1) gives the same k1 and k3 to {error:.0e}"


def fitted_amplitude(rig, k3):
    """Largest abs(z) (m) up to which a least-squares k1 z + k3 z^3 of Eq. (1) has this k3, or NaN where none has."""
    z = np.linspace(-1, 1, 401)

    def fitted(reach):
        powers = np.column_stack([z, z**3])
        return np.linalg.lstsq(powers, suspension_force(reach * z, rig), rcond=None)[0][1] / reach**3

    low, high = 1e-3 * rig.d, 0.3 * rig.d
    if not fitted(high) < k3 < fitted(low):
        return np.nan
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fitted(middle) > k3 else (low, middle)
    return 0.5 * (low + high)


def _k3_cause(e):
    reach = fitted_amplitude(e.rig, printed("Eq. (2)", "k3"))
    return (
        f"Eq. (2) with Table 2 gives {e.rig.k3:.5e}; the printed value is what a cubic fitted to Eq. (1) has up to "
        f"|z| = {1e3 * reach:.2g} mm, and also our mean over 2-80 Hz in the paper's reading "
        f"({e.paper.nonlinear_mean((2, 80)):.4e})"
    )


def _k1_range(e):
    half = 0.5e-6  # m: Table 2 prints d0 to a micrometre
    change = e.rig.wire_stiffness.sum() * half / e.rig.d
    return (
        "yes" if change < 5e-5 * e.rig.k1 else "no",
        f"k1 is {e.rig.k1:.2f} ± {change:.2f} N/m" + (f", ±{_percent(change / e.rig.k1)}" if e.rig.k1 else ""),
    )


def _cubic_error(e):
    largest = e.trials["relative"].max()
    error = float(cubic_law_error(largest, e.rig))
    return "yes" if abs(error) < 0.01 else "no", f"error of the force {_percent(error)} at |z| = {1e3 * largest:.2f} mm"


def _slightly_tightened(e):
    tension = e.rig.wire_stiffness.mean() * (e.rig.d - e.rig.d0)
    weight = e.rig.m * e.rig.gravity
    strain = (e.rig.d - e.rig.d0) / e.rig.d0
    return (
        "yes" if strain < 1e-3 else "no",
        f"a strain of {strain:.2g}, {tension:.2g} N a wire; the mass weighs {weight:.2g} N",
    )


# Identification


def _mode(e, symbol):
    modes = e.paper.modes
    return (modes.frequency if symbol.startswith("fn") else modes.damping)[int(symbol[-1]) - 1]


def _likely_ks():
    """Table 4's ks to four digits: what Table 1's may have been meant to say, as text."""
    return f"{printed('Table 4', 'ks'):.3e}".replace("e+0", "e")


def _ks_cause(e):
    likely = _likely_ks()
    value = oscillator_modes(_with(e, ks=float(likely))).frequency[1]
    return (
        f"the paper's simulation seems to have had ks = {likely} N/m, not Table 1's {PRINTED['Table 1']['ks'][0]}: "
        f"with it mode 2 lies at {value:.2f} Hz, where Table 3 has it"
    )


def _table_4_cause(e):
    error = printed("Table 4", "ks") / float(_likely_ks()) - 1
    return f"if Table 1's ks was meant to be {_likely_ks()} N/m, ks is off by {100 * error:+.2g} % and the claim holds"


def _second_mode_cause(e):
    ks = printed("Table 4", "ks")
    value = oscillator_modes(_with(e, ks=ks)).frequency[1]
    return f"follows from Table 4's ks, not Table 1's: with {ks:g} N/m it is {value:.4f} Hz"


def _second_damping_cause(e):
    changes = {symbol: printed("Table 4", symbol) for symbol in ("ks", "cs")}
    value = oscillator_modes(_with(e, **changes)).damping[1]
    return f"follows from Table 4's ks and cs: with them it is {value:.4f}"


def _table_4_error(e):
    errors = {s: printed("Table 4", s) / printed("Table 1", s) - 1 for s in ("ms", "ks", "cs", "m", "c")}
    errors["k1"] = printed("Table 4", "k1") / printed("Eq. (2)", "k1") - 1
    worst = max(errors, key=lambda s: abs(errors[s]))
    limit = printed("Claims", "error of Table 4") / 100
    others = max(abs(value) for symbol, value in errors.items() if symbol != worst)
    return (
        "yes" if abs(errors[worst]) < limit else "no",
        f"as printed, {worst} is off by {100 * errors[worst]:+.2f} %; the others by at most {_percent(others)}",
    )


def _errors(e, reading):
    """Relative errors of our Table 4 by symbol, of what is not zero."""
    identified, nominal = e.readings[reading].parameters, e.rig.oscillator
    symbols = [symbol for symbol in PRINTED["Table 4"] if getattr(nominal, symbol)]
    return {symbol: getattr(identified, symbol) / getattr(nominal, symbol) - 1 for symbol in symbols}


def _our_error(e, reading):
    errors = _errors(e, reading)
    worst = max(errors, key=lambda s: abs(errors[s]))
    limit = printed("Claims", "error of Table 4") / 100
    return "yes" if abs(
        errors[worst]
    ) < limit else "no", f"largest error of ours {100 * errors[worst]:+.3g} %, of {worst}"


def _as_printed_9(e):
    errors = _errors(e, "none")
    listed = ", ".join(f"{s} {100 * error:+.2g} %" for s, error in errors.items() if abs(error) > 5e-3)
    good = max(map(abs, errors.values())) < 5e-3
    return "yes" if good else "no", f"read so, the parameters are off: {listed}" if listed else "read so, none is off"


def _near_nominal(e):
    mean = e.paper.nonlinear_mean((5, 100))
    return (
        "yes" if abs(mean / e.rig.k3 - 1) < 0.01 else "no",
        f"mean over 5-100 Hz {100 * (mean / e.rig.k3 - 1):+.2f} % from Eq. (2), in the right reading "
        f"{100 * (e.right.nonlinear_mean((5, 100)) / e.rig.k3 - 1):+.3f} %",
    )


def _flat(e):
    real = e.paper.nonlinear_coefficient.real
    spread, right = np.ptp(real) / real.mean(), np.ptp(e.right.nonlinear_coefficient.real) / e.right.k3
    return (
        "yes" if spread < 0.02 else "no",
        f"the real part varies by {_percent(spread)} over 2-80 Hz, in the right reading by {_percent(right)}",
    )


def _imaginary(e):
    """Largest and mean size of the imaginary part over the mean real one, in the paper's reading and the right one."""
    shares = []
    for reading in (e.paper, e.right):
        coefficient = reading.nonlinear_coefficient
        shares.append(np.abs(coefficient.imag).mean() / coefficient.real.mean())
    return (
        "yes" if shares[0] < 0.1 else "no",
        f"on average {_percent(shares[0])} of the real part over 2-80 Hz; {_percent(shares[1], 1)} in the right one",
    )


def _closed_form_mean(e):
    frequency = np.arange(50, 1001) / 10
    theta = np.pi * frequency / e.record.sample_rate
    return e.rig.k3 * np.mean(theta / np.tan(theta))


def _overlaid(e):
    entries = [0, 1, 1], [0, 0, 1]
    estimated, fitted = (r[:, *entries] for r in (e.paper.receptance, e.paper.fitted_receptance))
    distance = np.abs(fitted / estimated - 1).max()
    return "yes" if distance < 0.01 else "no", f"largest distance {_percent(distance)} of H11, H21, H22 over 2-80 Hz"


def _jump(e):
    values = e.paper.singular_values
    jumps = values[:-1] / values[1:]
    after = int(jumps.argmax()) + 1
    return (
        "yes" if after == 4 and jumps[3] > 100 else "no",
        f"the largest fall is after number {after}, by a factor of {jumps.max():.2g}: two modes",
    )


def _gravity_harmless(e):
    tilt = np.degrees(e.statics[0][0].tilt)
    k3 = e.right.k3 / e.rig.k3 - 1
    good = abs(k3) < 0.01 and _our_error(e, "force")[0] == "yes"
    return "yes" if good else "no", f"at a tilt of {abs(tilt):.2g} degrees, k3 {100 * k3:+.2g} %, " + _our_error(
        e, "force"
    )[1]


# Theory


def amplitude_equation(group, Omega):
    """Coefficients a, b, c, d of Eq. (5a) by Eqs. (6a-g) as printed, arrays that broadcast."""
    mu, zeta_s, zeta, Omega0, gamma = group
    detuning, square = 1 - Omega**2 * (1 + mu), Omega0**2 - Omega**2
    e = detuning**2 + 4 * zeta_s**2 * Omega**2
    g = 1.5 * mu * gamma * detuning
    h = 2 * mu * detuning * square - mu**2 * Omega**4 - 8 * mu * zeta_s * zeta * Omega**2
    return (
        9 * gamma**2 / 16,
        1.5 * gamma * square - g * Omega**4 / e,
        square**2 + 4 * zeta**2 * Omega**2 - h * Omega**4 / e,
        -(Omega**4) / e,
    )


def _discriminant_rule(e):
    """The sign of the printed discriminant against the roots of (5a), for oscillators drawn around the rig."""
    rng = np.random.default_rng(2014)
    group = e.rig.nondimensional(e.force)
    centre = np.array([getattr(group, name) for name in Nondimensional.__dataclass_fields__])
    drawn = centre[:, None] * np.exp(rng.normal(0, 1, (5, _RANDOM_SETS)))
    Omega = rng.uniform(0.05, 2.5, _RANDOM_SETS)
    a, b, c, d = amplitude_equation(drawn, Omega)
    discriminant = 18 * a * b * c * d - 27 * a**2 * d**2 - 4 * b**3 * d + b**2 * c**2 - 4 * c**3 * a
    wrong, several = 0, 0
    for coefficients, sign in zip(np.column_stack([a, b, c, d]), np.sign(discriminant), strict=True):
        roots = np.roots(coefficients)
        count = int(((np.abs(roots.imag) < 1e-7 * np.abs(roots)) & (roots.real > 0)).sum())
        wrong += count != (3 if sign > 0 else 1)
        several += count == 3
    return (
        "yes" if not wrong else "no",
        f"{_RANDOM_SETS} random oscillators, {several} of them with three solutions: {wrong} exceptions",
    )


def _two_of_three_stable(e):
    several = e.curve.count == 3
    stable = e.curve.stable[several].sum(axis=1)
    if not stable.size:
        return "no", "there are never three solutions"
    usual = e.curve.stable[several] == [True, False, True]
    unusual = e.curve.frequency[several][~usual.all(axis=1)]
    if not unusual.size:
        return "yes", f"at each of {stable.size} frequencies from 10 to 80 Hz"
    return "partly", (
        f"at {_percent(usual.all(axis=1).mean(), 3)} of the frequencies; between {unusual.min():.1f} and "
        f"{unusual.max():.1f} Hz from {stable.min()} to {stable.max()} of the three are"
    )


def _detached(e):
    listed = ", ".join(f"{curve.kind} from {curve.low:.2f} to {curve.high:.2f} Hz" for curve in e.detached)
    good = [curve.kind for curve in e.detached] == ["inner"]
    return "yes" if good else "no", f"at {e.force:g} N: {listed or 'none'}"


def _inside_which(e):
    """Whether the two solutions of the detached curve lie below the third, by displacement."""
    at = e.inside(e.curve.frequency) & (e.curve.count == 3)
    if not at.any():
        return "no", "there is no detached curve"
    below = {
        name: (np.abs(getattr(e.curve, name)[at])[:, :2].max(axis=1) < np.abs(getattr(e.curve, name)[at])[:, 2]).mean()
        for name in ("relative", "mass", "shaker")
    }
    listed = ", ".join(f"{name} {100 * share:.3g} %" for name, share in below.items())
    return "yes" if below["relative"] == below["mass"] == 1 else "no", f"it lies below the main curve at: {listed}"


def _margin(e):
    """Forces at which an inner curve begins and ends to exist, around the force of the tests."""
    changes = [
        (event.force, event.after.count("inner") > event.before.count("inner"))
        for event in force_scenario(e.theory)
        if event.after.count("inner") != event.before.count("inner")
    ]
    told = ", ".join(
        f"{'begins' if begins else 'ends'} at {force:.3f} N ({100 * (force / e.force - 1):+.2g} %)"
        for force, begins in changes
    )
    inner = any(curve.kind == "inner" for curve in e.detached)
    return "yes" if inner else "no", f"an inner curve {told}" if told else "there is no inner curve at any force"


def _quasi_zero(e):
    softest = e.theory.replace(k1=0.0)
    found = detached_curves(softest, e.force)
    kinds = [curve.kind for curve in found]
    births = [
        event.force for event in force_scenario(softest) if event.after.count("inner") > event.before.count("inner")
    ]
    listed = ", ".join(f"{curve.kind} {curve.low:.1f}-{curve.high:.1f} Hz" for curve in found)
    first = f"; the first one at {min(births):.3f} N" if births else ""
    return "yes" if "inner" in kinds else "no", f"with k1 = 0 at {e.force:g} N: {listed or 'no detached curve'}{first}"


# Harmonic response


def _share(e, began, branch, where):
    """Verdict on the share of frequencies ``where`` tests that ``began`` so reach ``branch``."""
    trials = e.trials[where(e, e.trials["frequency"]) & began(e.trials)]
    if trials.empty:
        return "no", "no test at such a frequency"
    reached = (trials["branch"] == branch).groupby(trials["frequency"]).any()
    told = f"at {reached.sum()} of {reached.size} frequencies"
    if not reached.all():
        lost = reached.index[~reached]
        told += (
            f"; not at {lost[0]:g} Hz"
            if lost.size == 1
            else f"; not at {lost.size} from {lost[0]:g} to {lost[-1]:g} Hz"
        )
    return "yes" if reached.all() else "partly" if reached.mean() > 0.5 else "no", told


def _on_detached(e, frequency):
    return e.inside(frequency)


def _several(e, frequency):
    response = e.experiment.response
    return np.isin(frequency, response.frequency[response.count == 3])


def _settled(e):
    first = e.trials[e.trials["duration"] == e.trials["duration"].min()]
    share = (first["status"] == Status.SETTLED).groupby(first["from rest"]).mean()
    return (
        "yes" if share.min() > 0.99 else "partly" if share.max() > 0.5 else "no",
        f"{_percent(share.get(True, 0), 3)} of the tests from rest and {_percent(share.get(False, 0), 3)} of the "
        f"tapped ones are steady in the last second of {first['duration'].min():g} s",
    )


def _harmonics(e, channel):
    settled = e.trials[e.trials["status"] == Status.SETTLED]
    if settled.empty:
        return "no", "no test settled"
    largest = settled.groupby("branch")[channel].max().sort_values(ascending=False)
    worst = settled.loc[settled[channel].idxmax()]
    listed = ", ".join(f"{_percent(value)} {_where(branch)}" for branch, value in largest.items())
    return (
        "yes" if worst[channel] < _LIMIT else "no",
        f"largest {_percent(worst[channel])}, at {worst['frequency']:g} Hz (by branch: {listed})",
    )


def _where(branch):
    return "where there is one solution" if branch == "only" else f"on {branch}"


def _lower_harmonics(e):
    odd = e.trials[e.trials["status"] == Status.SUBHARMONIC]
    if odd.empty:
        return "yes", f"none in {len(e.trials)} tests"
    rest = int(odd["from rest"].sum())
    return (
        "no",
        f"{len(odd)} of {len(e.trials)} tests, {rest} of them from rest, end in motions with a line below f that "
        f"is up to {odd['below'].max():.2g} times z's line at f, between {odd['frequency'].min():g} and "
        f"{odd['frequency'].max():g} Hz",
    )


def _agreement(e, branches):
    table = e.experiment.table()
    on = table[table["branch"].isin(branches)]
    if on.empty:
        return "no", "no test ended there"
    worst = on.loc[on["distance [%]"].idxmax()]
    return (
        "yes" if worst["distance [%]"] < 5 else "partly",
        f"z of {len(on)} tests within {worst['distance [%]']:.2g} % (at {worst['frequency [Hz]']:g} Hz), in the middle "
        f"{on['distance [%]'].median():.2g} %",
    )


def _reached(e):
    missing = e.experiment.missing()
    listed = ", ".join(f"{'the only one' if branch == 'only' else branch} at {f:g} Hz" for f, branch in missing)
    return (
        "yes" if not missing else "partly",
        f"{len(missing)} stable solutions were reached by no test: {listed}" if missing else "every one was reached",
    )


# Wobbling


def _rocking(modes):
    return modes.frequency[modes.names.index("rocking")]


def _tilt(e):
    two, one = (abs(np.degrees(equilibrium.tilt)) for equilibrium, _ in e.statics)
    return "yes" if two < 0.1 * one else "no", f"at rest {one:.3g} degrees with one set, {two:.2g} with this rig"


def _rocking_mode(e):
    two, one = (_rocking(modes) for _, modes in e.statics)
    return (
        "yes" if two > 80 > one else "no",
        f"the rocking mode lies at {one:.3g} Hz with one set, at {two:.4g} Hz with this rig; the tests end at 80 Hz",
    )


def _tilt_in_motion(e):
    if e.single is None:
        return "no", "there is no detached curve to test"
    frequency = e.single.response.frequency
    same = e.trials[e.trials["frequency"].isin(frequency)]
    two, one = np.degrees(same["tilt"].max()), np.degrees(np.nanmax(e.single.tests[0].tilt))
    return (
        "yes" if two < 0.1 * one else "no",
        f"largest tilt in sine tests {one:.2g} degrees with one set, here {two:.2g}",
    )


def _single_set_misses(e):
    if e.single is None:
        return "no", "there is no detached curve to test"
    branch = e.single.branch[0]
    rest, tapped = np.split(branch, 2)
    return (
        "yes" if (rest == "low").mean() < 1 or (tapped == "high").mean() < 1 else "no",
        f"with one set, in {e.single.tests[0].time[-1]:.0f} s and after one light tap at most, "
        f"{int((rest == 'low').sum())} of {rest.size} tests from rest settle on the low branch and "
        f"{int((tapped == 'high').sum())} of {tapped.size} tapped ones on the high branch; notebook 04 "
        "gives them up to 6 s and sixteen more taps",
    )


_THIRD = "the cubic stiffness makes a third harmonic that grows with the amplitude of z, so on the higher branch"
_ABSORBED = (
    "above 60 Hz the suspended mass works as an absorber: the shaker's line at f is small, its harmonics are not"
)
_EDGE = "this close to the end of the detached curve, the start's transient takes the rig past its low side"
_MODE_NAMES = {
    "fn1": "natural frequency of mode 1", "zeta1": "damping ratio of mode 1",
    "fn2": "natural frequency of mode 2", "zeta2": "damping ratio of mode 2",
}  # fmt: skip

ROWS = (
    *_numbers("Table 1", lambda e, s: e.rig.wire_stiffness.mean() if s == "k" else getattr(e.rig, s)),
    *_numbers("Table 2", lambda e, s: e.rig.LG / e.rig.Lm if s == "LG/Lm" else getattr(e.rig, s)),
    *_numbers("Eq. (2)", lambda e, s: getattr(e.rig, s), causes={"k3": _k3_cause}),
    Claim("Eq. (2)", "k1 = 8k(1 - d0/d) and k3 = 4k d0/d^3 are the Taylor coefficients of Eq. (1)", _taylor),
    Claim(
        "Eq. (2)", "k1 = 28.235 N/m, five digits, follows from Table 2", _k1_range,
        "d0 is printed to a micrometre, and k1 rests on d - d0 = 3 µm",
    ),
    Claim("Eq. (2)", "the cubic law is good enough for the motions tested", _cubic_error),
    Claim("Eq. (2)", "the wires are only slightly tightened", _slightly_tightened),
    *_numbers("Tests", _conditions),
    _number(
        "Fig. 3", "mean k3", "mean k3, the paper's reading, over 5-100 Hz", lambda e: e.paper.nonlinear_mean((5, 100)),
        "the mean depends on the band it is taken over; the paper gives none",
    ),
    _number(
        "Fig. 3", "mean k3", "mean k3, the paper's reading, over 2-80 Hz", lambda e: e.paper.nonlinear_mean((2, 80)),
        "the mean depends on the band it is taken over; the paper gives none",
    ),
    _number(
        "Fig. 3", "mean k3", "mean k3 by theta cot(theta), over 5-100 Hz", _closed_form_mean,
        "closed form of what the paper's reading does to a held force",
    ),
    _number(
        "Fig. 3", "mean k3", "mean k3, the right reading, over 5-100 Hz", lambda e: e.right.nonlinear_mean((5, 100)),
        "z^3 was never held between samples: read without the hold it gives the k3 of Eq. (2), at every frequency",
    ),
    Claim("Fig. 3", "the mean is very close to the nominal value", _near_nominal),
    Claim("Fig. 3", "the coefficient hardly depends on frequency", _flat),
    Claim("Fig. 3", "its imaginary part is an order of magnitude smaller", _imaginary),
    *_numbers(
        "Table 3", _mode, _MODE_NAMES, {"fn2": _second_mode_cause, "zeta2": _second_damping_cause},
    ),
    _number(
        "Table 3", "fn1", "mode 1 from Table 1 and Eq. (2)", lambda e: oscillator_modes(e.rig).frequency[0],
    ),
    _number(
        "Table 3", "fn1", "mode 1 from Table 4 as printed",
        lambda e: oscillator_modes(_printed_oscillator(e)).frequency[0],
        "Table 3's first mode follows from Eq. (2)'s k1, not from Table 4's",
    ),
    _number(
        "Table 3", "fn2", "mode 2 from Table 4 as printed",
        lambda e: oscillator_modes(_printed_oscillator(e)).frequency[1],
        "within what the rounding of Table 4's digits leaves open",
    ),
    _number(
        "Table 3", "zeta2", "damping of mode 2 from Table 4 as printed",
        lambda e: oscillator_modes(_printed_oscillator(e)).damping[1],
    ),
    *_numbers(
        "Table 4", lambda e, s: getattr(e.paper.parameters, s),
        causes={
            "ks": _ks_cause,
            "cs": "the paper's estimate lies further from Table 1 than ours",
            "k1": "the paper's estimate lies further from Eq. (2) than ours; its own Table 3 does not follow from it",
        },
    ),
    Claim("Table 4", "largest error below 0.06 %, by the printed tables", _table_4_error, _table_4_cause),
    Claim("Table 4", "largest error below 0.06 %, by ours in the paper's reading", lambda e: _our_error(e, "all")),
    Claim("Table 4", "largest error below 0.06 %, by ours in the right reading", lambda e: _our_error(e, "force")),
    Claim("Table 4", "Eq. (9) as printed gives these parameters", _as_printed_9,
          "the force was held between samples, which Eq. (9) as printed ignores: H has to be read through the hold"),
    Claim("Fig. 4", "estimated and fitted receptances cannot be told apart", _overlaid),
    Claim("Fig. 5", "the singular values fall after the fourth", _jump),
    *_numbers(
        "Table 5", lambda e, s: getattr(e.theory.nondimensional(e.force), s),
        causes={"zeta_s": "truncated, not rounded; see the next row"},
    ),
    _number(
        "Table 5", "zeta_s", "zeta_s from Table 4 as printed",
        lambda e: _printed_oscillator(e).nondimensional(e.force).zeta_s,
        "truncated, not rounded",
    ),
    Claim("Section 2.2", "three solutions, or one, by the sign of the discriminant", _discriminant_rule),
    Claim("Section 2.2", "of three solutions two are stable and one is not", _two_of_three_stable,
          "at large amplitudes the main curve is unstable too, by the same multipliers"),
    Claim("Fig. 6", "there is one closed detached curve, an inner one", _detached),
    Claim("Fig. 6", "it lies inside the main curve of z and of x", _inside_which),
    Claim("Fig. 6", "this force is one at which an inner curve exists", _margin),
    Claim("Fig. 6", "it appears in particular with quasi-zero stiffness", _quasi_zero,
          "a little linear stiffness helps here: with k1 = 0 the curve is born at a larger force"),
    Claim("Fig. 6", "three seconds are enough for the transient", _settled,
          "the suspended mass is lightly damped; those tests were run again for six seconds"),
    Claim("Fig. 6", "from rest the rig settles on the lower branch of the detached curve",
          lambda e: _share(e, lambda t: t["from rest"], "low", _on_detached), _EDGE),
    Claim("Fig. 6", "a light tap then takes it to the higher branch",
          lambda e: _share(e, lambda t: t["light tap"], "high", _on_detached),
          "where one tap does not do it, another size or another instant of the period may"),
    Claim("Fig. 6", "from rest it settles on the lower branch wherever there are several",
          lambda e: _share(e, lambda t: t["from rest"], "low", _several), _EDGE),
    Claim("Fig. 6", "a tap takes it to the higher branch wherever there are several",
          lambda e: _share(e, lambda t: ~t["from rest"], "high", _several),
          "taps of four sizes at four instants were tried there: above the detached curve the rig ends in subharmonic "
          "motions or falls back"),
    Claim("Fig. 6", "rig and analytic solution agree, lower branch", lambda e: _agreement(e, ["low"])),
    Claim("Fig. 6", "rig and analytic solution agree, higher branch", lambda e: _agreement(e, ["high"]),
          "the third harmonic, which single-term theory leaves out"),
    Claim("Fig. 6", "rig and analytic solution agree where there is one", lambda e: _agreement(e, ["only"])),
    Claim("Fig. 6", "every stable solution can be reached", _reached,
          "stability about the single-term orbit is not that of the rig's own motion; and close to its end, hardly any "
          "start leads to the low side of the detached curve"),
    Claim("Section 4", "harmonics of the shaker xs below 5 %", lambda e: _harmonics(e, "shaker"), _ABSORBED),
    Claim("Section 4", "harmonics of the mass x below 5 %", lambda e: _harmonics(e, "mass"), _THIRD),
    Claim("Section 4", "harmonics of the relative displacement z below 5 %", lambda e: _harmonics(e, "z"), _THIRD),
    Claim("Section 4", "no lower harmonics", _lower_harmonics,
          "subharmonic motions that the single-term theory does not know; a tap can start them"),
    Claim("Section 1", "two sets reduce the tilt under gravity", _tilt),
    Claim("Section 1", "two sets take the rocking mode out of the way", _rocking_mode),
    Claim("Section 1", "two sets reduce the wobbling in motion", _tilt_in_motion),
    Claim("Section 1", "with one set, some branches are not observed", _single_set_misses),
    Claim("Conclusions", "gravity does not spoil the estimates", _gravity_harmless),
)  # fmt: skip

# The causes above are those of the paper's rig.
OTHER_RIG = "computed on a rig that is not the paper's"
PAPER_RIG = RigParameters()
