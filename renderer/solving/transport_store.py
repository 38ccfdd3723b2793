"""A store of transports. Rooms of one shape share a transport, whatever their materials."""

from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Lock

from renderer.scene.scene import Scene
from renderer.solving.plan import Plan
from renderer.system.cache import Cache
from renderer.transport.factors.hemisphere_rays import RemoteCast
from renderer.transport.transport import Transport, compute, compute_transport

Progress = Callable[[str], None]

MAX_KEPT_FACTORS = 100_000_000
"""Largest number of factors of all transports in the store, about 2 GB; above it the oldest are removed."""


@dataclass
class TransportStore:
    """Transports already computed, one for each geometry and plan.

    cache : on disk, for other runs; None for no cache
    elsewhere : as in `Transport`
    """

    cache: Cache | None = None
    kept: dict = field(default_factory=dict)
    elsewhere: RemoteCast | None = None
    _changing: Lock = field(default_factory=Lock, repr=False)

    def __reduce__(self):
        """Copy for another process. The copy shares only the cache on disk."""
        return TransportStore, (self.cache, {}, self.elsewhere)

    def transport(self, scene: Scene, plan: Plan, seed: int,
                  progress: Progress = lambda step: None) -> Transport:
        """The transport of that scene's geometry, computed once."""
        key = (scene.geometry_key, plan.patch_size, plan.rays, seed, plan.pair_rays_allowed, plan.gathered)
        with self._changing:
            found = self.kept.get(key)
            while found is None and sum(each.factors for each in self.kept.values()) > MAX_KEPT_FACTORS:
                del self.kept[next(iter(self.kept))]
        if found is None:
            progress(f"{scene.title}: form factors")
            found = compute_transport(scene, plan.patch_size, plan.rays, seed, self._remember(key),
                                      self.elsewhere, plan.pair_rays_allowed, plan.gathered)
            with self._changing:
                self.kept[key] = found
        return found

    def _remember(self, key: tuple):
        if self.cache is None:
            return compute
        return lambda name, make: self.cache.arrays(f"{key} {name}", make)
