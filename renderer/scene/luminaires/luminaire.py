"""Luminaires: where light starts, how much, and in which directions.

A kind of luminaire is a class that answers for itself: what it sends to a point and to a patch, where rays
to it go, how large and how far it is. A new kind derives from `PointLuminaire` or `OpeningLuminaire` of
opening.py and gives its `intensity`; it overrides what else it has in closed form.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np

from renderer.radiometry.quadrature import flux_on_patches
from renderer.scene.geometry import Rectangle
from renderer.scene.luminaires.outline import Outline

LONGEST_PIECE = 0.3
"""A piece of an opening or patch is at most this share of its distance long, so that two Gauss points each
way integrate it; less where intensities have finer detail."""
SMALLEST_PIECE = 0.05
"""The smallest piece of a patch, in sides of the luminous opening: where that touches a patch its light is
bounded."""


@dataclass(frozen=True)
class Luminaire(ABC):
    """A light source.

    center : (3,) [m]; normal : (3,) unit, the way flat sources, Lambertian points and nadirs face
    lumens : luminous flux [lm]
    """

    name: str
    center: np.ndarray
    normal: np.ndarray
    lumens: float

    is_point = False
    """Whether it has no extent."""
    lambertian = False
    """Whether it emits as the cosine about its normal by its kind."""
    forward_only = False
    """Whether no light leaves it backward, against its normal."""
    distribution = None
    """The measured intensities, of one from a photometric file."""
    opening = ()
    """Flat faces of its luminous opening, where those send the light."""
    area = 0.0
    """Area of its body [m²]."""
    rectangle = None
    """The outline as a rectangle, where it is one."""
    outline = None
    """Corners (k, 3) [m] of its opaque body, counter-clockwise seen from the front; None for a point."""
    axes = np.eye(3)
    """Unit directions (3, 3) that its intensities are counted from: of C0, C90 and the nadir."""
    longest_piece = LONGEST_PIECE
    """Length of a piece over its distance, across which its intensities are about linear."""

    @abstractmethod
    def intensity(self, away: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) per lumen [cd/lm] along unit directions (…, 3) that leave it."""

    @abstractmethod
    def illuminance(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Illuminance per lumen (k,) [lx/lm = m⁻²] at points (k, 3) [m] on planes of unit normals (k, 3),
        nothing standing between."""

    @abstractmethod
    def projected_area(self, away: np.ndarray) -> np.ndarray:
        """Luminous area (…) [m²] as seen from unit directions (…, 3); 0 for a point."""

    @property
    @abstractmethod
    def corners(self) -> np.ndarray:
        """Corners (k, 3) [m] of its outline; the centre of a point."""

    @abstractmethod
    def spread(self, square: np.ndarray) -> np.ndarray:
        """Points all over it (…, 3) [m], evenly, from points of the unit square (…, 2)."""

    @abstractmethod
    def distance(self, away: np.ndarray) -> np.ndarray:
        """Distance [m] of points at `away` (k, 3) from its centre (k,)."""

    @abstractmethod
    def may_light(self, corners: np.ndarray, normals: np.ndarray, slack: float) -> np.ndarray:
        """Whether light of it may reach elements (k, c, 3) [m] of unit normals (k, 3); what is nearer than
        `slack` [m] to a plane counts as in it (k,)."""

    def share_on(self, mesh, patch: np.ndarray) -> np.ndarray:
        """Share of its lumens that each patch of the room's mesh would receive if nothing stood between (k,);
        NaN where only a sum over points of the patch says.

        Here patches are halved until short, twice as long as pieces of an opening: what one receives too
        much, its neighbour receives too little.
        """
        smallest = SMALLEST_PIECE * np.sqrt(max((face.area for face in self.opening), default=0.0))

        def longest(middle: np.ndarray) -> np.ndarray:
            offset = np.abs((middle - self.center) @ self.axes.T) - self.half_box
            distance = np.linalg.norm(np.clip(offset, 0, None), axis=1)
            return np.maximum(2 * self.longest_piece * distance, smallest)

        return flux_on_patches(mesh, patch, self._may_reach(mesh, patch), self.illuminance, longest)

    def _may_reach(self, mesh, patch: np.ndarray) -> np.ndarray:
        """Which patches may receive light: some of the opening before them, some of them before it (k,)."""
        slack, half = 1e-9 * mesh.scale, self.half_box
        normal = mesh.normal[patch]
        height = ((self.center - mesh.centroid[patch]) * normal).sum(axis=1)
        before = height + np.abs(normal @ self.axes.T) @ half > slack
        if self.forward_only:
            before &= ((mesh.corners[patch] - self.center) @ self.normal).max(axis=1) > slack - half[2]
        return before

    @property
    def half_box(self) -> np.ndarray:
        """Half the box around its luminous opening (3,) [m], along its axes."""
        return np.zeros(3)

    def brought(self, places: np.ndarray, normals: np.ndarray, targets: np.ndarray) -> np.ndarray:
        """What light from points (k, n, 3) all over it brings to places (k, 1 or n, 3) of these normals
        (k, 1, 3), but for a factor."""
        reach = targets - places
        distance = np.sqrt(np.maximum(np.einsum("kni,kni->kn", reach, reach), 1e-200))
        incidence = np.einsum("kni,ki->kn", reach, normals[:, 0]).clip(0)
        return incidence * self.intensity(-reach / distance[..., None]) / distance**3

    def luminance(self, away: np.ndarray) -> np.ndarray:
        """Luminance (…) per lumen [cd/m²/lm] along unit directions (…, 3): all of its opening alike."""
        seen = self.projected_area(away)
        return np.where(seen > 0, self.intensity(away) / np.where(seen > 0, seen, 1.0), 0.0)

    def moved(self, shift: np.ndarray) -> "Luminaire":
        """The luminaire moved by (3,) [m]."""
        return replace(self, center=self.center + shift)

    @property
    def extremes(self) -> np.ndarray:
        """Points (k, 3) [m] along its edge and on its outer faces, all of which must be in the room."""
        return self.center[None]

    @property
    def geometry(self) -> list[np.ndarray]:
        """What the light that it sends depends on but for its lumens, as arrays."""
        return [self.center, self.normal, np.array(type(self).__name__.encode()), self.corners]


@dataclass(frozen=True)
class PointLuminaire(Luminaire):
    """A source without extent: I/d² arrives."""

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
        return np.linalg.norm(away, axis=1)

    def may_light(self, corners: np.ndarray, normals: np.ndarray, slack: float) -> np.ndarray:
        return np.einsum("ki,ki->k", corners.mean(axis=1) - self.center, normals) < -slack


@dataclass(frozen=True)
class ExtendedLuminaire(Luminaire):
    """A source with a body: an opaque sheet where the light does not come from its sides.

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
        """Points on its face that rays from places go to, as `Outline.aimed`."""
        return self.body.aimed(places, square)

    def distance(self, away: np.ndarray) -> np.ndarray:
        return self.body.distance(away)

    def may_light(self, corners: np.ndarray, normals: np.ndarray, slack: float) -> np.ndarray:
        return ((corners - self.center) @ self.normal > slack).any(axis=1) | (not self.forward_only)

    def moved(self, shift: np.ndarray) -> Luminaire:
        return replace(self, center=self.center + shift, body=self.body.moved(shift))

    @property
    def extremes(self) -> np.ndarray:
        # Along its edge: its ends may be in two arms of a room and it not.
        part = np.arange(8)[:, None, None] / 8
        rim = (1 - part) * self.outline + part * np.roll(self.outline, -1, axis=0)
        outer = [self.center + face.middle for face in self.opening]
        return np.concatenate([rim.reshape(-1, 3), np.reshape(outer, (-1, 3))])
