"""The single-term response over frequency and force as one folded sheet, seen from the side and from above."""

import numpy as np

from .response import closed_curves
from .style import BLACK, BLUE, GREY, ORANGE, PANELS, RED, SKY, legend, log_scale, style, subplots


def response_surface_figure(result, *, ax=None, **options):
    """Amplitude over frequency and force as one folded sheet, with its fold lines and the response at one force.

    Above, the sheet. Low and high solutions are light blue; the middle one of three, always unstable, is orange, and
    hatched by a denser mesh. Below, the same seen from above: the fold lines alone. Low and middle solutions meet at
    gamma_+ (solid), middle and high ones at gamma_- (dashed); between the lines there are three. Detached curves at
    the one force are bold and red. The first of two ``ax`` is made with ``projection="3d"``; options are those of
    `ForceScenario.surface`: ``forces``, ``band``, ``force``, ``quantity``, ``resolution``.

    Raises
    ------
    ValueError
        If an input is not allowed, the spring has no cubic part, or the first axes are flat.
    """
    surface = result.surface(**options)
    (low, high), forces, frequency = surface.band, surface.forces, surface.frequency
    pieces, force = surface.response.pieces, surface.response.force
    with style():
        figure, (sheet, lower) = subplots(2, 1, alt=_alt(surface), ax=ax, height=8.4, height_ratios=(2.4, 1))
        if ax is None:
            place = sheet.get_subplotspec()
            sheet.remove()
            # Drawn in this order, since matplotlib cannot sort surfaces that pass behind each other.
            sheet = figure.add_subplot(place, projection="3d", computed_zorder=False)
        elif sheet.name != "3d":
            raise ValueError('ax[0] is flat; expected axes made with projection="3d"')
        for (F, height), color, (alpha, mesh) in zip(
            surface.layers, (SKY, ORANGE, SKY), ((0.55, 0.15), (0.9, 0.5), (0.3, 0.15)), strict=True
        ):
            across = np.broadcast_to(frequency[:, None], F.shape)
            look = {"rcount": 40, "ccount": 14, "linewidth": mesh, "edgecolor": GREY, "alpha": alpha, "shade": False}
            sheet.plot_surface(across, F, height, color=color, **look)
        _fold_lines(sheet, surface, (0, 1))
        _fold_lines(lower, surface, (0,))
        for piece in pieces:
            look = {"color": RED, "linewidth": 2.8} if piece.closed else {"color": BLUE, "linewidth": 1.6}
            across, height = np.full(piece.frequency.size, force), 1e3 * abs(getattr(piece, surface.quantity))
            sheet.plot(piece.frequency, across, height, **look)
            lower.plot(piece.frequency, across, zorder=2 + piece.closed, **look, label=_name(piece, force))
        sheet.set(xlabel="frequency [Hz]", ylabel="force [N]", zlabel="amplitude [mm]", xlim=(low, high), ylim=forces)
        sheet.set_zlim(0, np.nanmax([height for _, height in surface.layers]))
        sheet.view_init(24, -118)
        sheet.set_box_aspect((1.5, 1.2, 0.9), zoom=1.1)
        sheet.set_title(f"(a) {dict(PANELS)[surface.quantity]}", loc="left")
        three = {"color": ORANGE, "alpha": 0.35, "linewidth": 0, "label": "three solutions, the middle one unstable"}
        minus, plus = surface.lines[1][0], surface.lines[0][0]
        lower.fill_between(frequency, minus, plus, where=plus > minus, **three)
        lower.set(xlabel="frequency [Hz]", ylabel="force [N]", xlim=(low, high), ylim=forces)
        log_scale(lower, (1, 2, 5))
        lower.set_title("(b) the same from above", loc="left")
        legend(lower, ax=ax)
        return figure


def _fold_lines(axes, surface, heights):
    """The fold lines inside the forces, with or without their heights."""
    names = (("-", "fold: low and middle meet ($\\gamma_+$)"), ("--", "fold: middle and high meet ($\\gamma_-$)"))
    for line, (dash, name) in zip(surface.lines, names, strict=True):
        inside = (line[0] >= surface.forces[0]) & (line[0] <= surface.forces[1])
        shown = [np.where(inside, line[k], np.nan) for k in heights]
        axes.plot(surface.frequency, *shown, dash, color=BLACK, linewidth=1.8, label=name)


def _name(piece, force):
    return f"{piece.kind} detached curve at {force:g} N" if piece.closed else f"response at {force:g} N"


def _alt(surface):
    (low, high), (least, most), closed = surface.band, surface.forces, closed_curves(surface.response)
    return (
        f"Two panels. Amplitude of the {surface.quantity} displacement as a folded sheet over frequency, {low:g} to "
        f"{high:g} hertz, and force, {least:g} to {most:g} newtons, with its two fold lines; and the fold lines from "
        f"above. At {surface.response.force:g} newtons: {', '.join(closed) or 'no closed detached curve'}."
    )
