"""Light from measured luminaires, nothing standing between: every place of the luminous opening sends its
share of the measured intensity in each direction, so that from afar I/d² arrives."""

from functools import cache
from itertools import pairwise

import numpy as np

from renderer.scene.luminaires import Face, Luminaire
from renderer.system.threads import in_threads
from renderer.transport.mesh.mesh import Mesh

NEAR, NEAREST = 0.3, 0.12
"""A part of an opening or patch is at most this share of its distance long, less where the table has
finer detail, so that two Gauss points each way integrate it."""
DEEPEST, DEEPEST_PATCH, SMALLEST = 36, 12, 0.05
"""Halvings of an opening, and of a patch, at the most; and the smallest part of a patch, in sides of the
opening."""
APART, DENSE = 0.3, 1.6
"""A point farther from a face than this share of its longer side sees it by one rule; how many places that
has for each length that a part may have."""
SECTORS = 8
GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)
POINTS = 1 << 13


def through_opening(points: np.ndarray, normals: np.ndarray, luminaire: Luminaire) -> np.ndarray:
    """Illuminance per lumen (k,) [m⁻²] at points (k, 3) [m] on planes of normals (k, 3), from a measured
    luminaire with an opening.

    The opening's luminance toward a direction is I over its projected area (CIE 117), all of it alike:
    E = Σ_faces ∫ I(d) cos θ_face / A_p(d) · cos θ / r² dA.
    """
    light = np.zeros(len(points))

    def work(start: int, stop: int) -> None:
        p, n = points[start:stop], normals[start:stop]
        for face in luminaire.opening:
            middle = luminaire.center + face.middle
            ahead = (p - middle) @ face.normal
            # How far the face reaches over the point's horizon.
            spread = np.abs(n @ face.u) + np.abs(n @ face.v)
            above = ((middle - p) * n).sum(axis=1) + spread > 0
            lit = np.flatnonzero((ahead > 0) & above)
            light[start + lit] += _from_face(p[lit], n[lit], luminaire, face)

    in_threads(work, len(points), POINTS)
    return light


def _from_face(p: np.ndarray, n: np.ndarray, luminaire: Luminaire, face: Face) -> np.ndarray:
    """What one face sends (k,) [m⁻²]: by one rule of Gauss over all of it from afar, else halved."""
    light = np.zeros(len(p))
    sides = np.array([np.linalg.norm(edge) * (2 if face.elliptic else 1) for edge in (face.u, face.v)])
    frame = np.stack([face.u, face.v, face.normal])
    frame /= np.linalg.norm(frame, axis=1)[:, None]
    offset = np.abs((p - luminaire.center - face.middle) @ frame.T) - np.append(sides / 2, 0.0)
    far = np.linalg.norm(np.clip(offset, 0, None), axis=1)
    whole = far > max(sides) * APART
    near = np.flatnonzero(~whole)
    light[near] = _near_face(p[near], n[near], luminaire, face)
    # From as far, as many places: one rule for all points of an octave.
    ring = np.floor(np.log2(np.where(whole, far, 1.0)))
    at, facing = (p - luminaire.center) @ luminaire.axes.T, n @ luminaire.axes.T
    for step in np.unique(ring[whole]):
        k = np.flatnonzero(whole & (ring == step))
        places, share = _rule(face, sides, closeness(luminaire) * 2**step)
        places = places @ luminaire.axes.T
        size = max(1, POINTS * 4 // len(places))
        for part in np.split(k, range(size, len(k), size)):
            light[part] = _sent(at[part, None], facing[part, None], places, luminaire, face) @ (
                face.area * share)
    return light


def _rule(face: Face, sides: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Places (m, 3) [m] on a face and the share (m,) of its area that each stands for: two, and DENSE more
    for each length `reach` [m] of its sides."""
    if face.elliptic:  # along the radius, and evenly around
        counts = [2 + int(max(sides) / 2 / reach), 6 + 2 * int(np.pi * max(sides) / 2 / reach)]
    else:
        counts = [2 + int(DENSE * side / reach) for side in sides]
    (s, ws), (t, wt) = (_legendre(count) for count in counts)
    if face.elliptic:
        t, wt = 2 * np.arange(counts[1]) / counts[1] - 1, np.full(counts[1], 2 / counts[1])
    s, t = (x.ravel() for x in np.meshgrid((1 + s) / 2, (1 + t) / 2, indexing="ij"))
    return face.at(s, t), np.outer(ws, wt).ravel() / 4


@cache
def _legendre(count: int) -> tuple[np.ndarray, np.ndarray]:
    return np.polynomial.legendre.leggauss(count)


def _near_face(p: np.ndarray, n: np.ndarray, luminaire: Luminaire, face: Face) -> np.ndarray:
    """What one face sends (k,) [m⁻²] to points near it: halved until short for its distance."""
    close = closeness(luminaire)
    turns = np.arange(SECTORS + 1) / SECTORS if face.elliptic else np.array([0.0, 1.0])
    cells = np.array([[0.0, 1.0, a, b] for a, b in pairwise(turns)])
    who = np.repeat(np.arange(len(p)), len(cells))
    cells = np.tile(cells, (len(p), 1))
    light = np.zeros(len(p))
    at, facing = (p - luminaire.center) @ luminaire.axes.T, n @ luminaire.axes.T
    for depth in range(DEEPEST + 1):
        if not len(who):
            break
        s0, s1, t0, t1 = cells.T
        sides = [np.linalg.norm(face.at(*a) - face.at(*b), axis=1) for a, b in (
            ((s0, (t0 + t1) / 2), (s1, (t0 + t1) / 2)), (((s0 + s1) / 2, t0), ((s0 + s1) / 2, t1)))]
        middle = luminaire.center + face.at((s0 + s1) / 2, (t0 + t1) / 2)
        far = np.linalg.norm(p[who] - middle, axis=1)
        large = (np.maximum(*sides) > close * far) & (depth < DEEPEST)
        s, t, share = gauss_points(cells[~large])
        k = who[~large]
        sent = _sent(at[k, None], facing[k, None], face.at(s, t) @ luminaire.axes.T, luminaire, face)
        light += face.area * np.bincount(k, share * sent.sum(axis=1), len(p))
        along_s = (sides[0] >= sides[1])[large]
        cells, who = halved(cells[large], along_s), np.repeat(who[large], 2)
    return light


def gauss_points(cells: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two Gauss points each way of cells (k, 4) of a unit square: s and t (k, 4), and what share of the
    square each stands for (k,)."""
    s0, s1, t0, t1 = cells.T[:, :, None]
    s, t = s0 + np.repeat(GAUSS, 2) * (s1 - s0), t0 + np.tile(GAUSS, 2) * (t1 - t0)
    return s, t, ((s1 - s0) * (t1 - t0) / 4)[:, 0]


def _sent(p, n, at, luminaire: Luminaire, face: Face) -> np.ndarray:
    """From places (…, 3) on a face to points (…, 3) that face along n (…, 3), per area of the face (…) [m⁻⁴].

    That is I / A_p · cos θ_face · cos θ / r², with A_p the opening's projected area; all along the
    luminaire's own axes and from its centre.
    """
    reach = [p[..., k] - at[..., k] for k in range(3)]
    distance2 = reach[0] * reach[0]
    for x in reach[1:]:
        distance2 += x * x
    np.maximum(distance2, 1e-30, out=distance2)
    light = luminaire.distribution.toward(*reach)
    light *= _along(reach, -n)
    light /= distance2
    light /= np.sqrt(distance2, out=distance2)
    faces = [(each.area, luminaire.axes @ each.normal) for each in luminaire.opening]
    if len(faces) == 2:  # the cosine cancels, and at grazing angles need not be divided
        light /= face.area * luminaire.distribution.flux
        return light
    seen = sum(area * _along(reach, normal) for area, normal in faces)
    light *= _along(reach, luminaire.axes @ face.normal)
    return np.divide(light, luminaire.distribution.flux * seen, out=np.zeros_like(light), where=seen > 0)


def _along(reach: list[np.ndarray], n: np.ndarray) -> np.ndarray:
    """How far components (…) each reach along n (3,) or (…, 3), at least 0."""
    total = reach[0] * n[..., 0]
    for x, component in zip(reach[1:], np.moveaxis(n[..., 1:], -1, 0), strict=True):
        total += x * component
    return np.maximum(total, 0, out=total)


def halved(cells: np.ndarray, along_s: np.ndarray) -> np.ndarray:
    """Cells (k, 4) of a unit square, s and t from and to, each cut in two along s or t (2k, 4)."""
    first, second = cells.copy(), cells.copy()
    for cut, low, high in ((along_s, 0, 1), (~along_s, 2, 3)):
        middle = (cells[cut, low] + cells[cut, high]) / 2
        first[cut, high], second[cut, low] = middle, middle
    return np.stack([first, second], axis=1).reshape(-1, 4)


def closeness(luminaire: Luminaire) -> float:
    """How long a part may be for its distance, so that the table is about linear across it."""
    return float(np.clip(3 * luminaire.distribution.step, NEAREST, NEAR))


def measured_flux(mesh: Mesh, patch: np.ndarray, luminaire: Luminaire, light_at) -> np.ndarray:
    """Share of a measured luminaire's lumens that each patch would receive if nothing stood between (k,).

    light_at : illuminance per lumen at points (k, 3) of normals (k, 3). Patches are halved likewise, but
    stay twice as long: what one receives too much, its neighbour receives too little.
    """
    close = 2 * closeness(luminaire)
    which = np.flatnonzero(_faces(mesh, patch, luminaire))
    cells = np.tile([0.0, 1.0, 0.0, 1.0], (len(which), 1))
    # Where the opening touches a patch its light is bounded.
    smallest = SMALLEST * np.sqrt(max((face.area for face in luminaire.opening), default=0.0))
    places = []
    lengths = np.linalg.norm(mesh.u[patch], axis=1), np.linalg.norm(mesh.v[patch], axis=1)
    for depth in range(DEEPEST_PATCH + 1):
        if not len(which):
            break
        s0, s1, t0, t1 = cells.T
        sides = lengths[0][which] * (s1 - s0), lengths[1][which] * (t1 - t0)
        middle = _on(mesh, patch[which], (s0 + s1) / 2, (t0 + t1) / 2)
        long = np.maximum(close * _distance(luminaire, middle), smallest)
        large = (np.maximum(*sides) > long) & (depth < DEEPEST_PATCH)
        s, t, share = gauss_points(cells[~large])
        k = np.repeat(which[~large], GAUSS.size**2)
        places.append((k, np.repeat(share, GAUSS.size**2), _on(mesh, patch[k], s.ravel(), t.ravel())))
        cells = halved(cells[large], (sides[0] >= sides[1])[large])
        which = np.repeat(which[large], 2)
    if not places:
        return np.zeros(len(patch))
    k, share, at = (np.concatenate(x) for x in zip(*places, strict=True))
    light = light_at(at, mesh.normal[patch[k]])
    return mesh.area[patch] * np.bincount(k, share * light, len(patch))


def _on(mesh: Mesh, patch: np.ndarray, s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Points of patches (k, 3) [m] from the unit square, equal areas from equal areas."""
    root = np.sqrt(1 - s)
    triangular = mesh.triangular[patch]
    return mesh.at(patch, np.where(triangular, 1 - root, s), np.where(triangular, t * root, t))


def _faces(mesh: Mesh, patch: np.ndarray, luminaire: Luminaire) -> np.ndarray:
    """Which patches may receive light: some of the opening before them, some of them before it (k,)."""
    slack = 1e-9 * mesh.scale
    normal, half = mesh.normal[patch], _half(luminaire)
    height = ((luminaire.center - mesh.centroid[patch]) * normal).sum(axis=1)
    before = height + np.abs(normal @ luminaire.axes.T) @ half > slack
    if luminaire.forward_only:
        before &= ((mesh.corners[patch] - luminaire.center) @ luminaire.normal).max(axis=1) > slack - half[2]
    return before


def _half(luminaire: Luminaire) -> np.ndarray:
    """Half the box around a luminous opening (3,) [m], along C0, C90 and the nadir."""
    half = np.zeros(3)
    for face in luminaire.opening:
        middle, u, v = (np.abs(x @ luminaire.axes.T) for x in (face.middle, face.u, face.v))
        half = np.maximum(half, middle + (u + v) / (1 if face.elliptic else 2))
    return half


def _distance(luminaire: Luminaire, points: np.ndarray) -> np.ndarray:
    """Distance [m] of points (k, 3) from the box around a luminous opening (k,)."""
    offset = np.abs((points - luminaire.center) @ luminaire.axes.T) - _half(luminaire)
    return np.linalg.norm(np.clip(offset, 0, None), axis=1)
