"""Readings of a room per lumen of its lamps, for columns of reflectances.

Bands exchange no light, so a reading in a band depends on the surfaces' reflectances in that band. All
models, lamps and paints of a room share its form factors, its meters and its direct light.
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


@dataclass(frozen=True)
class RoomGains:
    """A room whose lamps have one spectrum.

    lumens : (n_luminaires,) [lm]
    direct : (4,) READINGS of direct light per lumen [m⁻²]; 0 for the walls' luminance
    weights : (4, n_patches) of READINGS on radiosity
    """

    transport: Transport
    lumens: np.ndarray
    direct: np.ndarray
    weights: np.ndarray

    def indirect(self, reflectance: np.ndarray) -> np.ndarray:
        """READINGS (4, k) of reflected light per lumen of the lamps, for reflectances (n_surfaces, k)."""
        mesh = self.transport.mesh
        share = self.transport.direct @ (self.lumens / self.lumens.sum())
        read, step = [], 96
        for start in range(0, reflectance.shape[1], step):
            rho = reflectance[mesh.surface, start:start + step]
            falling = np.tile(share[:, None], (1, rho.shape[1]))
            _, received = radiosity(self.transport.exchange, rho, falling, BAR_TOLERANCE, share)
            read.append(self.weights @ (rho * (falling + received)))
        return np.hstack(read)


def room_gains(scene: Scene, patch_size: float, rays: int, seed: int = 0) -> RoomGains:
    """The form factors and meters of a room.

    patch_size : [m]
    rays : per patch, 0 for an empty convex room
    """
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


def _seen(transport: Transport, points: np.ndarray, normals: np.ndarray, seed: int,
          rays: int = 4096) -> np.ndarray:
    """Form factors (k, n_patches) from points to patches, by rays."""
    eye, n = transport.eye, len(transport.mesh.patches)
    square = Nets(rays, 2, (seed, Stream.STUDY_VIEW)).draw(0, len(points))
    directions = cosine_directions(square, np.stack([_frame(normal) for normal in normals]))
    origins = np.repeat(eye.off(points, normals), rays, axis=0)
    met = eye.first_hit(origins, directions.reshape(-1, 3)).reshape(len(points), rays)
    return np.stack([np.bincount(row[row >= 0], minlength=n) / rays for row in met])


def _frame(normal: np.ndarray) -> np.ndarray:
    """Unit vectors (3, 3), the last the normal."""
    across = np.eye(3)[np.abs(normal).argmin()]
    u = np.cross(normal, across)
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u), normal])
