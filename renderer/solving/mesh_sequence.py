"""One scene solved on several meshes, whose differences give the error bars of readings."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from renderer.colour.bands import band_set
from renderer.readings.photometer import Meter
from renderer.solving.plan import Plan
from renderer.solving.radiosity_field import RadiosityField, solve_field
from renderer.solving.transport_store import TransportStore
from renderer.system.threads import run_concurrently
from renderer.transport.factors.method import HemisphereRays
from renderer.transport.radiosity.agglomerate import MIN_PATCH_SIZE_RATIO
from renderer.transport.radiosity.solve import BAR_TOLERANCE


@dataclass(frozen=True)
class MeshSequence:
    """One scene in RGB, solved on several meshes.

    meshes : the mesh that is read, then one or two coarser ones, each coarser than the one before, or a finer
    one
    replicas : solutions with each replica of the rays, none where no ray is cast; on the second mesh, which
      has fewer rays, where the rays of the first are not divided
    """

    meshes: tuple[RadiosityField, ...]
    replicas: list[RadiosityField]

    @property
    def steps(self) -> tuple[float, ...]:
        """Patch size of each mesh over that of the mesh before."""
        sizes = [each.transport.mesh.size for each in self.meshes]
        return tuple(longer / shorter for shorter, longer in pairwise(sizes))


def make_mesh_sequence(light: RadiosityField, plan: Plan, store: TransportStore) -> MeshSequence:
    """A scene solved in RGB for error bars: on this mesh and on up to two coarser ones, or on a finer one
    where no coarser one is possible.

    light : solution on this mesh, in any bands; plan : its plan; store : of transports
    """
    scene, transport = light.scene, light.transport

    def on_this() -> tuple[RadiosityField, list[RadiosityField]]:
        # A copy if the light is in RGB already, because a solution must not refer to itself.
        fine = replace(light) if light.bands.name == "rgb" else solve_field(
            scene, band_set("rgb"), transport, BAR_TOLERANCE)
        return fine, fine.by_replica() if transport.replicas > 1 else []

    def on_another(plan: Plan) -> RadiosityField:
        other = store.transport(scene, plan, transport.seed + 1)
        return solve_field(scene, band_set("rgb"), other, BAR_TOLERANCE)

    # One method on all meshes, because errors of different methods may cancel by chance.
    like = replace(plan, pair_rays_allowed=not isinstance(transport.method, HemisphereRays))
    patches = transport.mesh.count
    times = max(2.0, float(np.sqrt(patches / 30_000)))
    coarser = [partial(on_another, like.times(k * times)) for k in (1, 2)]
    (fine, replicas), *others = run_concurrently(on_this, *coarser)
    meshes = [fine]
    for each in others:
        if each.transport.mesh.size < MIN_PATCH_SIZE_RATIO * meshes[-1].transport.mesh.size:
            break  # one patch for each wall, or facets: no coarser mesh exists
        meshes.append(each)
    if len(meshes) == 1:  # only a finer mesh is possible; 4000 patches cost little
        shorter = next((k for k in (8, 4) if patches * k * k < 4000), 2)
        meshes.append(on_another(like.times(transport.mesh.size / plan.patch_size / shorter)))
    return MeshSequence(tuple(meshes), replicas if transport.replicas > 1 else meshes[1].by_replica())


def meter_per_transport(make: Callable) -> Callable[[RadiosityField], Meter]:
    """Memoise one meter per transport: a function from a light to the meter that make(transport) returns."""
    meters = {}

    def of(light: RadiosityField) -> Meter:
        transport = light.transport
        if id(transport) not in meters:
            meters[id(transport)] = make(transport)
        return meters[id(transport)]

    return of
