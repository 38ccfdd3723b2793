"""Luminaires from the tables of a scene file."""

from dataclasses import replace

import numpy as np

from renderer.scene.luminaires.lambertian import IsotropicPoint, LambertianFace, LambertianPoint
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.scene.luminaires.measured import MeasuredOpening, MeasuredPoint
from renderer.scene.luminaires.opening import OpeningFace
from renderer.scene.luminaires.outline import ellipse, ellipse_about, rectangle_about
from renderer.scene.photometric.record import Photometry
from renderer.scene.photometric.shapes import NADIR, Cylinder, Ellipsoid, Shape


def make_luminaires(table, photometry: Photometry | None) -> list[Luminaire]:
    """The luminaires of a validated table of the scene file: one, or an array of them.

    photometry : of the table's file, for shape "ies"

    Raises ValueError with a sentence.
    """
    normal = np.array(table.normal or (0.0, 0.0, -1.0))
    normal = normal / np.abs(normal).max()
    normal /= np.linalg.norm(normal)
    along = _across(normal, table.up)
    across = np.cross(along, normal)
    make = KINDS.get(table.shape, _measured)
    one = make(table, normal, along, photometry)
    if table.array is None:
        return [one]
    counts, steps = table.array, table.spacing
    spots = [[(k - (n - 1) / 2) * step for k in range(n)] for n, step in zip(counts, steps, strict=True)]
    return [replace(one.moved(x * along + y * across), name=f"{table.name} {i},{j}")
            for j, y in enumerate(spots[1], 1) for i, x in enumerate(spots[0], 1)]


def _rectangle(table, normal: np.ndarray, along: np.ndarray, _photometry) -> Luminaire:
    center, across = np.array(table.center), np.cross(normal, along)
    return _face(table, center, normal,
                 rectangle_about(center, normal, along * table.size[0], across * table.size[1]))


def _disc(table, normal: np.ndarray, along: np.ndarray, _photometry) -> Luminaire:
    center, across, radius = np.array(table.center), np.cross(normal, along), table.diameter / 2
    return _face(table, center, normal, ellipse_about(center, normal, along * radius, across * radius))


def _face(table, center: np.ndarray, normal: np.ndarray, body) -> Luminaire:
    lumens = np.pi * table.luminance * body.area if table.flux is None else table.flux
    return LambertianFace(table.name, center, normal, lumens * table.dimming, body)


def _point(table, normal: np.ndarray, _along, _photometry) -> Luminaire:
    kind = LambertianPoint if table.distribution == "lambertian" else IsotropicPoint
    lumens = table.intensity * kind.lumens_per_candela if table.flux is None else table.flux
    return kind(table.name, np.array(table.center), normal, lumens * table.dimming)


def _measured(table, normal: np.ndarray, along: np.ndarray, photometry: Photometry) -> Luminaire:
    """A luminaire from a photometric file: C0 along `up`, the nadir along `normal`."""
    center, shape = np.array(table.center), photometry.shape
    axes = np.stack([along, np.cross(along, normal), normal])
    tilt = photometry.tilt.factor(normal) if photometry.tilt else 1.0
    lumens = (photometry.distribution.flux * tilt if table.flux is None else table.flux) * table.dimming
    says = {"distribution": photometry.distribution, "axes": axes}
    if not (shape.length or shape.width or shape.height):
        return MeasuredPoint(table.name, center, normal, lumens, **says)
    length, width = max(shape.length, 1e-3), max(shape.width, 1e-3)  # a line is 1 mm wide
    # Seen from the front, C0 to C90 is clockwise.
    if _is_round(shape):
        body = ellipse_about(center, normal, axes[0] * length / 2, -axes[1] * width / 2)
    else:
        body = rectangle_about(center, normal, axes[0] * length, -axes[1] * width)
    opening = _opening(shape, length, width, axes)
    return MeasuredOpening(table.name, center, normal, lumens, body, opening, shape=shape, **says)


KINDS = {"rectangle": _rectangle, "disc": _disc, "point": _point}
"""Functions that make a luminaire of each shape; shape "ies" is made by `_measured`."""


def _is_round(shape: Shape) -> bool:
    """Whether an opening is round seen from the nadir; a lying cylinder counts as the box around it."""
    return isinstance(shape, Ellipsoid) or (isinstance(shape, Cylinder) and shape.axis == NADIR)


def _opening(shape: Shape, length: float, width: float, axes: np.ndarray) -> tuple[OpeningFace, ...]:
    """Front, back and sides of a luminous opening, normals outward.

    A sphere gives I/d² at any distance, so a plate of 1 % of its size stands for an ellipsoid. A plate also
    stands for an opening of up to 0.2 m: at five times its length the illuminance is within 1 % of that of
    its true faces.
    """
    scale = 0.01 if isinstance(shape, Ellipsoid) else 1.0
    height = 0.0 if isinstance(shape, Ellipsoid) or shape.extent.max() <= 0.2 else shape.height
    u, v, down = scale * length * axes[0], scale * width * axes[1], height / 2 * axes[2]
    if not _is_round(shape):
        faces = [OpeningFace(down, u, v, axes[2]), OpeningFace(-down, u, v, -axes[2])]
        if height:
            for edge, other in ((u, v), (v, u)):
                n = edge / np.linalg.norm(edge)
                faces += [OpeningFace(side * edge / 2, other, 2 * down, side * n) for side in (1, -1)]
        return tuple(faces)
    faces = [OpeningFace(down, u / 2, v / 2, axes[2], True), OpeningFace(-down, u / 2, v / 2, -axes[2], True)]
    if height:
        rim = ellipse(np.zeros(3), u / 2, v / 2, 8)
        for a, b in zip(rim, np.roll(rim, -1, axis=0), strict=True):
            n = np.cross(b - a, axes[2])
            n *= np.sign(n @ (a + b)) / np.linalg.norm(n)
            faces.append(OpeningFace((a + b) / 2, b - a, 2 * down, n))
    return tuple(faces)


def _across(normal: np.ndarray, up) -> np.ndarray:
    """A unit vector in the luminaire's plane, along `up` where that is given. Raises ValueError."""
    direction = np.array(up) if up is not None else np.eye(3)[np.abs(normal).argmin()]
    direction = direction - (direction @ normal) * normal
    length = np.linalg.norm(direction)
    if up is not None and length < 1e-9 * np.linalg.norm(up):
        raise ValueError("up lies along normal; give any direction across it")
    return direction / length
