"""One scene solved on several meshes, from whose differences the error bars of readings come."""

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

    meshes : the mesh that is read, and one or two others, each coarser than the one before; or a finer one
    replicas : by each replica of the rays, none where none is cast; of the second mesh, which has fewer rays,
        where the first has none
    """

    meshes: tuple[RadiosityField, ...]
    replicas: list[RadiosityField]

    @property
    def steps(self) -> tuple[float, ...]:
        """Patch size of each mesh over that of the one before."""
        sizes = [each.transport.mesh.size for each in self.meshes]
        return tuple(longer / shorter for shorter, longer in pairwise(sizes))


def make_mesh_sequence(light: RadiosityField, plan: Plan, store: TransportStore) -> MeshSequence:
    """A scene solved in RGB as error bars need it: on this mesh and on two coarser ones where there are any,
    else on a finer one.

    light : on this mesh, in any bands; plan : its plan; store : of transports
    """
    scene, transport = light.scene, light.transport

    def on_this() -> tuple[RadiosityField, list[RadiosityField]]:
        # A copy where the light is in RGB already: a solution must not refer to itself.
        fine = replace(light) if light.bands.name == "rgb" else solve_field(
            scene, band_set("rgb"), transport, BAR_TOLERANCE)
        return fine, fine.by_replica() if transport.replicas > 1 else []

    def on_another(plan: Plan) -> RadiosityField:
        other = store.transport(scene, plan, transport.seed + 1)
        return solve_field(scene, band_set("rgb"), other, BAR_TOLERANCE)

    # The same method on all meshes: the errors of two methods differ, and may agree by chance.
    like = replace(plan, pair_rays_allowed=not isinstance(transport.method, HemisphereRays))
    patches = transport.mesh.count
    times = max(2.0, float(np.sqrt(patches / 30_000)))
    coarser = [partial(on_another, like.times(k * times)) for k in (1, 2)]
    (fine, replicas), *others = run_concurrently(on_this, *coarser)
    meshes = [fine]
    for each in others:
        if each.transport.mesh.size < MIN_PATCH_SIZE_RATIO * meshes[-1].transport.mesh.size:
            break  # a mesh of one patch a wall, or of facets, cannot be coarser
        meshes.append(each)
    if len(meshes) == 1:  # only a finer mesh is possible: as fine as 4000 patches, which cost little
        shorter = next((k for k in (8, 4) if patches * k * k < 4000), 2)
        meshes.append(on_another(like.times(transport.mesh.size / plan.patch_size / shorter)))
    return MeshSequence(tuple(meshes), replicas if transport.replicas > 1 else meshes[1].by_replica())


def meter_per_transport(make: Callable) -> Callable[[RadiosityField], Meter]:
    """The meter that make(transport) returns for each light, made once for each transport."""
    meters = {}

    def of(light: RadiosityField) -> Meter:
        transport = light.transport
        if id(transport) not in meters:
            meters[id(transport)] = make(transport)
        return meters[id(transport)]

    return of
