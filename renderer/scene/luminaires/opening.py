"""Luminaires with intensities that leave through an opening.

Each element of the opening sends its share of the intensity in every direction, so that the illuminance far
away is I/d².
"""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from renderer.radiometry.quadrature import gauss_points, halved, legendre
from renderer.scene.luminaires.luminaire import ExtendedLuminaire
from renderer.system.lazy import cached_property
from renderer.system.threads import in_threads


@dataclass(frozen=True)
class OpeningFace:
    """A flat part of a luminous opening, relative to the luminaire's centre.

    middle : (3,) [m]
    u, v : (3,) [m] edges of a rectangle, or half axes of an ellipse
    normal : (3,) unit vector
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
        """Points (…, 3) [m] of the face from coordinates (…) of the unit square; equal areas map to equal
        areas."""
        if self.elliptic:
            r, turn = np.sqrt(s)[..., None], 2 * np.pi * t[..., None]
            return self.middle + r * (np.cos(turn) * self.u + np.sin(turn) * self.v)
        return self.middle + (s[..., None] - 0.5) * self.u + (t[..., None] - 0.5) * self.v


@dataclass(frozen=True)
class OpeningLuminaire(ExtendedLuminaire):
    """A source whose flat faces together send an intensity that depends on direction.

    opening : the faces, relative to the centre
    """

    opening: tuple[OpeningFace, ...] = field()

    table_lumens = 1.0
    """Luminous flux [lm] of the intensities that `toward` returns."""

    def toward(self, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Luminous intensity (…) [cd] at `table_lumens` along directions of any length, given by components
        (…) along `axes`."""
        away = np.stack(np.broadcast_arrays(x, y, z), axis=-1) @ self.axes
        return self.intensity(away / np.maximum(np.linalg.norm(away, axis=-1), 1e-300)[..., None])

    def illuminance(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Illuminance per lumen, as in `Luminaire`: E = Σ_faces ∫ I(d) cos θ_face / A_p(d) · cos θ / r² dA.

        The opening's luminance toward a direction is I over its projected area (CIE 117-1995), uniform over
        the opening.
        """
        light = np.zeros(len(points))

        def work(start: int, stop: int) -> None:
            p, n = points[start:stop], normals[start:stop]
            for face in self.opening:
                middle = self.center + face.middle
                ahead = (p - middle) @ face.normal
                # Height of the face above the point's horizon.
                spread = np.abs(n @ face.u) + np.abs(n @ face.v)
                above = ((middle - p) * n).sum(axis=1) + spread > 0
                # For a plate that stands for a solid, points in its plane get the light of both faces from
                # the front alone.
                before = ahead >= 0 if face is self.opening[0] and len(self.opening) == 2 else ahead > 0
                lit = np.flatnonzero(before & above)
                light[start + lit] += _from_face(p[lit], n[lit], self, face)

        in_threads(work, len(points), 1 << 13)
        return light

    def projected_area(self, away: np.ndarray) -> np.ndarray:
        return sum((face.area * np.clip(away @ face.normal, 0, None) for face in self.opening),
                   np.zeros(away.shape[:-1]))

    @property
    def half_box(self) -> np.ndarray:
        half = np.zeros(3)
        for face in self.opening:
            middle, u, v = (np.abs(x @ self.axes.T) for x in (face.middle, face.u, face.v))
            half = np.maximum(half, middle + (u + v) / (1 if face.elliptic else 2))
        return half

    @property
    def geometry(self) -> list[np.ndarray]:
        return [*super().geometry, self.axes, np.array([[f.middle, f.u, f.v] for f in self.opening])]


def _from_face(p: np.ndarray, n: np.ndarray, luminaire: OpeningLuminaire, face: OpeningFace) -> np.ndarray:
    """Illuminance per lumen (k,) [m⁻²] from one face: by one Gauss rule over the face for points farther away
    than 0.3 of its longer side, by halving for nearer ones."""
    light = np.zeros(len(p))
    sides = np.array([np.linalg.norm(edge) * (2 if face.elliptic else 1) for edge in (face.u, face.v)])
    frame = np.stack([face.u, face.v, face.normal])
    frame /= np.linalg.norm(frame, axis=1)[:, None]
    offset = np.abs((p - luminaire.center - face.middle) @ frame.T) - np.append(sides / 2, 0.0)
    far = np.linalg.norm(np.clip(offset, 0, None), axis=1)
    whole = far > max(sides) * 0.3
    near = np.flatnonzero(~whole)
    light[near] = _near_face(p[near], n[near], luminaire, face)
    # One rule for all points within an octave of distance.
    ring = np.floor(np.log2(np.where(whole, far, 1.0)))
    at, facing = (p - luminaire.center) @ luminaire.axes.T, n @ luminaire.axes.T
    for step in np.unique(ring[whole]):
        k = np.flatnonzero(whole & (ring == step))
        places, share = _rule(face, sides, luminaire.longest_piece * 2**step)
        places = places @ luminaire.axes.T
        size = max(1, (1 << 15) // len(places))
        for part in np.split(k, range(size, len(k), size)):
            light[part] = _sent(at[part, None], facing[part, None], places, luminaire, face) @ (
                face.area * share)
    return light


def _rule(face: OpeningFace, sides: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Places (m, 3) [m] on a face and the share (m,) of its area that each stands for.

    Along each side there are two places, and 1.6 more for each length `reach` [m] of the side.
    """
    if face.elliptic:  # along the radius, and at equal steps around
        counts = [2 + int(max(sides) / 2 / reach), 6 + 2 * int(np.pi * max(sides) / 2 / reach)]
    else:
        counts = [2 + int(1.6 * side / reach) for side in sides]
    (s, ws), (t, wt) = (legendre(count) for count in counts)
    if face.elliptic:
        t, wt = 2 * np.arange(counts[1]) / counts[1] - 1, np.full(counts[1], 2 / counts[1])
    s, t = (x.ravel() for x in np.meshgrid((1 + s) / 2, (1 + t) / 2, indexing="ij"))
    return face.at(s, t), np.outer(ws, wt).ravel() / 4


def _near_face(p: np.ndarray, n: np.ndarray, luminaire: OpeningLuminaire, face: OpeningFace) -> np.ndarray:
    """Illuminance per lumen (k,) [m⁻²] from one face at points near it, the face halved until each part is
    short for its distance, at most 36 times."""
    close, deepest = luminaire.longest_piece, 36
    turns = np.arange(9) / 8 if face.elliptic else np.array([0.0, 1.0])  # an ellipse as eight sectors
    cells = np.array([[0.0, 1.0, a, b] for a, b in pairwise(turns)])
    who = np.repeat(np.arange(len(p)), len(cells))
    cells = np.tile(cells, (len(p), 1))
    light = np.zeros(len(p))
    at, facing = (p - luminaire.center) @ luminaire.axes.T, n @ luminaire.axes.T
    for depth in range(deepest + 1):
        if not len(who):
            break
        s0, s1, t0, t1 = cells.T
        sides = [np.linalg.norm(face.at(*a) - face.at(*b), axis=1) for a, b in (
            ((s0, (t0 + t1) / 2), (s1, (t0 + t1) / 2)), (((s0 + s1) / 2, t0), ((s0 + s1) / 2, t1)))]
        middle = luminaire.center + face.at((s0 + s1) / 2, (t0 + t1) / 2)
        far = np.linalg.norm(p[who] - middle, axis=1)
        large = (np.maximum(*sides) > close * far) & (depth < deepest)
        s, t, share = gauss_points(cells[~large])
        k = who[~large]
        sent = _sent(at[k, None], facing[k, None], face.at(s, t) @ luminaire.axes.T, luminaire, face)
        light += face.area * np.bincount(k, share * sent.sum(axis=1), len(p))
        along_s = (sides[0] >= sides[1])[large]
        cells, who = halved(cells[large], along_s), np.repeat(who[large], 2)
    return light


def _sent(p, n, at, luminaire: OpeningLuminaire, face: OpeningFace) -> np.ndarray:
    """Illuminance per lumen and area of the face (…) [m⁻⁴] from places (…, 3) to points (…, 3) with normals
    (…, 3).

    It is I / A_p · cos θ_face · cos θ / r², with A_p the opening's projected area. Coordinates are along the
    luminaire's axes, from its centre.
    """
    reach = [p[..., k] - at[..., k] for k in range(3)]
    distance2 = reach[0] * reach[0]
    for x in reach[1:]:
        distance2 += x * x
    np.maximum(distance2, 1e-30, out=distance2)
    light = luminaire.toward(*reach)
    light *= _along(reach, -n)
    light /= distance2
    light /= np.sqrt(distance2, out=distance2)
    faces = [(each.area, luminaire.axes @ each.normal) for each in luminaire.opening]
    if len(faces) == 2:  # cos θ_face cancels against A_p; dividing would give 0/0 at grazing angles
        light /= face.area * luminaire.table_lumens
        return light
    seen = sum(area * _along(reach, normal) for area, normal in faces)
    light *= _along(reach, luminaire.axes @ face.normal)
    return np.divide(light, luminaire.table_lumens * seen, out=np.zeros_like(light), where=seen > 0)


def _along(reach: list[np.ndarray], n: np.ndarray) -> np.ndarray:
    """Scalar product (…) of vectors, given by components (…), with n (3,) or (…, 3), at least 0."""
    total = reach[0] * n[..., 0]
    for x, component in zip(reach[1:], np.moveaxis(n[..., 1:], -1, 0), strict=True):
        total += x * component
    return np.maximum(total, 0, out=total)
