"""Luminaires with closed forms: Lambertian faces and points, and the isotropic point."""

from dataclasses import dataclass

import numpy as np

from renderer.radiometry.polygons import exchange_areas, exchanged, polygon_factors
from renderer.scene.luminaires.luminaire import ExtendedLuminaire, PointLuminaire


class IsotropicPoint(PointLuminaire):
    """A point with the same intensity in all directions."""

    lumens_per_candela = 4 * np.pi

    def intensity(self, away: np.ndarray) -> np.ndarray:
        return np.full(away.shape[:-1], 1 / (4 * np.pi))

    def share_on(self, mesh, patch: np.ndarray) -> np.ndarray:
        solid_angles = _solid_angles(mesh.corners[patch] - self.center)
        return np.where(_in_front(mesh, patch, self.center), solid_angles / (4 * np.pi), 0.0)


class _Cosine:
    lambertian = forward_only = True
    lumens_per_candela = np.pi

    def intensity(self, away: np.ndarray) -> np.ndarray:
        return np.clip(away @ self.normal, 0, None) / np.pi


class LambertianPoint(_Cosine, PointLuminaire):
    """A point whose intensity is proportional to the cosine of the angle from its normal."""

    def share_on(self, mesh, patch: np.ndarray) -> np.ndarray:
        center, normal = (np.broadcast_to(x, (len(patch), 3)) for x in (self.center, self.normal))
        return polygon_factors(center, normal, mesh.corners[patch])


@dataclass(frozen=True)
class LambertianFace(_Cosine, ExtendedLuminaire):
    """A flat rectangle or disc that emits from its front by Lambert's cosine law."""

    def illuminance(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        return illuminance_of_faces([self], points, normals)[:, 0]

    def brought(self, places: np.ndarray, normals: np.ndarray, targets: np.ndarray) -> np.ndarray:
        return exchanged(places, normals, targets, self.normal)

    def share_on(self, mesh, patch: np.ndarray) -> np.ndarray:
        slack = 1e-12 * mesh.scale
        height = (mesh.corners[patch] - self.center) @ self.normal
        side = (self.outline[None] - mesh.centroid[patch, None]) @ mesh.normal[patch][:, :, None]
        flux = np.zeros(len(patch))
        whole = (height >= -slack).all(axis=1) & (side[..., 0] >= -slack).all(axis=1)
        whole &= _in_front(mesh, patch, self.center)
        flux[whole] = self._on_whole(mesh, patch[whole])
        # NaN where the luminaire's plane cuts the patch, or the patch's plane cuts the luminaire.
        flux[~whole & (height > slack).any(axis=1) & (side[..., 0] > slack).any(axis=1)] = np.nan
        return flux

    def _on_whole(self, mesh, patch: np.ndarray) -> np.ndarray:
        """Share (k,) of the luminaire's lumens on patches that lie wholly in front of it and have it wholly
        in front of them."""
        away = mesh.centroid[patch] - self.center
        radius = np.linalg.norm(self.outline - self.center, axis=1).max()
        distance = np.maximum(away @ self.normal, np.linalg.norm(away, axis=1) - radius)  # lower bound
        diagonal = np.linalg.norm(mesh.corners[patch, 2] - mesh.corners[patch, 0], axis=1)
        # Light that falls as 1/d² has a mean within 6/24 · (1/64)² = 6e-5 of its value at their centre.
        far = diagonal < distance / 64
        outline = np.broadcast_to(self.outline, (len(patch), *self.outline.shape))
        flux = np.empty(len(patch))
        flux[~far] = exchange_areas(mesh.corners[patch[~far]], outline[~far])
        middles, normals = mesh.centroid[patch[far]], mesh.normal[patch[far]]
        flux[far] = mesh.area[patch[far]] * polygon_factors(middles, normals, outline[far])
        return flux / self.area


def illuminance_of_faces(faces: list[LambertianFace], points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Illuminance per lumen of each of some faces with equal numbers of corners (k, n_faces) [m⁻²] at points,
    without obstruction. points, normals : (k, 3) [m], unit"""
    outlines, areas = np.array([face.outline for face in faces]), np.array([face.area for face in faces])
    found, few = np.empty((len(points), len(faces))), max(1, (1 << 15) // max(1, len(points)))
    for start in range(0, len(faces), few):
        some = outlines[start:start + few]
        point = np.repeat(np.arange(len(points)), len(some))
        corners = np.broadcast_to(some, (len(points), *some.shape)).reshape(-1, *some.shape[1:])
        light = polygon_factors(points[point], normals[point], corners)
        found[:, start:start + few] = light.reshape(len(points), len(some))
    return found / areas


def _in_front(mesh, patch: np.ndarray, center: np.ndarray) -> np.ndarray:
    """Whether a point (3,) lies before patches (k,), beyond the rounding of a tilted patch's own plane."""
    return np.einsum("ki,ki->k", center - mesh.centroid[patch], mesh.normal[patch]) > 1e-12 * mesh.scale


def _solid_angles(corners: np.ndarray) -> np.ndarray:
    """Solid angles (k,) [sr] of quadrilaterals (k, 4, 3) seen from the origin (A. van Oosterom and J.
    Strackee, IEEE Trans. Biomed. Eng. 30, 1983)."""
    total = 0.0
    for second, third in ((1, 2), (2, 3)):
        a, b, c = corners[:, 0], corners[:, second], corners[:, third]
        la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
        triple = np.abs((np.cross(a, b) * c).sum(axis=1))
        below = (la * lb * lc + (a * b).sum(axis=1) * lc + (b * c).sum(axis=1) * la
                 + (c * a).sum(axis=1) * lb)
        total = total + 2 * np.arctan2(triple, below)
    return total
