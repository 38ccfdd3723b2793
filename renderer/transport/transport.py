"""Everything about light in a room that depends on geometry alone, computed once.

All materials, bands and pictures of a room share it.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from renderer.errors import InputError
from renderer.radiometry.polygons import HORIZON
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.scene.room import Room
from renderer.scene.scene import Scene
from renderer.system.cache import Arrays
from renderer.system.lazy import cached_property
from renderer.system.log import logged
from renderer.transport.direct.direct import direct_on_patches
from renderer.transport.direct.lamp_samples import sampled_direct
from renderer.transport.factors.contour import point_factors
from renderer.transport.factors.exchange import Exchange, between_patches, from_arrays
from renderer.transport.factors.hemisphere_rays import (
    RemoteCast,
    cast,
    look_round,
    rays_of_vertex,
    view_shares,
)
from renderer.transport.factors.method import FormFactorMethod, chosen_method
from renderer.transport.factors.pair_rays import PairVisibility, pair_visibility_from, probe_pairs
from renderer.transport.mesh.build import build_mesh
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.radiosity.replicas import departures
from renderer.transport.rays.ray_scene import RayScene
from renderer.transport.rays.sampling import REPLICAS, Stream


def compute(_name: str, make: Callable[[], Arrays]) -> Arrays:
    """The arrays that `make` returns, without a cache."""
    return make()


@dataclass
class Transport:
    """The mesh of a room and its operators, per lumen and per unit of radiosity. Each is computed at its
    first use.

    room, mesh, luminaires, seed
    faces : surface and luminaire of each luminaire's face
    rays_per_patch : requested number; 0 where nothing can stand between two points
    ray_scene : None where nothing can stand between two points
    remember : called with a name and a function that computes arrays; returns those arrays
    elsewhere : casts the rays of a large mesh on other machines; None for this machine
    pair_rays_allowed : whether rays may be cast between doubtful pairs only, where these are fewer
    sampled : whether direct light on patches is computed by random draws, for readings by final gathering
    meters, placed : meters in this room by place, and their places; scenes that differ in materials or lamps
      reuse them
    """

    room: Room
    mesh: Mesh
    luminaires: list[Luminaire]
    n_surfaces: int
    faces: list[tuple[int, int]]
    rays_per_patch: int
    seed: int
    ray_scene: RayScene | None
    remember: Callable[[str, Callable[[], Arrays]], Arrays] = compute
    elsewhere: RemoteCast | None = None
    pair_rays_allowed: bool = True
    sampled: bool = False
    seconds: float = field(default=0.0)
    meters: dict = field(default_factory=dict, repr=False)
    placed: dict = field(default_factory=dict, repr=False)

    def _remembered(self, name: str, make: Callable[[], Arrays]) -> Arrays:
        with logged(f"{name} of {len(self.mesh.patches)} patches"):
            return self.remember(name, make)

    @cached_property
    def hits(self) -> np.ndarray:
        """The unknown that each ray from each unknown meets (n_unknowns, rays)."""
        seed = self.seed, Stream.HEMISPHERE_RAYS
        return self._remembered("rays", lambda: {"hits": cast(
            self.mesh, self.ray_scene, self.rays_per_patch, seed, self.elsewhere)})["hits"]

    @cached_property
    def method(self) -> FormFactorMethod:
        """The method of computing form factors on this mesh."""
        return chosen_method(self.mesh.count, self.rays_per_patch, self._pair_visibility())

    def _pair_visibility(self) -> PairVisibility | None:
        """Visibility between patches; None where nothing stands between them, or where rays over hemispheres
        are fewer."""
        if self.ray_scene is None or not self.pair_rays_allowed:
            return None

        def make() -> Arrays:
            seed = self.seed, Stream.PAIR_RAYS
            pair_visibility = probe_pairs(self.mesh, self.ray_scene, self.rays_per_patch, seed)
            return {} if pair_visibility is None else pair_visibility.arrays()

        arrays = self._remembered("sight", make)
        return pair_visibility_from(arrays) if arrays else None

    @cached_property
    def _operator(self) -> Arrays:
        def make() -> Arrays:
            dense = not self.sampled or len(self.mesh.patches) <= 1000  # few rays: a sparse one
            return self.method.factors(self.mesh, lambda: self.hits, dense).arrays()

        return self._remembered("exchange", make)

    @cached_property
    def exchange_of_unknowns(self) -> Exchange:
        """The exchange operator between unknowns; gathered facets are one unknown."""
        return from_arrays(self._operator)

    @cached_property
    def exchange(self) -> Exchange:
        """The exchange operator between patches."""
        if self.mesh.gathering is None:
            return self.exchange_of_unknowns
        return between_patches(self.exchange_of_unknowns, self.mesh.gathering)

    def departures(self, radiosity: np.ndarray) -> np.ndarray:
        """Irradiance of unknowns with each replica of the operator minus irradiance with the whole operator
        (replicas, n_unknowns, n_bands) [W m⁻²]. Departures of independent replicas would be `stretch` times
        larger. radiosity : (n_patches, n_bands)"""
        more = partial(self.method.change, self.mesh, self.exchange_of_unknowns, lambda: self.hits)
        if self.mesh.gathering is None:
            return departures(self.exchange, more, radiosity)
        means = self.mesh.gathering.weights(self.exchange_of_unknowns.areas) @ radiosity
        return departures(self.exchange_of_unknowns, more, means)

    @property
    def stretch(self) -> float:
        """Factor that scales `departures` to independent replicas."""
        return self.method.stretch(self.mesh.count)

    @cached_property
    def _direct(self) -> Arrays:
        def make() -> Arrays:
            make_direct = sampled_direct if self.sampled and self.replicas > 1 else direct_on_patches
            direct, lost = make_direct(self.mesh, self.exchange_of_unknowns, self.luminaires, self.ray_scene,
                                       (self.seed, Stream.DIRECT_ON_PATCHES), self.replicas)
            return {"direct": direct, "lost": lost}

        return self._remembered("direct", make)

    @property
    def direct_replicas(self) -> np.ndarray:
        """Mean illuminance of each patch per lumen (replicas, n_patches, n_luminaires) [m⁻²]."""
        direct = self._direct["direct"]
        return direct if self.mesh.group is None else direct[:, self.mesh.group]

    @property
    def lost(self) -> np.ndarray:
        """Share of each luminaire's lumens that meets no surface (n_luminaires,)."""
        return self._direct["lost"]

    @property
    def rays(self) -> int:
        """Number of rays cast so far; without the camera's rays where the solve needs none."""
        return self.ray_scene.rays if self.ray_scene is not None else 0

    @cached_property
    def direct(self) -> np.ndarray:
        """Mean illuminance of each patch per lumen (n_patches, n_luminaires) [m⁻²]."""
        return self.direct_replicas.mean(axis=0)

    @cached_property
    def eye(self) -> RayScene:
        """The scene for a camera's rays, which are cast even where the solve needs no rays."""
        return self.ray_scene or RayScene(self.mesh)

    @property
    def replicas(self) -> int:
        """Number of replicas of the rays; 1 where none is cast, or they are too few to divide."""
        return self.method.replicas(self.mesh.count)

    @property
    def factors(self) -> int:
        """Largest number of factors that the operator holds."""
        return self.method.entries(self.mesh.count)

    def at_vertices(self, radiosity: np.ndarray, received: np.ndarray, replica: int | None,
                    shown: bool) -> np.ndarray:
        """Irradiance of each vertex by the patches (n_vertices, n_bands) [W m⁻²].

        radiosity, received : (n_patches, n_bands) light that each patch sends, and irradiance by the others
        replica : index of a replica of the rays; None for all rays
        shown : True for pictures, which show light at vertices; False for readings, which use the patches'
            means and take only the variation across patches from the vertices, with fewer rays
        """
        if self.ray_scene is not None and self.replicas == 1:
            return self.mesh.around_vertices @ received
        every, replicas = self.to_vertices if shown else self.to_vertices_read
        share = every if replica is None else replicas[replica]
        if self.mesh.group is None:
            return share @ radiosity.astype(share.dtype)
        found = self.mesh.around_vertices @ received
        found[~self.mesh.gathered] = share @ radiosity.astype(share.dtype)
        return found

    @cached_property
    def to_vertices(self) -> tuple:
        """Irradiance of each vertex per unit radiosity of each patch (n_vertices, n_patches): with all rays,
        and with each replica."""
        return self._from_vertices("vertices", self.rays_per_patch)

    @cached_property
    def to_vertices_read(self) -> tuple:
        """`to_vertices` with the number of rays that readings need."""
        if self.ray_scene is None:
            return self.to_vertices
        return self._from_vertices("vertices read", rays_of_vertex(self.rays_per_patch))

    def _from_vertices(self, name: str, rays: int) -> tuple:
        mesh = self.mesh
        points, normals = self._vertex_points()
        if self.mesh.group is not None:  # vertices of gathered facets receive their group's irradiance
            points, normals = points[~mesh.gathered], normals[~mesh.gathered]
        if self.ray_scene is None:
            lifted = points + HORIZON / 2 * mesh.scale * normals
            return self._remembered(name, lambda: {"factors": point_factors(
                lifted, normals, mesh)})["factors"], ()
        lifted = self.ray_scene.off(points, normals)
        hits = self._remembered(name, lambda: {"hits": look_round(
            lifted, normals, self.ray_scene, rays, (self.seed, Stream.VERTEX_RAYS))})["hits"]
        return view_shares(hits, len(mesh.patches)), tuple(
            view_shares(replica, len(mesh.patches)) for replica in np.split(hits, REPLICAS, axis=1))

    @cached_property
    def reflecting(self) -> np.ndarray:
        """Whether each patch reflects (n_patches,): faces of luminaires are black."""
        return ~np.isin(self.mesh.surface, [surface for surface, _ in self.faces])

    def _vertex_points(self) -> tuple[np.ndarray, np.ndarray]:
        """Points (n_vertices, 3) [m] where vertices receive light, and normals. Each point is moved by a
        thousandth of the distance toward the exposed patches around it, because on an edge or under an object
        light has no single value."""
        mesh = self.mesh
        share = np.where(self.reflecting, self.exchange.areas / mesh.area, 0.0)
        corner = mesh.patches.ravel()
        # A vertex is moved toward exposed patches, by weight, and toward covered ones only where no patch is
        # exposed.
        weight = np.repeat(np.where(share > 0.5, 1.0, 1e-9 + 1e-3 * share), 4)
        total = np.bincount(corner, weight, len(mesh.vertices))
        target = np.stack([np.bincount(corner, weight * np.repeat(mesh.centroid[:, k], 4),
                                       len(mesh.vertices)) for k in range(3)], axis=1)
        target /= total[:, None]
        normals = np.zeros_like(mesh.vertices)
        normals[corner] = np.repeat(mesh.normal, 4, axis=0)
        return mesh.vertices + 1e-3 * (target - mesh.vertices), normals


def compute_transport(scene: Scene, patch_size: float, rays: int, seed: int,
                      remember=compute, elsewhere: RemoteCast | None = None, pair_rays_allowed: bool = True,
                      sampled: bool = False) -> Transport:
    """Divide the room into patches and compute the exchange and the direct light between them.

    patch_size : [m]; rays : of each patch, a power of 2, or 0 where nothing can stand between two patches
    remember, elsewhere, pair_rays_allowed, sampled : as in `Transport`
    Raises InputError where objects fill the room.
    """
    started = time.perf_counter()
    with logged(f"{scene.title}: mesh of patches of {patch_size:.3g} m"):
        mesh, luminaires = build_mesh(scene, patch_size, not sampled), scene.placement.luminaires
    faces = [(k, s.luminaire) for k, s in enumerate(scene.surfaces) if s.luminaire is not None]
    transport = Transport(scene.room, mesh, luminaires, len(scene.surfaces), faces, rays, seed,
                          RayScene(mesh) if rays else None, remember, elsewhere, pair_rays_allowed, sampled)
    if not transport.exchange.areas.any():
        names = ", ".join(repr(body.name) for body in scene.bodies)
        raise InputError(f"{scene.path}: objects {names} fill the whole room. "
                         "Make them smaller.")
    _ = transport.lost  # computes direct light, so that its time is logged with this step
    if transport.replicas == 1:
        transport.__dict__.pop("hits", None)  # no longer needed, and large
    transport.seconds = time.perf_counter() - started
    return transport


def refuse_hidden(scene: Scene, transport: Transport, most: float = 0.05) -> None:
    """Raise InputError where a luminaire's light does not get into the room.

    most : share of its lumens that may be lost by sampling error
    """
    for index in np.flatnonzero(np.abs(transport.lost) > most):
        raise InputError(f"{scene.path}: luminaires[{index}] {transport.luminaires[index].name!r} sends "
                         f"{transport.lost[index]:.0%} of its light into a surface that it touches or an "
                         "object that covers it. Move it clear, or turn its normal into the room.")
