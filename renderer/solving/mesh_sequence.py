"""One scene solved several times, on ever coarser meshes: what the error bars of its readings come from."""

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
from renderer.transport.radiosity.solve import FOR_BARS

PATCHES_OF_A_CHEAP_MESH = 4000
"""Patches that a finer mesh may have without a second thought."""
MAX_PATCHES_OF_COARSER = 30_000
"""Patches, at most, of the mesh that tells another's error."""
MIN_PATCH_SIZE_RATIO = 1.25
"""How many times as long patches of one mesh are as those of another, at least, to tell its error."""


@dataclass(frozen=True)
class MeshSequence:
    """One scene in RGB, solved several times: how far apart these are tells how far a reading may err.

    meshes : as it is, and on one or two other meshes, each coarser than the one before; or on a finer one
    replicas : by each replica of the rays, none where none is cast; of the second mesh, whose rays are fewer,
        where the first has none
    """

    meshes: tuple[RadiosityField, ...]
    replicas: list[RadiosityField]

    @property
    def steps(self) -> tuple[float, ...]:
        """How many times as long patches are from each mesh to the next."""
        sizes = [each.transport.mesh.size for each in self.meshes]
        return tuple(longer / shorter for shorter, longer in pairwise(sizes))


def make_mesh_sequence(light: RadiosityField, plan: Plan, store: TransportStore) -> MeshSequence:
    """A scene in RGB, solved as error bars need it: on this mesh and on two, each coarser than the one
    before, or as many as can be; on a finer one where none can.

    light : on this mesh, in any bands; plan : what made it; store : where transports are shared
    """
    scene, transport = light.scene, light.transport

    def on_this() -> tuple[RadiosityField, list[RadiosityField]]:
        # If it is in RGB, a copy, lest it hold itself.
        fine = replace(light) if light.bands.name == "rgb" else solve_field(
            scene, band_set("rgb"), transport, FOR_BARS)
        return fine, fine.by_replica() if transport.replicas > 1 else []

    def on_another(plan: Plan) -> RadiosityField:
        return solve_field(scene, band_set("rgb"), store.transport(scene, plan, transport.seed + 1), FOR_BARS)

    # Like with like: factors of middles and of whole patches err apart, and might err together by chance.
    like = replace(plan, pair_rays_allowed=not isinstance(transport.method, HemisphereRays))
    patches = transport.mesh.count
    times = max(2.0, float(np.sqrt(patches / MAX_PATCHES_OF_COARSER)))
    coarser = [partial(on_another, like.times(k * times)) for k in (1, 2)]
    (fine, replicas), *others = run_concurrently(on_this, *coarser)
    meshes = [fine]
    for each in others:
        if each.transport.mesh.size < MIN_PATCH_SIZE_RATIO * meshes[-1].transport.mesh.size:
            break  # what has one patch a wall, or is made of facets, cannot be coarser
        meshes.append(each)
    if len(meshes) == 1:  # only finer: as far as that is cheap
        shorter = next((k for k in (8, 4) if patches * k * k < PATCHES_OF_A_CHEAP_MESH), 2)
        meshes.append(on_another(like.times(transport.mesh.size / plan.patch_size / shorter)))
    return MeshSequence(tuple(meshes), replicas if transport.replicas > 1 else meshes[1].by_replica())


def meter_per_transport(make: Callable) -> Callable[[RadiosityField], Meter]:
    """The meter that make(transport) puts in a room, for each light on its own transport, put once."""
    meters = {}

    def of(light: RadiosityField) -> Meter:
        transport = light.transport
        if id(transport) not in meters:
            meters[id(transport)] = make(transport)
        return meters[id(transport)]

    return of
