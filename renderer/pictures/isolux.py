"""A grid's isolux plan: contours and numbers, over the room, its furniture and its luminaires."""

from pathlib import Path

import numpy as np
import trimesh

from renderer.pictures.charts import new_figure, saved
from renderer.readings.grid import GridReading
from renderer.scene.grids import Grid
from renderer.scene.scene import Scene

LEVELS = 8
"""About so many contours."""
NUMBERS = 240
"""Most points whose value is written beside them."""
FINE_MESH = 20_000
"""An object of more faces is drawn as its hull."""
LEVEL = 0.9
"""Cosine between a grid's plane and the floor from which it is drawn as a plan."""


def save_isolux(scene: Scene, reading: GridReading, path: Path) -> Path:
    """Draw one grid's plan, or its elevation where it stands upright."""
    grid = reading.grid
    axes_of = _axes(grid)
    width, height = np.ptp(_flat(scene.room.corners, grid, axes_of), axis=0)
    inches = np.clip(np.array([width, height]) * 7.2 / max(width, height), (4.4, 2.6), None)
    figure = new_figure(inches[0] + 1.9, inches[1] + 1.7, f"{scene.title}: {grid.name}", dpi=110)
    axes = figure.add_subplot()
    filled = _draw_light(axes, reading, axes_of)
    if filled is not None:
        figure.colorbar(filled, ax=axes, label="illuminance [lx]", shrink=0.8, pad=0.02)
    _draw_room(axes, scene, grid, axes_of)
    axes.set_title(_caption(reading), fontsize=9.5)
    plan = axes_of[2, 2] == 1
    axes.set(aspect="equal", xlabel="x [m]" if plan else "across, from the grid's corner [m]",
             ylabel="y [m]" if plan else "up [m]")
    axes.margins(0.03)
    figure.legend(loc="outside lower center", ncols=4, fontsize=8, frameon=False)
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
    """Directions across, up and out of the paper (3, 3): the room's x and y for a level grid."""
    out = np.cross(grid.u, grid.v) / (np.linalg.norm(grid.u) * np.linalg.norm(grid.v))
    if abs(out[2]) > LEVEL:
        return np.eye(3)
    up = np.array([0.0, 0.0, 1.0]) - out[2] * out
    up /= np.linalg.norm(up)
    return np.array([np.cross(up, out), up, out])


def _flat(points: np.ndarray, grid: Grid, axes_of: np.ndarray) -> np.ndarray:
    """Points (…, 3) [m] on the paper (…, 2): room coordinates in a plan, else from the grid's corner."""
    origin = 0.0 if axes_of[2, 2] == 1 else grid.corner
    return (points - origin) @ axes_of[:2].T


def _draw_light(axes, reading: GridReading, axes_of: np.ndarray):
    """Filled contours, lines with their lux, and each point's own number; what the colours are, if any."""
    grid = reading.grid
    shape = grid.counts[::-1]
    lux = np.full(len(reading.read), np.nan)
    lux[reading.read] = reading.total
    places = _flat(grid.points, grid, axes_of)
    filled = None
    if min(shape) > 1 and np.ptp(reading.total) > 1e-6 * reading.most.value:
        from matplotlib.ticker import MaxNLocator

        levels = MaxNLocator(LEVELS).tick_values(reading.least.value, reading.most.value)
        surface = (*places.reshape(*shape, 2).transpose(2, 0, 1), np.ma.masked_invalid(lux.reshape(shape)))
        filled = axes.contourf(*surface, levels=levels, cmap="YlOrBr", alpha=0.75, zorder=1)
        lines = axes.contour(*surface, levels=levels, colors="#7a3b00", linewidths=0.9, zorder=3)
        axes.clabel(lines, fmt="%g", fontsize=8, inline=True)
    written = np.zeros(shape, dtype=bool)
    step = max(1, int(np.ceil(np.sqrt(lux.size / NUMBERS))))
    written[::step, ::step] = True
    for place, value in zip(places[written.ravel() & reading.read], lux[written.ravel() & reading.read],
                            strict=True):
        axes.annotate(_lux(value), place, ha="center", va="center", fontsize=6.5, color="#202020", zorder=4,
                      bbox={"boxstyle": "square,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.65})
    ring = grid.corner + np.array([0 * grid.u, grid.u, grid.u + grid.v, grid.v, 0 * grid.u])
    axes.plot(*_flat(ring, grid, axes_of).T, color="#707070", lw=0.8, ls=":", zorder=2,
              label="area of the grid")
    return filled


def _draw_room(axes, scene: Scene, grid: Grid, axes_of: np.ndarray) -> None:
    """The room cut by the grid's plane, what stands in it, its luminaires."""
    from matplotlib.collections import LineCollection

    # A hair off the plane, into the room: a grid on the floor cuts no wall.
    inward = np.sign((scene.room.bounds.mean(axis=0) - grid.corner) @ axes_of[2]) or 1.0
    at = grid.corner + 1e-4 * scene.room.scale * inward * axes_of[2]

    def cut(shell: np.ndarray) -> np.ndarray:
        triangles = trimesh.Trimesh(**trimesh.triangles.to_kwargs(shell))
        return _flat(trimesh.intersections.mesh_plane(triangles, axes_of[2], at), grid, axes_of)

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


def _footprint(mesh: trimesh.Trimesh) -> list[np.ndarray]:
    """Outlines of a body seen from above, each (k, 2) [m]."""
    import shapely

    if len(mesh.faces) > FINE_MESH:
        shape = shapely.convex_hull(shapely.MultiPoint(mesh.vertices[:, :2]))
    else:
        flat = shapely.polygons(mesh.triangles[:, :, :2])
        shape = shapely.union_all(flat[shapely.area(flat) > 0])
    parts = [part for part in getattr(shape, "geoms", [shape]) if part.geom_type == "Polygon"]
    return [np.array(part.exterior.coords) for part in parts]
