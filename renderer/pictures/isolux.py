"""The isolux plan of a grid: contours and numbers over the room, its furniture and its luminaires."""

from pathlib import Path

import numpy as np
import shapely
from scipy.interpolate import RBFInterpolator

from renderer.pictures.canvas import broken
from renderer.pictures.charts import new_figure, saved
from renderer.pictures.sheet import plain
from renderer.readings.grid import GridReading
from renderer.scene.grids import Grid
from renderer.scene.scene import Scene
from renderer.scene.triangle_mesh import TriangleMesh

CONTOUR_COLOUR = "#7a3b00"
"""Colour of contours and their numbers."""

LINE_STYLES = {
    "area of the grid": {"colors": "#707070", "linewidths": 0.8, "linestyles": ":", "zorder": 2},
    "object": {"colors": "#4a6078", "linewidths": 1.0, "zorder": 2.5},
    "luminaire": {"colors": "#cc2222", "linewidths": 1.2, "linestyles": "--", "zorder": 6},
}
"""Lines of the legend. A point luminaire is a cross."""

MAX_SPLINE_POINTS = 400
"""Number of points above which a spline through all of them takes seconds."""

FRAME_INCHES = 7.2
"""Longer side of the frame [inches]."""

DPI = 110

LETTER = 0.64
"""Width of a digit in sizes of the font; letters of a text are narrower on average."""


def save_isolux(scene: Scene, reading: GridReading, path: Path) -> Path:
    """Draw the plan of a grid, or the elevation of an upright one."""
    axes_of = _axes(reading.grid)
    walls, shapes = _room(scene, reading.grid, axes_of)
    low, high = _view(reading, axes_of, np.vstack([*walls, *(points for _, points in shapes)]))
    size = FRAME_INCHES * (high - low) / (high - low).max()
    figure = new_figure(*size, dpi=DPI)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    filled, lines = _draw_light(axes, reading, axes_of)
    _draw_room(axes, walls, shapes)
    plan = axes_of[2, 2] == 1
    axes.set_xlabel("x [m]" if plan else "across, from the grid's corner [m]")
    axes.set_ylabel("y [m]" if plan else "up [m]")
    _lay_out(figure, axes, size, f"{scene.title}: {reading.grid.name}", _caption(reading), filled)
    _write_numbers(axes, reading, _flat(reading.grid.points[reading.read], reading.grid, axes_of), lines)
    return saved(figure, path)


def _lay_out(figure, axes, size: np.ndarray, title: str, caption: str, filled) -> None:
    """Put the title, the caption, the colour bar of filled contours and the legend around axes.

    size : of the axes (2,) [inches]; filled : or None for no colour bar

    matplotlib's constrained layout would lay out every text several times.
    """
    digits = max(map(len, axes.yaxis.get_major_formatter().format_ticks(axes.get_yticks())))
    left = 0.55 + LETTER * 10 / 72 * digits
    right, bar = 0.2, 0.0
    if filled is not None:
        right = 0.9 + LETTER * 10 / 72 * max(len(f"{level:g}") for level in filled.levels)
        bar = max(0.8 * size[1], 0.18 * len(filled.levels))
    width = max(left + size[0] + right, 0.4 + LETTER * 9.5 / 72 * max(map(len, caption.split("\n"))), 5.8)
    names = broken(plain(title), 12.5 / 72, width - 0.4)
    head = 0.55 + 0.21 * len(names)
    body = max(size[1], bar + 0.15)
    height = head + body + 0.9
    figure.set_size_inches(width, height)
    corner = (width - left - size[0] - right) / 2 + left, height - head - (body + size[1]) / 2

    def box(x: float, y: float, across: float, up: float) -> tuple[float, ...]:
        return x / width, y / height, across / width, up / height

    axes.set_position(box(*corner, *size))
    figure.text(0.5, 1 - 0.1 / height, "\n".join(names), fontsize=12.5, weight="bold", ha="center", va="top")
    figure.text(0.5, 1 - (head - 0.08) / height, caption, fontsize=9.5, ha="center", va="bottom")
    if filled is not None:
        right_of = box(corner[0] + size[0] + 0.18, corner[1] + (size[1] - bar) / 2, 0.27, bar)
        figure.colorbar(filled, cax=figure.add_axes(right_of), label="illuminance [lx]", format="%g",
                        ticks=filled.levels)
    figure.legend(loc="lower center", ncols=4, fontsize=8, frameon=False)


def _caption(reading: GridReading) -> str:
    parts = [f"Ē {_lux(reading.mean.value)} ± {reading.mean.uncertainty:.2g} lx",
             f"Eₘᵢₙ {_lux(reading.least.value)} lx", f"Eₘₐₓ {_lux(reading.most.value)} lx"]
    if reading.uniformity is not None:
        parts.append(f"U₀ {reading.uniformity:.3f} ± {reading.uniformity_error:.1g}")
    points = f"{reading.grid.counts[0]} × {reading.grid.counts[1]} points"
    if reading.left_out:
        points += f", {reading.left_out} left out"
    return ",   ".join(parts) + f"\n{points}"


def _lux(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def _axes(grid: Grid) -> np.ndarray:
    """Unit vectors (3, 3) across, up and out of the paper. For a nearly level grid they are the room's
    axes."""
    out = np.cross(grid.u, grid.v) / (np.linalg.norm(grid.u) * np.linalg.norm(grid.v))
    if abs(out[2]) > 0.9:
        return np.eye(3)
    up = np.array([0.0, 0.0, 1.0]) - out[2] * out
    up /= np.linalg.norm(up)
    return np.array([np.cross(up, out), up, out])


def _flat(points: np.ndarray, grid: Grid, axes_of: np.ndarray) -> np.ndarray:
    """Points (…, 3) [m] on the paper (…, 2): room coordinates in a plan, else from the grid's corner."""
    origin = 0.0 if axes_of[2, 2] == 1 else grid.corner
    return (points - origin) @ axes_of[:2].T


def _draw_light(axes, reading: GridReading, axes_of: np.ndarray) -> tuple:
    """Draw filled contours of interpolated illuminance, and their lines. None of both for uniform illuminance
    and for a single row of points."""
    if min(reading.grid.counts) == 1 or np.ptp(reading.total) <= 1e-6 * reading.most.value:
        return None, None
    from matplotlib.ticker import MaxNLocator

    levels = MaxNLocator(10, steps=[1, 2, 2.5, 5, 10]).tick_values(reading.least.value, reading.most.value)
    places, lux = interpolated(reading)
    surface = (*np.moveaxis(_flat(places, reading.grid, axes_of), -1, 0), np.ma.masked_invalid(lux))
    filled = axes.contourf(*surface, levels=levels, cmap="YlOrBr", alpha=0.75, zorder=1)
    return filled, axes.contour(*surface, levels=levels, colors=CONTOUR_COLOUR, linewidths=0.9, zorder=3)


def interpolated(reading: GridReading) -> tuple[np.ndarray, np.ndarray]:
    """Places (k_v, k_u, 3) [m], eight to each step of the grid, and the illuminance there (k_v, k_u) [lx].

    A thin plate spline through the points that were read, limited to their range; NaN where the nearest point
    was not read. Of more than MAX_SPLINE_POINTS the nearest 25 of each place, and four places to each step.
    """
    grid = reading.grid
    n_u, n_v = grid.counts
    many = len(reading.total) > MAX_SPLINE_POINTS
    steps = 4 if many else 8
    across, up = ((0.5 + np.linspace(0, n - 1, (n - 1) * steps + 1)) / n for n in (n_u, n_v))
    t, s = np.meshgrid(up, across, indexing="ij")
    places = grid.corner + s[..., None] * grid.u + t[..., None] * grid.v
    # In cells, for equal weight of both directions.
    fine = np.column_stack([(s * n_u).ravel(), (t * n_v).ravel()])
    centres = np.array([(i + 0.5, j + 0.5) for j in range(n_v) for i in range(n_u)])
    i, j = np.minimum(fine.astype(int), [n_u - 1, n_v - 1]).T
    near = j * n_u + i
    kernel = {"kernel": "thin_plate_spline"}
    if many:  # 25 points may lie on one line, which does not determine a thin plate
        kernel = {"kernel": "multiquadric", "epsilon": 0.25, "degree": 0, "neighbors": 25}
    elif _in_line(reading):
        kernel = {"kernel": "linear", "degree": 0}
    lux = RBFInterpolator(centres[reading.read], reading.total, **kernel)(fine)
    lux = np.clip(lux, reading.total.min(), reading.total.max())
    return places, np.where(reading.read[near], lux, np.nan).reshape(s.shape)


def _in_line(reading: GridReading) -> bool:
    """Whether the points that were read lie on one line, which does not determine a thin plate."""
    places = np.argwhere(reading.read.reshape(reading.grid.counts[::-1]))
    return np.linalg.matrix_rank(places - places[0]) < 2


def _write_numbers(axes, reading: GridReading, places: np.ndarray, lines) -> None:
    """Write the illuminance at places (k, 2) [m] where there is room, then on contours where that covers no
    number."""
    from matplotlib.patheffects import withStroke

    style = {"ha": "center", "va": "center", "zorder": 7, "clip_on": True,
             "path_effects": [withStroke(linewidth=2, foreground="white", alpha=0.7)]}
    numbers = [_lux(value) for value in reading.total]
    to_paper, point = axes.transData.transform, DPI / 72
    width = max(22.0, (LETTER * max(map(len, numbers)) + 0.4) * 7.2) * point
    height = 9.0 * point
    taken: list[np.ndarray] = []
    for place, at, number in zip(places, to_paper(places), numbers, strict=True):
        if _free(at, taken, width, height):
            taken.append(at)
            axes.text(*place, number, fontsize=7.2, color="#202020", **style)
    style |= {"fontsize": 8, "color": CONTOUR_COLOUR, "weight": "bold"}
    for level, pieces in zip(lines.levels, lines.allsegs, strict=True) if lines else ():
        for piece in pieces:
            path = to_paper(piece)
            if np.linalg.norm(np.diff(path, axis=0), axis=1).sum() < 3 * width:
                continue
            order = np.argsort(np.abs(np.arange(len(path)) - len(path) / 2), kind="stable")
            spot = next((k for k in order if _free(path[k], taken, 1.15 * width, 1.3 * height)), None)
            if spot is not None:
                taken.append(path[spot])
                axes.text(*piece[spot], f"{level:g}", **style)


def _free(at: np.ndarray, taken: list[np.ndarray], width: float, height: float) -> bool:
    """Whether a label of size (width, height) at `at` overlaps none of the labels at the places `taken`."""
    return not any(abs(at[0] - x) < width and abs(at[1] - y) < height for x, y in taken)


def _view(reading: GridReading, axes_of: np.ndarray, drawn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corner [m] of the part of the paper to show: all that is drawn (k, 2), or a
    grid and its surroundings where it is shorter than 0.35 of that."""
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    corners = _flat(_corners(reading.grid), reading.grid, axes_of)
    first, last = corners.min(axis=0), corners.max(axis=0)
    if (last - first).max() < 0.35 * (high - low).max():
        middle, reach = (first + last) / 2, (last - first).max()
        return middle - reach, middle + reach
    margin = 0.03 * (high - low).max()
    return low - margin, high + margin


def _corners(grid: Grid) -> np.ndarray:
    """The corners (5, 3) [m] of a grid, the first one again at the end."""
    return grid.corner + np.array([0 * grid.u, grid.u, grid.u + grid.v, grid.v, 0 * grid.u])


def _room(scene: Scene, grid: Grid, axes_of: np.ndarray
          ) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
    """The section (m, 2, 2) [m] of the room in the grid's plane; and the grid, the objects and the luminaires
    as lines (k, 2) [m], each with its label in the legend. A point luminaire is one place (1, 2)."""
    # Slightly off the plane, into the room: a grid on the floor cuts no wall.
    inward = np.sign((scene.room.bounds.mean(axis=0) - grid.corner) @ axes_of[2]) or 1.0
    at = grid.corner + 1e-4 * scene.room.scale * inward * axes_of[2]

    def cut(shell: np.ndarray) -> np.ndarray:
        return _flat(_section(shell, axes_of[2], at), grid, axes_of)

    plan = axes_of[2, 2] == 1
    shapes = [("area of the grid", _flat(_corners(grid), grid, axes_of))]
    for body in scene.bodies:
        shapes += [("object", ring) for ring in (_footprint(body.mesh) if plan else cut(body.mesh.triangles))]
    for lum in scene.luminaires if plan else ():
        outline = np.vstack([lum.corners, lum.corners[:1]]) if len(lum.corners) > 1 else lum.corners
        shapes.append(("luminaire" if len(outline) > 1 else "point luminaire", _flat(outline, grid, axes_of)))
    return cut(scene.room.shell), shapes


def _draw_room(axes, walls: np.ndarray, shapes: list[tuple[str, np.ndarray]]) -> None:
    """Draw the room's section (m, 2, 2) [m], and the lines and point luminaires of `_room`."""
    from matplotlib.collections import LineCollection

    axes.add_collection(LineCollection(walls, colors="black", linewidths=1.6, zorder=5), autolim=False)
    for label in dict.fromkeys(label for label, _ in shapes):
        lines = [points for each, points in shapes if each == label]
        if label in LINE_STYLES:
            axes.add_collection(LineCollection(lines, label=label, **LINE_STYLES[label]), autolim=False)
        else:
            axes.plot(*np.vstack(lines).T, "x", color="#cc2222", zorder=6, label=label,
                      scalex=False, scaley=False)


def _section(triangles: np.ndarray, normal: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Lines (m, 2, 3) [m] along which a plane through `at` (3,) cuts triangles (k, 3, 3) that have corners on
    both sides of it."""
    height = (triangles - at) @ normal
    above = height >= 0
    cut = above.any(axis=1) & ~above.all(axis=1)
    triangles, height, above = triangles[cut], height[cut], above[cut]
    lone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    row, ends = np.arange(len(lone)), []
    for other in ((lone + 1) % 3, (lone + 2) % 3):
        share = height[row, lone] / (height[row, lone] - height[row, other])
        corner = triangles[row, lone]
        ends.append(corner + share[:, None] * (triangles[row, other] - corner))
    return np.stack(ends, axis=1)


def _footprint(mesh: TriangleMesh) -> list[np.ndarray]:
    """Outlines (k, 2) [m] of a body from above; the convex hull for a body with over 20,000 faces."""
    if len(mesh.faces) > 20_000:
        shape = shapely.convex_hull(shapely.MultiPoint(mesh.vertices[:, :2]))
    else:
        flat = shapely.polygons(mesh.triangles[:, :, :2])
        shape = shapely.union_all(flat[shapely.area(flat) > 0])
    parts = [part for part in getattr(shape, "geoms", [shape]) if part.geom_type == "Polygon"]
    return [np.array(part.exterior.coords) for part in parts]
