"""The plan of a solve, made before anything is computed: patch size, rays, and what is left out."""

from dataclasses import dataclass, replace

import numpy as np

from renderer.errors import InputError
from renderer.scene.flat import Parts
from renderer.scene.geometry import triangle_areas
from renderer.scene.mounting import MAX_MOUNTING_GAP
from renderer.scene.scene import Scene
from renderer.transport.factors.method import FormFactorMethod, expected_method

PATCHES_AT_1_PERCENT = 1280
"""Number of patches of an empty room for an accuracy of 1 %; the error falls as 1/patches
(docs/verification.md)."""
MAX_PATCHES_DENSE = 12_000
"""Largest number of patches for a dense operator (1.2 GB); above it rays are cast even in an empty room."""
MIN_RAYS_PER_PATCH = 256
"""Smallest number of rays from a patch; an eighth of it in the largest rooms, whose readings add up many
patches."""
MIN_PROMISED_ACCURACY = 0.001
"""Accuracy that memory allows at the most difficult place tested, 1 cm from a corner at ρ = 0.9; with rays,
under a table, twice that (docs/tradeoff.md). Most readings are several times more accurate."""
MIN_ACCURACY_BY_PATHS = 0.0015
"""Smallest accuracy for which meters are read by paths; below it they are read by all elements that they
see."""
MIN_ACCURACY_OF_SURFACES_BY_PATHS = 0.01
"""Smallest accuracy for which mean luminances of surfaces are read by paths; below it the solved patches take
less time (docs/decisions.md, D182)."""
MAX_RAYS = 80_000_000
"""Largest number of rays of all patches: their results and the operator take about 5 GB."""


@dataclass(frozen=True)
class Plan:
    """How a scene is solved.

    patch_size : edge of a patch [m]
    rays : number from each patch; 0 where nothing can stand between two patches
    reasons : sentences on what is modelled and what is left out
    pair_rays_allowed : whether rays may be cast between doubtful pairs only, where these are fewer
    accuracy : of readings, for which the plan was made [1]
    gathered : whether the mesh is only for readings by paths, in which solved light counts only after a
      further reflection
    """

    patch_size: float
    rays: int
    reasons: tuple[str, ...]
    pair_rays_allowed: bool = True
    accuracy: float = 0.01
    gathered: bool = False

    def by_paths(self, meters: int) -> bool:
        """Whether that many meters are read by paths. Up to 8 in a room without obstacles are read by
        elements."""
        return self.accuracy >= MIN_ACCURACY_BY_PATHS and (self.rays > 0 or meters > 8)

    def method(self, patches: int, doubtful_share: float | None) -> FormFactorMethod:
        """The form-factor method of a mesh of that many patches. doubtful_share : as in `expected_method`"""
        return expected_method(patches, self.rays, doubtful_share if self.pair_rays_allowed else None)

    def times(self, factor: float) -> "Plan":
        """The plan with patches longer by `factor`, and enough rays for replicas. The change of a reading on
        that mesh gives the mesh error."""
        rays = self.rays and max(self.rays, MIN_RAYS_PER_PATCH)
        return replace(self, patch_size=factor * self.patch_size, rays=rays)

    def finer(self, patches: int, mesh: float, sampling: float) -> "Plan | None":
        """A plan with smaller errors, if memory allows one; else None.

        patches : number in the present mesh; mesh, sampling : its errors over the requested accuracy
        """
        limit = 150_000 if self.rays else MAX_PATCHES_DENSE
        share = 0.7  # of the requested error, for mesh and for sampling: in quadrature they make 1
        shorter = min(2.0, np.sqrt(limit / patches)) if mesh > share else 1.0
        shorter = shorter if shorter > 1.2 else 1.0  # a smaller gain does not justify another solve
        rays, most = self.rays, MAX_RAYS / (patches * shorter**2)
        while sampling > share and 4 * rays <= most:
            rays, sampling = 4 * rays, sampling / 2
        if shorter == 1 and rays == self.rays:
            return None
        while rays > most:
            rays //= 2
        return replace(self, patch_size=self.patch_size / float(shorter), rays=rays)

    @property
    def promise(self) -> float:
        """Smallest accuracy that readings can be promised, before anything is computed [1]."""
        return 2 * MIN_PROMISED_ACCURACY if self.rays else MIN_PROMISED_ACCURACY


def make_reading_plan(scene: Scene, accuracy: float, patch_size: float | None, meters: int) -> Plan:
    """The cheapest plan for reading that many meters to the requested accuracy [1], without pictures. Raises
    InputError."""
    # A mesh whose light counts only after a further reflection may be 15 times less accurate, up to 20 %.
    loose = make_plan(scene, max(accuracy, min(15 * accuracy, 0.2)), patch_size)
    loose = replace(loose, accuracy=accuracy)
    if not loose.by_paths(meters) or not any(lum.lumens for lum in scene.luminaires):
        return make_plan(scene, accuracy, patch_size)
    # Twice the rays for high accuracies: with fewer, paths would need more steps, which cost more.
    rays = loose.rays and min(loose.rays, 128 if accuracy >= 0.005 else 256)
    by_paths = "meters are read by paths, for which a coarse mesh is enough"
    return replace(loose, rays=rays, pair_rays_allowed=False, gathered=True,
                   reasons=(*loose.reasons, by_paths))


def make_plan(scene: Scene, accuracy: float, patch_size: float | None) -> Plan:
    """The cheapest plan for the requested accuracy [1], or with the requested patch size [m]. Raises
    InputError."""
    area = sum(body.mesh.area for body in scene.bodies)
    if not any(body.of_room for body in scene.bodies):  # otherwise a black box is far away
        area += scene.room.area
    wanted = PATCHES_AT_1_PERCENT * 0.01 / accuracy
    h = min(patch_size or float(np.sqrt(area / np.clip(wanted, 96, 10_000))), scene.room.scale)
    count = sum(_patches(parts, h) for parts in scene.room.surfaces.values())
    count += sum(_patches(body.parts, h) for body in scene.bodies)
    most = 1_200_000  # their sparse operator takes 8 GB
    if count > most:
        fits = float(np.sqrt(area / most))
        raise InputError(f"{scene.path}: solver.patch_size is {h:g}; that makes about {count:.3g} "
                         f"patches, and at most {most} are allowed. Use {fits:.2g} or more.")
    free = [luminaire.name for _, luminaire in scene.placement.free]
    in_the_way = list(dict.fromkeys(body.name for body in scene.bodies)) + free
    if not scene.room.convex:
        in_the_way.insert(0, "corners of the room")
    reasons = []
    if not in_the_way and count <= MAX_PATCHES_DENSE:
        reasons.append("nothing can stand between two patches: exact factors, no ray is cast")
        rays = 0
    else:
        reasons.append(f"obstacles: {', '.join(in_the_way)}: visibility by rays" if in_the_way
                       else "too many patches for a dense operator: rays")
        rays = _rays(count, accuracy)
    reasons += taking_no_part(scene)
    if len(free) < len(scene.faces):
        reasons.append("luminaires mounted on a surface cover it; light in a gap below "
                       f"{MAX_MOUNTING_GAP:.1%} of their size is left out")
    return Plan(h, rays, tuple(reasons), accuracy=accuracy)


def taking_no_part(scene: Scene) -> list[str]:
    """A sentence on objects with parts that have no effect; [] where there are none."""
    of_bodies = zip(scene.bodies, scene.exposed[len(scene.room.surfaces):], strict=True)
    sunk = [body.name for body, own in of_bodies if own.cut and not body.of_room]
    return [f"parts of {', '.join(dict.fromkeys(sunk))} inside another object, outside the room or in the "
            "place of another surface have no effect"] if sunk else []


def _rays(patches: float, accuracy: float) -> int:
    """Number of rays from each patch, a power of 2: fewer for finer meshes, whose readings add up more
    patches."""
    fewest = 2 ** np.floor(np.log2(np.clip(40e6 / patches, MIN_RAYS_PER_PATCH / 8, MIN_RAYS_PER_PATCH)))
    loose = 0.01 / accuracy
    # 400 rays at 1 %. With this power, sampling errors are proportional to the accuracy (docs/decisions.md,
    # D47).
    wanted = 400 * loose**0.7 * min(1.0, PATCHES_AT_1_PERCENT * loose / patches)
    rays = 2 ** np.ceil(np.log2(np.clip(wanted, fewest, 8192)) - 0.1)
    return int(min(rays, 2 ** np.floor(np.log2(MAX_RAYS / patches))))


def _patches(parts: Parts, h: float) -> float:
    """Approximate number of patches of size h [m] into which a surface is divided."""
    count = sum(np.ceil(np.linalg.norm(r.u) / h) * np.ceil(np.linalg.norm(r.v) / h) for r in parts.rectangles)
    count += sum(np.ceil(p.shape.area / h**2) for p in parts.polygons)
    return float(count + np.maximum(1, triangle_areas(parts.triangles) / h**2).sum())
