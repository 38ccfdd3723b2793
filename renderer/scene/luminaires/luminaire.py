"""Luminaires: place, luminous flux and distribution of light.

Each kind of luminaire is a class with the illuminance that it gives at points and on patches, the points on
it that rays aim at, its size and its distance. A new kind derives from `PointLuminaire`, or from
`OpeningLuminaire` in opening.py, and defines its `intensity`; it overrides other methods where it has a
closed form.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np

from renderer.radiometry.quadrature import flux_on_patches
from renderer.scene.geometry import Rectangle
from renderer.scene.luminaires.outline import Outline

MAX_PIECE_SHARE = 0.3
"""Largest length of a piece of an opening or patch, relative to its distance, that two Gauss points each way
integrate; intensities with finer detail need shorter pieces."""


@dataclass(frozen=True)
class Luminaire(ABC):
    """A light source.

    center : (3,) [m]
    normal : (3,) unit vector: front of a flat source, axis of a Lambertian point, photometric nadir
    lumens : luminous flux [lm]
    """

    name: str
    center: np.ndarray
    normal: np.ndarray
    lumens: float

    is_point = False
    """Whether the luminaire has no extent."""
    lambertian = False
    """Whether the luminaire emits by Lambert's cosine law."""
    forward_only = False
    """Whether all light leaves to the side of the normal."""
    distribution = None
    """Measured intensities of a luminaire from a photometric file; None for others."""
    opening = ()
    """Flat faces of the luminous opening, for luminaires whose light leaves from them."""
    area = 0.0
    """Area of the body [m²]."""
    rectangle = None
    """The outline as a Rectangle; None for other outlines."""
    outline = None
    """Corners (k, 3) [m] of the opaque body, counter-clockwise seen from the front; None for a point."""
    axes = np.eye(3)
    """Unit vectors (3, 3) along C0, C90 and the nadir."""
    longest_piece = MAX_PIECE_SHARE
    """Largest length of a piece, relative to its distance, over which intensities are nearly linear."""

    @abstractmethod
    def intensity(self, away: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) per lumen [cd/lm] along unit directions (…, 3) away from the luminaire."""

    @abstractmethod
    def illuminance(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Unobstructed illuminance (k,) per lumen [lx/lm = m⁻²] at points (k, 3) [m] on planes with unit
        normals (k, 3)."""

    @abstractmethod
    def projected_area(self, away: np.ndarray) -> np.ndarray:
        """Projected luminous area (…) [m²] toward unit directions (…, 3); 0 for a point."""

    @property
    @abstractmethod
    def corners(self) -> np.ndarray:
        """Corners (k, 3) [m] of the outline; the centre of a point."""

    @abstractmethod
    def spread(self, square: np.ndarray) -> np.ndarray:
        """Points (…, 3) [m] of even density on the luminaire, from points (…, 2) of the unit square."""

    @abstractmethod
    def distance(self, away: np.ndarray) -> np.ndarray:
        """Distance (k,) [m] of points from the luminaire; away : (k, 3) [m] from its centre."""

    @abstractmethod
    def may_light(self, corners: np.ndarray, normals: np.ndarray, slack: float) -> np.ndarray:
        """Whether light may reach elements (k,) with corners (k, c, 3) [m] and unit normals (k, 3).

        slack : [m], distance within which a point counts as in a plane
        """

    def share_on(self, mesh, patch: np.ndarray) -> np.ndarray:
        """Share (k,) of the lumens that each patch of the mesh receives without obstruction.

        NaN for a patch that needs a sum over points on it. Patches are halved down to twice the length of the
        opening's pieces; the errors of neighbouring pieces cancel.
        """
        # Illuminance stays finite where the opening touches a patch, so pieces need not be shorter than this.
        smallest = 0.05 * np.sqrt(max((face.area for face in self.opening), default=0.0))

        def longest(middle: np.ndarray) -> np.ndarray:
            offset = np.abs((middle - self.center) @ self.axes.T) - self.half_box
            distance = np.linalg.norm(np.clip(offset, 0, None), axis=1)
            return np.maximum(2 * self.longest_piece * distance, smallest)

        return flux_on_patches(mesh, patch, self._may_reach(mesh, patch), self.illuminance, longest)

    def _may_reach(self, mesh, patch: np.ndarray) -> np.ndarray:
        """Whether patches (k,) may receive light: part of the opening is in front of the patch, and part of
        the patch in front of the opening."""
        slack, half = 1e-9 * mesh.scale, self.half_box
        normal = mesh.normal[patch]
        height = ((self.center - mesh.centroid[patch]) * normal).sum(axis=1)
        before = height + np.abs(normal @ self.axes.T) @ half > slack
        if self.forward_only:
            before &= ((mesh.corners[patch] - self.center) @ self.normal).max(axis=1) > slack - half[2]
        return before

    @property
    def half_box(self) -> np.ndarray:
        """Half the sides (3,) [m], along `axes`, of the box around the luminous opening."""
        return np.zeros(3)

    def brought(self, places: np.ndarray, normals: np.ndarray, targets: np.ndarray) -> np.ndarray:
        """Illuminance (k, n), up to a constant factor, from points of the luminaire.

        places, normals : (k, 1 or n, 3) [m] and (k, 1, 3) of the meters
        targets : (k, n, 3) [m] points on the luminaire
        """
        reach = targets - places
        distance = np.sqrt(np.maximum(np.einsum("kni,kni->kn", reach, reach), 1e-200))
        incidence = np.einsum("kni,ki->kn", reach, normals[:, 0]).clip(0)
        return incidence * self.intensity(-reach / distance[..., None]) / distance**3

    def luminance(self, away: np.ndarray) -> np.ndarray:
        """Luminance (…) per lumen [cd/m²/lm] along unit directions (…, 3), uniform over the opening."""
        seen = self.projected_area(away)
        return np.where(seen > 0, self.intensity(away) / np.where(seen > 0, seen, 1.0), 0.0)

    def moved(self, shift: np.ndarray) -> "Luminaire":
        """The luminaire moved by (3,) [m]."""
        return replace(self, center=self.center + shift)

    @property
    def extremes(self) -> np.ndarray:
        """Points (k, 3) [m] on the edge and the outer faces, all of which must be in the room."""
        return self.center[None]

    @property
    def geometry(self) -> list[np.ndarray]:
        """Arrays that determine the luminaire's light per lumen; the key of the cache."""
        return [self.center, self.normal, np.array(type(self).__name__.encode()), self.corners]


@dataclass(frozen=True)
class PointLuminaire(Luminaire):
    """A source without extent, with illuminance by I/d²."""

    is_point = True

    def illuminance(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        away = points - self.center
        distance2 = np.maximum(np.einsum("ki,ki->k", away, away), 1e-300)
        away /= np.sqrt(distance2)[:, None]
        incidence = np.clip(-np.einsum("ki,ki->k", away, normals), 0, None)
        return incidence * self.intensity(away) / distance2

    def projected_area(self, away: np.ndarray) -> np.ndarray:
        return np.zeros(away.shape[:-1])

    @property
    def corners(self) -> np.ndarray:
        return self.center[None]

    def spread(self, square: np.ndarray) -> np.ndarray:
        return np.broadcast_to(self.center, (*square.shape[:-1], 3))

    def distance(self, away: np.ndarray) -> np.ndarray:
        return np.sqrt(np.einsum("ki,ki->k", away, away))  # a third of the time of numpy.linalg.norm

    def may_light(self, corners: np.ndarray, normals: np.ndarray, slack: float) -> np.ndarray:
        return np.einsum("ki,ki->k", corners.mean(axis=1) - self.center, normals) < -slack


@dataclass(frozen=True)
class ExtendedLuminaire(Luminaire):
    """A source with a body, an opaque sheet.

    body : its outline
    """

    body: Outline

    @property
    def outline(self) -> np.ndarray:
        return self.body.corners

    @property
    def corners(self) -> np.ndarray:
        return self.body.corners

    @property
    def rectangle(self) -> Rectangle | None:
        return self.body.rectangle

    @property
    def area(self) -> float:
        return self.body.area

    def projected_area(self, away: np.ndarray) -> np.ndarray:
        return self.area * np.clip(away @ self.normal, 0, None)

    def spread(self, square: np.ndarray) -> np.ndarray:
        return self.body.spread(square)

    def aimed(self, places: np.ndarray, square: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points on the face at which rays from places aim, and their areas: see `Outline.aimed`."""
        return self.body.aimed(places, square)

    def distance(self, away: np.ndarray) -> np.ndarray:
        return self.body.distance(away)

    def may_light(self, corners: np.ndarray, normals: np.ndarray, slack: float) -> np.ndarray:
        return ((corners - self.center) @ self.normal > slack).any(axis=1) | (not self.forward_only)

    def moved(self, shift: np.ndarray) -> Luminaire:
        return replace(self, center=self.center + shift, body=self.body.moved(shift))

    @property
    def extremes(self) -> np.ndarray:
        # Points along the edge: its ends may be in two arms of a room and its middle outside.
        part = np.arange(8)[:, None, None] / 8
        rim = (1 - part) * self.outline + part * np.roll(self.outline, -1, axis=0)
        outer = [self.center + face.middle for face in self.opening]
        return np.concatenate([rim.reshape(-1, 3), np.reshape(outer, (-1, 3))])
