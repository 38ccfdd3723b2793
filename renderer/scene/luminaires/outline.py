"""The outline of a luminaire: points at which rays aim, its distance from points, its division into
patches."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace

import numpy as np

from renderer.scene.geometry import Rectangle, rectangle_grid
from renderer.system.lazy import cached_property


@dataclass(frozen=True)
class Outline(ABC):
    """A flat convex outline.

    center : (3,) [m]
    normal : (3,) unit vector of the front
    """

    center: np.ndarray
    normal: np.ndarray

    rectangle = None
    """The outline as a `Rectangle`; None for others."""

    @property
    @abstractmethod
    def corners(self) -> np.ndarray:
        """Corners (k, 3) [m], counter-clockwise seen from the front."""

    @property
    @abstractmethod
    def width(self) -> float:
        """The shorter side or the diameter [m]."""

    @property
    @abstractmethod
    def sides(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A corner and two edges (3,) [m] of the rectangle around the outline."""

    @abstractmethod
    def moved(self, shift: np.ndarray) -> "Outline":
        """The outline moved by (3,) [m]."""

    @abstractmethod
    def spread(self, square: np.ndarray) -> np.ndarray:
        """Points (…, 3) [m] of even density in the outline, from points (…, 2) of the unit square."""

    @abstractmethod
    def distance(self, away: np.ndarray) -> np.ndarray:
        """Distance (k,) [m] of points from the outline; away : (k, 3) [m] from its centre."""

    @abstractmethod
    def divided(self, patch_size: float) -> tuple[np.ndarray, np.ndarray]:
        """Vertices (k, 3) [m] and patches (m, 4) of about `patch_size` [m]."""

    @abstractmethod
    def second_side(self, first: np.ndarray) -> tuple:
        """Range (0 … 1) along the second of `sides` that lies in the outline, at shares (…) of the first."""

    @cached_property
    def area(self) -> float:
        """Area [m²]."""
        edges = self.corners - self.center
        return float(np.cross(edges, np.roll(edges, -1, axis=0)).sum(axis=0) @ self.normal) / 2

    def aimed(self, places: np.ndarray, square: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points (k, n, 3) [m] in the outline, densest where it is nearest to the place, and the area (k, n),
        up to a factor, that each stands for.

        places : (k, 1 or n, 3) [m]
        square : (k, n, 2) points of the unit square

        Points have even density in the angle along each side, seen from the place. From a height h the
        density is as h²/((h² + x²)(h² + y²)). Near a large face the illuminance from a point over this
        density varies little; at even density it would vary by orders of magnitude. On a disc the second side
        is the chord.
        """
        corner, *sides = self.sides
        offset = places - corner
        lengths = [np.linalg.norm(side) for side in sides]
        height = np.maximum(np.abs(offset @ self.normal), 1e-6 * max(lengths))  # never 0, in the plane
        stands, shares, start, stop = 1.0, [], 0.0, 1.0
        for k, (side, length) in enumerate(zip(sides, lengths, strict=True)):
            below = offset @ side / length
            first, last = (np.arctan2(end * length - below, height) for end in (start, stop))
            aside = height * np.tan(first + square[..., k] * (last - first))
            stands = stands * ((height * height + aside * aside) * ((last - first) / height))
            shares.append(((below + aside) / length).clip(start, stop))
            start, stop = self.second_side(shares[0])
        targets = [c + shares[0] * u + shares[1] * v for c, u, v in zip(corner, *sides, strict=True)]
        return np.stack(targets, axis=-1), stands


@dataclass(frozen=True)
class RectangularOutline(Outline):
    """A rectangular outline."""

    rectangle: Rectangle = field()

    @property
    def corners(self) -> np.ndarray:
        return self.rectangle.corners

    @property
    def width(self) -> float:
        return min(np.linalg.norm(self.rectangle.u), np.linalg.norm(self.rectangle.v))

    @property
    def sides(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self.rectangle.corner, self.rectangle.u, self.rectangle.v

    def moved(self, shift: np.ndarray) -> Outline:
        return replace(self, center=self.center + shift,
                       rectangle=replace(self.rectangle, corner=self.rectangle.corner + shift))

    def spread(self, square: np.ndarray) -> np.ndarray:
        s, t = square[..., 0], square[..., 1]
        return np.stack([c + s * u + t * v for c, u, v in zip(*self.sides, strict=True)], axis=-1)

    def distance(self, away: np.ndarray) -> np.ndarray:
        along = away @ self.normal
        over = [np.maximum(np.abs(away @ edge) / np.linalg.norm(edge) - np.linalg.norm(edge) / 2, 0.0)
                for edge in (self.rectangle.u, self.rectangle.v)]
        return np.sqrt(along**2 + over[0] ** 2 + over[1] ** 2)

    def divided(self, patch_size: float) -> tuple[np.ndarray, np.ndarray]:
        steps = [np.linspace(0, 1, 1 + int(np.ceil(np.linalg.norm(edge) / patch_size)))
                 for edge in (self.rectangle.u, self.rectangle.v)]
        return rectangle_grid(self.rectangle, *steps)

    def second_side(self, first: np.ndarray) -> tuple:
        return 0.0, 1.0


@dataclass(frozen=True)
class RoundOutline(Outline):
    """A disc or an ellipse; polygon : corners (k, 3) [m] of a polygon of its area."""

    polygon: np.ndarray

    @property
    def corners(self) -> np.ndarray:
        return self.polygon

    @property
    def width(self) -> float:
        return 2 * np.linalg.norm(self.corners[0] - self.center)

    @property
    def sides(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        spoke = self.corners[0] - self.center
        u, v = 2 * spoke, 2 * np.cross(self.normal, spoke)
        return self.center - (u + v) / 2, u, v

    def moved(self, shift: np.ndarray) -> Outline:
        return replace(self, center=self.center + shift, polygon=self.polygon + shift)

    def spread(self, square: np.ndarray) -> np.ndarray:
        spokes = self.corners - self.center
        turn = square[..., 1] * len(spokes)
        sector = np.minimum(turn.astype(int), len(spokes) - 1)
        part = (turn - sector)[..., None]
        edge = (1 - part) * spokes[sector] + part * spokes[(sector + 1) % len(spokes)]
        return self.center + np.sqrt(square[..., :1]) * edge

    def distance(self, away: np.ndarray) -> np.ndarray:
        along = away @ self.normal
        beside = np.linalg.norm(away - along[:, None] * self.normal, axis=1) - self.width / 2
        return np.hypot(along, np.maximum(beside, 0.0))

    def divided(self, patch_size: float) -> tuple[np.ndarray, np.ndarray]:
        k = len(self.corners)
        vertices = np.vstack([self.corners, self.center])
        return vertices, np.array([[k, i, (i + 1) % k, (i + 1) % k] for i in range(k)])

    def second_side(self, first: np.ndarray) -> tuple:
        half = np.sqrt(np.maximum(first * (1 - first), 0.0))
        return 0.5 - half, 0.5 + half


def rectangle_about(center: np.ndarray, normal: np.ndarray, u: np.ndarray, v: np.ndarray) -> Outline:
    """A rectangle of edges u and v (3,) [m] about a centre."""
    return RectangularOutline(center, normal, Rectangle(center - (u + v) / 2, u, v))


def ellipse_about(center: np.ndarray, normal: np.ndarray, u: np.ndarray, v: np.ndarray) -> Outline:
    """An ellipse of half axes u and v (3,) [m] about a centre."""
    return RoundOutline(center, normal, ellipse(center, u, v, 64))


def ellipse(center: np.ndarray, u: np.ndarray, v: np.ndarray, corners: int) -> np.ndarray:
    """Corners (k, 3) of a polygon with the area of the ellipse of half axes u and v, so that lumens and far
    illuminance are those of the ellipse."""
    angle = 2 * np.pi * np.arange(corners) / corners
    swell = np.sqrt(2 * np.pi / corners / np.sin(2 * np.pi / corners))
    return center + swell * (np.outer(np.cos(angle), u) + np.outer(np.sin(angle), v))
