"""Luminaires: where light starts, how much, and in which directions."""

from dataclasses import dataclass

import numpy as np

from renderer.scene.geometry import Rectangle

DISC_CORNERS = 64


@dataclass(frozen=True)
class Luminaire:
    """A light source.

    center : (3,) [m]; normal : (3,) unit, the way flat sources and Lambertian points face
    outline : (k, 3) [m] corners, counter-clockwise seen from the front; None for a point
    rectangle : the outline as a rectangle, where it is one
    lambertian : whether a point emits as cosine about its normal; else alike in all directions
    lumens : luminous flux [lm]
    """

    name: str
    center: np.ndarray
    normal: np.ndarray
    outline: np.ndarray | None
    rectangle: Rectangle | None
    lambertian: bool
    lumens: float

    @property
    def area(self) -> float:
        """Luminous area [m²]; 0 for a point."""
        if self.outline is None:
            return 0.0
        edges = self.outline - self.center
        return float(np.cross(edges, np.roll(edges, -1, axis=0)).sum(axis=0) @ self.normal) / 2

    def intensity(self, away: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) per lumen [cd/lm] along unit directions (…, 3) that leave it."""
        if not self.lambertian:
            return np.full(away.shape[:-1], 1 / (4 * np.pi))
        return np.clip(away @ self.normal, 0, None) / np.pi


def make_luminaire(table) -> Luminaire:
    """The luminaire that a validated table of the scene file describes."""
    center = np.array(table.center)
    normal = np.array(table.normal or (0.0, 0.0, -1.0))
    normal = normal / np.abs(normal).max()
    normal /= np.linalg.norm(normal)
    outline = rectangle = None
    if table.shape != "point":
        u = _across(normal, table.up)
        v = np.cross(normal, u)
        if table.shape == "rectangle":
            u, v = u * table.size[0], v * table.size[1]
            rectangle = Rectangle(center - (u + v) / 2, u, v)
            outline = rectangle.corners
        else:
            angle = 2 * np.pi * np.arange(DISC_CORNERS) / DISC_CORNERS
            # The polygon has the disc's area, so its lumens and its illuminance from afar.
            radius = table.diameter / 2 * np.sqrt(
                2 * np.pi / DISC_CORNERS / np.sin(2 * np.pi / DISC_CORNERS))
            outline = center + radius * (np.outer(np.cos(angle), u) + np.outer(np.sin(angle), v))
    lambertian = table.shape != "point" or table.distribution == "lambertian"
    luminaire = Luminaire(table.name, center, normal, outline, rectangle, lambertian, 0.0)
    return Luminaire(**{**vars(luminaire), "lumens": _lumens(table, luminaire.area, lambertian)})


def _lumens(table, area: float, lambertian: bool) -> float:
    if table.flux is not None:
        return table.flux
    if table.luminance is not None:
        return np.pi * table.luminance * area
    return table.intensity * (np.pi if lambertian else 4 * np.pi)


def _across(normal: np.ndarray, up) -> np.ndarray:
    """A unit vector in the luminaire's plane, along `up` where that is given."""
    direction = np.array(up) if up is not None else np.eye(3)[np.abs(normal).argmin()]
    direction = direction - (direction @ normal) * normal
    length = np.linalg.norm(direction)
    if up is not None and length < 1e-9 * np.linalg.norm(up):
        raise ValueError("up lies along normal; give any direction across it")
    return direction / length
