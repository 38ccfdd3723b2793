"""The virtual photometer: what arrives at a point on a plane of any tilt."""

import numpy as np

from renderer.errors import InputError
from renderer.scene.reading import INSIDE
from renderer.transport.contour import HORIZON, polygon_factors
from renderer.transport.direct import direct_at
from renderer.transport.field import Sensor, direct_on, emitted, seen_from, sense
from renderer.transport.transport import Transport
from renderer.transport.visibility import STAND_OFF

LARGEST = 2.5e-4
"""Surfaces are divided until no element fills more of the meter's view: 1/4000. Then the light
on an element may be taken at its middle."""
DEEPEST = 24
READING_RAYS = 4096
"""Shadow rays from the meter itself to each luminaire."""
ELEMENT_RAYS = 16
"""Shadow rays from each element; their errors average out over thousands of elements."""


def place(transport: Transport, position: np.ndarray, normal: np.ndarray, where: str) -> np.ndarray:
    """A meter's position (3,), lifted off any surface that it touches. Raises InputError.

    A meter on a floor stands on it; in a corner it touches three surfaces and leaves all three.
    """
    refuse_outside(transport, position, where)
    lift = HORIZON if transport.visibility is None else STAND_OFF
    position, touched = off_surfaces(transport, position, lift)
    if (touched @ normal < -1 + 1e-9).any():
        raise InputError(f"{where} faces the surface it lies on (normal {_short(normal)}) and sees "
                         "nothing. Turn its normal round.")
    refuse_inside(transport, position, where)
    for lum in transport.luminaires:
        if lum.outline is None and np.linalg.norm(position - lum.center) < 1e-6 * transport.mesh.scale:
            raise InputError(f"{where}: position {_short(position)} is on the point luminaire "
                             f"{lum.name!r}, where illuminance has no limit. Move one of them.")
    return position


def off_surfaces(transport: Transport, position: np.ndarray,
                 lift: float) -> tuple[np.ndarray, np.ndarray]:
    """A point lifted off every surface it touches, and the normals of those (k, 3).

    lift : relative to the room's longest side; a surface nearer than this is touched.
    """
    mesh = transport.mesh
    lift *= mesh.scale
    height = np.einsum("ki,ki->k", position - mesh.corners[:, 0], mesh.normal)
    s, t = mesh.inside(np.arange(len(mesh.patches)), position)
    edge = 1e-6
    on = (s >= -edge) & (t >= -edge) & np.where(
        mesh.triangular, s + t <= 1 + edge, (s <= 1 + edge) & (t <= 1 + edge))
    on &= (np.abs(height) <= lift) & (mesh.twin < 0) & (transport.exchange.areas > 0)
    touched = mesh.normal[on]
    touched = np.unique(np.round(touched, 6), axis=0)
    return np.clip(position, *mesh.bounds) + lift * touched.sum(axis=0), touched


def refuse_outside(transport: Transport, position: np.ndarray, where: str) -> None:
    """Raise InputError for a point outside the room."""
    slack = INSIDE * transport.mesh.scale
    low, high = transport.mesh.bounds
    if (position < low - slack).any() or (position > high + slack).any():
        raise InputError(f"{where}: position {_short(position)} is outside the room, which reaches "
                         f"from {_short(low)} to {_short(high)} m. Move it into the room.")


def refuse_inside(transport: Transport, position: np.ndarray, where: str) -> None:
    """Raise InputError for a point inside a solid."""
    if transport.visibility is not None:
        # From inside a solid every direction ends on the back of a surface.
        probes = np.vstack([np.eye(3), -np.eye(3), [[0.6, 0.64, 0.48]]])
        seen = transport.visibility.first_hit(np.tile(position, (len(probes), 1)), probes)
        if (seen < 0).sum() > len(probes) // 2:
            raise InputError(f"{where}: position {_short(position)} is inside an object. "
                             "Move it into the open room.")


def _short(xyz: np.ndarray) -> str:
    return "[" + ", ".join(f"{x:.6g}" for x in xyz) + "]"


def direct_reading(transport: Transport, position: np.ndarray, normal: np.ndarray,
                   seed: int) -> np.ndarray:
    """Illuminance per lumen of each luminaire, straight from it (n_luminaires,) [m⁻²]."""
    return direct_at(position[None], normal[None], transport.luminaires, transport.visibility,
                     (transport.seed, 5, seed), READING_RAYS)[0]


def indirect_sensor(transport: Transport, position: np.ndarray, normal: np.ndarray,
                    seed: int) -> Sensor:
    """What the surfaces send to a meter: one row whose value is indirect irradiance."""
    patch, corners, factor, whole = _elements(transport, position, normal)
    if transport.visibility is not None:
        square = np.random.default_rng((transport.seed, 6, seed)).random((len(patch), 2))
        targets = _within(transport.mesh, patch, corners, square)
        lifted = transport.visibility.off(targets, transport.mesh.normal[patch])
        factor = factor * transport.visibility.clear(np.broadcast_to(position, lifted.shape), lifted)
        seen = factor > 0
        patch, corners, factor, whole = (x[seen] for x in (patch, corners, factor, whole))
    triangular = transport.mesh.triangular[patch]
    middle = np.where(triangular[:, None], corners[:, :3].mean(axis=1), corners.mean(axis=1))
    # A whole patch has its mean, which no hot spot under a near lamp can falsify.
    light = transport.direct[patch]
    divided = np.flatnonzero(~whole)
    light[divided] = direct_on(transport, patch[divided], *middle[divided].T, seed, ELEMENT_RAYS)
    return sense(transport, 1, np.zeros(len(patch), dtype=int), patch, *middle.T, factor, light)


def luminance_sensor(transport: Transport, position: np.ndarray, direction: np.ndarray, where: str):
    """What an eye sees along one direction: a sensor of one row, and the lamps' part (1, n)."""
    refuse_outside(transport, position, where)
    eye, _ = off_surfaces(transport, position, 2 * STAND_OFF)
    refuse_inside(transport, eye, where)
    seen = seen_from(transport, eye, direction[None] / np.linalg.norm(direction))
    if seen[0][0] < 0:
        raise InputError(f"{where}: nothing is seen along {_short(direction)} from {_short(position)}. "
                         "Look into the room.")
    row, weight = np.zeros(1, dtype=int), np.ones(1)
    light = direct_on(transport, *seen, 0, READING_RAYS)
    return (sense(transport, 1, row, *seen, weight, light), emitted(transport, 1, row, seen[0], weight))


def _elements(transport: Transport, position: np.ndarray, normal: np.ndarray):
    """Patches divided until none fills much of the view: patch, corners (k, 4, 2), factor, and
    whether it is a whole patch."""
    mesh = transport.mesh
    patch = np.flatnonzero((transport.exchange.areas > 0) & transport.reflecting)
    unit = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    half = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])
    corners = np.where(mesh.triangular[patch][:, None, None], half, unit)
    done = []
    for depth in range(DEEPEST):
        world = mesh.at(patch[:, None], corners[..., 0], corners[..., 1])
        n = len(patch)
        factor = polygon_factors(np.broadcast_to(position, (n, 3)),
                                 np.broadcast_to(normal, (n, 3)), world)
        large = (factor > LARGEST) if depth < DEEPEST - 1 else np.zeros(n, dtype=bool)
        kept = ~large & (factor > 0)
        done.append((patch[kept], corners[kept], factor[kept], np.full(kept.sum(), depth == 0)))
        if not large.any():
            break
        corners = _quarters(corners[large], mesh.triangular[patch[large]])
        patch = np.repeat(patch[large], 4)
    return tuple(np.concatenate(parts) for parts in zip(*done, strict=True))


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


def _within(mesh, patch: np.ndarray, corners: np.ndarray, square: np.ndarray) -> np.ndarray:
    """A point of each element (k, 3) from points of the unit square (k, 2)."""
    p, q = square.T[..., None]
    triangular = mesh.triangular[patch][:, None]
    fold = triangular & (p + q > 1)
    p, q = np.where(fold, 1 - p, p), np.where(fold, 1 - q, q)
    a, b, d = corners[:, 0], corners[:, 1], corners[:, 3]
    st = a + p * (b - a) + q * (d - a)
    return mesh.at(patch, st[:, 0], st[:, 1])
