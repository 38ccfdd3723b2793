"""Illuminance in rooms with one bounce: all surfaces are black except flat faces that do not see each other.

Then E = E_direct + Σ_faces ρ ∫ E_direct(x) cos θ cos θ' / π r² dA over the visible part of each face. Shadows
are polygons in closed form, the illuminance of the faces is Lambert's formula without the hidden part, and
the integral is computed to 1e-8.
"""

from dataclasses import dataclass

import numpy as np

from renderer.studies.validation.exact.geometry import ConvexBody, Plane, factor, normal_of
from renderer.studies.validation.exact.quadrature import integral, region_triangles


@dataclass(frozen=True)
class Lamp:
    """One luminaire.

    flux : [lm]
    center : (3,) [m]
    normal : (3,) unit vector; None for an isotropic point
    outline : (c, 3) [m] of a flat luminaire, counter-clockwise seen from its front; None for a point
    """

    flux: float
    center: np.ndarray
    normal: np.ndarray | None = None
    outline: np.ndarray | None = None

    @property
    def area(self) -> float:
        """Area of the face [m²]."""
        edges = self.outline - self.outline[0]
        return float(np.linalg.norm(np.cross(edges[1:-1], edges[2:]).sum(axis=0))) / 2

    def illuminance(
        self, points: np.ndarray, normal: np.ndarray, body: ConvexBody | None = None
    ) -> np.ndarray:
        """Illuminance (k,) [lx] at points (k, 3) with one unit normal (3,); body : hides part of a flat
        luminaire."""
        if self.outline is not None:
            return self.flux / self.area * factor(points, normal, self.outline, body)
        away = points - self.center
        r2 = (away * away).sum(axis=1)
        incidence = (-away @ normal).clip(0) / r2**1.5
        if self.normal is None:
            return self.flux / (4 * np.pi) * incidence
        return self.flux / np.pi * (away @ self.normal).clip(0) / np.sqrt(r2) * incidence


@dataclass(frozen=True)
class OneBounce:
    """A room with some reflecting faces.

    faces : polygon (c, 3), counter-clockwise seen from the room, and reflectance of each
    bodies : all bodies in the room, also those with reflecting faces; at most one may stand in front of a
        flat lamp
    """

    lamp: Lamp
    faces: tuple[tuple[np.ndarray, float], ...]
    bodies: tuple[ConvexBody, ...] = ()

    def illuminance(self, position: np.ndarray, normal: np.ndarray) -> float:
        """Illuminance [lx] at a point (3,) [m] with a unit normal (3,)."""
        return self.direct(position, normal) + sum(
            self._reflected(position, normal, *face) for face in self.faces)

    def direct(self, position: np.ndarray, normal: np.ndarray) -> float:
        """Illuminance [lx] from the lamp alone."""
        lamp, bodies = self.lamp, self.bodies
        if lamp.outline is None and any(body.blocks(lamp.center, position) for body in bodies):
            return 0.0
        body = self._before(lamp) if lamp.outline is not None else None
        return float(lamp.illuminance(position[None], normal, body)[0])

    def _before(self, lamp: Lamp) -> ConvexBody | None:
        """The body in front of a flat lamp, or None. Raises ValueError for several."""
        some = [b for b in self.bodies
                if ((np.concatenate(b.faces) - lamp.outline[0]) @ normal_of(lamp.outline)).max() > 1e-9]
        if len(some) > 1:
            raise ValueError("at most one body may stand in front of a flat lamp")
        return some[0] if some else None

    def _reflected(self, position: np.ndarray, normal: np.ndarray, polygon: np.ndarray, rho: float) -> float:
        """Illuminance [lx] by light that one face reflects."""
        plane, lamp = Plane(polygon), self.lamp
        if plane.height(position) <= 1e-9:
            return 0.0
        region = plane.polygon.intersection(plane.before(position, normal))
        own = _owner(self.bodies, polygon)
        others = [b for b in self.bodies if b is not own]
        lines, body = None, None
        if lamp.outline is None:
            if plane.height(lamp.center) <= 0:
                return 0.0
            for each in others:
                region = region.difference(plane.shadow(each, lamp.center))
        else:
            others = [*others, ConvexBody((lamp.outline,))]
            body = self._before(lamp)
            body = None if body is own else body
            if body is not None:
                lines = penumbra_lines(plane, lamp.outline, body)
        if lamp.normal is not None:
            region = region.intersection(plane.before(lamp.center, lamp.normal))
        for each in others:
            region = region.difference(plane.shadow(each, position))

        def brought(places: np.ndarray) -> np.ndarray:
            points = plane.solid(places)
            reach = points - position
            r2 = (reach * reach).sum(axis=1)
            seen = (reach @ normal).clip(0) * plane.height(position) / r2**2
            return lamp.illuminance(points, plane.normal, body) * seen

        return rho / np.pi * integral(brought, region_triangles(region, lines))


def _owner(bodies: tuple[ConvexBody, ...], polygon: np.ndarray) -> ConvexBody | None:
    return next((b for b in bodies if any(face is polygon for face in b.faces)), None)


def penumbra_lines(plane: Plane, outline: np.ndarray, body: ConvexBody) -> np.ndarray:
    """Lines (m, 2, 2) of a plane, a place and a direction each, with a kink of the illuminance by a flat lamp
    past a body.

    Each lies in a plane through a corner of the one and an edge of the other, or in the plane of a face.
    """
    corners, edges = np.unique(np.concatenate(body.faces).round(12), axis=0), body.edges
    edges = edges[_first_of_each(edges)]
    sides = np.stack([outline, np.roll(outline, -1, axis=0)], axis=1)
    planes = [(c, np.cross(b - a, c - a)) for c in outline for a, b in edges]
    planes += [(c, np.cross(b - a, c - a)) for c in corners for a, b in sides]
    planes += [(face[0], normal_of(face)) for face in body.faces]
    lines = []
    for point, n in planes:
        size = np.linalg.norm(n)
        if size < 1e-9:
            continue
        flat, c = plane.axes @ n / size, (point - plane.origin) @ n / size
        steep = np.linalg.norm(flat)
        if steep > 1e-9:
            flat, c = flat / steep, c / steep
            lines.append([c * flat, [-flat[1], flat[0]]])
    return np.array(lines)


def _first_of_each(edges: np.ndarray) -> np.ndarray:
    ends = np.sort(edges.round(12).view([("", float)] * 3)[..., 0], axis=1)
    return np.unique(ends, axis=0, return_index=True)[1]
