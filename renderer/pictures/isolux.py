"""The isolux plan of a grid: contours and numbers over the room, its furniture and its luminaires."""

from pathlib import Path

import numpy as np
from scipy.interpolate import RBFInterpolator

from renderer.pictures.charts import lay_out, new_figure, saved
from renderer.readings.grid import GridReading
from renderer.scene.grids import Grid
from renderer.scene.scene import Scene
from renderer.scene.triangle_mesh import TriangleMesh


def save_isolux(scene: Scene, reading: GridReading, path: Path) -> Path:
    """Draw the plan of a grid, or the elevation of an upright one."""
    grid = reading.grid
    axes_of = _axes(grid)
    width, height = np.ptp(_flat(scene.room.corners, grid, axes_of), axis=0)
    inches = np.clip(np.array([width, height]) * 7.2 / max(width, height), (4.4, 2.6), None)
    figure = new_figure(inches[0] + 1.9, inches[1] + 1.7, f"{scene.title}: {grid.name}", dpi=110)
    axes = figure.add_subplot()
    drawn = _draw_light(axes, reading, axes_of)
    if drawn is not None:
        figure.colorbar(drawn[0], ax=axes, label="illuminance [lx]", shrink=0.8, pad=0.02)
    _draw_room(axes, scene, grid, axes_of)
    axes.set_title(_caption(reading), fontsize=9.5)
    plan = axes_of[2, 2] == 1
    axes.set(aspect="equal", xlabel="x [m]" if plan else "across, from the grid's corner [m]",
             ylabel="y [m]" if plan else "up [m]")
    axes.margins(0.03)
    _zoom(axes, reading, axes_of, _flat(scene.room.corners, grid, axes_of))
    figure.legend(loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    _write_numbers(figure, axes, reading, axes_of, drawn and drawn[1])
    return saved(figure, path)


def _caption(reading: GridReading) -> str:
    parts = [f"$\\bar{{E}}$ {_lux(reading.mean.value)} ± {reading.mean.uncertainty:.2g} lx",
             f"$E_{{min}}$ {_lux(reading.least.value)} lx,  $E_{{max}}$ {_lux(reading.most.value)} lx"]
    if reading.uniformity is not None:
        parts.append(f"$U_0$ {reading.uniformity:.3f} ± {reading.uniformity_error:.1g}")
    points = f"{reading.grid.counts[0]} × {reading.grid.counts[1]} points"
    if reading.left_out:
        points += f", {reading.left_out} left out"
    return ",  ".join(parts) + f"\n{points}"


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


def _draw_light(axes, reading: GridReading, axes_of: np.ndarray):
    """Draw filled contours of interpolated illuminance, and their lines; None for uniform illuminance."""
    grid = reading.grid
    drawn = None
    if min(grid.counts) > 1 and np.ptp(reading.total) > 1e-6 * reading.most.value:
        from matplotlib.ticker import MaxNLocator

        levels = MaxNLocator(8).tick_values(reading.least.value, reading.most.value)
        places, lux = interpolated(reading)
        surface = (*np.moveaxis(_flat(places, grid, axes_of), -1, 0), np.ma.masked_invalid(lux))
        filled = axes.contourf(*surface, levels=levels, cmap="YlOrBr", alpha=0.75, zorder=1)
        drawn = filled, axes.contour(*surface, levels=levels, colors="#7a3b00", linewidths=0.9, zorder=3)
    ring = grid.corner + np.array([0 * grid.u, grid.u, grid.u + grid.v, grid.v, 0 * grid.u])
    axes.plot(*_flat(ring, grid, axes_of).T, color="#707070", lw=0.8, ls=":", zorder=2,
              label="area of the grid")
    return drawn


def interpolated(reading: GridReading) -> tuple[np.ndarray, np.ndarray]:
    """Places (k_v, k_u, 3) [m], eight to each step of the grid, and the illuminance there (k_v, k_u) [lx].

    A thin plate spline through the points that were read, limited to their range; NaN where the nearest point
    was not read.
    """
    grid = reading.grid
    n_u, n_v = grid.counts
    across, up = ((0.5 + np.linspace(0, n - 1, (n - 1) * 8 + 1)) / n for n in (n_u, n_v))
    t, s = np.meshgrid(up, across, indexing="ij")
    places = grid.corner + s[..., None] * grid.u + t[..., None] * grid.v
    # In cells, for equal weight of both directions.
    fine = np.column_stack([(s * n_u).ravel(), (t * n_v).ravel()])
    centres = np.array([(i + 0.5, j + 0.5) for j in range(n_v) for i in range(n_u)])
    i, j = np.minimum(fine.astype(int), [n_u - 1, n_v - 1]).T
    near = j * n_u + i
    kernel = {"kernel": "linear", "degree": 0} if _in_line(reading) else {"kernel": "thin_plate_spline"}
    # The nearest 400 of many centres: all of them take memory as their square.
    nearest = 400 if len(reading.total) > 400 else None
    lux = RBFInterpolator(centres[reading.read], reading.total, neighbors=nearest, **kernel)(fine)
    lux = np.clip(lux, reading.total.min(), reading.total.max())
    return places, np.where(reading.read[near], lux, np.nan).reshape(s.shape)


def _in_line(reading: GridReading) -> bool:
    """Whether the points that were read lie on one line, which does not determine a thin plate."""
    places = np.argwhere(reading.read.reshape(reading.grid.counts[::-1]))
    return np.linalg.matrix_rank(places - places[0]) < 2


def _write_numbers(figure, axes, reading: GridReading, axes_of: np.ndarray, lines) -> None:
    """Write the illuminance at points where there is room, then on contours where that covers no number."""
    lay_out(figure)
    to_paper = axes.transData.transform
    places = to_paper(_flat(reading.grid.points, reading.grid, axes_of))
    width, height = (figure.dpi / 72 * x for x in (22.0, 9.0))  # size of a number
    taken: list[np.ndarray] = []
    for index, value in zip(np.flatnonzero(reading.read), reading.total, strict=True):
        at = places[index]
        if _free(at, taken, width, height):
            taken.append(at)
            axes.text(*axes.transData.inverted().transform(at), _lux(value), ha="center", va="center",
                      fontsize=6.5, color="#202020", zorder=4,
                      bbox={"boxstyle": "square,pad=0.05", "fc": "white", "ec": "none", "alpha": 0.5})
    if lines is None:
        return
    for level, pieces in zip(lines.levels, lines.allsegs, strict=True):
        for piece in pieces:
            path = to_paper(piece)
            if np.linalg.norm(np.diff(path, axis=0), axis=1).sum() < 3 * width:
                continue
            order = np.argsort(np.abs(np.arange(len(path)) - len(path) / 2), kind="stable")
            spot = next((path[k] for k in order if _free(path[k], taken, 1.15 * width, 1.3 * height)), None)
            if spot is not None:
                taken.append(spot)
                axes.text(*axes.transData.inverted().transform(spot), f"{level:g}", ha="center", va="center",
                          fontsize=8, color="#7a3b00", zorder=5, weight="bold",
                          bbox={"boxstyle": "square,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.8})


def _free(at: np.ndarray, taken: list[np.ndarray], width: float, height: float) -> bool:
    """Whether a label of size (width, height) at `at` overlaps none of the labels at the places `taken`."""
    return not any(abs(at[0] - x) < width and abs(at[1] - y) < height for x, y in taken)


def _zoom(axes, reading: GridReading, axes_of: np.ndarray, room: np.ndarray) -> None:
    """Zoom to a grid and its surroundings where it is shorter than 0.35 of the room (k, 2)."""
    corners = _flat(reading.grid.corner + np.array([0 * reading.grid.u, reading.grid.u, reading.grid.v,
                                                    reading.grid.u + reading.grid.v]), reading.grid, axes_of)
    low, high = corners.min(axis=0), corners.max(axis=0)
    if (high - low).max() < 0.35 * np.ptp(room, axis=0).max():
        margin = 0.5 * (high - low).max()
        middle, reach = (low + high) / 2, (high - low).max() / 2 + margin
        axes.set(xlim=(middle[0] - reach, middle[0] + reach), ylim=(middle[1] - reach, middle[1] + reach))


def _draw_room(axes, scene: Scene, grid: Grid, axes_of: np.ndarray) -> None:
    """Draw the section of the room in the grid's plane, the objects and the luminaires."""
    from matplotlib.collections import LineCollection

    # Slightly off the plane, into the room: a grid on the floor cuts no wall.
    inward = np.sign((scene.room.bounds.mean(axis=0) - grid.corner) @ axes_of[2]) or 1.0
    at = grid.corner + 1e-4 * scene.room.scale * inward * axes_of[2]

    def cut(shell: np.ndarray) -> np.ndarray:
        return _flat(_section(shell, axes_of[2], at), grid, axes_of)

    axes.add_collection(LineCollection(cut(scene.room.shell), colors="black", linewidths=1.6, zorder=5))
    plan = axes_of[2, 2] == 1
    label = "object"
    for body in scene.bodies:
        for ring in _footprint(body.mesh) if plan else cut(body.mesh.triangles):
            axes.plot(*ring.T, color="#4a6078", lw=1.0, zorder=2.5, label=label)
            label = None
    label = "luminaire"
    for lum in scene.luminaires if plan else ():
        outline = np.vstack([lum.corners, lum.corners[:1]])
        style = {"marker": "x", "ls": ""} if lum.is_point else {"ls": "--", "lw": 1.2}
        axes.plot(*_flat(outline, grid, axes_of).T, color="#c22", zorder=6, label=label, **style)
        label = None


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
    import shapely

    if len(mesh.faces) > 20_000:
        shape = shapely.convex_hull(shapely.MultiPoint(mesh.vertices[:, :2]))
    else:
        flat = shapely.polygons(mesh.triangles[:, :, :2])
        shape = shapely.union_all(flat[shapely.area(flat) > 0])
    parts = [part for part in getattr(shape, "geoms", [shape]) if part.geom_type == "Polygon"]
    return [np.array(part.exterior.coords) for part in parts]
