"""How a curve looks and where it runs, as SVG in whole tenths of a point, and its entry in a legend."""

import numpy as np
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.path import Path

# Line key of the house (`figures.style`); "outline" is a closed shape, filled lightly. Widths and dashes in points.
KINDS = {
    "stable": {"width": 1.6},
    "unstable": {"width": 1.6, "dash": (5.9, 2.6)},
    "line": {"width": 1.2},
    "wire": {"width": 2.2},
    "slack": {"width": 1.4, "dash": (3.0, 2.2)},
    "outline": {"width": 1.2, "fill": 0.15},
    "point": {"width": 1.2, "radius": 3.0},
    "dot": {"width": 0.0, "radius": 2.5, "fill": 1.0},
}


def handles(keys):
    """Legend entries, one for each label and colour; where solid and dashed share both, the solid one."""
    entries = {}
    for kind, label, color in keys:
        if label and (kind != "unstable" or (label, color) not in entries):
            entries[label, color] = _handle(kind, label, color)
    return list(entries.values())


def _handle(kind, label, color):
    key = KINDS[kind]
    if "radius" in key:
        fill = color if "fill" in key else "none"
        return Line2D([], [], linestyle="none", marker="o", color=color, markerfacecolor=fill, label=label)
    return Line2D([], [], linestyle="--" if "dash" in key else "-", color=color, label=label)


def look(kind, color):
    """SVG attributes of a kind of line, in tenths of a point."""
    key = KINDS[kind]
    color = to_hex(color)
    text = f'stroke="{color}" stroke-width="{10 * key["width"]:g}"'
    text += f' fill="{color}" fill-opacity="{key["fill"]:g}"' if "fill" in key else ' fill="none"'
    if "dash" in key:
        text += ' stroke-dasharray="{:g} {:g}"'.format(*(10 * length for length in key["dash"]))
    return text


def path_of(curve, axes, box, height):
    """The curve as SVG path text in whole tenths of a point: absolute starts, relative steps."""
    points = np.column_stack([curve.x, curve.y])
    for column, scale in enumerate((axes.get_xscale(), axes.get_yscale())):
        if scale == "log":
            points[points[:, column] <= 0, column] = np.nan
    points = axes.transData.transform(points)
    key = KINDS[curve.kind]
    if "radius" in key:
        points = points[np.isfinite(points).all(axis=1)]
        r = round(10 * key["radius"])
        circle = f"m{-r} 0a{r} {r} 0 1 0 {2 * r} 0a{r} {r} 0 1 0{-2 * r} 0"
        return "".join(f"M{x} {y}{circle}" for x, y in _tenths(points, height))
    if not len(points):
        return ""
    if "fill" in key:
        return _line(_tenths(points, height)) + "z"
    # Matplotlib's own clipping and merging of points that lie on a straight line within a ninth of a pixel.
    margin = np.array([-5, -5, 5, 5])
    cleaned = Path(points).cleaned(remove_nans=True, clip=tuple(box + margin), simplify=True)
    keep = cleaned.codes != Path.STOP
    starts = np.flatnonzero(cleaned.codes[keep] == Path.MOVETO)[1:]
    return "".join(_line(_tenths(part, height)) for part in np.split(cleaned.vertices[keep], starts) if len(part) > 1)


def _tenths(points, height):
    return np.rint(10 * np.column_stack([points[:, 0], height - points[:, 1]])).astype(int).tolist()


def _line(points):
    """One piece of a line; repeated points are dropped, a minus sign needs no space before it."""
    (x, y), *rest = points
    steps = []
    for next_x, next_y in rest:
        if (next_x, next_y) != (x, y):
            steps += [next_x - x, next_y - y]
            x, y = next_x, next_y
    return f"M{points[0][0]} {points[0][1]}" + ("l" + " ".join(map(str, steps)).replace(" -", "-") if steps else "")
