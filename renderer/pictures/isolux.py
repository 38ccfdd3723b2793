"""The isolux plan of a grid: contours and numbers over the room, its furniture and its luminaires."""

from itertools import pairwise
from pathlib import Path

import contourpy
import numpy as np
import shapely
from scipy.interpolate import RBFInterpolator

from renderer.pictures.drawing import DPI, POINT, Frame, Sheet, cross_mark, font, round_ticks, tick_labels
from renderer.pictures.isolux_sheet import CROSS_SIZE, LINE_STYLES, colours_between, lay_out
from renderer.readings.grid import GridReading
from renderer.scene.grids import Grid
from renderer.scene.scene import Scene
from renderer.scene.triangle_mesh import TriangleMesh
from renderer.system.files import whole_file

CONTOUR_COLOUR = "#7a3b00"
"""Colour of contours and their numbers."""

MAX_SPLINE_POINTS = 400
"""Number of points above which a spline through all of them takes seconds."""


def save_isolux(scene: Scene, reading: GridReading, path: Path) -> Path:
    """Draw the plan of a grid, or the elevation of an upright one."""
    axes_of = _axes(reading.grid)
    walls, shapes = _room(scene, reading.grid, axes_of)
    frame = Frame(*_view(reading, axes_of, np.vstack([*walls, *(points for _, points in shapes)])))
    levels, contours = _draw_light(frame, reading, axes_of)
    luminaires = [shape for shape in shapes if "luminaire" in shape[0]]
    _draw_shapes(frame, [shape for shape in shapes if "luminaire" not in shape[0]])
    for contour in (piece for pieces in contours for piece in pieces):
        frame.line(contour, CONTOUR_COLOUR, 0.9)
    for wall in walls:
        frame.line(wall, "black", 1.6)
    _draw_shapes(frame, luminaires)
    names = ("x [m]", "y [m]") if axes_of[2, 2] == 1 else ("across, from the grid's corner [m]", "up [m]")
    sheet, corner = lay_out(f"{scene.title}: {reading.grid.name}", _caption(reading), frame, levels,
                            list(dict.fromkeys(label for label, _ in shapes)), names)
    places = _flat(reading.grid.points[reading.read], reading.grid, axes_of)
    _write_numbers(sheet, reading.total, frame.pixels(places) + corner, levels,
                   [[frame.pixels(piece) + corner for piece in pieces] for pieces in contours])
    with whole_file(path) as part:
        sheet.image.save(part, "PNG", dpi=(DPI, DPI), compress_level=3)
    return path


def _caption(reading: GridReading) -> list[list[tuple]]:
    """Two lines, each the runs of text of `Sheet.runs`."""

    def text(words: str) -> tuple:
        return words, 9.5, "", 0

    def symbol(letter: str, below: str = "") -> list[tuple]:
        return [(letter, 9.5, "-Oblique", 0), (below, 7, "-Oblique", 2 * POINT)]

    runs = [*symbol("Ē"), text(f" {_lux(reading.mean.value)} ± {reading.mean.uncertainty:.2g} lx,   "),
            *symbol("E", "min"), text(f" {_lux(reading.least.value)} lx,   "),
            *symbol("E", "max"), text(f" {_lux(reading.most.value)} lx")]
    if reading.uniformity is not None:
        runs += [text(",   "), *symbol("U", "0"),
                 text(f" {reading.uniformity:.3f} ± {reading.uniformity_error:.1g}")]
    points = f"{reading.grid.counts[0]} × {reading.grid.counts[1]} points"
    if reading.left_out:
        points += f", {reading.left_out} left out"
    return [runs, [text(points)]]


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


def _draw_light(frame: Frame, reading: GridReading, axes_of: np.ndarray
                ) -> tuple[np.ndarray, list[list[np.ndarray]]]:
    """Fill the areas between levels of the interpolated illuminance.

    Returns the levels (n,) [lx], and of each its contours (k, 2) [m] on the paper. None for uniform
    illuminance, and for a single row of points.
    """
    if min(reading.grid.counts) == 1 or np.ptp(reading.total) <= 1e-6 * reading.most.value:
        return np.zeros(0), []
    levels = round_ticks(reading.least.value, reading.most.value, 10)
    places, lux = interpolated(reading)
    across, up = np.moveaxis(_flat(places, reading.grid, axes_of), -1, 0)
    surface = contourpy.contour_generator(across, up, np.ma.masked_invalid(lux), fill_type="OuterOffset")
    rings = []
    for (low, high), colour in zip(pairwise(levels), colours_between(levels), strict=True):
        for points, offsets in zip(*surface.filled(low, high), strict=True):
            for k, (start, stop) in enumerate(pairwise(offsets)):
                x, y = points[start:stop].T
                size = abs(x[1:] @ y[:-1] - x[:-1] @ y[1:])
                # A hole comes before an area that fills it.
                rings.append((size * (1 + 1e-9 * (k > 0)), points[start:stop], "white" if k else colour))
    for _, points, colour in sorted(rings, key=lambda ring: -ring[0]):
        frame.area(points, colour)
    return levels, [surface.lines(level) for level in levels]


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


def _write_numbers(sheet: Sheet, lux: np.ndarray, places: np.ndarray, levels: np.ndarray,
                   contours: list[list[np.ndarray]]) -> None:
    """Write the illuminance at points where there is room, then on contours where that covers no number.

    lux : (k,) [lx] at places (k, 2); contours : of each level; all places in pixels of the sheet
    """
    numbers = [_lux(value) for value in lux]
    width = max(22.0 * POINT, 3 * POINT + max(map(font(7.2).getlength, numbers)))
    height = 9.0 * POINT
    taken: list[np.ndarray] = []
    for at, number in zip(places, numbers, strict=True):
        if _free(at, taken, width, height):
            taken.append(at)
            sheet.text(*at, number, 7.2, colour="#202020", veil=0.5)
    for level, pieces in zip(tick_labels(levels), contours, strict=True):
        for piece in pieces:
            if np.linalg.norm(np.diff(piece, axis=0), axis=1).sum() < 3 * width:
                continue
            order = np.argsort(np.abs(np.arange(len(piece)) - len(piece) / 2), kind="stable")
            spot = next((piece[k] for k in order if _free(piece[k], taken, 1.15 * width, 1.3 * height)), None)
            if spot is not None:
                taken.append(spot)
                sheet.text(*spot, level, 8, "-Bold", CONTOUR_COLOUR, veil=0.8)


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


def _draw_shapes(frame: Frame, shapes: list[tuple[str, np.ndarray]]) -> None:
    for label, points in shapes:
        for line in [points] if len(points) > 1 else cross_mark(points[0], CROSS_SIZE * POINT / frame.scale):
            frame.line(line, *LINE_STYLES[label])


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
