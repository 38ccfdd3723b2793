"""Readings of a grid of meters: mean, extremes and uniformity, each with its error bar."""

from dataclasses import dataclass

import numpy as np

from renderer.errors import InputError
from renderer.readings.finding import rgb_error_percent
from renderer.readings.meter_place import stand_each
from renderer.readings.uncertainty import Figure, half_widths
from renderer.scene.grids import Grid
from renderer.scene.room import INSIDE_TOLERANCE, distances, outside
from renderer.transport.transport import Transport


@dataclass(frozen=True)
class GridReading:
    """Illuminances of a grid [lx].

    read : (n_v · n_u,) whether a meter can stand at each point; the other fields are for the k points where
    one can
    direct, indirect, mesh_error, sampling_error : (k,) [lx]
    mean, least, most : Ē, E_min and E_max
    band_error : of the mean [lx]
    uniformity, uniformity_error : U₀ = E_min / Ē; None where there is no light
    rgb : (k,) total illuminance in RGB on the same transport [lx], beside 31 bands; else None
    """

    grid: Grid
    read: np.ndarray
    direct: np.ndarray
    indirect: np.ndarray
    mesh_error: np.ndarray
    sampling_error: np.ndarray
    mean: Figure
    least: Figure
    most: Figure
    band_error: float
    uniformity: float | None
    uniformity_error: float | None
    rgb: np.ndarray | None = None

    @property
    def figures(self) -> tuple[Figure, Figure]:
        """Figures to which the requested accuracy applies: the mean, and the minimum, on which U₀ depends."""
        return self.mean, self.least

    @property
    def total(self) -> np.ndarray:
        """Illuminance (k,) [lx]."""
        return self.direct + self.indirect

    @property
    def uncertainty(self) -> np.ndarray:
        """95 % half-width of each point (k,) [lx]."""
        return np.hypot(self.mesh_error, self.sampling_error)

    @property
    def rgb_error_percent(self) -> float | None:
        """100 (RGB ÷ 31 bands − 1) of the mean [%]; None without light or where RGB is not known."""
        return None if self.rgb is None else rgb_error_percent(float(self.rgb.mean()), self.mean.value)

    @property
    def worst_point(self) -> int:
        """Index, among the points read, of the one where the relative error of RGB is largest."""
        lit = np.where(self.total > 0, self.total, np.inf)
        return int(np.abs((self.rgb - self.total) / lit).argmax())

    @property
    def left_out(self) -> int:
        """Number of points outside the room, in an object, or too near a wall."""
        return int((~self.read).sum())


def readable(transport: Transport, grid: Grid, where: str) -> np.ndarray:
    """Whether a meter can stand at each point of a grid (n,). Raises InputError where it can stand at
    none."""
    points = grid.points
    read = np.ones(len(points), dtype=bool)
    walls = transport.room.shell
    normals = np.cross(walls[:, 1] - walls[:, 0], walls[:, 2] - walls[:, 0])
    # Surfaces at more than 60° to the grid are walls.
    flat = np.abs(normals @ grid.normal) > 0.5 * np.linalg.norm(normals, axis=1)
    read &= ~outside(points, transport.room.shell, INSIDE_TOLERANCE * transport.room.scale)
    if grid.border and not flat.all():
        some, few = np.flatnonzero(read), max(1, (1 << 16) // len(walls))
        for part in np.split(some, range(few, len(some), few)):
            read[part] = distances(points[part], walls[~flat]) >= grid.border * (1 - 1e-9)
    asked = np.flatnonzero(read)
    for k, spot in zip(asked, stand_each(transport, points[asked], grid.normal), strict=True):
        read[k] = spot is not None
        if spot is not None:
            transport.placed[points[k].tobytes(), grid.normal.tobytes()] = spot
    if not read.any():
        raise InputError(f"{where}: a meter can stand at none of its {len(points)} points: each is outside "
                         "the room, in an object, faces the surface it lies on or is nearer to a wall than "
                         "the border. Move the grid, or turn its normal.")
    return read


def summarise(grid: Grid, read: np.ndarray, own: np.ndarray, meshes: np.ndarray, replicas: np.ndarray,
              steps: tuple[float, ...], quadrature: float, band_error: float,
              rare: np.ndarray | None = None) -> GridReading:
    """A grid's figures from the illuminance by lamps and by each surface at each of its points [lx].

    own : (k, 1 + n_surfaces) in the bands read; the first column is the lamps'
    meshes : (m, k, 1 + n_surfaces) in RGB, on the mesh read and on others
    replicas : (s, k, 1 + n_surfaces) in RGB
    steps, quadrature, rare : as in `half_widths`; rare : (k,), None where nothing is sampled

    The mean is linear in its points, so its error is that of one meter that reads the mean: errors common to
    all points count in full, others cancel. E_min lies between the least of E − u and the least of E + u,
    where u are the points' errors; E_max likewise. The error of U₀ is the error of E_min − U₀ Ē, which is
    linear too, over Ē, with that of the choice of the lowest point.
    """
    total = own.sum(axis=1)
    rare = np.zeros(len(own)) if rare is None else rare
    errors = np.array([half_widths(meshes[:, k], replicas[:, k], steps, quadrature, rare[k])
                       for k in range(len(own))])
    bars = np.hypot(*errors.T)

    def figure(name: str, k: int, sign: int) -> Figure:
        bar = sign * total[k] - (sign * total - bars).min()
        widen = bar / bars[k] if bars[k] > 0 else 1.0
        return Figure(name, float(total[k]), *(float(e) * widen for e in errors[k]))

    least, most = int(total.argmin()), int(total.argmax())
    mean = Figure(f"{grid.name}: mean", float(total.mean()), *half_widths(
        meshes.mean(axis=1), replicas.mean(axis=1), steps, quadrature, np.linalg.norm(rare) / len(rare)))
    lowest, highest = figure(f"{grid.name}: minimum", least, 1), figure(f"{grid.name}: maximum", most, -1)
    uniformity = error = None
    if mean.value > 0:
        uniformity = lowest.value / mean.value
        apart = [x[..., least, :] - uniformity * x.mean(axis=-2) for x in (meshes, replicas)]
        error = (np.hypot(*half_widths(*apart, steps)) + lowest.uncertainty - bars[least]) / mean.value
    return GridReading(grid, read, own[:, 0], own[:, 1:].sum(axis=1), errors[:, 0], errors[:, 1], mean,
                       lowest, highest, band_error, uniformity, None if error is None else float(error))
