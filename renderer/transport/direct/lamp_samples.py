"""Direct light by random draws: for each of many points one place on one luminaire (next-event
estimation)."""

from dataclasses import dataclass

import numpy as np

from renderer.radiometry.polygons import polygon_factors
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.system.threads import in_threads
from renderer.transport.factors.exchange import Exchange
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.rays.ray_scene import RayScene
from renderer.transport.rays.sampling import Nets


@dataclass(frozen=True)
class LampFaces:
    """Flat pieces that emit light, of all luminaires one after the other.

    lamp : (n_faces,) index of the luminaire
    start, u, v, normal, middle : (3, n_faces) [m]
    elliptic : (n_faces,) whether u and v are half axes of an ellipse
    area : (n_faces,) [m²]; share : (n_faces,) of its luminaire's draws
    corners : (n_faces, 4, 3) [m]
    near : (n_faces,) distance [m] below which a Lambertian rectangle is computed in closed form; 0 for others
    """

    luminaires: list[Luminaire]
    lamp: np.ndarray
    start: np.ndarray
    u: np.ndarray
    v: np.ndarray
    normal: np.ndarray
    middle: np.ndarray
    elliptic: np.ndarray
    area: np.ndarray
    share: np.ndarray
    corners: np.ndarray
    near: np.ndarray

    def __len__(self) -> int:
        return len(self.lamp)

    def places(self, face: np.ndarray, s: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Points (3, k) [m] on faces (k,) from the unit square; equal areas of the square are equal areas of
        the face."""
        round_ = self.elliptic[face]
        if round_.any():
            r, turn = np.sqrt(s), 2 * np.pi * t
            s = np.where(round_, r * np.cos(turn), s)
            t = np.where(round_, r * np.sin(turn), t)
        found = self.u.take(face, axis=1) * s
        found += self.v.take(face, axis=1) * t
        found += self.start.take(face, axis=1)
        return found

    def brought(self, face: np.ndarray, reach: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Illuminance per lumen (k,) [m⁻²] at points without obstruction, each face represented by one place
        on it.

        face : (k,) index; reach : (3, k) [m] from the points to the places
        normals : (3, k) unit, of the points
        """
        distance2 = np.maximum(_dot(reach, reach), 1e-200)
        distance = np.sqrt(distance2)
        light = np.maximum(_dot(reach, normals), 0.0)
        light /= distance * distance2
        lamp = self.lamp[face]
        for kind, members in self._kinds():
            chosen = slice(None) if members.all() else np.flatnonzero(members[lamp])
            some = face[chosen]
            if len(some):
                light[chosen] *= self._sent(kind, some, -reach[:, chosen] / distance[chosen])
        return light

    def _kinds(self):
        """For each distribution of light: one luminaire that has it, and a mask of all that do
        (n_luminaires,)."""
        groups = {}
        for k, lum in enumerate(self.luminaires):
            solid = len(lum.opening) > 2
            key = "cosine" if lum.lambertian else (k if solid or lum.distribution is None else id(
                lum.distribution))
            groups.setdefault(key, []).append(k)
        for members in groups.values():
            yield self.luminaires[members[0]], np.isin(np.arange(len(self.luminaires)), members)

    def _sent(self, kind: Luminaire, face: np.ndarray, away: np.ndarray) -> np.ndarray:
        """Intensity per lumen (k,) [sr⁻¹] of a whole face along unit directions (3, k)."""
        if kind.lambertian:
            return np.maximum(_dot(away, self.normal.take(face, axis=1)), 0.0) / np.pi
        if kind.distribution is None:
            light = kind.intensity(away.T)
        else:
            local = np.einsum("kij,jk->ik", self._axes[self.lamp[face]], away)
            light = kind.distribution.toward(*local) / kind.distribution.flux
        if len(kind.opening) > 2:
            seen = kind.projected_area(away.T)
            share = np.maximum(_dot(away, self.normal[:, face]), 0.0) * self.area[face]
            light = np.divide(light * share, seen, out=np.zeros_like(light), where=seen > 0)
        return light

    @property
    def _axes(self) -> np.ndarray:
        return np.array([lum.axes for lum in self.luminaires])


def lamp_faces(luminaires: list[Luminaire]) -> LampFaces:
    """The faces of all luminaires."""
    rows = [(k, *face) for k, lum in enumerate(luminaires) for face in _faces_of(lum)]
    lamp, start, u, v, normal, elliptic, area, share, near = (np.array(x) for x in zip(*rows, strict=True))
    corners = np.stack([start, start + u, start + u + v, start + v], axis=1)
    vectors = (np.ascontiguousarray(of.T) for of in (start, u, v, normal, start + (u + v) / 2))
    return LampFaces(luminaires, lamp, *vectors, elliptic, area, share, corners, near)


def _faces_of(lum: Luminaire) -> list[tuple]:
    """start, u, v, normal, elliptic, area, share and near of each face of a luminaire, as in `LampFaces`."""
    if len(lum.opening) > 2:
        total = sum(face.area for face in lum.opening)
        faces = []
        for face in lum.opening:
            middle = lum.center + face.middle
            start = middle if face.elliptic else middle - (face.u + face.v) / 2
            share = face.area / total
            faces.append((start, face.u, face.v, face.normal, face.elliptic, face.area, share, 0.0))
        return faces
    if lum.is_point:
        return [(lum.center, np.zeros(3), np.zeros(3), lum.normal, False, 0.0, 1.0, 0.0)]
    if lum.rectangle is not None:
        start, u, v = lum.rectangle.corner, lum.rectangle.u, lum.rectangle.v
        # For nearer points the light is a closed form, and rays give only its shadow: the light from one
        # place on a near face has no upper bound.
        near = 2.0 * max(np.linalg.norm(u), np.linalg.norm(v)) if lum.lambertian else 0.0
        return [(start, u, v, lum.normal, False, lum.area, 1.0, near)]
    # The ellipse with the outline's area; the outline's corners lie a little outside it.
    u, v = (lum.outline[n] - lum.center for n in (0, len(lum.outline) // 4))
    swell = np.sqrt(lum.area / (np.pi * np.linalg.norm(np.cross(u, v))))
    return [(lum.center, swell * u, swell * v, lum.normal, True, lum.area, 1.0, 0.0)]


def draw_table(faces: LampFaces, lit: np.ndarray) -> np.ndarray:
    """Cumulated probabilities (n_patches, n_faces) of drawing each face from a point of each patch.

    lit : (n_patches, n_luminaires) approximate light of each luminaire on a patch, in any unit. A mean of few
      draws may be below 0, where most of a near face is hidden
    """
    lumens = np.array([lum.lumens for lum in faces.luminaires])
    weight = np.maximum(lit, 0) * lumens
    total = weight.sum(axis=1, keepdims=True)
    chance = weight / np.where(total > 0, total, 1.0)
    alike = lumens / max(lumens.sum(), 1e-300)
    # Share of draws made by lumens alone, so that light that `lit` missed has a weight of at most 1 over
    # this.
    by_lumens = 0.1
    chance = np.where(total > 0, (1 - by_lumens) * chance + by_lumens * alike, alike)
    cumulated = np.cumsum(chance[:, faces.lamp] * faces.share, axis=1)
    return cumulated / np.maximum(cumulated[:, -1:], 1e-300)


def draw(table: np.ndarray, row: np.ndarray, choice: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The face (k,) drawn from rows (k,) of a table, and its probability (k,).

    table : from `draw_table`; choice : (k,) from 0 to 1
    """
    n = table.shape[1]
    table, first, face = table.ravel(), row * n, np.zeros(len(row), dtype=int)
    for k in reversed(range(n.bit_length())):  # bisection in all rows at once: the last number of a row is 1
        ahead = np.minimum(face + (1 << k), n)
        face = np.where(table.take(first + ahead - 1) <= choice, ahead, face)
    before = np.where(face > 0, table.take(first + np.maximum(face - 1, 0)), 0.0)
    return face, np.maximum(table.take(first + face) - before, 1e-300)


def next_event(faces: LampFaces, table: np.ndarray, row: np.ndarray, places: np.ndarray, normals: np.ndarray,
               numbers: np.ndarray, ray_scene: RayScene | None) -> tuple[np.ndarray, np.ndarray]:
    """A luminaire (k,) drawn for each place, and its illuminance per lumen with shadows, over its probability
    (k,) [m⁻²]. The mean over draws is the illuminance by all luminaires.

    table, row : as in `draw`
    places : (k, 3) [m], off their surface; normals : (k, 3) unit
    numbers : (k, 3) from 0 to 1, which choose a face and a place on it
    ray_scene : None where nothing can stand between
    """
    face, chance = draw(table, row, numbers[:, 0])
    points, normals = np.ascontiguousarray(places.T), np.ascontiguousarray(normals.T)
    targets = faces.places(face, numbers[:, 1], numbers[:, 2])
    reach = targets - points
    light = faces.brought(face, reach, normals)
    past, lit = light.copy(), np.flatnonzero(light > 0)
    if ray_scene is not None:
        past[lit] *= ray_scene.clear(places[lit], targets[:, lit].T)
    # Distances are from the face's middle, not from the place drawn: otherwise only near places, which are
    # brighter, would be replaced by the mean, and the result would be too low.
    apart = faces.middle.take(face, axis=1) - points
    near = np.flatnonzero(_dot(apart, apart) < faces.near[face] ** 2)
    if len(near):  # the closed form, minus the light of the place drawn where that is hidden
        whole = polygon_factors(places[near], normals[:, near].T, faces.corners[face[near]])
        past[near] += whole / faces.area[face[near]] - light[near]
    return faces.lamp[face], past / chance


def about_lit(faces: LampFaces, mesh: Mesh, seed: tuple[int, ...]) -> np.ndarray:
    """Approximate unobstructed illuminance per lumen by each luminaire on each patch (n_patches,
    n_luminaires) [m⁻²]: the mean of a few points on each patch, fewer where there are many luminaires."""
    points = 4 if len(faces) <= 64 else 2
    n, every = len(mesh.patches), np.arange(len(faces))
    lit = np.zeros((n, len(faces.luminaires)))

    def work(start: int, stop: int) -> None:
        square = Nets(points, 4, seed).draw(start, stop)
        places = mesh.spread(np.arange(start, stop), square[..., :2]).reshape(-1, 3)
        normals = np.repeat(mesh.normal[start:stop], points, axis=0)
        point, face = (x.ravel() for x in np.meshgrid(np.arange(len(places)), every, indexing="ij"))
        s, t = (square[..., k].ravel()[point] for k in (2, 3))
        reach = faces.places(face, s, t) - places.T[:, point]
        light = faces.brought(face, reach, normals.T[:, point])
        cell = point // points * lit.shape[1] + faces.lamp[face]
        lit[start:stop] = np.bincount(cell, light, (stop - start) * lit.shape[1]).reshape(stop - start, -1)

    in_threads(work, n, max(1, (1 << 15) // (points * len(faces))))
    return lit / points


def draws_of_patch(patches: int) -> int:
    """Number of luminaires drawn from each patch in each replica, 16 or 32: fewer for many patches,
    whose errors average out."""
    return 32 if patches <= 1024 else 16


def sampled_direct(mesh: Mesh, exchange: Exchange, luminaires: list[Luminaire], ray_scene: RayScene | None,
                   seed: tuple[int, ...], replicas: int) -> tuple[np.ndarray, np.ndarray]:
    """The results of `direct_on_patches` by draws, whose number for a patch does not grow with the number of
    luminaires."""
    n, count = mesh.count, len(luminaires)
    if not count:
        return np.zeros((replicas, n, 0)), np.zeros(0)
    faces = lamp_faces(luminaires)
    table = draw_table(faces, about_lit(faces, mesh, (*seed, 0)))
    draws = draws_of_patch(n)
    nets = Nets(draws, 5, (*seed, 1), replicas)
    mean = np.zeros((replicas, n, count))

    def work(start: int, stop: int) -> None:
        patch = start + np.flatnonzero(exchange.areas[start:stop] > 0)
        square = nets.draw(start, stop)[patch - start]
        row = np.repeat(patch, square.shape[1])
        if mesh.gathering is not None:
            row, square = mesh.gathering.pick(patch, square)
            places = mesh.spread(row.ravel(), square[..., :2].reshape(-1, 1, 2)).reshape(-1, 3)
            row = row.ravel()
        else:
            places = mesh.spread(patch, square[..., :2]).reshape(-1, 3)
        normals = mesh.normal[row]
        places = places if ray_scene is None else ray_scene.off(places, normals)
        lamp, light = next_event(faces, table, row, places, normals,
                                 square[..., 2:].reshape(-1, 3), ray_scene)
        replica = np.tile(np.repeat(np.arange(replicas), draws), len(patch))
        cell = (replica * (stop - start) + np.repeat(patch - start, square.shape[1])) * count + lamp
        tallied = np.bincount(cell, light / draws, replicas * (stop - start) * count)
        mean[:, start:stop] = tallied.reshape(replicas, stop - start, count)

    in_threads(work, n, max(1, (1 << 15) // (draws * replicas)))  # what stays in the cache
    arrived = exchange.areas @ mean
    lost = 1 - arrived.mean(axis=0)
    # Light is lost only if the sum misses it by 8 standard errors: 1 in 10,000 by Student's t for 8 replicas.
    doubt = 8 * arrived.std(axis=0, ddof=1) / np.sqrt(replicas) if replicas > 1 else 0.0
    lost = np.sign(lost) * np.maximum(np.abs(lost) - doubt, 0.0)
    whole = arrived.mean(axis=0)
    return mean / np.where(whole > 0, whole, 1.0), lost


def _dot(a, b) -> np.ndarray:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
