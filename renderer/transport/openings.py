"""Light from measured luminaires, nothing standing between: every place of the luminous opening sends its
share of the measured intensity in each direction, so that from afar I/d² arrives."""

from itertools import pairwise

import numpy as np

from renderer.scene.luminaires import Face, Luminaire
from renderer.transport.patches import Mesh
from renderer.transport.threads import in_threads

NEAR, NEAREST = 0.3, 0.12
"""A part of an opening or patch is at most this share of its distance long, less where the table has
finer detail, so that two Gauss points each way integrate it."""
DEEPEST, DEEPEST_PATCH, SMALLEST = 36, 12, 0.05
"""Halvings of an opening, and of a patch, at the most; and the smallest part of a patch, in sides of the
opening."""
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
    """What one face sends (k,) [m⁻²]: the face halved until it is short for its distance."""
    flat = len(luminaire.opening) == 2
    close = closeness(luminaire)
    turns = np.arange(SECTORS + 1) / SECTORS if face.elliptic else np.array([0.0, 1.0])
    cells = np.array([[0.0, 1.0, a, b] for a, b in pairwise(turns)])
    who = np.repeat(np.arange(len(p)), len(cells))
    cells = np.tile(cells, (len(p), 1))
    light = np.zeros(len(p))
    for depth in range(DEEPEST + 1):
        if not len(who):
            break
        s0, s1, t0, t1 = cells.T
        sides = [np.linalg.norm(face.at(*a) - face.at(*b), axis=1) for a, b in (
            ((s0, (t0 + t1) / 2), (s1, (t0 + t1) / 2)), (((s0 + s1) / 2, t0), ((s0 + s1) / 2, t1)))]
        middle = luminaire.center + face.at((s0 + s1) / 2, (t0 + t1) / 2)
        far = np.linalg.norm(p[who] - middle, axis=1)
        large = (np.maximum(*sides) > close * far) & (depth < DEEPEST)
        done = ~large
        for gs in GAUSS:
            for gt in GAUSS:
                a = cells[done]
                at = luminaire.center + face.at(a[:, 0] + gs * (a[:, 1] - a[:, 0]),
                                                a[:, 2] + gt * (a[:, 3] - a[:, 2]))
                share = face.area * (a[:, 1] - a[:, 0]) * (a[:, 3] - a[:, 2]) / 4
                sent = _sent(p[who[done]], n[who[done]], at, luminaire, face, flat)
                light += np.bincount(who[done], share * sent, len(p))
        along_s = (sides[0] >= sides[1])[large]
        cells, who = halved(cells[large], along_s), np.repeat(who[large], 2)
    return light


def _sent(p, n, at, luminaire: Luminaire, face: Face, flat: bool) -> np.ndarray:
    """From places on a face to points, per area of the face (k,) [m⁻⁴]."""
    reach = p - at
    distance2 = np.maximum(np.einsum("ki,ki->k", reach, reach), 1e-30)
    away = reach / np.sqrt(distance2)[:, None]
    incidence = np.clip(-np.einsum("ki,ki->k", away, n), 0, None)
    if flat:  # the cosine cancels, and at grazing angles need not be divided
        return luminaire.intensity(away) / face.area * incidence / distance2
    leaving = np.clip(away @ face.normal, 0, None)
    return luminaire.luminance(away) * leaving * incidence / distance2


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
    flux = np.zeros(len(patch))
    lengths = np.linalg.norm(mesh.u[patch], axis=1), np.linalg.norm(mesh.v[patch], axis=1)
    for depth in range(DEEPEST_PATCH + 1):
        if not len(which):
            break
        s0, s1, t0, t1 = cells.T
        sides = lengths[0][which] * (s1 - s0), lengths[1][which] * (t1 - t0)
        middle = _on(mesh, patch[which], (s0 + s1) / 2, (t0 + t1) / 2)
        long = np.maximum(close * _distance(luminaire, middle), smallest)
        large = (np.maximum(*sides) > long) & (depth < DEEPEST_PATCH)
        done, k = cells[~large], which[~large]
        for gs in GAUSS:
            for gt in GAUSS:
                at = _on(mesh, patch[k], done[:, 0] + gs * (done[:, 1] - done[:, 0]),
                         done[:, 2] + gt * (done[:, 3] - done[:, 2]))
                share = mesh.area[patch[k]] * (done[:, 1] - done[:, 0]) * (done[:, 3] - done[:, 2]) / 4
                flux += np.bincount(k, share * light_at(at, mesh.normal[patch[k]]), len(patch))
        cells = halved(cells[large], (sides[0] >= sides[1])[large])
        which = np.repeat(which[large], 2)
    return flux


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
