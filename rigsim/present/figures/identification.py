"""Figures of an identification: the paper's Figs. 3, 4 and 5."""

import numpy as np

from .style import BLACK, BLUE, GREY, ORANGE, RED, outer_labels, style, subplots

_ENTRIES = (("$H_{11}$", 0, 0), ("$H_{21}$", 1, 0), ("$H_{22}$", 1, 1))


def nonlinear_coefficient_figure(identification, *, ax=None):
    """Real and imaginary part of k3(omega) with its mean, and the nominal value where known (the paper's Fig. 3)."""
    mean = identification.nonlinear_coefficient.real.mean()
    imaginary = np.mean(np.abs(identification.nonlinear_coefficient.imag))
    alt = (
        f"Real part of the nonlinear coefficient over frequency, with mean {mean:.4g} newtons per cubic metre, "
        f"and its imaginary part, on average {imaginary:.2g} in size."
    )
    with style():
        figure, axes = subplots(2, 1, alt=alt, ax=ax, height=5.0, sharex=True, height_ratios=(3, 2))
        _draw_coefficient(axes, identification, mean)
        outer_labels(axes, ax=ax)
        return figure


def receptance_figure(identification, *, ax=None):
    """H11, H21 and H22 of the underlying linear system, estimated (solid) and fitted (dashed) (the paper's Fig. 4)."""
    peaks, entries = identification.modes.frequency, _entries(identification)
    alt = (
        f"Magnitude and phase of {_named(entries)} of the underlying linear system: estimates as solid "
        f"lines, fitted rational fractions as dashed lines over them; modes at {_listed(peaks)} Hz."
    )
    with style():
        figure, axes = subplots(
            2, len(entries), alt=alt, ax=ax, width=10.0, height=5.0, sharex=True, height_ratios=(3, 2), squeeze=False
        )
        _draw_receptances(axes, identification)
        outer_labels(axes, ax=ax)
        return figure


def singular_value_figure(identification, *, ax=None):
    """Singular values of the subspace step with their jump marked (the paper's Fig. 5)."""
    order = len(identification.state_space.A)
    values = identification.singular_values
    alt = (
        f"Singular values on a logarithmic scale: {order} large ones, then a fall by a factor of "
        f"{values[order - 1] / values[order]:.2g}, which gives the order of the model."
    )
    with style():
        figure, axis = subplots(alt=alt, ax=ax)
        _draw_singular_values(axis, identification)
        return figure


def identification_figure(identification, *, ax=None):
    """Singular values, coefficient and receptances of an identification on one page, in nine panels or in five."""
    order, mean = len(identification.state_space.A), identification.nonlinear_coefficient.real.mean()
    jump = identification.singular_values[order - 1] / identification.singular_values[order]
    alt = (
        f"Identification of a record: singular values that fall by a factor of {jump:.2g} after number {order}; "
        f"nonlinear coefficient with mean {mean:.4g} newtons per cubic metre; receptances of the underlying linear "
        f"system, with modes at {_listed(identification.modes.frequency)} Hz, estimated and fitted."
    )
    several = len(_entries(identification)) > 1
    with style():
        shape = {"height": 8.6, "height_ratios": (3, 3, 2)} if several else {"height": 6.0}
        figure, axes = subplots(2 + several, 3, alt=alt, ax=ax, width=10.0, **shape)
        _draw_singular_values(axes[0, 0], identification)
        _draw_coefficient(axes[0, 1:], identification, mean)
        _draw_receptances(axes[1:] if several else axes[1, :2, None], identification)
        if several:
            outer_labels(axes[1:], ax=ax)
        else:
            axes[1, 2].set_axis_off()
        return figure


def _entries(identification):
    """Names and places of the receptances that differ."""
    return _ENTRIES if identification.receptance.shape[1] == 2 else _ENTRIES[:1]


def _named(entries):
    return "the receptances H11, H21 and H22" if len(entries) > 1 else "the receptance H11"


def _draw_coefficient(axes, identification, mean):
    frequency, coefficient = identification.frequency, identification.nonlinear_coefficient
    real, imaginary = axes
    real.plot(frequency, coefficient.real, color=BLUE, label="estimate")
    wide = identification.nonlinear_half_width
    if np.isfinite(wide).all():
        ends = coefficient.real - wide, coefficient.real + wide
        real.fill_between(frequency, *ends, color=BLUE, alpha=0.2, linewidth=0, label="95 % interval")
    real.axhline(mean, color=ORANGE, linestyle="--", label=f"mean {mean:.4g}")
    if identification.nominal is not None and identification.nominal.k3 > 0:
        nominal = identification.nominal.k3
        real.axhline(nominal, color=BLACK, linestyle=":", label=f"nominal {nominal:.4g}")
    # The edges of the band are the least certain: they must not set the scale, nor must rounding on a clean record.
    low, high = np.quantile(coefficient.real, (0.05, 0.95))
    margin = max(high - low, 0.1 * abs(mean))
    real.set_ylim(low - margin, high + margin)
    real.set_ylabel("Re $k_3$ [N/m$^3$]")
    real.legend()
    imaginary.plot(frequency, coefficient.imag, color=RED)
    low, high = imaginary.get_ylim()
    imaginary.set_ylim(min(low, -0.1 * abs(mean)), max(high, 0.1 * abs(mean)))
    imaginary.set_ylabel("Im $k_3$ [N/m$^3$]")
    for axis in axes:
        axis.set_xlabel("frequency [Hz]")


def _draw_receptances(axes, identification):
    frequency = identification.frequency
    for (label, row, column), magnitude, phase in zip(_entries(identification), *axes, strict=True):
        estimated = identification.receptance[:, row, column]
        fitted = identification.fitted_receptance[:, row, column]
        magnitude.semilogy(frequency, np.abs(estimated), color=BLUE, label="estimate")
        magnitude.semilogy(frequency, np.abs(fitted), color=RED, linestyle="--", label="fraction polynomial")
        magnitude.set(title=label, xlabel="frequency [Hz]", ylabel="magnitude [m/N]")
        phase.set(xlabel="frequency [Hz]", ylabel="phase [°]")
        for values, colour, line in ((estimated, BLUE, "-"), (fitted, RED, "--")):
            phase.plot(frequency, np.degrees(np.unwrap(np.angle(values))), color=colour, linestyle=line)
    axes[0][-1].legend(loc="upper right")


def _draw_singular_values(axis, identification):
    values, order = identification.singular_values, len(identification.state_space.A)
    number = np.arange(1, values.size + 1)
    axis.semilogy(number[:order], values[:order], "o", color=BLUE, label=f"{order} kept")
    axis.semilogy(number[order:], values[order:], "o", color=GREY, markerfacecolor="none", label="left out")
    above, below = values[order - 1 : order + 1]
    between = {"arrowstyle": "<->", "color": BLACK}
    axis.annotate("", xy=(order + 0.5, below), xytext=(order + 0.5, above), arrowprops=between)
    axis.text(order + 1.5, np.sqrt(above * below), f"jump: {above / below:.2g}", va="center")
    axis.set(xlabel="number", ylabel="singular value")
    axis.legend(loc="upper right")


def _listed(values):
    return " and ".join(f"{value:.4g}" for value in values)
