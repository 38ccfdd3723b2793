"""Direct light at several meters, with the number of shadow rays that each meter needs."""

from collections.abc import Sequence

import numpy as np

from renderer.readings.final_gather import PATH_REPLICAS
from renderer.readings.meter_place import MeterPlace
from renderer.readings.path_starts import PathStart
from renderer.readings.uncertainty import counted_half_width, student
from renderer.transport.direct.direct import direct_at, hidden_light, unoccluded
from renderer.transport.rays.sampling import Stream
from renderer.transport.transport import Transport

MIN_SHADOW_RAYS, MAX_SHADOW_RAYS = 32, 1 << 14
"""Fewest and most rays from a meter to each luminaire in each replica."""
DIRECT_SHARE = 0.4
"""Share of the requested error that direct light may have, where the whole error is larger than requested."""
ORDER = 0.75
"""Power of the number of rays with which the error of a penumbra falls: the error of the share of a net's
points on one side of a line."""


class StraightLight:
    """Direct illuminance at several meters.

    rays : (n_meters,) shadow rays so far, to each luminaire in each replica
    per_lumen : (PATH_REPLICAS, n_meters, n_luminaires) illuminance per lumen [m⁻²]
    """

    def __init__(self, transport: Transport, spots: Sequence[MeterPlace], lumens: np.ndarray):
        """lumens : (n_luminaires,)"""
        self._transport, self._spots, self._lumens = transport, spots, lumens
        self.rays = np.zeros(len(spots), dtype=int)
        self.per_lumen = np.zeros((PATH_REPLICAS, len(spots), len(lumens)))
        position, normal = (np.array([getattr(spot, name) for spot in spots])
                            for name in ("position", "normal"))
        self._bare = unoccluded(position, normal, transport.luminaires)

    def cast(self, rays: np.ndarray) -> None:
        """Cast more rays from meters that need them. They replace the earlier rays, because one large net has
        a smaller error than several small ones.

        rays : (n_meters,) powers of 2, to each luminaire in each replica
        """
        for count in np.unique(rays[rays > self.rays]):
            some = np.flatnonzero((rays == count) & (rays > self.rays))
            doubtful = self.rays[some, None] == 0
            if not doubtful.all():
                # No rays go to luminaires that together have at most a tenth of the error.
                error2 = np.square(self._of_each(some)).sum(axis=0)
                doubtful = doubtful | (error2 > 0.1 * error2.mean(axis=1, keepdims=True))
            bare = np.where(doubtful, self._bare[some], 0.0)
            found = _kept(self._transport, [self._spots[k] for k in some], int(count), bare)
            self.per_lumen[:, some] = np.where(doubtful, found, self.per_lumen[:, some])
            self.rays[some] = count

    def lx(self) -> np.ndarray:
        """Illuminance by replica (PATH_REPLICAS, n_meters) [lx]."""
        return self.per_lumen @ self._lumens

    def _of_each(self, some: slice | np.ndarray) -> np.ndarray:
        """95 % half-widths of some meters (2, k, n_luminaires) [lx]: from the spread of the replicas, and of
        the count of rays past an edge."""
        spread = student(PATH_REPLICAS) * self.per_lumen[:, some].std(axis=0, ddof=1) / PATH_REPLICAS**0.5
        hidden = hidden_light(self.per_lumen[:, some], self._bare[some], self._transport.luminaires)
        count = counted_half_width(hidden, self.rays[some, None], PATH_REPLICAS)
        return np.stack([spread, count]) * self._lumens

    def counting_errors(self) -> np.ndarray:
        """95 % half-widths of the count of rays past edges (n_meters,) [lx]."""
        return np.linalg.norm(self._of_each(slice(None))[1], axis=1)

    def errors(self) -> np.ndarray:
        """95 % half-widths (n_meters,) [lx]."""
        spread = student(PATH_REPLICAS) * self.lx().std(axis=0, ddof=1) / PATH_REPLICAS**0.5
        return np.hypot(spread, self.counting_errors())

    def wanted(self, limit: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rays that meters need (n_meters,), as for `cast`, and their expected errors with these rays [lx].

        limit : (n_meters,) largest allowed error of the whole reading [lx]
        """
        error = self.errors()
        excess = error / np.maximum(DIRECT_SHARE * limit, 1e-300)
        doubled = np.ceil(np.log2(np.maximum(excess, 1.0)) / ORDER).clip(max=np.log2(MAX_SHADOW_RAYS))
        rays = np.minimum(self.rays * 2 ** doubled.astype(int), MAX_SHADOW_RAYS)
        return rays, error * (self.rays / rays) ** ORDER


class NoStraightLight(StraightLight):
    """Nothing: of meters that read indirect light alone, of sights and of surfaces."""

    def __init__(self, transport: Transport, spots: Sequence[PathStart], lumens: np.ndarray):
        self._transport, self._spots, self._lumens = transport, spots, np.zeros(len(lumens))
        self.rays, self._bare = np.ones(len(spots), dtype=int), np.zeros((len(spots), len(lumens)))
        self.per_lumen = np.zeros((PATH_REPLICAS, len(spots), len(lumens)))

    def cast(self, rays: np.ndarray) -> None:
        """Cast no ray."""


def _kept(transport: Transport, spots: list[MeterPlace], rays: int, bare: np.ndarray) -> np.ndarray:
    """Illuminance per lumen (PATH_REPLICAS, n_meters, n_luminaires) [m⁻²], kept for the next room of this
    shape. bare : (n_meters, n_luminaires) without shadows; 0 for luminaires without rays [m⁻²]"""
    position, normal, origin = (np.array([getattr(spot, name) for spot in spots])
                                for name in ("position", "normal", "origin"))
    key = "straight", rays, bare.tobytes(), origin.tobytes(), normal.tobytes()
    if key not in transport.meters:
        made = direct_at(position, normal, transport.luminaires, transport.ray_scene,
                         (transport.seed, Stream.DIRECT_BESIDE_PATHS), rays, origins=origin,
                         replicas=PATH_REPLICAS, bare=bare)
        if made.size > 1 << 19:  # 4 MB
            return made
        transport.meters[key] = made
    return transport.meters[key]
