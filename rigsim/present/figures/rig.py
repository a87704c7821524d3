"""The rig drawn to scale, as Figs. 1b and 2 of the paper draw it: at rest, or as it hangs under gravity."""

import numpy as np
from matplotlib.patches import Circle, Wedge

from ... import checks
from ...model.chipmunk import RigSpace
from ...model.planar import StaticEquilibrium, longest_step, rest_position
from ...parameters import RigParameters
from .rig_parts import SETS, frame_sizes, only_rigs, rig_parts
from .style import BLACK, GREY, ORANGE, RED, SKY, legend, outer_labels, style, subplots

_PAPER = {1: "Fig. 1b", 2: "Fig. 2"}


def rig_figure(result, *, ax=None, beside=(), exaggeration=1.0, titles=None):
    """Rigs in their vertical plane, side by side on one scale: Fig. 1b of the paper for one wire set, Fig. 2 for two.

    Parameters
    ----------
    result : RigParameters or StaticEquilibrium
        A rig is drawn without gravity's sag, an equilibrium as it hangs.
    beside : RigParameters, StaticEquilibrium or sequence of them
        Drawn to the right.
    exaggeration : float
        The tilt is drawn this many times as large, and the figure says so.
    titles : str or sequence of str, optional
        One a rig.

    Raises
    ------
    ValueError
        If one is not a rig's, there are not as many titles as rigs, or the exaggeration is not above zero.
    """
    kinds, expected = (
        (RigParameters, StaticEquilibrium),
        "RigParameters or StaticEquilibrium: others have no shape to draw",
    )
    drawn = (result, *checks.one_or_many("beside", beside, kinds, expected))
    rigs = only_rigs(getattr(one, "parameters", one) for one in drawn)
    at = [getattr(one, "coordinates", rest_position(p)) for one, p in zip(drawn, rigs, strict=True)]
    titles = [f"{SETS[p.wire_sets].capitalize()} ({_PAPER[p.wire_sets]})" for p in rigs] if titles is None else titles
    titles = checks.one_or_many("titles", titles, str, "text")
    if len(titles) != len(rigs):
        raise ValueError(f"titles has {len(titles)} elements for {len(rigs)} rigs; expected one a rig")
    exaggeration = checks.real("exaggeration", exaggeration, low=0.0, high=1e6, low_open=True)
    words = [_rig_words(p, q) for p, q in zip(rigs, at, strict=True)]
    alt = "Side view of the rig to scale. " + " ".join(words)
    several = len(rigs) > 1
    with style():
        figure, grid = subplots(
            1, len(rigs), alt=alt, ax=ax, width=5.6 * len(rigs), height=5.7 if several else 6.0, squeeze=False,
            sharey=True,
        )  # fmt: skip
        for axes, p, q, title in zip(grid[0], rigs, at, titles, strict=True):
            _draw_rig(axes, p, q, exaggeration)
            axes.set_title(title)
        outer_labels(grid, ax=ax)
        legend(grid, ax=ax, columns=5 if several else 3, inside=False)
    return figure


def debug_figure(result, *, ax=None):
    """The rig of a `StaticEquilibrium` as pymunk itself draws the two bodies of its `RigSpace`, hanging."""
    p = result.parameters
    space = RigSpace([p], longest_step(p) / 2, "equilibrium")
    with style():
        alt = f"pymunk's own drawing of {SETS[p.wire_sets]}: frame, cylinder, and springs for the wires in the plane."
        figure, axes = subplots(alt=alt, ax=ax, height=4.0)
        space.debug_draw(axes)
    return figure


def _rig_words(p, q):
    spacing = "" if p.wire_sets == 1 else f", {1e3 * (p.set_positions[1] - p.set_positions[0]):.3g} mm apart"
    spacing += f", their middle {1e3 * p.set_centre:.3g} mm from P" if p.set_centre else ""
    words = (
        f"A cylinder {1e3 * p.Lm:.3g} mm long and {2e3 * p.Rm:.3g} mm thick hangs in a frame on {SETS[p.wire_sets]}"
        f"{spacing}, wires {1e3 * p.d:.3g} mm long, its centre of mass {1e3 * p.LG:.3g} mm from P"
    )
    return words + (f"; it is tilted by {np.degrees(q[3]):.3g} degrees." if q[3] else ".")


def _draw_rig(axes, p, q, exaggeration):
    parts = {name: 1e3 * points for name, points in rig_parts(p, q, exaggeration).items()}
    half, top, bar, wall = (1e3 * size for size in frame_sizes(p))
    axes.plot(*parts["ground"].T, color=GREY, linewidth=1.0)
    axes.fill(*parts["frame"].T, facecolor="#D9D9D9", edgecolor=BLACK, linewidth=1.0, label="frame")
    for center in parts["rollers"]:
        axes.add_patch(Circle(center, bar / 2, facecolor="white", edgecolor=BLACK))
    axes.plot(*parts["shaker"].T, color=BLACK, linewidth=1.2)
    axes.plot(*parts["damper"].T, color=BLACK, linewidth=1.0)
    axes.fill(*parts["mass"].T, facecolor=SKY, alpha=0.5, edgecolor=BLACK, label="suspended mass", zorder=2)
    axes.plot(*parts["wires"].T, color=RED, linewidth=1.6, label="wires in the plane", zorder=3)
    axes.plot(*parts["pins"].T, ".", color=BLACK, markersize=5, label="pins", zorder=4)
    hidden = parts["hidden"].T
    axes.plot(*hidden, "o", color=RED, markerfacecolor="white", markersize=8, label="wires across the plane", zorder=4)
    axes.plot(*hidden, ".", color=RED, markersize=4, zorder=5)
    _centre_of_mass(axes, parts["G"][0], 0.035 * top)
    (P,) = parts["P"]
    axes.plot(*P, "+", color=BLACK, markersize=9, markeredgewidth=1.6, zorder=6)
    _dimensions(axes, p, q, top)
    shaken = 0.35 * top
    small = {"ha": "center", "va": "center", "fontsize": 9}
    middle = (wall - half) / 2
    axes.text(middle, shaken + 0.14 * top, f"$k_s$ = {p.ks / 1e3:.4g} kN/m", **small)
    axes.text(middle, -shaken - 0.14 * top, f"$c_s$ = {p.cs:.3g} N s/m", **small)
    axes.text(-half + bar + 0.05 * top, 0.1 * top, "$c$", **small)
    _arrow(axes, (wall + 0.28 * top, 0), (-half, 0), ORANGE)
    axes.text(wall + 0.22 * top, 0, "$f(t)$", ha="right", va="center", color=BLACK)
    if p.gravity:
        _arrow(axes, (1.2 * half, -0.5 * top), (1.2 * half, -0.9 * top), BLACK)
        axes.text(1.25 * half, -0.7 * top, f"gravity\n{p.gravity:.3g} m/s²", ha="left", va="center", fontsize=9)
    tilted = f"tilt {np.degrees(q[3]):.3g}°" + (
        f", drawn {exaggeration:g} times as large" if exaggeration != 1 else ", to scale"
    )
    if q[3]:
        axes.text(0.5, 0.015, tilted, transform=axes.transAxes, ha="center", va="bottom", fontsize=9)
    axes.set(
        xlabel="x [mm]", ylabel="y [mm]", aspect="equal",
        xlim=(wall - 1.5 * bar, 1.75 * half), ylim=(-top - 4.5 * bar, top + 0.6 * bar),
    )  # fmt: skip
    axes.grid(False)


def _centre_of_mass(axes, center, radius):
    axes.add_patch(Circle(center, radius, facecolor="white", edgecolor=BLACK, zorder=6))
    for begin in (0, 180):
        axes.add_patch(Wedge(center, radius, begin, begin + 90, facecolor=BLACK, zorder=7))


def _arrow(axes, begin, end, color, head="-|>", width=1.4):
    look = {"arrowstyle": head, "color": color, "linewidth": width, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, begin, arrowprops=look)


def _dimensions(axes, p, q, top):
    """Dimension lines of the rig at rest, beside the mass."""
    origin = 1e3 * (q[1] - p.LG * np.cos(q[3]))  # x of P
    LG, Rm, d, Lm = (1e3 * size for size in (p.LG, p.Rm, p.d, p.Lm))
    left, right = origin + LG - Lm / 2, origin + LG + Lm / 2
    gap = 0.03 * top

    def dimension(begin, end, text, at, ha="left", va="center"):
        _arrow(axes, begin, end, GREY, "<->", 0.9)
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
        axes.text(*at, text, ha=ha, va=va, fontsize=9, zorder=8, bbox=box)

    def leader(*points):
        axes.plot(*zip(*points, strict=True), color=GREY, linewidth=0.6)

    low, beside = -Rm - 0.27 * top, right + 0.14 * top
    dimension((left, low), (right, low), f"$L_m$ = {Lm:.4g} mm", (right + gap, low))
    for x in (left, right):
        leader((x, -Rm - gap), (x, low - gap))
    dimension((beside, -Rm), (beside, Rm), f"$2R_m$ = {2 * Rm:.4g} mm", (beside + gap, 0))
    dimension((beside, Rm), (beside, Rm + d), f"$d$ = {d:.4g} mm", (beside + gap, Rm + d / 2))
    for y in (-Rm, Rm):
        leader((right + gap, y), (beside + gap, y))
    if p.LG:
        over, text = Rm + 0.15 * top, f"$L_G$\n{LG:.4g} mm"
        place = ((origin + LG + gap, over),) if p.wire_sets == 1 else ((origin, over + gap), "center", "bottom")
        dimension((origin, over), (origin + LG, over), text, *place)
        for x in (origin, origin + LG):
            leader((x, 0.05 * top), (x, over + gap))
    sets = origin + 1e3 * np.array(p.set_positions)
    if p.set_centre:
        over, text = -0.62 * top, f"sets' middle\n{1e3 * p.set_centre:.4g} mm"
        dimension((origin, over), (sets.mean(), over), text, (max(origin, sets.mean()) + gap, over))
        for x in (origin, sets.mean()):
            leader((x, -0.05 * top), (x, over - gap))
    if sets[-1] > sets[0]:
        over, text = -0.8 * top, f"{sets[-1] - sets[0]:.4g} mm"
        dimension((sets[0], over), (sets[-1], over), text, (sets.mean(), over + gap), "center", "bottom")
    axes.text(origin - gap, -gap, "P", ha="right", va="top", fontsize=9, zorder=8)
    axes.text(origin + LG + gap, -gap, "G", ha="left", va="top", fontsize=9, zorder=8)
