"""The virtual photometer: what arrives at a point on a plane of any tilt."""

from dataclasses import dataclass

import numpy as np

from renderer.errors import InputError
from renderer.radiometry.polygons import HORIZON, exchanged, polygon_factors
from renderer.readings.elements import Seen, all_seen, element_light, near_lamps, seen_past
from renderer.readings.uncertainty import half_width
from renderer.scene import room as room_shell
from renderer.system.threads import in_threads
from renderer.transport.direct.direct import direct_at
from renderer.transport.factors.shafts import may_be_hidden
from renderer.transport.rays.ray_scene import STAND_OFF
from renderer.transport.rays.sampling import Nets, Stream
from renderer.transport.sensors import Sensor, sense
from renderer.transport.transport import Transport

LARGEST, COARSEST, OF_PATCH = 2.5e-4, 2e-3, 2.0
"""Surfaces are divided until no element fills more of the meter's view: 1/4000. Then the light on an element
may be taken at its middle. Where rays go to each, as many times what a patch of the mesh fills on average, up
to 1/500."""
NEAR_LAMP = 0.5
"""An element's half diagonal is at most this share of its distance to any lamp that lights it."""
MAX_DIVISIONS = 24
READING_RAYS, MOST_RAYS, ENOUGH = 1 << 10, 1 << 14, 5e-4
"""Shadow rays from the meter itself to each luminaire in each replica, and in penumbrae up to so
many, until so small a share of what comes straight from them is uncertain."""
ELEMENTS_PER_SLICE = 1 << 14
"""Rays from the meter to elements worked on at once: what stays in the cache."""
ELEMENT_RAYS, FEWER = 4, 4
"""Rays from the meter to each element, and shadow rays from there to each luminaire, in each independent
part, as many times more as elements are larger: their errors average out over thousands. So many times fewer
where only an error bar hangs on them."""


MAX_KEPT_METERS = 50_000
"""Patches of a mesh times meters that are kept for the next room of its shape: some 30 MB."""


@dataclass(frozen=True)
class Spot:
    """A meter's place: for exact factors a hair off what it touches, for rays by their tolerance.

    position, origin : (3,) [m]; normal : (3,) unit; touched : (k, 3) normals of what it touches
    """

    position: np.ndarray
    origin: np.ndarray
    normal: np.ndarray
    touched: np.ndarray


def place(transport: Transport, position: np.ndarray, normal: np.ndarray, where: str) -> Spot:
    """Where a meter at a point (3,) that faces along a unit normal stands. Raises InputError.

    A meter on a floor stands on it; in a corner it touches three surfaces and leaves all three.
    """
    key = (position.tobytes(), normal.tobytes())
    if key not in transport.placed:
        refuse_outside(transport, position, where)
        transport.placed[key] = stand(transport, position, normal, where)
    return transport.placed[key]


def stand(transport: Transport, position: np.ndarray, normal: np.ndarray, where: str) -> Spot:
    """As `place`, of a point that is in the room."""
    spot = off_surfaces(transport, position, normal)
    if (spot.touched @ normal < -1 + 1e-9).any():
        raise InputError(f"{where} faces the surface it lies on (normal {_short(normal)}) and sees "
                         "nothing. Turn its normal round.")
    refuse_inside(transport, spot.origin, where, position)
    for lum in transport.luminaires:
        if lum.is_point and np.linalg.norm(position - lum.center) < 1e-6 * transport.mesh.scale:
            raise InputError(f"{where}: position {_short(position)} is on the point luminaire "
                             f"{lum.name!r}, where illuminance has no limit. Move one of them.")
    return spot


def off_surfaces(transport: Transport, position: np.ndarray, facing: np.ndarray) -> Spot:
    """Lift a point off every surface that it touches; off a sheet to the side it faces."""
    mesh = transport.mesh
    height = np.einsum("ki,ki->k", position - mesh.corners[:, 0], mesh.normal)
    s, t = mesh.inside(np.arange(len(mesh.patches)), position)
    edge = 1e-6
    on = (s >= -edge) & (t >= -edge) & np.where(
        mesh.triangular, s + t <= 1 + edge, (s <= 1 + edge) & (t <= 1 + edge))
    on &= (np.abs(height) <= STAND_OFF * mesh.scale) & (transport.exchange.areas > 0)
    along, index = mesh.normal @ facing, np.arange(len(mesh.twin))
    on &= (mesh.twin < 0) | (along > 0) | ((along == 0) & (index < mesh.twin))
    touched, which = np.unique(np.round(mesh.normal[on], 6), axis=0, return_inverse=True)
    low = np.full(len(touched), np.inf)
    np.minimum.at(low, which.ravel(), height[on])
    inside = np.clip(position, *mesh.bounds)

    def lifted(lift: float) -> np.ndarray:
        return inside + np.clip(lift * mesh.scale - low, 0.0, None) @ touched

    return Spot(lifted(HORIZON), lifted(STAND_OFF), facing, touched)


def refuse_outside(transport: Transport, position: np.ndarray, where: str) -> None:
    """Raise InputError for a point outside the room."""
    room_shell.refuse_place_outside(transport.room, position, f"{where}: position", "Move it into the room")


def refuse_inside(transport: Transport, lifted: np.ndarray, where: str, position: np.ndarray) -> None:
    """Raise InputError for a point inside a solid: `position` (3,) [m], `lifted` off what it touches."""
    solids = transport.mesh.solids
    if len(solids) and room_shell.winding(lifted[None], solids)[0] < -0.5:
        raise InputError(f"{where}: position {_short(position)} is inside an object. "
                         "Move it into the open room.")


def _short(xyz: np.ndarray) -> str:
    return "[" + ", ".join(f"{x:.6g}" for x in xyz) + "]"


@dataclass(frozen=True)
class Meter:
    """A photometer in its place: what it reads is linear in the light on the surfaces.

    direct : (k, n_luminaires) illuminance per lumen, straight from each [m⁻²]
    sensors : k sensors whose rows (n_surfaces) are what each surface sends
    k : independent samples; one where no ray is cast
    """

    direct: np.ndarray
    sensors: tuple[Sensor, ...]


def make_meter(transport: Transport, position: np.ndarray, normal: np.ndarray, where: str,
               own: Meter | None = None) -> Meter:
    """A meter at a point (3,) [m] that faces along a unit normal (3,). Raises InputError.

    own : the same on the mesh that is read, where this one on another mesh tells its error: light straight
        from the luminaires is the same, and fewer rays do
    """
    own = own if own is not None and len(own.direct) == transport.replicas else None
    key = (*position, *normal, own is None)
    if key in transport.meters:
        kept = transport.meters[key]
        return kept if own is None else Meter(own.direct, kept.sensors)
    spot = place(transport, position, normal, where)
    rays = _element_rays(transport) // (1 if own is None else FEWER)
    sensors = _sensors(transport, spot, rays)
    meter = Meter(_direct(transport, spot) if own is None else own.direct, sensors)
    if (len(transport.meters) + 1) * len(transport.mesh.patches) <= MAX_KEPT_METERS:
        transport.meters[key] = meter
    return meter


def _sensors(transport: Transport, spot: Spot, rays: int) -> tuple[Sensor, ...]:
    """What each surface sends to a meter, in independent samples. rays : in each to what is seen in part"""
    replicas = transport.replicas
    patch, corners, factor, whole = _elements(transport, spot)
    seen = all_seen(transport.mesh, patch, corners, replicas)
    if transport.ray_scene is not None:
        seen = _seen(transport, spot, patch, corners, seen, rays)
        some = seen.share.any(axis=0)
        patch, corners, factor, seen = patch[some], corners[some], factor[some], seen.of(some)
        whole = whole[some] & (seen.share == 1).all(axis=0)
    # A whole patch has its mean light; elements of patches have their own.
    light = transport.direct_replicas[:, patch]
    divided = np.flatnonzero(~whole)
    light[:, divided] = element_light(transport, spot.position, spot.normal, patch[divided], corners[divided],
                                      seen.of(divided), rays)
    return tuple(sense(transport, transport.n_surfaces, transport.mesh.surface[patch], patch, *seen.middle.T,
                       factor * seen.share, light, conserving=True))


def _direct(transport: Transport, spot: Spot) -> np.ndarray:
    """Illuminance per lumen, straight from each luminaire (replicas, n_luminaires) [m⁻²]."""
    replicas, rays = transport.replicas, READING_RAYS if transport.replicas > 1 else MOST_RAYS
    while True:
        direct = direct_at(spot.position[None], spot.normal[None], transport.luminaires, transport.ray_scene,
                           (transport.seed, Stream.DIRECT_AT_METER), rays, origins=spot.origin[None],
                           replicas=replicas)[:, 0]
        total = direct.sum(axis=1)
        if rays == MOST_RAYS or half_width(total) <= ENOUGH * total.mean():
            return direct
        rays *= 4


def _seen(transport: Transport, spot: Spot, patch: np.ndarray, corners: np.ndarray, seen: Seen,
          rays: int) -> Seen:
    """What a meter sees of each element (k) past what stands between. seen : what there is to see; rays : to
    each in each replica"""
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

    in_threads(look, len(doubtful), ELEMENTS_PER_SLICE // (transport.replicas * rays))
    by_replica = (len(doubtful), transport.replicas, rays)
    worth, clear = worth.reshape(by_replica), clear.reshape(by_replica)
    return seen_past(seen, doubtful, places.reshape(*by_replica, 2), worth, clear)


def largest(patches: int, rays: int) -> float:
    """Share of a meter's view that an element may fill, on a mesh of so many patches with so many rays each,
    0 for none."""
    return min(max(LARGEST, OF_PATCH / patches), COARSEST) if rays else LARGEST


def _element_rays(transport: Transport) -> int:
    """Rays to and from each element, a power of 2, in each replica."""
    more = largest(len(transport.mesh.patches), transport.rays_per_patch) / LARGEST
    return ELEMENT_RAYS << round(np.log2(more))


def _elements(transport: Transport, spot: Spot):
    """Patches divided until none fills much of the view or lies near a lamp for its size: patch, one after
    the other, corners (k, 4, 2), factor, and whether it is a whole patch."""
    mesh, most = transport.mesh, largest(len(transport.mesh.patches), transport.rays_per_patch)
    patch = np.flatnonzero((transport.exchange.areas > 0) & transport.reflecting)
    unit = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    half = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])
    corners = np.where(mesh.triangular[patch][:, None, None], half, unit)
    done = []
    for depth in range(MAX_DIVISIONS):
        world = mesh.at(patch[:, None], corners[..., 0], corners[..., 1])
        n = len(patch)
        factor = polygon_factors(np.broadcast_to(spot.position, (n, 3)),
                                 np.broadcast_to(spot.normal, (n, 3)), world)
        large = (factor > most) | ((factor > 0) & near_lamps(transport, patch, world, NEAR_LAMP).any(axis=1))
        large &= depth < MAX_DIVISIONS - 1
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
    """Each element divided into four (4k, 4, 2)."""
    a, b, c, d = np.moveaxis(corners, 1, 0)
    ab, bc, cd, da, m = (a + b) / 2, (b + c) / 2, (c + d) / 2, (d + a) / 2, (a + b + c + d) / 4
    quads = np.stack([np.stack(q, axis=1) for q in (
        (a, ab, m, da), (ab, b, bc, m), (m, bc, c, cd), (da, m, cd, d))], axis=1)
    ac = (a + c) / 2
    triangles = np.stack([np.stack(q, axis=1) for q in (
        (a, ab, ac, ac), (ab, b, bc, bc), (ac, bc, c, c), (bc, ac, ab, ab))], axis=1)
    return np.where(triangular[:, None, None, None], triangles, quads).reshape(-1, 4, 2)
