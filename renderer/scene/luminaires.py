"""Luminaires: where light starts, how much, and in which directions."""

from dataclasses import dataclass, field, replace

import numpy as np

from renderer.scene.geometry import Rectangle
from renderer.scene.photometric.distribution import Distribution
from renderer.scene.photometric.record import Photometry, Shape
from renderer.system.lazy import cached_property

DISC_CORNERS = 64
THINNEST = 1e-3
"""A luminous opening [m] that is a line is this wide."""
SIDES = 8
"""Flat sides that a round luminous opening with height has."""


@dataclass(frozen=True)
class Face:
    """A flat part of a luminous opening, given from the luminaire's centre.

    middle : (3,) [m]; u, v : (3,) [m] edges of a rectangle, or half axes of an ellipse; normal : (3,) unit
    """

    middle: np.ndarray
    u: np.ndarray
    v: np.ndarray
    normal: np.ndarray
    elliptic: bool = False

    @cached_property
    def area(self) -> float:
        """Area [m²]."""
        return float(np.linalg.norm(np.cross(self.u, self.v))) * (np.pi if self.elliptic else 1.0)

    def at(self, s: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Points (…, 3) [m] from the unit square, equal areas from equal areas."""
        if self.elliptic:
            r, turn = np.sqrt(s)[..., None], 2 * np.pi * t[..., None]
            return self.middle + r * (np.cos(turn) * self.u + np.sin(turn) * self.v)
        return self.middle + (s[..., None] - 0.5) * self.u + (t[..., None] - 0.5) * self.v


@dataclass(frozen=True)
class Luminaire:
    """A light source.

    center : (3,) [m]; normal : (3,) unit, the way flat sources, Lambertian points and nadirs face
    outline : (k, 3) [m] corners of its opaque body, counter-clockwise seen from the front; None for a point
    rectangle : the outline as a rectangle, where it is one
    lambertian : whether it emits as cosine about its normal; else alike in all directions, or as measured
    lumens : luminous flux [lm]
    distribution : measured intensities, of any flux; None for the others
    axes : (3, 3) directions of C0, C90 and the nadir, of a measured one
    opening : flat faces of its luminous opening, of a measured one that is no point
    """

    name: str
    center: np.ndarray
    normal: np.ndarray
    outline: np.ndarray | None
    rectangle: Rectangle | None
    lambertian: bool
    lumens: float
    distribution: Distribution | None = None
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))
    opening: tuple[Face, ...] = ()

    @cached_property
    def area(self) -> float:
        """Area of its body [m²]; 0 for a point."""
        if self.outline is None:
            return 0.0
        edges = self.outline - self.center
        return float(np.cross(edges, np.roll(edges, -1, axis=0)).sum(axis=0) @ self.normal) / 2

    @property
    def forward_only(self) -> bool:
        """Whether no light leaves it backward, against its normal."""
        return self.lambertian if self.distribution is None else self.backward_share < 1e-6

    @cached_property
    def backward_share(self) -> float:
        """Share of a measured luminaire's flux (0 … 1) that leaves against its normal."""
        return self.share_into(-self.normal)

    def share_into(self, direction: np.ndarray) -> float:
        """Share of a measured luminaire's flux (0 … 1) to the side of a unit direction (3,)."""
        return self.distribution.beyond(self.axes @ -direction)

    def intensity(self, away: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) per lumen [cd/lm] along unit directions (…, 3) that leave it."""
        if self.distribution is not None:
            return self.distribution.intensity(away @ self.axes.T) / self.distribution.flux
        if not self.lambertian:
            return np.full(away.shape[:-1], 1 / (4 * np.pi))
        return np.clip(away @ self.normal, 0, None) / np.pi

    def projected_area(self, away: np.ndarray) -> np.ndarray:
        """Luminous area (…) [m²] as seen from unit directions (…, 3); 0 for a point."""
        if self.distribution is None:
            return self.area * np.clip(away @ self.normal, 0, None)
        return sum((face.area * np.clip(away @ face.normal, 0, None) for face in self.opening),
                   np.zeros(away.shape[:-1]))

    def luminance(self, away: np.ndarray) -> np.ndarray:
        """Luminance (…) per lumen [cd/m²/lm] along unit directions (…, 3): all of its opening alike."""
        seen = self.projected_area(away)
        return np.where(seen > 0, self.intensity(away) / np.where(seen > 0, seen, 1.0), 0.0)


def make_luminaires(table, photometry: Photometry | None) -> list[Luminaire]:
    """The luminaires that a validated table of the scene file describes: one, or an array of them.

    photometry : what the table's file states, of shape "ies". Raises ValueError with a sentence.
    """
    normal = np.array(table.normal or (0.0, 0.0, -1.0))
    normal = normal / np.abs(normal).max()
    normal /= np.linalg.norm(normal)
    along = _across(normal, table.up)
    across = np.cross(along, normal)
    make = _measured if photometry else _lambertian
    one = make(table, normal, along, photometry)
    if table.array is None:
        return [one]
    counts, steps = table.array, table.spacing
    spots = [[(k - (n - 1) / 2) * step for k in range(n)] for n, step in zip(counts, steps, strict=True)]
    return [replace(moved(one, x * along + y * across), name=f"{table.name} {i},{j}")
            for j, y in enumerate(spots[1], 1) for i, x in enumerate(spots[0], 1)]


def moved(luminaire: Luminaire, shift: np.ndarray) -> Luminaire:
    """A luminaire moved by (3,) [m]."""
    if luminaire.outline is None:
        return replace(luminaire, center=luminaire.center + shift)
    rectangle = luminaire.rectangle
    return replace(luminaire, center=luminaire.center + shift, outline=luminaire.outline + shift,
                   rectangle=rectangle and replace(rectangle, corner=rectangle.corner + shift))


def _lambertian(table, normal: np.ndarray, along: np.ndarray, _photometry) -> Luminaire:
    """A rectangle, a disc, or a point."""
    center, across = np.array(table.center), np.cross(normal, along)
    outline = rectangle = None
    if table.shape == "rectangle":
        rectangle = _rectangle(center, along * table.size[0], across * table.size[1])
        outline = rectangle.corners
    elif table.shape == "disc":
        outline = _ellipse(center, along * table.diameter / 2, across * table.diameter / 2, DISC_CORNERS)
    lambertian = table.shape != "point" or table.distribution == "lambertian"
    luminaire = Luminaire(table.name, center, normal, outline, rectangle, lambertian, 0.0)
    return replace(luminaire, lumens=_lumens(table, luminaire.area, lambertian) * table.dimming)


def _lumens(table, area: float, lambertian: bool) -> float:
    if table.flux is not None:
        return table.flux
    if table.luminance is not None:
        return np.pi * table.luminance * area
    return table.intensity * (np.pi if lambertian else 4 * np.pi)


def _measured(table, normal: np.ndarray, along: np.ndarray, photometry: Photometry) -> Luminaire:
    """A luminaire from a photometric file: C0 along `up`, the nadir along `normal`."""
    center, shape = np.array(table.center), photometry.shape
    axes = np.stack([along, np.cross(along, normal), normal])
    outline = rectangle = None
    length, width = shape.length, shape.width
    if length or width or shape.height:
        length, width = max(length, THINNEST), max(width, THINNEST)
        # Seen from the front, C0 to C90 is clockwise.
        if shape.circular:
            outline = _ellipse(center, axes[0] * length / 2, -axes[1] * width / 2, DISC_CORNERS)
        else:
            rectangle = _rectangle(center, axes[0] * length, -axes[1] * width)
            outline = rectangle.corners
    lumens = (photometry.distribution.flux if table.flux is None else table.flux) * table.dimming
    return Luminaire(table.name, center, normal, outline, rectangle, False, lumens, photometry.distribution,
                     axes, _opening(shape, length, width, axes))


def _opening(shape: Shape, length: float, width: float, axes: np.ndarray) -> tuple[Face, ...]:
    """Front, back and sides of a luminous opening, normals outward."""
    if not (length or width):
        return ()
    u, v, down = length * axes[0], width * axes[1], shape.height / 2 * axes[2]
    if not shape.circular:
        faces = [Face(down, u, v, axes[2]), Face(-down, u, v, -axes[2])]
        if shape.height:
            for edge, other in ((u, v), (v, u)):
                n = edge / np.linalg.norm(edge)
                faces += [Face(edge / 2, other, 2 * down, n), Face(-edge / 2, other, 2 * down, -n)]
        return tuple(faces)
    faces = [Face(down, u / 2, v / 2, axes[2], True), Face(-down, u / 2, v / 2, -axes[2], True)]
    if shape.height:
        rim = _ellipse(np.zeros(3), u / 2, v / 2, SIDES)
        for a, b in zip(rim, np.roll(rim, -1, axis=0), strict=True):
            n = np.cross(b - a, axes[2])
            n *= np.sign(n @ (a + b)) / np.linalg.norm(n)
            faces.append(Face((a + b) / 2, b - a, 2 * down, n))
    return tuple(faces)


def _rectangle(center: np.ndarray, u: np.ndarray, v: np.ndarray) -> Rectangle:
    return Rectangle(center - (u + v) / 2, u, v)


def _ellipse(center: np.ndarray, u: np.ndarray, v: np.ndarray, corners: int) -> np.ndarray:
    """Corners (k, 3) of a polygon with the area of the ellipse of half axes u and v, so with its lumens
    and its illuminance from afar."""
    angle = 2 * np.pi * np.arange(corners) / corners
    swell = np.sqrt(2 * np.pi / corners / np.sin(2 * np.pi / corners))
    return center + swell * (np.outer(np.cos(angle), u) + np.outer(np.sin(angle), v))


def _across(normal: np.ndarray, up) -> np.ndarray:
    """A unit vector in the luminaire's plane, along `up` where that is given."""
    direction = np.array(up) if up is not None else np.eye(3)[np.abs(normal).argmin()]
    direction = direction - (direction @ normal) * normal
    length = np.linalg.norm(direction)
    if up is not None and length < 1e-9 * np.linalg.norm(up):
        raise ValueError("up lies along normal; give any direction across it")
    return direction / length
