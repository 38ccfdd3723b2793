"""Light straight from the luminaires, per lumen of each, at points and on patches."""

import numpy as np

from renderer.scene.luminaires.lambertian import LambertianFace, illuminance_of_faces
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.system.threads import CHUNK, in_threads
from renderer.transport.factors.exchange import Exchange
from renderer.transport.factors.shafts import SHAFT_SLACK, reaches
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.rays.ray_scene import RayScene
from renderer.transport.rays.sampling import REPLICAS, Nets

PATCH_POINTS = 4
"""Points on a patch in each replica, where its direct light has no closed form."""
SHADOW_RAYS = 64
"""Rays from a point to a luminaire with area, so that its penumbra has 64 steps."""


def unoccluded(points: np.ndarray, normals: np.ndarray, luminaires: list[Luminaire]) -> np.ndarray:
    """Illuminance per lumen of each luminaire (k, n_luminaires) [m⁻²] at points, without obstruction.

    points, normals : (k, 3) [m], unit
    """
    factors, faces = np.zeros((len(points), len(luminaires))), {}
    for index, lum in enumerate(luminaires):
        if isinstance(lum, LambertianFace):
            faces.setdefault(len(lum.outline), []).append(index)
        else:
            factors[:, index] = lum.illuminance(points, normals)
    for some in faces.values():
        factors[:, some] = illuminance_of_faces([luminaires[k] for k in some], points, normals)
    return factors


def hidden_light(direct: np.ndarray, bare: np.ndarray, luminaires: list[Luminaire]) -> np.ndarray:
    """Illuminance per lumen without shadows (…, n_luminaires) [m⁻²] of luminaires with extent that are
    partly or wholly hidden, so that their visible share is a count of rays; 0 for others.

    direct : (replicas, …, n_luminaires) with shadows; bare : (…, n_luminaires) without
    """
    counted = np.array([not luminaire.is_point for luminaire in luminaires], dtype=bool)
    return bare * (counted & (direct.mean(axis=0) < (1 - 1e-12) * bare))


def visible_share(points: np.ndarray, normals: np.ndarray, luminaire: Luminaire,
                  ray_scene: RayScene, rays: int, seed: tuple[int, ...], replicas: int,
                  shift: np.ndarray | None = None) -> np.ndarray:
    """Share of a luminaire's light that reaches each point unobstructed (replicas, k).

    points : (k, 3) [m], already off their surface; or (k, replicas, 3), one for each replica
    normals : (k, 3) unit
    rays : number from each point in each replica, to places all over the luminaire; each ray is weighted with
      the illuminance from its place
    seed : the last number is the luminaire's index
    shift : (k, 3) [m] from this luminaire to the one of each point, which is like it; by default 0
    The luminaire aims the rays (`aimed`) so that their weights are nearly equal: a few rays of unequal weight
    would be biased.
    """
    each = points if points.ndim > 2 else points[:, None]
    shift = np.zeros((len(points), 1, 3)) if shift is None else shift[:, None]
    if luminaire.is_point:
        clear = ray_scene.clear(each, np.broadcast_to(luminaire.center + shift, each.shape)).T
        return np.broadcast_to(clear.astype(float), (replicas, len(points)))
    nets = Nets(rays, 2, seed, replicas, seed[:-1])  # all luminaires share the scrambling
    share = np.empty((replicas, len(points)))

    def work(start: int, stop: int) -> None:
        square = nets.draw(start, stop)
        few = max(1, (1 << 15) // (rays * replicas))  # arrays that fit the processor's cache
        for first in range(start, stop, few):
            some = slice(first, min(first + few, stop))
            origins = each[some] if each.shape[1] == 1 else np.repeat(each[some], rays, axis=1)
            places = origins - shift[some]
            targets, stands = luminaire.aimed(places, square[some.start - start:some.stop - start])
            weight = stands * luminaire.brought(places, normals[some, None], targets)
            past = weight * ray_scene.clear(origins, targets + shift[some])
            past, total = (np.einsum("kpr->pk", w.reshape(-1, replicas, rays)) for w in (past, weight))
            share[:, some] = past / np.where(total > 0, total, 1.0)

    in_threads(work, len(points), max(1, CHUNK // (rays * replicas)))
    return share


def may_be_shadowed(points: np.ndarray, normals: np.ndarray, lamps: np.ndarray,
                    boxes: np.ndarray) -> np.ndarray:
    """Whether a box may stand between a luminaire and each group of points (k,). Groups with False need no
    shadow rays.

    points : (k, c, 3) [m], c points of each group
    normals : (k, 3) unit normals of the groups' tangent planes; a box counts in front of these
    lamps : (k, 2, 3) [m], or (2, 3) for all groups, lowest and highest corner of the luminaire
    boxes : (m, 8, 3) [m]
    Each group is enclosed in a box along the room's axes.
    """
    boxes = np.stack([boxes.min(axis=1), boxes.max(axis=1)]).transpose(0, 2, 1)
    lamps = np.broadcast_to(lamps, (len(points), 2, 3))
    shadowed = np.zeros(len(points), dtype=bool)
    together = 32  # consecutive groups that are first tested together

    def work(start: int, stop: int) -> None:
        p, n, lamp = (each[start:stop].T for each in (points, normals, lamps))
        front = (p * n[:, None]).sum(axis=0).min(axis=0)
        p = p.min(axis=1), p.max(axis=1)
        # Most groups of points have no box near them: one test clears them all.
        first = np.arange(0, stop - start, together)
        low, high = np.minimum.reduceat(p[0], first, axis=1), np.maximum.reduceat(p[1], first, axis=1)
        facing = np.minimum.reduceat(n, first, axis=1)
        alike = (facing == np.maximum.reduceat(n, first, axis=1)).all(axis=0)
        least = np.where(alike, np.minimum.reduceat(front, first), -np.inf)
        lamp = lamp[:, 0], lamp[:, 1]
        nearest = np.minimum.reduceat(lamp[0], first, axis=1), np.maximum.reduceat(lamp[1], first, axis=1)
        found = shadowed[start:stop]
        some = max(1, (1 << 12) // len(first))
        for block in range(0, boxes.shape[2], some):
            box = boxes[..., block:block + some]
            group, of = (each.ravel() for each in np.indices((len(first), box.shape[2])))
            near = np.flatnonzero(_in_the_way(low[:, group], high[:, group], facing[:, group], least[group],
                                              [each[:, group] for each in nearest], box[..., of]))
            point = (first[group[near], None] + np.arange(together)).ravel()
            of = np.repeat(of[near], together)
            asked = np.flatnonzero(point < stop - start)
            asked = asked[~found[point[asked]]]
            k, other, own = point[asked], box[..., of[asked]], [each[:, point[asked]] for each in lamp]
            hidden = _in_the_way(p[0][:, k], p[1][:, k], n[:, k], front[k], own, other)
            # A luminaire does not obstruct its own light.
            hidden &= (other != own).any(axis=(0, 1))
            found[k[hidden]] = True

    in_threads(work, len(points), 1 << 15)
    return shadowed


def _alike(luminaires: list[Luminaire]) -> list[np.ndarray]:
    """Indices of luminaires that differ in their place alone, by groups."""
    groups: dict[tuple, list[int]] = {}
    for index, lum in enumerate(luminaires):
        size = float(np.abs(lum.corners - lum.center).max()) or 1.0
        parts = [lum.corners - lum.center, *((face.middle, face.u, face.v) for face in lum.opening)]
        # Equal to rounding, as the luminaires of an array are.
        form = [np.round(np.array(part) / size, 9).tobytes() for part in parts]
        turned = np.round(np.vstack([lum.normal, lum.axes]), 9).tobytes()
        light = "cosine" if lum.lambertian else index if lum.distribution is None else id(lum.distribution)
        groups.setdefault((type(lum), f"{size:.9e}", light, turned, *form), []).append(index)
    return [np.array(some) for some in groups.values()]


def _boxes(luminaires: list[Luminaire]) -> np.ndarray:
    """Lowest and highest corner of each luminaire (n_luminaires, 2, 3) [m]."""
    return np.array([[lum.corners.min(axis=0), lum.corners.max(axis=0)]
                     for lum in luminaires]).reshape(-1, 2, 3)


def _in_the_way(low: np.ndarray, high: np.ndarray, normal: np.ndarray, front: np.ndarray, lamp: np.ndarray,
                box: np.ndarray) -> np.ndarray:
    """Whether each box reaches between a luminaire and a group of points, in front of the group (k,).

    low, high : (3, k) [m], lowest and highest corners of the groups
    normal : (3, k) unit, of the groups
    front : (k,) [m], positions of the groups' tangent planes along their normals
    lamp : lowest and highest corner of the luminaire, (3, k) [m] each
    box : (2, 3, k) [m], lowest and highest corner of each box
    """
    to_low, to_high = lamp[0] - low, lamp[1] - high
    slack = SHAFT_SLACK * np.maximum(-to_low, to_high).max(axis=0, initial=0.0)
    least, most = box
    found = (np.where(normal > 0, most, least) * normal).sum(axis=0) > front + slack
    k = np.flatnonzero(found)
    found[k] = reaches(to_low[:, k], to_high[:, k], least[:, k] - high[:, k] - slack[k],
                       most[:, k] - low[:, k] + slack[k])
    return found


def direct_at(points: np.ndarray, normals: np.ndarray, luminaires: list[Luminaire],
              ray_scene: RayScene | None, seed: tuple[int, ...], rays: int = SHADOW_RAYS,
              origins: np.ndarray | None = None, replicas: int = 1,
              around: np.ndarray | None = None, bare: np.ndarray | None = None) -> np.ndarray:
    """Illuminance per lumen at points (replicas, k, n_luminaires) [m⁻²], with shadows.

    points, normals : (k, 3) [m], unit
    ray_scene : None where nothing can stand between
    rays : to each luminaire from each point in each replica
    origins : where rays start, (k, 3) [m], or (k, replicas, 3), one for each replica; by default off the
        points along their normals
    around : (k, c, 3) [m] corners of a shape that contains all origins of a point
    bare : (k, n_luminaires) [m⁻²] the illuminance without shadows, where it is known already
    """
    bare = unoccluded(points, normals, luminaires) if bare is None else bare
    factors = np.repeat(bare[None], replicas, axis=0)
    if ray_scene is not None:
        around = points[:, None] if around is None else around
        lifted = ray_scene.off(points, normals) if origins is None else origins
        boxes, few = _boxes(luminaires), max(1, (1 << 16) // max(1, len(points)))
        for alike in _alike(luminaires):
            for some in np.split(alike, range(few, len(alike), few)):
                index, point = np.nonzero(bare[:, some].T > 0)
                lamp, first = some[index], int(some[0])
                shadowed = may_be_shadowed(around[point], normals[point], boxes[lamp],
                                           ray_scene.mesh.obstacles)
                lamp, point = lamp[shadowed], point[shadowed]
                shift = np.array([luminaires[k].center - luminaires[first].center for k in lamp])
                factors[:, point, lamp] *= visible_share(
                    lifted[point], normals[point], luminaires[first], ray_scene, rays, (*seed, first),
                    replicas, shift.reshape(-1, 3))
    return factors


def direct_on_patches(mesh: Mesh, exchange: Exchange, luminaires: list[Luminaire],
                      ray_scene: RayScene | None, seed: tuple[int, ...],
                      replicas: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean illuminance of each patch per lumen (replicas, n_patches, n_luminaires) [m⁻²], and the share of
    each luminaire's lumens that met no patch (n_luminaires,).

    It is the closed form times the share of light that is not obstructed. Each luminaire's sum over the
    patches is then scaled to 1, because all its lumens arrive on some patch.
    """
    live = np.flatnonzero(exchange.areas > 0)
    mean = np.zeros((replicas, mesh.count, len(luminaires)))
    for index, lum in enumerate(luminaires):
        flux = _unoccluded_on(mesh, live, lum, (*seed, index, 0))
        mean[:, live, index] = flux / exchange.areas[live]
        if ray_scene is not None:
            # The number of points on a patch doubles with its share of the luminaire's light above 1/256.
            doubled = np.ceil(np.log2(np.maximum(256 * flux, 1))).clip(max=5)
            for more in np.unique(doubled[flux > 0]).astype(int):
                lit = live[(flux > 0) & (doubled == more)]
                mean[:, lit, index] *= _share_on(mesh, lit, lum, ray_scene, (*seed, index, 1, more), replicas,
                                                 PATCH_POINTS << more)
    arrived = exchange.areas @ mean
    return mean / np.where(arrived > 0, arrived, 1.0)[:, None], 1 - arrived.mean(axis=0)


def _unoccluded_on(mesh: Mesh, unknown: np.ndarray, lum: Luminaire, seed) -> np.ndarray:
    """Share of a luminaire's lumens that each unknown would receive without obstruction (k,); for gathered
    facets their sum."""
    if mesh.gathering is None:
        return _unoccluded_flux(mesh, unknown, lum, seed)
    wanted = np.zeros(mesh.count, dtype=bool)
    wanted[unknown] = True
    patch = np.flatnonzero(wanted[mesh.group] & ~mesh.covered)
    flux = _unoccluded_flux(mesh, patch, lum, seed)
    return np.bincount(mesh.group[patch], flux, mesh.count)[unknown]


def _unoccluded_flux(mesh: Mesh, patch: np.ndarray, lum: Luminaire, seed) -> np.ndarray:
    """Share of a luminaire's lumens that each patch would receive without obstruction (k,)."""
    flux = lum.share_on(mesh, patch)
    sampled = np.flatnonzero(np.isnan(flux))
    if len(sampled):
        points, normals = _points_on(mesh, patch[sampled], seed, REPLICAS)
        light = lum.illuminance(points, normals).reshape(len(sampled), -1)
        flux[sampled] = light.mean(axis=1) * mesh.area[patch[sampled]]
    return flux


def _share_on(mesh: Mesh, patch: np.ndarray, lum: Luminaire, ray_scene: RayScene, seed,
              replicas: int, on_each: int, rays: int = 8) -> np.ndarray:
    """Share of a luminaire's light on each patch that is not obstructed (replicas, k).

    on_each : points on each patch in each replica; rays : from each point to the luminaire
    """
    points, normals = _points_over(mesh, patch, seed, replicas, on_each)
    share = np.ones((replicas, len(patch)))
    maybe = may_be_shadowed(points[:, None], normals, _boxes([lum])[0], ray_scene.mesh.obstacles)
    some = maybe.reshape(len(patch), -1).any(axis=1)
    of_some = np.repeat(some, replicas * on_each)
    points, normals, maybe = points[of_some], normals[of_some], maybe[of_some]
    factors = unoccluded(points, normals, [lum])[:, 0]
    past = factors.copy()
    asked = np.flatnonzero(maybe & (factors > 0))
    past[asked] *= visible_share(ray_scene.off(points[asked], normals[asked]), normals[asked], lum,
                                 ray_scene, rays, (*seed, 0), 1)[0]
    past, total = (np.einsum("kpr->pk", x.reshape(-1, replicas, on_each)) for x in (past, factors))
    share[:, some] = past / np.where(total > 0, total, 1.0)
    return share


def _points_on(mesh: Mesh, patch: np.ndarray, seed, replicas: int,
               on_each: int = PATCH_POINTS) -> tuple[np.ndarray, np.ndarray]:
    """Points all over each patch, `replicas` · `on_each` on each, and their normals (k · points, 3)."""
    points = mesh.spread(patch, Nets(on_each, 2, seed, replicas).draw(0, len(patch)))
    return points.reshape(-1, 3), np.repeat(mesh.normal[patch], points.shape[1], axis=0)


def _points_over(mesh: Mesh, unknown: np.ndarray, seed, replicas: int, on_each: int
                 ) -> tuple[np.ndarray, np.ndarray]:
    """Points all over each unknown and their normals: `_points_on`, and for gathered facets points all over
    these."""
    if mesh.gathering is None:
        return _points_on(mesh, unknown, seed, replicas, on_each)
    facet, square = mesh.gathering.pick(unknown, Nets(on_each, 2, seed, replicas).draw(0, len(unknown)))
    points = mesh.spread(facet.ravel(), square.reshape(-1, 1, 2))
    return points.reshape(-1, 3), mesh.normal[facet.ravel()]
