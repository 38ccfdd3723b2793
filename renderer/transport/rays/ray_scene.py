"""Rays through a scene. Only this module uses Embree, which computes in single precision.

Before rays are cast the scene is centred and scaled to unit size in double precision. Tolerances are
therefore relative: results do not depend on the size of the room (1 mm or 10 km) or its distance from the
origin.
"""

from dataclasses import dataclass
from threading import Lock

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from renderer.scene.scene import STAND_OFF
from renderer.system.threads import CHUNK, in_threads
from renderer.transport.mesh.mesh import Mesh

NOTHING, COVERED = -1, -2
"""Results of a ray that meets no patch: it leaves the scene (NOTHING), or it meets the back of a surface
because it started inside a solid or outside the room (COVERED)."""


@dataclass
class RayScene:
    """Rays through the patches of one mesh.

    rays : number of rays cast
    exposed : (n_patches,) whether rays may meet a patch. Covered patches, such as a crate's underside and the
      floor under it, are left out: of two surfaces in one place a ray may meet either.
    """

    mesh: Mesh
    rays: int = 0

    def __post_init__(self):
        self._counting = Lock()
        mesh = self.mesh
        self._between = _embree(self._cast(mesh.blockers))
        lengths = (each / mesh.scale for each in (mesh.corners[:, 0] - mesh.middle, mesh.u, mesh.v))
        self._spans = np.array([each.T for each in (*lengths, mesh.normal)], dtype=np.float32)
        self.exposed = ~self.mesh.covered
        self._build()

    def _build(self) -> None:
        mesh = self.mesh
        paired = mesh.twin >= 0
        either = self.exposed | (paired & self.exposed[mesh.twin])
        front = np.flatnonzero(either & (~paired | (np.arange(len(paired)) < mesh.twin)))
        corners = self._cast(mesh.vertices)[mesh.patches[front]]
        quads = np.flatnonzero(~mesh.triangular[front])
        triangles = np.concatenate([corners[:, :3], corners[quads][:, [0, 2, 3]]])
        patch = np.concatenate([front, front[quads]])
        twin = mesh.twin[patch]
        self._normal = mesh.normal[patch].astype(np.float32)
        backs = np.where((twin >= 0) & self.exposed[twin], twin, COVERED)
        self._of_face = np.concatenate([np.where(self.exposed[patch], patch, COVERED), backs])
        self._patches = _embree(triangles)

    def _cast(self, points: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray((points - self.mesh.middle) / self.mesh.scale, dtype=np.float32)

    def _count(self, n: int) -> None:
        with self._counting:
            self.rays += n

    def first_hit(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """The patch that each ray meets first (k,), or NOTHING, or COVERED.

        origins : (k, 3) [m], already off their surface; directions : (k, 3), of any length
        """
        n = len(origins)
        patch = np.full(n, NOTHING, dtype=np.int64)
        if self._patches is None:
            return patch

        def work(start: int, stop: int) -> None:
            d = np.ascontiguousarray(directions[start:stop], dtype=np.float32)
            hit = self._patches[0].run(self._cast(origins[start:stop]), d, query="INTERSECT")
            behind = np.einsum("ij,ij->i", d, self._normal.take(hit, axis=0, mode="clip")) > 0
            found = self._of_face.take(hit + len(self._normal) * behind, mode="clip")
            patch[start:stop] = np.where(hit >= 0, found, NOTHING)

        in_threads(work, n)
        self._count(n)
        return patch

    def clear(self, origins: np.ndarray, targets: np.ndarray) -> np.ndarray:
        """Whether nothing stands between points off their surface (k, …, 3) [m] and their targets (k, …)."""
        free = np.empty(np.broadcast_shapes(origins.shape, targets.shape)[:-1], dtype=bool)

        def work(start: int, stop: int) -> None:
            a, b = self._cast(origins[start:stop]), self._cast(targets[start:stop])
            reach = b - a
            free[start:stop] = self._free(a, reach, np.einsum("...i,...i->...", reach, reach))

        in_threads(work, len(free), max(1, CHUNK * len(free) // max(1, free.size)))
        return free

    def _free(self, origins: np.ndarray, reach: np.ndarray, distance2: np.ndarray) -> np.ndarray:
        """Whether nothing stands between origins (…, 3) and points at `reach` (…, 3) from them, in units of
        the scaled scene. `reach` is overwritten.

        distance2 : (…) squared length of `reach`
        """
        self._count(distance2.size)
        if self._between is None:
            return np.ones(distance2.shape, dtype=bool)
        reach *= np.maximum(1 - 2 * STAND_OFF / np.sqrt(np.maximum(distance2, 1e-30)), 0)[..., None]
        origins = np.ascontiguousarray(np.broadcast_to(origins, reach.shape)).reshape(-1, 3)
        ahead = np.ones(distance2.size, dtype=np.float32)
        met = self._between[0].run(origins, reach.reshape(-1, 3), ahead, query="OCCLUDED")
        return (met != 0).reshape(distance2.shape)

    def between(self, first: np.ndarray, second: np.ndarray, square: np.ndarray) -> tuple[np.ndarray, ...]:
        """Exchange along rays between points all over pairs of patches, in proportion to `exchanged`: without
        obstruction, and with it; both (k, rays).

        first, second : (k,) patches
        square : (4, k, rays) points of the unit hypercube; single precision, as all arrays here
        """
        s, t, p, q = square
        for patch, one, other in ((first, s, t), (second, p, q)):
            _fold(self.mesh.triangular[patch], one, other)
        origins, reach = np.empty((*s.shape, 3), s.dtype), np.empty((*s.shape, 3), s.dtype)
        distance2, ahead, back = np.full_like(s, 1e-18), np.zeros_like(s), np.zeros_like(s)
        ours, theirs = (self._spans.take(patch, axis=2)[..., None] for patch in (first, second))
        for k in range(3):
            (corner, u, v, normal), (other, along, across, facing) = ours[:, k], theirs[:, k]
            at = s * u
            at += t * v
            at += corner + STAND_OFF * normal
            origins[..., k] = at
            to = p * along
            to += q * across
            to += other
            to -= at
            reach[..., k] = to
            ahead += to * normal
            back -= to * facing
            to *= to
            distance2 += to
        worth = np.maximum(ahead, 0, out=ahead) * np.maximum(back, 0, out=back)
        worth /= distance2 * distance2
        return worth, worth * self._free(origins, reach, distance2)

    def off(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Points (k, 3) [m] moved off their surface, from which rays may start."""
        return points + STAND_OFF * self.mesh.scale * normals


def _fold(triangular: np.ndarray, s: np.ndarray, t: np.ndarray) -> None:
    """Reflect points of the unit square (k, rays) past the diagonal of triangles, in place."""
    rows = np.flatnonzero(triangular)
    if len(rows):
        one, other = s[rows], t[rows]
        past = one + other > 1
        s[rows], t[rows] = np.where(past, 1 - one, one), np.where(past, 1 - other, other)


def _embree(triangles: np.ndarray) -> tuple[EmbreeScene, TriangleMesh] | None:
    """Embree's scene of triangles (k, 3, 3), and the object that holds them; None where there are none."""
    if not len(triangles):
        return None
    scene, faces = EmbreeScene(), np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3)
    return scene, TriangleMesh(scene, triangles.reshape(-1, 3), faces)
