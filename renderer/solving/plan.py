"""What a scene requires, decided before anything is computed: mesh, rays, and what is left out."""

from dataclasses import dataclass, replace

import numpy as np
import trimesh

from renderer.errors import InputError
from renderer.scene.flat import Parts
from renderer.scene.mounting import MAX_MOUNTING_GAP
from renderer.scene.scene import Scene
from renderer.transport.factors.method import FormFactorMethod, expected_method

PATCHES_AT_1_PERCENT = 1280
"""Patches of an empty room for 1 %; the error falls as 1/patches (docs/verification.md)."""
MAX_PATCHES_DENSE = 12_000
MAX_PATCHES = 1_200_000
"""Above the first, a dense operator outgrows 1.2 GB, so rays are cast even in an empty room;
above the second, the sparse one outgrows 8 GB."""
MAX_PATCHES_UNASKED = 150_000
"""Patches that a mesh is refined to, unasked."""
RAYS_AT_1_PERCENT, RAYS_GROW = 400, 0.7
"""Rays a patch, with that many patches; of a finer mesh fewer do, since its readings add up more. And the
power of one over the accuracy that they grow as: bars by sampling then fall with it
(docs/decisions.md, D47)."""
FEWEST_RAYS, MOST_RAYS = 256, 8192
PROMISE, PROMISE_WITH_RAYS = 0.001, 0.002
"""What memory allows at a point 1 cm from a corner at ρ = 0.9, and under a table: the hardest places
tried (docs/tradeoff.md); most readings are several times better."""
FINEST_GATHER = 0.0015
"""Accuracy from which meters are read by paths; finer ones by all elements that they see, one by one."""
FEW_METERS = 8
"""Meters of a room with nothing in the way that are read by elements whatever the accuracy."""
RAYS_FOR_PATHS = 256
"""Rays a patch, at most, where light counts only after a reflection."""
GATHERED_TIMES, LOOSEST_MESH = 15.0, 0.2
"""A mesh that counts only after a reflection may be so many times less accurate; at most."""
BY_PATHS = "meters are read by paths: a coarse mesh, since solved light counts only once it is reflected"
MIN_PATCH_SIZE_CHANGE = 1.2
"""Patches shorter by less are not worth another solve."""
MAX_RAYS = 80_000_000
"""Of all patches: what they meet, and the operator made of it, take some 5 GB."""
RAYS_OF_LARGE = 40_000_000
"""Of a whole room, where FEWEST_RAYS or an eighth of that a patch are more: of a million patches each needs
few, since its readings add up many."""
SHARE_OF_BAR = 0.7
"""Share of the error asked that mesh and sampling may each have: in quadrature they make 1."""


@dataclass(frozen=True)
class Plan:
    """How a scene is solved.

    patch_size : edge of a patch [m]
    rays : rays per patch; 0 where nothing can stand between two patches
    reasons : what is modelled and what is left out, in sentences
    pair_rays_allowed : whether rays may go between doubtful pairs alone, where those need no more
    accuracy : of readings [1], what it was made for
    gathered : whether the mesh serves readings by paths alone, to which it matters only after a reflection
    """

    patch_size: float
    rays: int
    reasons: tuple[str, ...]
    pair_rays_allowed: bool = True
    accuracy: float = 0.01
    gathered: bool = False

    def by_paths(self, meters: int) -> bool:
        """Whether so many meters are read by paths."""
        return self.accuracy >= FINEST_GATHER and (self.rays > 0 or meters > FEW_METERS)

    def method(self, patches: int, doubtful_share: float | None) -> FormFactorMethod:
        """The form-factor method of a mesh of that many patches. doubtful_share : as in `expected_method`"""
        return expected_method(patches, self.rays, doubtful_share if self.pair_rays_allowed else None)

    def times(self, factor: float) -> "Plan":
        """The same with patches so many times as long: how far the answer moves tells the mesh error.

        Rays are enough to be drawn in replicas.
        """
        rays = self.rays and max(self.rays, FEWEST_RAYS)
        return replace(self, patch_size=factor * self.patch_size, rays=rays)

    def finer(self, patches: int, mesh: float, sampling: float) -> "Plan | None":
        """A plan for errors that many times smaller (above 1), within what memory holds; None if none is.

        patches : how many the plan made; mesh, sampling : error over what was asked
        """
        limit = MAX_PATCHES_UNASKED if self.rays else MAX_PATCHES_DENSE
        shorter = min(2.0, np.sqrt(limit / patches)) if mesh > SHARE_OF_BAR else 1.0
        shorter = shorter if shorter > MIN_PATCH_SIZE_CHANGE else 1.0
        rays, most = self.rays, MAX_RAYS / (patches * shorter**2)
        while sampling > SHARE_OF_BAR and 4 * rays <= most:
            rays, sampling = 4 * rays, sampling / 2
        if shorter == 1 and rays == self.rays:
            return None
        while rays > most:
            rays //= 2
        return replace(self, patch_size=self.patch_size / float(shorter), rays=rays)

    @property
    def promise(self) -> float:
        """Smallest accuracy that readings may be asked for, before anything is computed [1]."""
        return PROMISE_WITH_RAYS if self.rays else PROMISE


def make_reading_plan(scene: Scene, accuracy: float, patch_size: float | None, meters: int) -> Plan:
    """The cheapest way to read so many meters to the accuracy asked, and nothing else. Raises InputError."""
    loose = make_plan(scene, max(accuracy, min(GATHERED_TIMES * accuracy, LOOSEST_MESH)), patch_size)
    loose = replace(loose, accuracy=accuracy)
    if not loose.by_paths(meters) or not any(lum.lumens for lum in scene.luminaires):
        return make_plan(scene, accuracy, patch_size)
    rays = loose.rays and min(loose.rays, RAYS_FOR_PATHS)
    return replace(loose, rays=rays, pair_rays_allowed=False, gathered=True,
                   reasons=(*loose.reasons, BY_PATHS))


def make_plan(scene: Scene, accuracy: float, patch_size: float | None) -> Plan:
    """The cheapest way to the accuracy asked, or with the patch size asked. Raises InputError."""
    area = sum(body.mesh.area for body in scene.bodies)
    if not any(body.of_room for body in scene.bodies):  # else the room itself is black and far away
        area += scene.room.area
    wanted = PATCHES_AT_1_PERCENT * 0.01 / accuracy
    h = min(patch_size or float(np.sqrt(area / np.clip(wanted, 96, 10_000))), scene.room.scale)
    count = sum(_patches(parts, h) for parts in scene.room.surfaces.values())
    count += sum(_patches(body.parts, h) for body in scene.bodies)
    if count > MAX_PATCHES:
        fits = float(np.sqrt(area / MAX_PATCHES))
        raise InputError(f"{scene.path}: solver.patch_size is {h:g}; that makes about {count:.3g} "
                         f"patches, and at most {MAX_PATCHES} are allowed. Use {fits:.2g} or more.")
    free = [luminaire.name for _, luminaire in scene.placement.free]
    in_the_way = list(dict.fromkeys(body.name for body in scene.bodies)) + free
    if not scene.room.convex:
        in_the_way.insert(0, "corners of the room")
    reasons = []
    if not in_the_way and count <= MAX_PATCHES_DENSE:
        reasons.append("nothing can stand between two patches: exact factors, no ray is cast")
        rays = 0
    else:
        reasons.append(f"in the way: {', '.join(in_the_way)}: visibility by rays" if in_the_way
                       else "too many patches for a dense operator: rays")
        rays = _rays(count, accuracy)
    reasons += taking_no_part(scene)
    if len(free) < len(scene.faces):
        reasons.append("luminaires mounted on a surface cover it; the light in a gap below "
                       f"{MAX_MOUNTING_GAP:.1%} of their size is left out")
    return Plan(h, rays, tuple(reasons), accuracy=accuracy)


def taking_no_part(scene: Scene) -> list[str]:
    """What objects are partly inside another or outside the room, in a sentence; none where none is."""
    of_bodies = zip(scene.bodies, scene.exposed[len(scene.room.surfaces):], strict=True)
    sunk = [body.name for body, own in of_bodies if own.parts is not body.parts and not body.of_room]
    return [f"what of {', '.join(dict.fromkeys(sunk))} is inside another object, outside the room or there "
            "twice takes no part"] if sunk else []


def _rays(patches: float, accuracy: float) -> int:
    """Rays a patch, a power of 2."""
    fewest = 2 ** np.floor(np.log2(np.clip(RAYS_OF_LARGE / patches, FEWEST_RAYS / 8, FEWEST_RAYS)))
    loose = 0.01 / accuracy
    wanted = RAYS_AT_1_PERCENT * loose**RAYS_GROW * min(1.0, PATCHES_AT_1_PERCENT * loose / patches)
    rays = 2 ** np.ceil(np.log2(np.clip(wanted, fewest, MOST_RAYS)) - 0.1)
    return int(min(rays, 2 ** np.floor(np.log2(MAX_RAYS / patches))))


def _patches(parts: Parts, h: float) -> float:
    """About how many patches of size h [m] a surface is divided into."""
    count = sum(np.ceil(np.linalg.norm(r.u) / h) * np.ceil(np.linalg.norm(r.v) / h) for r in parts.rectangles)
    count += sum(np.ceil(p.shape.area / h**2) for p in parts.polygons)
    return float(count + np.maximum(1, trimesh.triangles.area(parts.triangles) / h**2).sum())
