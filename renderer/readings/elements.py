"""Mean direct light over the part of each surface element that a meter sees.

The light of a near lamp varies much across an element. Where a body hides the brightest part from the meter,
the light at the middles of elements is wrong by errors of one sign, which refinement does not reveal: 0.28 %
on the floor below an opaque uplight, with a bar of 0.05 %.
"""

from dataclasses import dataclass

import numpy as np

from renderer.radiometry.polygons import exchanged
from renderer.radiometry.quadrature import GAUSS
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.transport.direct.direct import unoccluded
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.rays.sampling import Nets, Stream
from renderer.transport.sensors import Spread, direct_on
from renderer.transport.transport import Transport


@dataclass(frozen=True)
class Seen:
    """The visible parts of elements (k).

    share : (replicas, k) visible share of each element
    middle : (k, 2) s and t of the middle of its visible part
    row : (k,) row of the element in `places` and `past`; -1 for an element that is seen whole
    places : (n, replicas, rays, 2) ends of the rays, as s and t
    past : (n, replicas, rays) exchange with the meter at these places, 0 where hidden, up to a constant
    factor
    """

    share: np.ndarray
    middle: np.ndarray
    row: np.ndarray
    places: np.ndarray
    past: np.ndarray

    def of(self, which: np.ndarray) -> "Seen":
        """The visible parts of some of the elements."""
        return Seen(self.share[:, which], self.middle[which], self.row[which], self.places, self.past)


def all_seen(mesh: Mesh, patch: np.ndarray, corners: np.ndarray, replicas: int) -> Seen:
    """`Seen` for elements of which nothing is hidden from the meter.

    patch : (k,); corners : (k, 4, 2) as s and t
    """
    triangular = mesh.triangular[patch][:, None]
    middle = np.where(triangular, corners[:, :3].mean(axis=1), corners.mean(axis=1))
    none = np.zeros((0, replicas, 1, 2))
    return Seen(np.ones((replicas, len(patch))), middle, np.full(len(patch), -1), none, none[..., 0])


def seen_past(seen: Seen, doubtful: np.ndarray, places: np.ndarray, worth: np.ndarray,
              clear: np.ndarray) -> Seen:
    """`Seen` with the results of rays to doubtful elements.

    seen : of all elements, as if nothing were hidden; doubtful : (n,) indices of the elements with rays
    places : (n, replicas, rays, 2) ends of the rays, as s and t
    worth : (n, replicas, rays) unobstructed exchange with the meter, up to a constant factor
    clear : (n, replicas, rays) whether each ray is unobstructed
    """
    past, share, middle, row = worth * clear, seen.share.copy(), seen.middle.copy(), seen.row.copy()
    total = worth.sum(axis=2)
    share[:, doubtful] = np.where(total > 0, past.sum(axis=2) / np.where(total > 0, total, 1.0), 0.0).T
    some = np.flatnonzero(past.any(axis=(1, 2)) & ~clear.all(axis=(1, 2)))
    row[doubtful[some]] = np.arange(len(some))
    places, past = places[some], past[some]
    middle[doubtful[some]] = np.einsum("npri,npr->ni", places, past) / past.sum(axis=(1, 2))[:, None]
    return Seen(share, middle, row, places, past)


def element_light(transport: Transport, position: np.ndarray, normal: np.ndarray, patch: np.ndarray,
                  corners: np.ndarray, seen: Seen, rays: int) -> np.ndarray:
    """Mean direct illuminance per lumen on the visible parts of elements (replicas, k, n_luminaires) [m⁻²].

    position, normal : (3,) [m], of the meter
    patch : (k,); corners : (k, 4, 2) of the elements, as s and t
    rays : from each element to each luminaire in each replica
    """
    mesh, facing = transport.mesh, transport.mesh.normal[patch]
    world = mesh.at(patch[:, None], corners[..., 0], corners[..., 1])
    bare = unoccluded(mesh.at(patch, *seen.middle.T), facing, transport.luminaires)
    # The light of a near lamp varies as 1/d⁴. Its value at the middle is within 1/400 of the mean below 0.06,
    # and within 1/4,000 below 0.02; the latter where no rays are cast, since other errors are then smaller.
    most = 0.06 if transport.ray_scene is not None else 0.02
    steep = near_lamps(transport, patch, world, most) & (bare > 0)
    for index in np.flatnonzero(steep.any(axis=0)):
        lum = transport.luminaires[index]
        whole = np.flatnonzero(steep[:, index] & (seen.row < 0))
        st, weight = _gauss(mesh, patch[whole], corners[whole])
        at = mesh.at(patch[whole, None], st[..., 0], st[..., 1])
        weight = weight * exchanged(position, normal, at, facing[whole, None])
        bare[whole, index] = _mean(at, facing[whole], weight, lum, bare[whole, index])
        partly = np.flatnonzero(steep[:, index] & (seen.row >= 0))
        st, weight = (x[seen.row[partly]].reshape(len(partly), x.shape[1] * x.shape[2], *x.shape[3:])
                      for x in (seen.places, seen.past))
        at = mesh.at(patch[partly, None], st[..., 0], st[..., 1])
        bare[partly, index] = _mean(at, facing[partly], weight, lum, bare[partly, index])
    spread = Spread(corners, _places(transport, patch, corners, seen), bare)
    return direct_on(transport, patch, *seen.middle.T, 0, rays, len(seen.share), spread)


def _gauss(mesh: Mesh, patch: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of Gauss' rule on elements (k, 4, 2) as s and t, and weights (k, 4): of third degree on a
    quadrilateral, of second on a triangle."""
    triangular = mesh.triangular[patch][:, None]
    quad = np.stack([np.repeat(GAUSS, 2), np.tile(GAUSS, 2)], axis=1), np.full(4, 0.25)
    triangle = np.array([[1, 1], [4, 1], [1, 4], [2, 2]]) / 6, np.array([1, 1, 1, 0]) / 3
    pq, weight = (np.where(triangular[..., None] if x.ndim > 1 else triangular, x, y)
                  for x, y in zip(triangle, quad, strict=True))
    a, b, d = corners[:, None, 0], corners[:, None, 1], corners[:, None, 3]
    return a + pq[..., :1] * (b - a) + pq[..., 1:] * (d - a), weight


def _mean(at: np.ndarray, normals: np.ndarray, weight: np.ndarray, lum: Luminaire,
          otherwise: np.ndarray) -> np.ndarray:
    """Mean unobstructed illuminance per lumen (k,) of a luminaire at places (k, n, 3) with weights (k, n);
    `otherwise` where all weights are 0."""
    k, n = weight.shape
    light = unoccluded(at.reshape(-1, 3), np.repeat(normals, n, axis=0), [lum])[:, 0].reshape(k, n)
    total = weight.sum(axis=1)
    return np.where(total > 0, (light * weight).sum(axis=1) / np.where(total > 0, total, 1.0), otherwise)


def _places(transport: Transport, patch: np.ndarray, corners: np.ndarray, seen: Seen) -> np.ndarray:
    """Starts of shadow rays (k, replicas, 2), as s and t: all over an element that is wholly visible; on
    others the end of a ray from the meter, drawn in proportion to its exchange."""
    replicas, mesh = len(seen.share), transport.mesh
    square = Nets(replicas, 2, (transport.seed, Stream.PLACES_ON_ELEMENTS, 0)).draw(0, len(patch))
    places = np.stack(mesh.within(patch, corners, square), axis=-1)
    partly = np.flatnonzero(seen.row >= 0)
    past = seen.past[seen.row[partly]]
    lot = np.random.default_rng((transport.seed, Stream.PLACES_SEEN)).random((len(partly), replicas, 1))
    past = np.where(past.any(axis=2, keepdims=True), past, past.mean(axis=1, keepdims=True))
    upto = past.cumsum(axis=2)
    drawn = (upto <= lot * upto[..., -1:]).sum(axis=2).clip(max=past.shape[2] - 1)
    st = seen.places[seen.row[partly]]
    own = np.take_along_axis(st, drawn[..., None, None], axis=2)[:, :, 0]
    # Where nothing of the element is visible in a replica, the place has no weight.
    places[partly] = own
    return places


def near_lamps(transport: Transport, patch: np.ndarray, world: np.ndarray, most: float) -> np.ndarray:
    """Whether half the diagonal of an element is longer than `most` times its distance from a lamp that
    lights it (k, n_luminaires).

    patch : (k,); world : (k, 4, 3) [m] corners of the elements
    """
    middle, normal = world.mean(axis=1), transport.mesh.normal[patch]
    size = np.linalg.norm(world - middle[:, None], axis=2).max(axis=1)
    slack = 1e-9 * transport.mesh.scale
    near = np.zeros((len(patch), len(transport.luminaires)), dtype=bool)
    for index, lum in enumerate(transport.luminaires):
        # The light of a face that touches a wall is finite there: elements of a hundredth of the face are
        # small enough.
        large = np.flatnonzero(
            size > np.maximum(most * lum.distance(middle - lum.center), 0.01 * np.sqrt(lum.area)))
        if len(large):
            near[large, index] = lum.may_light(world[large], normal[large], slack)
    return near
