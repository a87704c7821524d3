"""The readings of H_E side by side: what each makes of the nonlinear coefficient."""

import numpy as np

from ... import checks
from ...identification.result import Identification
from .style import BLACK, BLUE, GREEN, ORANGE, style, subplots

_LOOKS = {
    "force": {"color": GREEN, "linestyle": "-"},
    "all": {"color": BLUE, "linestyle": "--"},
    "none": {"color": ORANGE, "linestyle": (0, (1, 1.5))},
}


def readings_figure(identification, *, ax=None, beside=()):
    """Real and imaginary part of k3(omega) by each reading, over the mean of the right one's real part.

    Where the force was held at its value, theta cot(theta) + i theta is drawn too: what the readings other than the
    right one should show. ``beside``, an `Identification` or a sequence of them, are of the same record, each by
    another reading.

    Raises
    ------
    ValueError
        If two are by the same reading, or none is by the right one.
    """
    identifications = identification, *checks.one_or_many("beside", beside, Identification, "an Identification")
    by_reading = {each.conversion: each for each in identifications}
    if len(by_reading) != len(identifications) or "force" not in by_reading:
        listed = ", ".join(each.conversion for each in identifications)
        raise ValueError(f'identifications are by the readings {listed}; expected "force" and others, each once')
    right = by_reading["force"]
    unit = right.nonlinear_coefficient.real.mean()
    told = [
        f'"{name}" lies between {_percent(c.real.min() / unit - 1)} and {_percent(c.real.max() / unit - 1)}, with an '
        f"imaginary part of up to {_percent(np.abs(c.imag).max() / unit)}"
        for name, c in ((name, each.nonlinear_coefficient) for name, each in by_reading.items())
    ]
    alt = "Nonlinear coefficient over frequency, relative to the right reading's mean: " + "; ".join(told) + "."
    with style():
        figure, (real, imaginary) = subplots(1, 2, alt=alt, ax=ax, width=9.5, height=3.9)
        for name, each in by_reading.items():
            ratio = 100 * each.nonlinear_coefficient / unit
            real.plot(each.frequency, ratio.real - 100, label=f'"{name}"', **_LOOKS[name])
            imaginary.plot(each.frequency, ratio.imag, **_LOOKS[name])
        if right.hold == "zero":
            theta = np.pi * right.frequency / right.state_space.sample_rate
            look = {"color": BLACK, "linewidth": 3.5, "alpha": 0.25}
            real.plot(right.frequency, 100 * (theta / np.tan(theta) - 1), label="θ cot θ + iθ", **look)
            imaginary.plot(right.frequency, 100 * theta, **look)
        real.set(xlabel="frequency [Hz]", ylabel="error of Re $k_3$ [%]")
        imaginary.set(xlabel="frequency [Hz]", ylabel="Im $k_3$ [% of Re]")
        real.legend()
        return figure


def _percent(value):
    return f"{100 * value:.2g} %"
