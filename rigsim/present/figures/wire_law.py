"""Force of the wires by Eq. (1) and by Eq. (2), and the error of Eq. (2)."""

import numpy as np

from ... import checks
from ...model.wires import cubic_law_error, suspension_force
from .style import BLACK, GREY, ORANGE, RED, SKY, style, subplots


def wire_law_figure(parameters, *, ax=None, reached=None, largest=5e-3):
    """Force of a rig's wires by Eq. (1) and by Eq. (2), and the error of Eq. (2), up to z = ``largest`` (m).

    ``reached``, the least and the largest amplitude of z in a test (m), is marked as a band. Of a slack rig (d0 > d)
    the gap is marked, of a buckled one its two wells; the error is then in newtons, since Eq. (1) itself vanishes.

    Raises
    ------
    ValueError
        If ``largest`` is not above zero or the range reached is not ascending.
    """
    largest = checks.positive("largest", largest, "m")
    z = np.linspace(-largest, largest, 401)
    decades = np.geomspace(largest / 100, largest, 301)
    if parameters.gap:
        return _without_tension(parameters, ax, reached, largest, z)
    error = 100 * cubic_law_error(decades, parameters)
    alt = (
        f"Left: force of the wires over z by the exact and the cubic law; at {1e3 * largest:.3g} mm they give "
        f"{suspension_force(largest, parameters):.4g} N and {suspension_force(largest, parameters, 'cubic'):.4g} N. "
        f"Right: error of the cubic law, which grows with z to {error[-1]:.2g} %."
    )
    if reached is not None:
        reached = np.array(checks.pair("reached", reached, "m"))
        worst = 100 * float(cubic_law_error(reached[1], parameters))
        alt += (
            f" The test reaches amplitudes of z from {1e3 * reached[0]:.2g} to {1e3 * reached[1]:.3g} mm, "
            f"with an error of at most {worst:.2g} %."
        )
    with style():
        figure, (left, right) = subplots(1, 2, alt=alt, ax=ax, width=9.0)
        if reached is not None:
            (low, high), look = 1e3 * reached, {"color": SKY, "alpha": 0.25, "linewidth": 0}
            left.axvspan(-high, high, **look, label="z reached in the test")
            right.axvspan(low, high, **look, label="amplitudes in the test")
        left.plot(1e3 * z, suspension_force(z, parameters), color=BLACK, label="Eq. (1), exact")
        left.plot(1e3 * z, suspension_force(z, parameters, "cubic"), "--", color=ORANGE, label="Eq. (2), cubic")
        left.set(xlabel="relative displacement z [mm]", ylabel="force of the wires [N]")
        left.legend()
        right.loglog(1e3 * decades, error, color=BLACK, label="error of Eq. (2)")
        right.set(xlabel="relative displacement z [mm]", ylabel="error of the force [%]")
        right.legend()
    return figure


def _without_tension(parameters, ax, reached, largest, z):
    """The same of a rig with d0 > d: the gap of wires that let go, or the wells of wires that push."""
    gap, exact, cubic = parameters.gap, suspension_force(z, parameters), suspension_force(z, parameters, "cubic")
    if parameters.tension_only:
        alt = (
            f"Left: force of the wires over z. They are slack, without force, up to {1e3 * gap:.3g} mm to either side. "
        )
        name = "Eq. (2), cubic, if wires pushed"
    else:
        alt = f"Left: force of the wires over z. It pushes off the middle, to wells at z = ±{1e3 * gap:.3g} mm. "
        name = "Eq. (2), cubic"
    alt += (
        f"Right: the difference of both laws, at most {np.abs(cubic - exact).max():.3g} N up to {1e3 * largest:.3g} mm."
    )
    if reached is not None:
        reached = np.array(checks.pair("reached", reached, "m"))
        alt += f" The test reaches amplitudes of z from {1e3 * reached[0]:.2g} to {1e3 * reached[1]:.3g} mm."
    with style():
        figure, (left, right) = subplots(1, 2, alt=alt, ax=ax, width=9.0)
        for axes in (left, right):
            if reached is not None:
                axes.axvspan(-1e3 * reached[1], 1e3 * reached[1], color=SKY, alpha=0.25, linewidth=0, label="z reached")
            if parameters.tension_only:
                axes.axvspan(-1e3 * gap, 1e3 * gap, color=GREY, alpha=0.25, linewidth=0, label="wires slack")
            axes.set_xlabel("relative displacement z [mm]")
        left.plot(1e3 * z, exact, color=BLACK, label="Eq. (1), exact")
        left.plot(1e3 * z, cubic, "--", color=ORANGE, label=name)
        if not parameters.tension_only:
            left.plot([-1e3 * gap, 1e3 * gap], [0, 0], "o", color=RED, markersize=5, label="at rest, without weight")
        left.set_ylabel("force of the wires [N]")
        right.plot(1e3 * z, cubic - exact, color=BLACK, label="Eq. (2) less Eq. (1)")
        right.set_ylabel("error of the force [N]")
        left.legend()
        right.legend()
    return figure
