"""The single-term response over frequency and force: one folded sheet, with its fold lines."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from ... import checks
from ...parameters import oscillator_of
from ...theory.amplitude import frequency_response
from ...theory.cubic import complex_amplitudes, dynamic_stiffness, fold_levels, solve
from .style import BLACK, BLUE, GREY, ORANGE, RED, SKY, style, subplots

_TITLES = {"shaker": "shaker $x_s$", "mass": "suspended mass $x$", "relative": "relative $z = x_s - x$"}


def response_surface_figure(
    parameters, forces=(0.3, 7.0), frequencies=(12.0, 65.0), *, force=3.18, quantity="relative", resolution=120
):
    """Amplitude over frequency and force as one folded sheet, with its fold lines and the response at one force.

    Above, the sheet: in the terms of `rigsim.theory.cubic`, a frequency and a relative amplitude U belong to the
    force at which (3/4) gamma X^2/e = U [(U + r)^2 + s^2], so every column of it runs over U and nothing is solved
    but its ends. Low and high solutions are light blue; the middle one of three, always unstable, is orange, and
    hatched by a denser mesh. Below, the same seen from above: the fold lines alone. Low and middle solutions meet at
    gamma_+ (solid), middle and high ones at gamma_- (dashed); between the lines there are three.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
        A rig is taken with the cubic law of Eq. (2).
    forces : (float, float)
        Least and largest force amplitude (N, above zero).
    frequencies : (float, float)
        Least and largest forcing frequency (Hz, above zero).
    force : float
        Force (N, within ``forces``) whose response is drawn on the sheet, detached curves bold and red.
    quantity : {"relative", "mass", "shaker"}
        Whose amplitude is the height (mm).
    resolution : int
        Columns of the sheet, and points of each layer in a column (8 to 2000).

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If an input is not allowed, the spring has no cubic part, or the shaker is undamped.
    """
    oscillator = oscillator_of(parameters)
    forces = _span("forces", forces, "N")
    low, high = _span("frequencies", frequencies, "Hz")
    force = checks.real("force", force, "N", low=forces[0], high=forces[1])
    checks.one_of("quantity", quantity, tuple(_TITLES))
    resolution = checks.integer("resolution", resolution, low=8, high=2000)
    checks.positive("k3", oscillator.k3, "N/m^3")
    checks.positive("cs", oscillator.cs, "N s/m")
    frequency = np.linspace(low, high, resolution)
    layers, lines = _sheet(oscillator, frequency, forces, quantity, resolution)
    pieces = frequency_response(oscillator, force, np.linspace(low, high, 4 * resolution)).pieces
    with style():
        figure, (upper, lower) = subplots(
            2, 1, alt=_alt((low, high), forces, force, pieces, quantity), height=8.4, height_ratios=(2.4, 1)
        )
        place = upper.get_subplotspec()
        upper.remove()
        # Drawn in this order, since matplotlib cannot sort surfaces that pass behind each other.
        sheet = figure.add_subplot(place, projection="3d", computed_zorder=False)
        for (F, height), color, (alpha, mesh) in zip(
            layers, (SKY, ORANGE, SKY), ((0.55, 0.15), (0.9, 0.5), (0.3, 0.15)), strict=True
        ):
            across = np.broadcast_to(frequency[:, None], F.shape)
            options = {"rcount": 40, "ccount": 14, "linewidth": mesh, "edgecolor": GREY, "alpha": alpha, "shade": False}
            sheet.plot_surface(across, F, height, color=color, **options)
        _fold_lines(sheet, frequency, lines, forces, (0, 1))
        _fold_lines(lower, frequency, lines, forces, (0,))
        for piece in pieces:
            options = {"color": RED, "linewidth": 2.8} if piece.closed else {"color": BLUE, "linewidth": 1.6}
            across, height = np.full(piece.frequency.size, force), 1e3 * abs(getattr(piece, quantity))
            sheet.plot(piece.frequency, across, height, **options)
            lower.plot(piece.frequency, across, zorder=2 + piece.closed, **options, label=_name(piece, force))
        sheet.set(xlabel="frequency (Hz)", ylabel="force (N)", zlabel="amplitude (mm)", xlim=(low, high), ylim=forces)
        sheet.set_zlim(0, np.nanmax([height for _, height in layers]))
        sheet.view_init(24, -118)
        sheet.set_box_aspect((1.5, 1.2, 0.9), zoom=1.1)
        sheet.set_title(f"(a) {_TITLES[quantity]}", loc="left")
        three = {"color": ORANGE, "alpha": 0.35, "linewidth": 0, "label": "three solutions, the middle one unstable"}
        minus, plus = lines[1][0], lines[0][0]
        lower.fill_between(frequency, minus, plus, where=plus > minus, **three)
        lower.set(xlabel="frequency (Hz)", ylabel="force (N)", yscale="log", xlim=(low, high), ylim=forces)
        lower.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        lower.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        lower.yaxis.set_minor_formatter(NullFormatter())
        lower.set_title("(b) the same from above", loc="left")
        entries = dict(zip(*reversed(lower.get_legend_handles_labels()), strict=True))  # each name once
        figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=2)
        return figure


def _span(name, values, unit):
    low, high = checks.array(name, values, unit, low=0.0, low_open=True, min_size=2)[:2]
    if len(values) != 2 or not low < high:
        raise ValueError(f"{name} = {tuple(values)} is not allowed; expected two numbers, ascending")
    return float(low), float(high)


def _sheet(oscillator, frequency, forces, quantity, points):
    """Layers, low, middle and high, as (force, amplitude in mm), (n, points) each; lines gamma_+ and gamma_-, (n,).

    Where a column has no folds its inflection parts the low layer from the high one, and the middle one is empty.
    """
    group = oscillator.nondimensional(forces[0])
    Omega = 2 * np.pi * frequency / oscillator.omega_s
    X = Omega**2
    numbers = group.mu, group.zeta_s, group.zeta, group.Omega0
    r, s, e = np.array([dynamic_stiffness(*numbers, x) for x in X]).T
    folded = r < -np.sqrt(3) * s
    deepest = np.minimum(r, -np.sqrt(3) * s)  # where there are levels at all
    U_minus, U_plus = np.array([fold_levels(*pair)[2:] for pair in zip(deepest, s, strict=True)]).T
    U_minus[~folded] = U_plus[~folded] = np.maximum(-2 * r[~folded] / 3, 0)

    def on_sheet(U):
        """Force and amplitude of the solutions U (n, k)."""
        gamma = 4 / 3 * (e / X**2)[:, None] * U * ((U + r[:, None]) ** 2 + s[:, None] ** 2)
        force = oscillator.ks * np.sqrt(gamma * group.mu * oscillator.ks / oscillator.k3)
        amplitudes = complex_amplitudes(group, Omega[:, None], U)
        lines = dict(zip(("shaker", "mass", "relative"), amplitudes, strict=True))
        return force, 1e3 * force / oscillator.ks * abs(lines[quantity])

    ends = []  # of the three layers, at the least force and at the largest
    for force in forces:
        U, count = solve(*numbers, oscillator.nondimensional(force).gamma, Omega)
        only = np.where(U[:, 0] < U_plus, U_minus, U_plus)
        middle = np.where(count == 3, U[:, 1], only)
        ends.append((np.minimum(U[:, 0], U_plus), middle, np.maximum(np.nanmax(U, axis=1), U_minus)))
    layers = []
    for first, last in zip(*ends, strict=True):
        U = np.linspace(first, last, points, axis=1)
        U[first == last] = np.nan  # wholly outside the forces
        layers.append(on_sheet(U))
    lines = []
    for U in (U_plus, U_minus):
        force, amplitude = on_sheet(np.where(folded, U, np.nan)[:, None])
        lines.append((force[:, 0], amplitude[:, 0]))
    return layers, lines


def _fold_lines(ax, frequency, lines, forces, heights):
    """The fold lines inside the forces, with or without their heights."""
    names = (("-", "fold: low and middle meet ($\\gamma_+$)"), ("--", "fold: middle and high meet ($\\gamma_-$)"))
    for line, (dash, name) in zip(lines, names, strict=True):
        inside = (line[0] >= forces[0]) & (line[0] <= forces[1])
        shown = [np.where(inside, line[k], np.nan) for k in heights]
        ax.plot(frequency, *shown, dash, color=BLACK, linewidth=1.8, label=name)


def _name(piece, force):
    return f"{piece.kind} detached curve at {force:g} N" if piece.closed else f"response at {force:g} N"


def _alt(frequencies, forces, force, pieces, quantity):
    closed = [
        f"{piece.kind} detached curve from {piece.frequency.min():.1f} to {piece.frequency.max():.1f} hertz"
        for piece in pieces
        if piece.closed
    ]
    return (
        f"Two panels. Amplitude of the {quantity} displacement as a folded sheet over frequency, {frequencies[0]:g} to "
        f"{frequencies[1]:g} hertz, and force, {forces[0]:g} to {forces[1]:g} newtons, with its two fold lines; and "
        f"the fold lines from above. At {force:g} newtons: {', '.join(closed) or 'no closed detached curve'}."
    )
