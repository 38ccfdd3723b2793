"""What a room makes of light, one column of reflectances at a time: readings per lumen of its lamps.

A band knows no other band, so a reading in it depends on the surfaces' reflectances in it alone. All models,
lamps and paints of one room share its form factors, its meters and its direct light.
"""

from dataclasses import dataclass

import numpy as np

from renderer.scene.scene import Scene
from renderer.transport.direct.direct import direct_at
from renderer.transport.radiosity.solve import BAR_TOLERANCE, radiosity
from renderer.transport.rays.sampling import Nets, Stream, cosine_directions
from renderer.transport.transport import Transport, compute_transport

READINGS = ("task", "floor", "eye", "walls")
"""Mean illuminance at the task, the floor and the eye; mean luminance of the walls."""
METER_RAYS = 4096
COLUMNS_AT_ONCE = 96


@dataclass(frozen=True)
class RoomGains:
    """A room whose lamps share one spectrum.

    direct : (4,) readings straight from the lamps, per lumen [m⁻²]; 0 for the walls' luminance
    weights : (4, n_patches) on radiosity
    """

    transport: Transport
    lumens: np.ndarray
    direct: np.ndarray
    weights: np.ndarray

    def indirect(self, reflectance: np.ndarray) -> np.ndarray:
        """Readings by way of the surfaces (4, k) for reflectances (n_surfaces, k), per lumen of the lamps."""
        mesh = self.transport.mesh
        share = self.transport.direct @ (self.lumens / self.lumens.sum())
        read = []
        for start in range(0, reflectance.shape[1], COLUMNS_AT_ONCE):
            rho = reflectance[mesh.surface, start:start + COLUMNS_AT_ONCE]
            falling = np.tile(share[:, None], (1, rho.shape[1]))
            _, received = radiosity(self.transport.exchange, rho, falling, BAR_TOLERANCE, share)
            read.append(self.weights @ (rho * (falling + received)))
        return np.hstack(read)


def room_gains(scene: Scene, patch_size: float, rays: int, seed: int = 0) -> RoomGains:
    """A room's meters and form factors. patch_size [m]; rays : per patch, 0 in an empty convex room."""
    transport = compute_transport(scene, patch_size, rays, seed)
    lumens = np.array([luminaire.lumens for luminaire in scene.luminaires])
    direct, weights = [], []
    for name in READINGS[:-1]:
        spots = [meter for meter in scene.photometers if meter.name.startswith(name)]
        points = np.array([meter.position for meter in spots])
        normals = np.array([meter.normal for meter in spots], dtype=float)
        there = direct_at(points, normals, transport.luminaires, transport.ray_scene,
                          (seed, Stream.STUDY_DIRECT)).mean(axis=0)
        direct.append(float((there @ lumens).mean() / lumens.sum()))
        weights.append(_seen(transport, points, normals, seed).mean(axis=0))
    walls = np.array([name.startswith("wall") for name in scene.surface_names])[transport.mesh.surface]
    area = np.where(walls, transport.exchange.areas, 0.0)
    return RoomGains(
        transport, lumens, np.array([*direct, 0.0]), np.stack([*weights, area / area.sum() / np.pi])
    )


def _seen(transport: Transport, points: np.ndarray, normals: np.ndarray, seed: int) -> np.ndarray:
    """Share of each point's view, by the cosine, that each patch fills (k, n_patches)."""
    eye, n = transport.eye, len(transport.mesh.patches)
    square = Nets(METER_RAYS, 2, (seed, Stream.STUDY_VIEW)).draw(0, len(points))
    directions = cosine_directions(square, np.stack([_frame(normal) for normal in normals]))
    origins = np.repeat(eye.off(points, normals), METER_RAYS, axis=0)
    met = eye.first_hit(origins, directions.reshape(-1, 3)).reshape(len(points), METER_RAYS)
    return np.stack([np.bincount(row[row >= 0], minlength=n) / METER_RAYS for row in met])


def _frame(normal: np.ndarray) -> np.ndarray:
    """Axes (3, 3) whose last is the normal."""
    across = np.eye(3)[np.abs(normal).argmin()]
    u = np.cross(normal, across)
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u), normal])
