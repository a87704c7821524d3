"""The rig drawn to scale from its parameters, its wires' force law, and how it hangs and rocks."""

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Wedge

from ... import checks
from ...model.planar import linear_modes, pack, rest_position, static_equilibrium
from ...model.wires import cubic_law_error, suspension_force
from ...parameters import RigParameters
from .style import BLACK, BLUE, GREY, ORANGE, RED, SKY, style, subplots

_WORDS = {1: "one wire set", 2: "two wire sets"}
_PAPER = {1: "Fig. 1b", 2: "Fig. 2"}
_LOOK = {1: {"color": RED, "marker": "s", "linestyle": "--"}, 2: {"color": BLUE, "marker": "o", "linestyle": "-"}}


def only_rigs(rigs):
    """The rigs as a tuple.

    Raises
    ------
    ValueError
        If one is not a `RigParameters`.
    """
    rigs = tuple(rigs)
    for p in rigs:
        if not isinstance(p, RigParameters):
            raise ValueError(f"parameters = {p!r} has no shape to draw; expected RigParameters")
    return rigs


def rig_parts(parameters, coordinates, exaggeration=1.0):
    """The parts of the rig in its vertical plane, as points to be joined by lines.

    Cylinder, wires and pins are to scale; frame, guide, shaker and damper are schematic, with
    sizes that follow from the wires' reach.

    Parameters
    ----------
    parameters : RigParameters
    coordinates : array_like, shape (..., 4)
        xs, X, Y (m) and tilt (rad), as in `rigsim.model.planar`.
    exaggeration : float
        The tilt about P is drawn this many times as large.

    Returns
    -------
    dict of str to ndarray, shape (..., n, 2)
        m. "frame" and "mass" are closed outlines; "wires", "shaker" and "damper" lines interrupted by NaN; "rollers",
        "pins" (frame and mass pin of each wire in the plane), "hidden" (where the wires across the plane
        are pinned), "P" and "G" points; "ground", shape (n, 2), stands still.
    """
    coordinates = np.asarray(coordinates, dtype=float)
    exaggeration = checks.positive("exaggeration", exaggeration)
    xs, X, Y, tilt = np.moveaxis(coordinates, -1, 0)
    P = np.stack([X - parameters.LG * np.cos(tilt), Y - parameters.LG * np.sin(tilt)], axis=-1)[..., None, :]
    cos, sin = np.cos(exaggeration * tilt)[..., None], np.sin(exaggeration * tilt)[..., None]

    def on_mass(along, across):
        along, across = np.asarray(along), np.asarray(across)
        return P + np.stack([cos * along - sin * across, sin * along + cos * across], axis=-1)

    def on_frame(points):
        points = np.asarray(points, dtype=float)
        return points + np.stack([xs, np.zeros_like(xs)], axis=-1)[..., None, :]

    wires = pack([parameters])[1][0][: 4 * parameters.wire_sets]
    planar = wires[wires["hidden"] == 0]
    across = wires[wires["hidden"] > 0][::2]
    frame_pins = on_frame(np.column_stack([planar["anchor_x"], planar["anchor_y"]]))
    mass_pins = on_mass(planar["along"] + parameters.LG, planar["across"])
    ends = parameters.LG + parameters.Lm / 2 * np.array([-1, 1, 1, -1])
    mass = on_mass(ends, parameters.Rm * np.array([-1, -1, 1, 1]))
    half, top, bar, wall = _frame_sizes(parameters)
    frame = np.array(
        [[-half, top], [half, top], [half, top - bar], [bar - half, top - bar],
         [bar - half, bar - top], [half, bar - top], [half, -top], [-half, -top]]
    )  # fmt: skip
    left, level = on_frame([[-half, 0.0]]), 0.35 * top
    behind = (mass[..., :1, :] + mass[..., 3:, :]) / 2
    return {
        "ground": _ground(half, top, bar, wall),
        "frame": on_frame(frame),
        "rollers": on_frame([[-0.7 * half, -top - bar / 2], [0.7 * half, -top - bar / 2]]),
        "shaker": _joined(
            _spring(wall, left + [0, level], 0.06 * top), _dashpot(wall, left - [0, level], 0.06 * top)
        ),
        "damper": _dashpot(on_frame([[bar - half, 0.0]]), behind, 0.04 * top),
        "mass": mass,
        "wires": _joined(*(_joined(frame_pins[..., i : i + 1, :], mass_pins[..., i : i + 1, :], gap=False)
                           for i in range(len(planar)))),
        "pins": np.concatenate([frame_pins, mass_pins], axis=-2),
        "hidden": on_mass(across["along"] + parameters.LG, across["across"]),
        "P": P,
        "G": on_mass([parameters.LG], [0.0]),
    }  # fmt: skip


def _frame_sizes(parameters):
    """Half length and half height of the frame, its bars' thickness, and where the shaker's wall stands (m)."""
    reach = parameters.Rm + parameters.d
    bar = 0.08 * reach
    half = parameters.Lm / 2 + abs(parameters.LG) + 0.35 * reach
    return half, reach + bar, bar, -half - 0.8 * max(reach, half)


def _joined(*lines, gap=True):
    """Lines one after the other, shape (..., n, 2), with a NaN between them if ``gap``."""
    shape = np.broadcast_shapes(*(line.shape[:-2] for line in lines))
    parts = []
    for line in lines:
        parts.append(np.broadcast_to(line, (*shape, *line.shape[-2:])))
        if gap:
            parts.append(np.full((*shape, 1, 2), np.nan))
    return np.concatenate(parts[:-1] if gap else parts, axis=-2)


def _between(begin, end, along, across):
    """Points at a share of the way from begin to end and at a distance (m) across it, which is upwards."""
    way = np.asarray(along)[:, None] * (end - begin)
    return begin + way + np.column_stack([np.zeros(len(across)), across])


def _spring(wall, end, width):
    along = np.concatenate([[0, 0.2], np.linspace(0.2, 0.8, 9)[:-1] + 0.0375, [0.8, 1]])
    across = np.concatenate([[0, 0], width * (-1.0) ** np.arange(8), [0, 0]])
    begin = np.stack([np.full(end.shape[:-1], wall), end[..., 1]], axis=-1)
    return _between(begin, end, along, across)


def _dashpot(begin, end, width):
    if np.isscalar(begin):
        begin = np.stack([np.full(end.shape[:-1], begin), end[..., 1]], axis=-1)
    cup = _between(begin, end, [0, 0.35, 0.35, 0.7, 0.35, 0.35, 0.7], width * np.array([0, 0, 1, 1, 1, -1, -1]))
    plunger = _between(begin, end, [0.55, 0.55, 0.55, 1], 0.7 * width * np.array([1, -1, 0, 0]))
    return _joined(cup, plunger)


def _ground(half, top, bar, wall):
    """Wall and guide with their hatching."""
    floor = -top - bar
    tick = 0.6 * bar
    lines = [np.array([[wall, 0.6 * top], [wall, -0.6 * top]]), np.array([[-1.1 * half, floor], [1.1 * half, floor]])]
    lines += [np.array([[wall, y], [wall - tick, y - tick]]) for y in np.linspace(-0.55, 0.6, 10) * top]
    lines += [np.array([[x, floor], [x - tick, floor - tick]]) for x in np.linspace(-1.05, 1.1, 16) * half]
    return _joined(*lines)


def rig_figure(parameters, coordinates=None, exaggeration=1.0, title=None):
    """The rig in its vertical plane, to scale: Fig. 1b of the paper for one wire set, Fig. 2 for two.

    Parameters
    ----------
    parameters : RigParameters
    coordinates : array_like, shape (4,), optional
        xs, X, Y (m) and tilt (rad), as `static_equilibrium` gives them; without gravity's sag if left out.
    exaggeration : float
        The tilt is drawn this many times as large, and the figure says so.
    title : str, optional

    Returns
    -------
    DescribedFigure

    Raises
    ------
    ValueError
        If ``parameters`` is not a rig's, there are not four coordinates, or the exaggeration is not above zero.
    """
    return rigs_figure(
        [parameters], None if coordinates is None else [coordinates], exaggeration, None if title is None else [title]
    )


def rigs_figure(rigs, coordinates=None, exaggeration=1.0, titles=None):
    """Rigs side by side on the same scale; see `rig_figure`.

    Parameters
    ----------
    rigs : sequence of RigParameters, length n
    coordinates : sequence of array_like, optional
        n times (4,).
    exaggeration : float
    titles : sequence of str, optional
        n titles.

    Returns
    -------
    DescribedFigure

    Raises
    ------
    ValueError
        As `rig_figure`, or if there are not as many coordinates or titles as rigs.
    """
    rigs = only_rigs(rigs)
    at = [rest_position(p) for p in rigs] if coordinates is None else list(coordinates)
    titles = [f"{_WORDS[p.wire_sets].capitalize()} ({_PAPER[p.wire_sets]})" for p in rigs] if titles is None else titles
    for name, given in (("coordinates", at), ("titles", titles)):
        if len(given) != len(rigs) or not rigs:
            raise ValueError(f"{name} has {len(given)} elements for {len(rigs)} rigs; expected one a rig, at least one")
    at = [checks.array("coordinates", q) for q in at]
    for q in at:
        if q.size != 4:
            raise ValueError(f"coordinates has {q.size} elements; expected 4: xs, X, Y and tilt")
    exaggeration = checks.positive("exaggeration", exaggeration)
    words = [_rig_words(p, q) for p, q in zip(rigs, at, strict=True)]
    alt = "Side view of the rig to scale. " + " ".join(words)
    with style():
        figure, grid = subplots(
            1,
            len(rigs),
            alt=alt,
            width=5.6 * len(rigs),
            height=5.7 if len(rigs) > 1 else 6.0,
            squeeze=False,
            sharey=True,
        )
        for axes, p, q, title in zip(grid[0], rigs, at, titles, strict=True):
            _draw_rig(axes, p, q, exaggeration)
            axes.set_title(title)
        for axes in grid[0, 1:]:
            axes.set_ylabel("")
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=5 if len(rigs) > 1 else 3)
    return figure


def _rig_words(p, q):
    spacing = "" if p.wire_sets == 1 else f", {1e3 * (p.set_positions[1] - p.set_positions[0]):.3g} mm apart"
    words = (
        f"A cylinder {1e3 * p.Lm:.3g} mm long and {2e3 * p.Rm:.3g} mm thick hangs in a frame on {_WORDS[p.wire_sets]}"
        f"{spacing}, wires {1e3 * p.d:.3g} mm long, its centre of mass {1e3 * p.LG:.3g} mm from P"
    )
    return words + (f"; it is tilted by {np.degrees(q[3]):.3g} degrees." if q[3] else ".")


def _draw_rig(axes, p, q, exaggeration):
    parts = {name: 1e3 * points for name, points in rig_parts(p, q, exaggeration).items()}
    half, top, bar, wall = (1e3 * size for size in _frame_sizes(p))
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
        xlabel="x (mm)", ylabel="y (mm)", aspect="equal",
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
    if sets[-1] > sets[0]:
        over, text = -0.8 * top, f"{sets[-1] - sets[0]:.4g} mm"
        dimension((sets[0], over), (sets[-1], over), text, (sets.mean(), over + gap), "center", "bottom")
    axes.text(origin - gap, -gap, "P", ha="right", va="top", fontsize=9, zorder=8)
    axes.text(origin + LG + gap, -gap, "G", ha="left", va="top", fontsize=9, zorder=8)


def modes_figure(parameters, largest=4e-3):
    """Mode shapes of the rig about its static equilibrium, drawn on the rig; their amplitude is arbitrary.

    Parameters
    ----------
    parameters : RigParameters
    largest : float
        Each mode is drawn so large that no corner of frame or mass moves by more than this (m).

    Returns
    -------
    DescribedFigure

    Raises
    ------
    ValueError
        If ``parameters`` is not a rig's, it has no stable equilibrium, a mode does not oscillate, or ``largest`` is not
        above zero.
    """
    (parameters,) = only_rigs([parameters])
    largest = checks.positive("largest", largest, "m")
    rest, modes = static_equilibrium(parameters).coordinates, linear_modes(parameters)
    told = [f"{name} {f:.4g} Hz" for name, f in zip(modes.names, modes.frequency, strict=True)]
    sets = _WORDS[parameters.wire_sets]
    alt = f"Mode shapes of the rig with {sets}, thick on the grey rig at rest, not to scale: {', '.join(told)}."
    with style():
        figure, grid = subplots(1, 4, alt=alt, width=11.0, height=5.0, sharex=True, sharey=True)
        still = rig_parts(parameters, rest)
        for axes, shape, text, damping in zip(grid, modes.shape, told, modes.damping, strict=True):
            # To first order the corners move in proportion, so one step tells how far to go.
            small = 1e-6 * shape.real
            reach = max(
                np.linalg.norm(rig_parts(parameters, rest + small)[name] - still[name], axis=-1).max()
                for name in ("frame", "mass")
            )
            moved = rig_parts(parameters, rest + small * (largest / reach))
            for parts, look in ((still, {"color": GREY, "linewidth": 0.8}), (moved, {"color": RED, "linewidth": 1.6})):
                for name in ("frame", "mass"):
                    axes.fill(*(1e3 * parts[name]).T, fill=False, edgecolor=look["color"], linewidth=look["linewidth"])
                axes.plot(*(1e3 * parts["wires"]).T, **look | {"linewidth": 0.8})
            axes.set(xlabel="x (mm)", title=f"{text}\ndamping {100 * damping:.2f} %", aspect="equal")
        grid[0].set_ylabel("y (mm)")
        looks = {"at rest": GREY, "in the mode (amplitude and sign arbitrary)": RED}
        lines = [Line2D([], [], color=color, label=text) for text, color in looks.items()]
        figure.legend(handles=lines, loc="outside upper center", ncols=2)
    return figure


def wire_law_figure(parameters, reached=None, largest=5e-3):
    """Force of the wires by Eq. (1) and by Eq. (2), and the error of Eq. (2).

    Parameters
    ----------
    parameters : RigParameters
    reached : pair of float, optional
        Least and largest amplitude of z in a test (m), marked as a band.
    largest : float
        The force is drawn up to this z (m).

    Returns
    -------
    DescribedFigure

    Raises
    ------
    ValueError
        If ``largest`` is not above zero or the range reached is not ascending.
    """
    largest = checks.positive("largest", largest, "m")
    z = np.linspace(-largest, largest, 401)
    decades = np.geomspace(largest / 100, largest, 301)
    error = 100 * cubic_law_error(decades, parameters)
    alt = (
        f"Left: force of the wires over z by the exact and the cubic law; at {1e3 * largest:.3g} mm they give "
        f"{suspension_force(largest, parameters):.4g} N and {suspension_force(largest, parameters, 'cubic'):.4g} N. "
        f"Right: error of the cubic law, which grows with z to {error[-1]:.2g} %."
    )
    if reached is not None:
        reached = checks.array("reached", reached, "m", low=0.0, low_open=True, min_size=2)
        if reached.size != 2 or reached[0] >= reached[1]:
            raise ValueError(f"reached = {reached} m is not allowed; expected the least and the largest amplitude of z")
        worst = 100 * float(cubic_law_error(reached[1], parameters))
        alt += (
            f" The test reaches amplitudes of z from {1e3 * reached[0]:.2g} to {1e3 * reached[1]:.3g} mm, "
            f"with an error of at most {worst:.2g} %."
        )
    with style():
        figure, (left, right) = subplots(1, 2, alt=alt, width=9.0)
        if reached is not None:
            low, high = 1e3 * reached
            left.axvspan(-high, high, color=SKY, alpha=0.25, linewidth=0, label="z reached in the test")
            right.axvspan(low, high, color=SKY, alpha=0.25, linewidth=0, label="amplitudes in the test")
        left.plot(1e3 * z, suspension_force(z, parameters), color=BLACK, label="Eq. (1), exact")
        left.plot(1e3 * z, suspension_force(z, parameters, "cubic"), "--", color=ORANGE, label="Eq. (2), cubic")
        left.set(xlabel="relative displacement z (mm)", ylabel="force of the wires (N)")
        left.legend()
        right.loglog(1e3 * decades, error, color=BLACK, label="error of Eq. (2)")
        right.set(xlabel="relative displacement z (mm)", ylabel="error of the force (%)")
        right.legend()
    return figure


def statics_figure(parameters, points=25):
    """Tilt under gravity, rocking and bounce over the wires' tension and the mass's offset, with one set and two.

    The lower and the higher of the two modes are drawn, not "rocking" and "bounce": with two sets they change
    places as the offset grows. One set's wires are twice as stiff, so that k1 and k3 are equal. Where there is no
    stable equilibrium, or the rig cannot be built, a cross on the lower edge says so.

    Parameters
    ----------
    parameters : RigParameters
        With one set or two; the other rig follows from it.
    points : int
        Rigs a curve.

    Returns
    -------
    DescribedFigure

    Raises
    ------
    ValueError
        If ``parameters`` is not a rig's, or ``points`` not a whole number of at least 2.
    """
    (parameters,) = only_rigs([parameters])
    points = checks.integer("points", points, low=2)
    rigs = {1: parameters.single_set(), 2: _two_sets(parameters)}
    stretch = np.geomspace(min(0.1, _stretch(parameters) / 3e-6 or 0.1), 33, points) * 3e-6
    offset = np.linspace(parameters.Lm / 100, 0.45 * parameters.Lm, points)
    sweeps = (
        ("stretch of the wires d - d0 (µm)", 1e6, stretch, lambda p, value: p.replace(d0=p.d - value), _stretch),
        ("offset of the centre of mass LG (mm)", 1e3, offset, lambda p, value: p.replace(LG=value), lambda p: p.LG),
    )
    told = [
        f"{_WORDS[n]} tilts by {np.degrees(tilt):.2g} degrees and rocks and bounces at {lower:.3g} and {upper:.4g} Hz"
        for n, (tilt, lower, upper) in ((n, _hangs(rig)) for n, rig in rigs.items())
    ]
    alt = (
        "Tilt at rest, and the two frequencies at which the mass rocks and bounces, over the stretch of the wires and "
        f"over the offset of the centre of mass. This rig with {'; with '.join(told)}."
    )
    with style():
        figure, grid = subplots(2, 2, alt=alt, width=9.5, height=6.6, sharex="col", sharey="row")
        for column, (label, unit, values, change, now) in zip(grid.T, sweeps, strict=True):
            for n, rig in rigs.items():
                tilt, lower, upper = np.array([_hangs_if_built(rig, change, value) for value in values]).T
                look = {"color": _LOOK[n]["color"], "linestyle": _LOOK[n]["linestyle"], "linewidth": 0.8}
                column[1].plot(unit * values, upper, **look, label=f"{_WORDS[n]}, higher mode")
                for axes, result in ((column[0], np.degrees(tilt)), (column[1], lower)):
                    axes.plot(unit * values, result, **_LOOK[n], markersize=3.5, label=_WORDS[n])
                    failed = np.isnan(result)
                    if failed.any():
                        axes.plot(
                            unit * values[failed], np.full(failed.sum(), 0.02 + 0.05 * (n - 1)), "x",
                            color=_LOOK[n]["color"], transform=axes.get_xaxis_transform(), clip_on=False,
                            label=f"{_WORDS[n]}: none found",
                        )  # fmt: skip
            for axes in column:
                axes.axvline(unit * now(parameters), color=GREY, linewidth=1.0, linestyle=":", label="this rig")
            column[1].set_xlabel(label)
        for axes in grid.flat:
            axes.set_yscale("log")
        for axes in grid[:, 0]:
            axes.set_xscale("log")
        grid[0, 0].set_ylabel("tilt at rest (°)")
        grid[1, 0].set_ylabel("rocking and bounce (Hz)")
        tension = rigs[2].wire_stiffness.mean() * 1e-6
        above = grid[0, 0].secondary_xaxis("top", functions=(lambda s: tension * s, lambda T: T / tension))
        above.set_xlabel("tension of a wire, two sets (N); twice that with one")
        handles = {}
        for axes in grid.flat:
            handles.update({label: handle for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)})
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3)
    return figure


def _stretch(parameters):
    return parameters.d - parameters.d0


def _two_sets(parameters):
    if parameters.wire_sets == 2:
        return parameters
    half = parameters.wire_stiffness / 2
    return parameters.replace(wire_sets=2, k=tuple(np.tile(half, 2)))


def _hangs(parameters):
    """Tilt (rad), and the two frequencies at which the mass rocks and bounces (Hz), NaN where there is none."""
    tilt, pair = np.nan, (np.nan, np.nan)
    try:
        tilt = abs(static_equilibrium(parameters).tilt)
        modes = linear_modes(parameters)
        pair = modes.frequency[[name in ("rocking", "bounce") for name in modes.names]]
    except ValueError:
        pass  # the figure marks it
    return tilt, *pair


def _hangs_if_built(rig, change, value):
    try:
        return _hangs(change(rig, value))
    except ValueError:
        return (np.nan,) * 3
