"""Two parallel reflecting faces between black walls, under a point lamp, with all bounces.

Without objects between the faces, kernel and light are smooth, and the error of Nyström's method on Gauss'
nodes falls as a power of the number of nodes (K. E. Atkinson, The Numerical Solution of Integral Equations of
the Second Kind, 1997, ch. 4).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from renderer.studies.validation.exact.geometry import Plane
from renderer.studies.validation.exact.one_bounce import Lamp
from renderer.studies.validation.exact.quadrature import integral, region_triangles


@dataclass(frozen=True)
class ParallelFaces:
    """Two rectangles (4, 3) [m] that face each other, with their reflectances, and a point lamp between
    them.

    nodes : number along each side. For lamps at least a third of the gap from either face, and sides up to
      two gaps long, 24 nodes give the results of 32 within 1e-7.
    """

    lamp: Lamp
    faces: tuple[tuple[np.ndarray, float], tuple[np.ndarray, float]]
    nodes: int = 24

    def illuminance(self, position: np.ndarray, normal: np.ndarray) -> float:
        """Illuminance [lx] at a point (3,) [m] with a unit normal (3,)."""
        light = float(self.lamp.illuminance(position[None], normal)[0])
        return light + sum(self._reflected(position, normal, k) for k in (0, 1))

    def _reflected(self, position: np.ndarray, normal: np.ndarray, k: int) -> float:
        rho, plane = self.faces[k][1], Plane(self.faces[k][0])
        height = plane.height(position)
        if height <= 1e-9:
            return 0.0
        region = plane.polygon.intersection(plane.before(position, normal))

        def brought(places: np.ndarray) -> np.ndarray:
            points = plane.solid(places)
            reach = points - position
            seen = (reach @ normal).clip(0) * height / (reach * reach).sum(axis=1) ** 2
            return self._received(points, plane.normal, k) * seen

        return rho / np.pi * integral(brought, region_triangles(region))

    def _received(self, points: np.ndarray, normal: np.ndarray, k: int) -> np.ndarray:
        """Illuminance (k,) [lx] on one face, from the lamp and from the other face."""
        at, weights = self._nodes[1 - k]
        kernel = _kernel(points, normal, at, self._normals[1 - k])
        return self.lamp.illuminance(points, normal) + kernel @ (weights * self._radiosity[1 - k])

    @cached_property
    def _normals(self) -> list[np.ndarray]:
        return [Plane(polygon).normal for polygon, _ in self.faces]

    @cached_property
    def _nodes(self) -> list[tuple[np.ndarray, np.ndarray]]:
        x, w = np.polynomial.legendre.leggauss(self.nodes)
        s, t = (each.ravel()[:, None] for each in np.meshgrid((1 + x) / 2, (1 + x) / 2))
        found = []
        for polygon, _ in self.faces:
            u, v = polygon[1] - polygon[0], polygon[3] - polygon[0]
            area = np.linalg.norm(np.cross(u, v))
            found.append((polygon[0] + s * u + t * v, area * np.outer(w, w).ravel() / 4))
        return found

    @cached_property
    def _radiosity(self) -> list[np.ndarray]:
        """Radiosity [lm/m²] at the nodes of each face."""
        (a, wa), (b, wb) = self._nodes
        na, nb = self._normals
        rho = [rho for _, rho in self.faces]
        direct = [self.lamp.illuminance(at, n) for at, n in ((a, na), (b, nb))]
        kernel = _kernel(a, na, b, nb)
        send = [rho[k] * direct[k] for k in (0, 1)]
        light = [x.copy() for x in send]
        for _ in range(2000):
            before = light[0]
            light[1] = send[1] + rho[1] * (kernel.T @ (wa * light[0]))
            light[0] = send[0] + rho[0] * (kernel @ (wb * light[1]))
            if np.abs(light[0] - before).max() <= 1e-13 * np.abs(light[0]).max():
                break
        return light


def _kernel(points: np.ndarray, normal: np.ndarray, at: np.ndarray, facing: np.ndarray) -> np.ndarray:
    """Kernel cos θ cos θ' / π r² (k, m) [m⁻²] between points (k, 3) and places (m, 3)."""
    reach = at[None] - points[:, None]
    r2 = (reach * reach).sum(axis=2)
    return (reach @ normal).clip(0) * (-(reach @ facing)).clip(0) / (np.pi * r2 * r2)
