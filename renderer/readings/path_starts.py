"""Where the paths of a reading start: at a meter, along a line of sight, or all over a surface."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from renderer.readings.meter_place import MeterPlace
from renderer.transport.factors.contour import frames
from renderer.transport.rays.sampling import cosine_direction_each
from renderer.transport.transport import Transport


@dataclass(frozen=True)
class Sight:
    """The start of paths along sight lines.

    origin : (3,) [m] of the eye, off surfaces
    directions : sight lines (…, 3), of unit length, from points (…, 2) of the unit square
    """

    origin: np.ndarray
    directions: Callable[[np.ndarray], np.ndarray]

    @property
    def key(self) -> bytes:
        """Differs between different sights."""
        return self.origin.tobytes() + self.directions(np.array([[0.1, 0.1], [0.9, 0.3]])).tobytes()


@dataclass(frozen=True)
class WholeSurface:
    """The start of paths all over the exposed area of a surface. index : of the surface"""

    index: int

    @property
    def key(self) -> bytes:
        """Differs between different surfaces."""
        return str(self.index).encode()


PathStart = MeterPlace | Sight | WholeSurface


@dataclass(frozen=True)
class Beginnings:
    """The first places that paths reach.

    met : (k,) patch, negative for none
    places : (3, k) [m] on it
    emitted : (k,) π times the luminance per lumen toward the eye of a luminaire seen there [m⁻²]; None where
      luminaires are not seen
    """

    met: np.ndarray
    places: np.ndarray
    emitted: np.ndarray | None = None


def begin(transport: Transport, starts: list[PathStart], square: np.ndarray) -> Beginnings:
    """The first places of paths from several starts of one kind.

    square : (2, n_starts · k) points of the unit square, those of one start after those of another
    """
    each = square.shape[1] // len(starts)
    if isinstance(starts[0], WholeSurface):
        return _all_over(transport, starts, square, each)
    origins = np.repeat(np.array([start.origin for start in starts]).T, each, axis=1)
    if isinstance(starts[0], MeterPlace):
        turn = frames(np.array([start.normal for start in starts])).astype(np.float32).reshape(-1, 9)
        along = cosine_direction_each(square, np.repeat(turn.T, each, axis=1))
        return Beginnings(*meeting(transport, origins, along))
    parts = np.split(square.T, len(starts))
    along = np.concatenate([start.directions(part) for start, part in zip(starts, parts, strict=True)]).T
    met, places = meeting(transport, origins, along)
    return Beginnings(met, places, _emitted(transport, met, along))


def meeting(transport: Transport, origins: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The patch (k,) that each ray meets first, negative for none, and the place (3, k) [m] on it.

    origins, along : (3, k) [m] off surfaces, and of any length
    """
    mesh = transport.mesh
    met = transport.eye.first_hit(origins.T, along.T)
    found = np.maximum(met, 0)
    normal, along = mesh.normal.take(found, axis=0).T, along.astype(float)
    height = np.einsum("ik,ik->k", mesh.corners[:, 0].take(found, axis=0).T - origins, normal)
    slope = np.einsum("ik,ik->k", along, normal)
    return met, origins + height / np.where(slope == 0, -1.0, slope) * along


def _all_over(transport: Transport, starts: list[WholeSurface], square: np.ndarray, each: int) -> Beginnings:
    """Places of even density over surfaces: the first number chooses the patch and a place along it."""
    mesh, areas = transport.mesh, transport.exchange.areas
    met, first = np.empty(square.shape[1], dtype=int), np.empty(square.shape[1])
    for k, start in enumerate(starts):
        patches = np.flatnonzero((mesh.surface == start.index) & (areas > 0))
        ends = np.cumsum(areas[patches])
        some = slice(k * each, (k + 1) * each)
        at = square[0, some] * ends[-1]
        chosen = np.minimum(np.searchsorted(ends, at, side="right"), len(patches) - 1)
        met[some] = patches[chosen]
        first[some] = ((at - ends[chosen]) / areas[patches[chosen]] + 1).clip(0, 1 - 1e-9)
    at = np.stack([first, square[1]], axis=-1)
    for patch in np.intersect1d(met, list(mesh.partly)):  # draw again where another surface covers the place
        random, asked = np.random.default_rng((int(patch), int(square[0, 0] * 2**30))), met == patch
        for _ in range(64):
            asked[asked] = mesh.hidden_at(int(patch), at[asked])
            at[asked] = random.random((asked.sum(), 2))
    return Beginnings(met, mesh.spread(met, at[:, None])[:, 0].T)


def _emitted(transport: Transport, met: np.ndarray, along: np.ndarray) -> np.ndarray:
    """π times the luminance per lumen (k,) [m⁻²] of luminaires that sight lines (3, k) meet; 0 elsewhere."""
    found, surface = np.zeros(len(met)), np.where(met >= 0, transport.mesh.surface[met], -1)
    for face, lamp in transport.faces:
        seen = np.flatnonzero(surface == face)
        found[seen] = np.pi * transport.luminaires[lamp].luminance(-along[:, seen].T)
    return found
