"""The virtual photometer: illuminance at a point on a plane of any tilt."""

from dataclasses import dataclass

import numpy as np

from renderer.radiometry.polygons import exchanged, polygon_factors
from renderer.readings.elements import Seen, all_seen, element_light, near_lamps, seen_past
from renderer.readings.meter_place import MeterPlace, place
from renderer.readings.uncertainty import counted_half_width, half_width
from renderer.system.threads import in_threads
from renderer.transport.direct.direct import direct_at, hidden_light, unoccluded
from renderer.transport.factors.shafts import may_be_hidden
from renderer.transport.rays.sampling import Nets, Stream
from renderer.transport.sensors import Sensor, sense
from renderer.transport.transport import Transport

MAX_VIEW_SHARE, MAX_VIEW_SHARE_BY_RAYS = 2.5e-4, 2e-3
"""Largest share of a meter's view that an element may fill if its light is evaluated at its middle; the
second value where rays go to the elements, whose sampling errors are larger than the error of the middle."""
READING_RAYS = 1 << 10
"""Shadow rays from the meter to each luminaire in each replica; more in penumbrae."""


@dataclass(frozen=True)
class Meter:
    """A photometer in its place. Its reading is linear in the light on the surfaces.

    direct : (replicas, n_luminaires) direct illuminance per lumen of each luminaire [m⁻²]
    sensors : one for each replica, with a row for the light of each surface (n_surfaces); a single one where
      no ray is cast
    counted : (n_luminaires,) per lumen, from `counted_half_width` [m⁻²]; None where it is not known
    """

    direct: np.ndarray
    sensors: tuple[Sensor, ...]
    counted: np.ndarray | None = None


def make_meter(transport: Transport, position: np.ndarray, normal: np.ndarray, where: str,
               own: Meter | None = None) -> Meter:
    """A meter at a point (3,) [m] that faces along a unit normal (3,). Raises InputError.

    own : the meter at this place on the mesh that is read, if this one is for its error bar: it then shares
      the direct light and needs fewer rays
    """
    own = own if own is not None and len(own.direct) == transport.replicas else None
    key = (*position, *normal, own is None)
    if key in transport.meters:
        kept = transport.meters[key]
        return kept if own is None else Meter(own.direct, kept.sensors, own.counted)
    spot = place(transport, position, normal, where)
    rays = _element_rays(transport) // (1 if own is None else 4)
    sensors = _sensors(transport, spot, rays)
    direct, counted = _direct(transport, spot) if own is None else (own.direct, own.counted)
    meter = Meter(direct, sensors, counted)
    # Meters are kept for other materials and lamps up to this number of meters times patches (about 30 MB).
    if (len(transport.meters) + 1) * len(transport.mesh.patches) <= 50_000:
        transport.meters[key] = meter
    return meter


def _sensors(transport: Transport, spot: MeterPlace, rays: int) -> tuple[Sensor, ...]:
    """Sensors for the light of each surface at a meter, one for each replica. rays : to each element in each
    replica"""
    replicas = transport.replicas
    patch, corners, factor, whole = _elements(transport, spot)
    seen = all_seen(transport.mesh, patch, corners, replicas)
    if transport.ray_scene is not None:
        seen = _seen(transport, spot, patch, corners, seen, rays)
        some = seen.share.any(axis=0)
        patch, corners, factor, seen = patch[some], corners[some], factor[some], seen.of(some)
        whole = whole[some] & (seen.share == 1).all(axis=0)
    # A whole patch has its mean direct light; for a smaller element direct light is computed.
    light = transport.direct_replicas[:, patch]
    divided = np.flatnonzero(~whole | (transport.ray_scene is None))
    light[:, divided] = element_light(transport, spot.position, spot.normal, patch[divided], corners[divided],
                                      seen.of(divided), rays)
    return tuple(sense(transport, transport.n_surfaces, transport.mesh.surface[patch], patch, *seen.middle.T,
                       factor * seen.share, light, conserving=True))


def _direct(transport: Transport, spot: MeterPlace) -> tuple[np.ndarray, np.ndarray]:
    """Direct illuminance per lumen of each luminaire (replicas, n_luminaires) [m⁻²], by enough rays for an
    uncertainty of 0.05 %; and `counted` of `Meter`."""
    replicas, most = transport.replicas, 1 << 14
    rays = READING_RAYS if replicas > 1 else most
    at, normal, origin = spot.position[None], spot.normal[None], spot.origin[None]
    bare = unoccluded(at, normal, transport.luminaires)
    while True:
        direct = direct_at(at, normal, transport.luminaires, transport.ray_scene,
                           (transport.seed, Stream.DIRECT_AT_METER), rays, origins=origin,
                           replicas=replicas, bare=bare)[:, 0]
        total = direct.sum(axis=1)
        if rays == most or half_width(total) <= 5e-4 * total.mean():
            hidden = hidden_light(direct, bare[0], transport.luminaires)
            return direct, counted_half_width(hidden, rays, replicas)
        rays *= 4


def _seen(transport: Transport, spot: MeterPlace, patch: np.ndarray, corners: np.ndarray, seen: Seen,
          rays: int) -> Seen:
    """The visible parts of elements (k) from a meter, with obstruction.

    patch : (k,); corners : (k, 4, 2) as s and t; seen : without obstruction
    rays : to each element in each replica
    """
    mesh, ray_scene = transport.mesh, transport.ray_scene
    world = mesh.at(patch[:, None], corners[..., 0], corners[..., 1])
    doubtful = np.flatnonzero(may_be_hidden(spot.position, spot.normal, world, mesh.obstacles, mesh.scale))
    nets = Nets(rays, 2, (transport.seed, Stream.METER_TO_ELEMENTS), transport.replicas)
    places = np.empty((len(doubtful), transport.replicas * rays, 2))
    worth, clear = np.empty(places.shape[:2]), np.empty(places.shape[:2], dtype=bool)

    def look(start: int, stop: int) -> None:
        some = doubtful[start:stop]
        points = mesh.within(patch[some], corners[some], nets.draw(start, stop))
        targets = mesh.at(patch[some, None], *points)
        lifted = ray_scene.off(targets, mesh.normal[patch[some], None])
        clear[start:stop] = ray_scene.clear(np.broadcast_to(spot.origin, lifted.shape), lifted)
        worth[start:stop] = exchanged(spot.position, spot.normal, targets, mesh.normal[patch[some], None])
        places[start:stop] = np.stack(points, axis=-1)

    in_threads(look, len(doubtful), (1 << 14) // (transport.replicas * rays))
    by_replica = (len(doubtful), transport.replicas, rays)
    worth, clear = worth.reshape(by_replica), clear.reshape(by_replica)
    return seen_past(seen, doubtful, places.reshape(*by_replica, 2), worth, clear)


def max_view_share(patches: int, rays: int) -> float:
    """Largest share of a meter's view that an element may fill. patches : number in the mesh; rays : from
    each patch, 0 for none"""
    # A patch of the mesh fills 1/patches of the view on average.
    return min(max(MAX_VIEW_SHARE, 2 / patches), MAX_VIEW_SHARE_BY_RAYS) if rays else MAX_VIEW_SHARE


def _element_rays(transport: Transport) -> int:
    """Number of rays in each replica from the meter to each element, and from each element to each luminaire:
    a power of 2, more for larger elements. The errors of thousands of elements average out."""
    more = max_view_share(len(transport.mesh.patches), transport.rays_per_patch) / MAX_VIEW_SHARE
    return 4 << round(np.log2(more))


def _elements(transport: Transport, spot: MeterPlace, max_divisions: int = 24):
    """Patches divided until each element fills a small enough share of the view and is small relative to its
    distance from lamps.

    Returns the patch of each element, ascending (k,), corners (k, 4, 2) as s and t, form factor from the
    meter (k,), and whether the element is a whole patch (k,).
    """
    mesh, most = transport.mesh, max_view_share(len(transport.mesh.patches), transport.rays_per_patch)
    patch = np.flatnonzero((transport.exchange.areas > 0) & transport.reflecting)
    unit = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    half = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])
    corners = np.where(mesh.triangular[patch][:, None, None], half, unit)
    done = []
    for depth in range(max_divisions):
        world = mesh.at(patch[:, None], corners[..., 0], corners[..., 1])
        n = len(patch)
        factor = polygon_factors(np.broadcast_to(spot.position, (n, 3)),
                                 np.broadcast_to(spot.normal, (n, 3)), world)
        large = (factor > most) | ((factor > 0) & near_lamps(transport, patch, world, 0.5).any(axis=1))
        large &= depth < max_divisions - 1
        kept = ~large & (factor > 0)
        done.append((patch[kept], corners[kept], factor[kept], np.full(kept.sum(), depth == 0)))
        if not large.any():
            break
        corners = _quarters(corners[large], mesh.triangular[patch[large]])
        patch = np.repeat(patch[large], 4)
    found = [np.concatenate(each) for each in zip(*done, strict=True)]
    order = np.argsort(found[0], kind="stable")
    return tuple(each[order] for each in found)


def _quarters(corners: np.ndarray, triangular: np.ndarray) -> np.ndarray:
    """Each element (k, 4, 2) divided into four (4k, 4, 2)."""
    a, b, c, d = np.moveaxis(corners, 1, 0)
    ab, bc, cd, da, m = (a + b) / 2, (b + c) / 2, (c + d) / 2, (d + a) / 2, (a + b + c + d) / 4
    quads = np.stack([np.stack(q, axis=1) for q in (
        (a, ab, m, da), (ab, b, bc, m), (m, bc, c, cd), (da, m, cd, d))], axis=1)
    ac = (a + c) / 2
    triangles = np.stack([np.stack(q, axis=1) for q in (
        (a, ab, ac, ac), (ab, b, bc, bc), (ac, bc, c, c), (bc, ac, ab, ab))], axis=1)
    return np.where(triangular[:, None, None, None], triangles, quads).reshape(-1, 4, 2)
