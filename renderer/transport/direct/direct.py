"""Light straight from the luminaires: per lumen of each, at points and on patches."""

import numpy as np

from renderer.scene.luminaires.luminaire import Luminaire
from renderer.system.threads import CHUNK, in_threads
from renderer.transport.factors.exchange import Exchange
from renderer.transport.factors.shafts import SLACK, reaches
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.rays.ray_scene import RayScene
from renderer.transport.rays.sampling import REPLICAS, Nets

PATCH_POINTS, PATCH_RAYS = 4, 8
"""Points on a patch, and shadow rays from each, where its direct light has no closed form: in each of
so many independent replicas."""
BRIGHT, MOST = 256, 5
"""A patch has twice the points for each time that its share of a luminaire's light doubles past 1 in so many,
so often at most: what all of them miss together is then small, and they are few."""
POINTS_PER_SLICE = 1 << 15
"""Rays to a luminaire worked on at once: what stays in the cache."""
POINTS_SEEN_TOGETHER = 32
"""Points in a row that are first looked at as one."""
PAIRS_PER_SLICE = 1 << 12
"""Of those and boxes, looked at in one go."""
SHADOW_RAYS = 64
"""Rays from a point to a luminaire with area: its penumbra in 64 steps, jittered."""


def unoccluded(points: np.ndarray, normals: np.ndarray, luminaires: list[Luminaire]) -> np.ndarray:
    """Illuminance per lumen (k, n_luminaires) [lx/lm = m⁻²], nothing standing between."""
    factors = np.zeros((len(points), len(luminaires)))
    for index, lum in enumerate(luminaires):
        factors[:, index] = lum.illuminance(points, normals)
    return factors


def visible_share(points: np.ndarray, normals: np.ndarray, luminaire: Luminaire,
                  ray_scene: RayScene, rays: int, seed: tuple[int, ...], replicas: int) -> np.ndarray:
    """Share of a luminaire's light that reaches each point past what stands between (replicas, k).

    points : (k, 3) [m], already off their surface, or (k, replicas, 3), a place for each replica. Rays go to
    points all over the luminaire, each weighted with what it would bring; so many to each point in each of
    `replicas` independent nets. What few rays say is biased as that weight varies, so they are aimed.
    """
    each = points if points.ndim > 2 else points[:, None]
    if luminaire.is_point:
        clear = ray_scene.clear(each, np.broadcast_to(luminaire.center, each.shape)).T
        return np.broadcast_to(clear.astype(float), (replicas, len(points)))
    nets = Nets(rays, 2, seed, replicas)
    share = np.empty((replicas, len(points)))

    def work(start: int, stop: int) -> None:
        square = nets.draw(start, stop)
        few = max(1, POINTS_PER_SLICE // (rays * replicas))
        for first in range(start, stop, few):
            some = slice(first, min(first + few, stop))
            origins = each[some] if each.shape[1] == 1 else np.repeat(each[some], rays, axis=1)
            targets, stands = luminaire.aimed(origins, square[some.start - start:some.stop - start])
            weight = stands * luminaire.brought(origins, normals[some, None], targets)
            past = weight * ray_scene.clear(origins, targets)
            past, total = (np.einsum("kpr->pk", w.reshape(-1, replicas, rays)) for w in (past, weight))
            share[:, some] = past / np.where(total > 0, total, 1.0)

    in_threads(work, len(points), max(1, CHUNK // (rays * replicas)))
    return share


def may_be_shadowed(points: np.ndarray, normals: np.ndarray, luminaire: Luminaire,
                    boxes: np.ndarray) -> np.ndarray:
    """Whether some box (m, 8, 3) reaches between any of a group of points (k, c, 3), on the front of their
    tangent plane, and the luminaire (k,), each in a box along the room's axes. Where it is False no shadow
    ray is needed."""
    lamp = np.array([luminaire.corners.min(axis=0), luminaire.corners.max(axis=0)])
    boxes = np.stack([boxes.min(axis=1), boxes.max(axis=1)])
    # A sheet does not stand in the way of its own light.
    boxes = boxes[:, ~(boxes == lamp[:, None]).all(axis=(0, 2))].transpose(0, 2, 1)
    shadowed = np.zeros(len(points), dtype=bool)

    def work(start: int, stop: int) -> None:
        p, n = points[start:stop].T, normals[start:stop].T
        front = (p * n[:, None]).sum(axis=0).min(axis=0)
        p = p.min(axis=1), p.max(axis=1)
        # Of points one after the other most have nothing near them, which all of them tell at once.
        first = np.arange(0, stop - start, POINTS_SEEN_TOGETHER)
        low, high = np.minimum.reduceat(p[0], first, axis=1), np.maximum.reduceat(p[1], first, axis=1)
        facing = np.minimum.reduceat(n, first, axis=1)
        alike = (facing == np.maximum.reduceat(n, first, axis=1)).all(axis=0)
        least = np.where(alike, np.minimum.reduceat(front, first), -np.inf)
        found = shadowed[start:stop]
        some = max(1, PAIRS_PER_SLICE // len(first))
        for block in range(0, boxes.shape[2], some):
            box = boxes[..., block:block + some]
            group, of = (each.ravel() for each in np.indices((len(first), box.shape[2])))
            near = np.flatnonzero(_in_the_way(low[:, group], high[:, group], facing[:, group], least[group],
                                              lamp, box[..., of]))
            point = (first[group[near], None] + np.arange(POINTS_SEEN_TOGETHER)).ravel()
            of = np.repeat(of[near], POINTS_SEEN_TOGETHER)
            asked = np.flatnonzero(point < stop - start)
            asked = asked[~found[point[asked]]]
            k = point[asked]
            hidden = _in_the_way(p[0][:, k], p[1][:, k], n[:, k], front[k], lamp, box[..., of[asked]])
            found[k[hidden]] = True

    in_threads(work, len(points), POINTS_PER_SLICE)
    return shadowed


def _in_the_way(low: np.ndarray, high: np.ndarray, normal: np.ndarray, front: np.ndarray, lamp: np.ndarray,
                box: np.ndarray) -> np.ndarray:
    """Whether each of boxes (2, 3, k) reaches between a lamp's (2, 3) and what goes from low to high (3, k),
    in front of what faces along a normal (3, k), `front` (k,) along it."""
    to_low, to_high = lamp[0][:, None] - low, lamp[1][:, None] - high
    slack = SLACK * np.maximum(-to_low, to_high).max(axis=0, initial=0.0)
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
    """Illuminance per lumen at points (replicas, k, n_luminaires) [m⁻²], shadows included.

    visibility : None where nothing can stand between; rays : to each luminaire, in each of `replicas`
    independent nets; origins : where rays start, (k, 3) [m], or (k, replicas, 3), one for each replica; else
    off the points along their normals; around : (k, c, 3) corners of what holds all of those; bare :
    (k, n_luminaires) [m⁻²] without shadows, where that is known already.
    """
    bare = unoccluded(points, normals, luminaires) if bare is None else bare
    factors = np.repeat(bare[None], replicas, axis=0)
    if ray_scene is not None:
        around = points[:, None] if around is None else around
        lifted = ray_scene.off(points, normals) if origins is None else origins
        for index, luminaire in enumerate(luminaires):
            lit = np.flatnonzero(factors[0, :, index] > 0)
            lit = lit[may_be_shadowed(around[lit], normals[lit], luminaire, ray_scene.mesh.obstacles)]
            factors[:, lit, index] *= visible_share(lifted[lit], normals[lit], luminaire, ray_scene,
                                                    rays, (*seed, index), replicas)
    return factors


def direct_on_patches(mesh: Mesh, exchange: Exchange, luminaires: list[Luminaire],
                      ray_scene: RayScene | None, seed: tuple[int, ...],
                      replicas: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean illuminance of each patch per lumen (replicas, n_patches, n_luminaires) [m⁻²], in so many
    independent samples: one where nothing can stand between.

    In closed form where nothing stands between; times the share that gets past what does. All
    lumens arrive somewhere: each luminaire's sum is scaled to 1. Returns also what was missing
    from that sum before (n_luminaires,).
    """
    live = np.flatnonzero(exchange.areas > 0)
    mean = np.zeros((replicas, mesh.count, len(luminaires)))
    for index, lum in enumerate(luminaires):
        flux = _unoccluded_on(mesh, live, lum, (*seed, index, 0))
        mean[:, live, index] = flux / exchange.areas[live]
        if ray_scene is not None:
            doubled = np.ceil(np.log2(np.maximum(BRIGHT * flux, 1))).clip(max=MOST)
            for more in np.unique(doubled[flux > 0]).astype(int):
                lit = live[(flux > 0) & (doubled == more)]
                mean[:, lit, index] *= _share_on(mesh, lit, lum, ray_scene, (*seed, index, 1, more), replicas,
                                                 PATCH_POINTS << more)
    arrived = exchange.areas @ mean
    return mean / np.where(arrived > 0, arrived, 1.0)[:, None], 1 - arrived.mean(axis=0)


def _unoccluded_on(mesh: Mesh, unknown: np.ndarray, lum: Luminaire, seed) -> np.ndarray:
    """The same of each unknown (k,): of gathered facets their sum."""
    if mesh.gathering is None:
        return _unoccluded_flux(mesh, unknown, lum, seed)
    wanted = np.zeros(mesh.count, dtype=bool)
    wanted[unknown] = True
    patch = np.flatnonzero(wanted[mesh.group] & ~mesh.covered)
    flux = _unoccluded_flux(mesh, patch, lum, seed)
    return np.bincount(mesh.group[patch], flux, mesh.count)[unknown]


def _unoccluded_flux(mesh: Mesh, patch: np.ndarray, lum: Luminaire, seed) -> np.ndarray:
    """Share of a luminaire's lumens that each patch would receive if nothing stood between (k,)."""
    flux = lum.share_on(mesh, patch)
    sampled = np.flatnonzero(np.isnan(flux))
    if len(sampled):
        points, normals = _points_on(mesh, patch[sampled], seed, REPLICAS)
        light = lum.illuminance(points, normals).reshape(len(sampled), -1)
        flux[sampled] = light.mean(axis=1) * mesh.area[patch[sampled]]
    return flux


def _share_on(mesh: Mesh, patch: np.ndarray, lum: Luminaire, ray_scene: RayScene, seed,
              replicas: int, on_each: int) -> np.ndarray:
    """Share of a luminaire's light on each patch that gets past what stands between (replicas, k), by so many
    points on each in each replica."""
    points, normals = _points_over(mesh, patch, seed, replicas, on_each)
    share = np.ones((replicas, len(patch)))
    maybe = may_be_shadowed(points[:, None], normals, lum, ray_scene.mesh.obstacles)
    some = maybe.reshape(len(patch), -1).any(axis=1)
    of_some = np.repeat(some, replicas * on_each)
    points, normals, maybe = points[of_some], normals[of_some], maybe[of_some]
    factors = unoccluded(points, normals, [lum])[:, 0]
    past = factors.copy()
    asked = np.flatnonzero(maybe & (factors > 0))
    past[asked] *= visible_share(ray_scene.off(points[asked], normals[asked]), normals[asked], lum,
                                 ray_scene, PATCH_RAYS, (*seed, 0), 1)[0]
    past, total = (np.einsum("kpr->pk", x.reshape(-1, replicas, on_each)) for x in (past, factors))
    share[:, some] = past / np.where(total > 0, total, 1.0)
    return share


def _points_on(mesh: Mesh, patch: np.ndarray, seed, replicas: int,
               on_each: int = PATCH_POINTS) -> tuple[np.ndarray, np.ndarray]:
    """`replicas` times so many points all over each patch, and their normals (k · points, 3)."""
    points = mesh.spread(patch, Nets(on_each, 2, seed, replicas).draw(0, len(patch)))
    return points.reshape(-1, 3), np.repeat(mesh.normal[patch], points.shape[1], axis=0)


def _points_over(mesh: Mesh, unknown: np.ndarray, seed, replicas: int, on_each: int
                 ) -> tuple[np.ndarray, np.ndarray]:
    """The same all over each unknown: of gathered facets all over these."""
    if mesh.gathering is None:
        return _points_on(mesh, unknown, seed, replicas, on_each)
    facet, square = mesh.gathering.pick(unknown, Nets(on_each, 2, seed, replicas).draw(0, len(unknown)))
    points = mesh.spread(facet.ravel(), square.reshape(-1, 1, 2))
    return points.reshape(-1, 3), mesh.normal[facet.ravel()]
