"""A solved room and its readings with error bars."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from renderer.colour.bands import BandSet, narrow_bands
from renderer.colour.lamps import spectral_flux
from renderer.readings.meter_place import place
from renderer.readings.path_starts import PathStart
from renderer.readings.photometer import Meter, make_meter
from renderer.readings.reading import Reading
from renderer.readings.spectrum import reconstructed
from renderer.readings.uncertainty import band_error, half_widths
from renderer.scene.scene import Scene
from renderer.solving.gathered import BatchReading, GatherFields, gather_fields, read_batch
from renderer.solving.mesh_sequence import MeshSequence, make_mesh_sequence, meter_per_transport
from renderer.solving.plan import Plan, make_plan
from renderer.solving.radiosity_field import RadiosityField, solve_field
from renderer.solving.transport_store import Progress, TransportStore
from renderer.solving.watch import Watch
from renderer.system.lazy import cached_property
from renderer.system.log import LOGGER
from renderer.system.threads import run_concurrently
from renderer.transport.transport import Transport, refuse_hidden


@dataclass(frozen=True)
class Solution(RadiosityField):
    """Light in a room, with error bars.

    plan : of its solve; store : of transports on this and on other meshes
    watch : reports the progress of long readings
    """

    plan: Plan
    store: TransportStore
    watch: Watch = field(default_factory=Watch, repr=False, compare=False)

    def __repr__(self) -> str:
        return (f"Solution({self.scene.title!r}, {self.bands.name} bands, "
                f"{self.transport.mesh.count} patches)")

    def photometer(self, position, normal, name: str = "photometer") -> Reading:
        """Read a meter at a point (3,) [m] that faces along `normal` (3,). Raises InputError."""
        if self.by_paths(1):
            return self.read_at([(position, normal, name)])[0]
        return self._by_elements(position, normal, name)

    def _by_elements(self, position, normal, name: str) -> Reading:
        where = f"{self.scene.path}: photometer {name!r}"
        position, normal = np.asarray(position, dtype=float), np.asarray(normal, dtype=float)
        facing = normal / np.linalg.norm(normal)
        at = self.meters(position, facing, where)
        meter = at(self)
        direct, indirect = self.read(meter)
        return self._logged(Reading(
            name, position, normal, direct, indirect.sum(axis=0),
            *self._power(meter.direct.mean(axis=0), indirect.sum(axis=0)), self.bands, *self._errors(at),
            indirect @ self.bands.luminous, indirect, self._rgb_lx(at)))

    def _logged(self, reading: Reading) -> Reading:
        LOGGER.debug("%r: direct %.6g lx, by %s", reading.name, reading.direct_lx, ", ".join(
            f"{surface.name} {lx:.6g} lx" for surface, lx in zip(self.scene.surfaces, reading.by_surface_lx,
                                                                 strict=True)))
        return reading

    def _rgb_lx(self, at: Callable[[RadiosityField], Meter]) -> float | None:
        """The reading in RGB [lx], which its error bar needs anyway; None for bands other than 31."""
        own = self.mesh_sequence.meshes[0]
        return float(own.read_lx(at(own)).sum()) if self.bands.name == "31" else None

    def meters(
        self, position: np.ndarray, normal: np.ndarray, where: str
    ) -> Callable[[RadiosityField], Meter]:
        """The meter at a point (3,) [m] that faces along a unit normal (3,), as a function from the light on
        this mesh or on another for its error. Raises InputError."""
        own = make_meter(self.transport, position, normal, where)
        return meter_per_transport(lambda transport: own if transport is self.transport else make_meter(
            transport, position, normal, where, own))

    def _power(self, straight: np.ndarray, indirect: np.ndarray
               ) -> tuple[np.ndarray, np.ndarray] | tuple[None, None]:
        """Spectral irradiance at a meter at 1 nm (471,) [W m⁻² nm⁻¹], and irradiance in each band (n_bands,)
        [W m⁻²]; None where the bands give no spectrum.

        straight : (n_luminaires,) direct illuminance per lumen of each luminaire [m⁻²]
        indirect : (n_bands,) indirect irradiance
        """
        if not self.bands.knows_spectrum or self.bands.watts is None:
            return None, None
        lamps = np.array([spectral_flux(lamp, lum.lumens) for lum, lamp in
                          zip(self.scene.luminaires, self.scene.lamps, strict=True)]).reshape(-1, 471)
        reflected = reconstructed(indirect, self.flux.sum(axis=0), lamps.sum(axis=0), self.bands)
        return straight @ lamps + reflected, straight @ self._lamp_watts + indirect * self.bands.watts

    @cached_property
    def _lamp_watts(self) -> np.ndarray:
        """Power of each luminaire in each band (n_luminaires, n_bands) [W]."""
        return self.scene.watts(self.bands)

    def photometers(self) -> list[Reading]:
        """Read the scene's photometers."""
        return self.read_at([(p.position, p.normal, p.name) for p in self.scene.photometers])

    def read_at(self, spots: list[tuple]) -> list[Reading]:
        """Read a meter at each (position, normal, name), on every core. Raises InputError."""
        if not spots:
            return []
        if self.by_paths(len(spots)):
            return self._by_paths(spots)
        self.make_ready()
        return run_concurrently(*[partial(self._by_elements, *spot) for spot in spots])

    def _by_paths(self, spots: list[tuple]) -> list[Reading]:
        spots = [(np.asarray(at, dtype=float), np.asarray(normal, dtype=float), name)
                 for at, normal, name in spots]
        batch = self.batch([place(self.transport, at, normal / np.linalg.norm(normal),
                                  f"{self.scene.path}: photometer {name!r}") for at, normal, name in spots])
        errors, bands = batch.errors(self.quadrature).tolist(), batch.band_errors()
        readings = []
        rgb = batch.meshes[0].sum(axis=1).tolist() if self.bands.name == "31" else [None] * len(spots)
        for k, (position, normal, name) in enumerate(spots):
            power, watts = self._power(batch.straight[k], batch.indirect[k])
            readings.append(self._logged(Reading(
                name, position, normal, batch.direct[k], batch.indirect[k], power, watts, self.bands,
                *errors[k], bands[k], batch.by_surface_lx[k], None, rgb[k])))
        return readings

    def by_paths(self, meters: int) -> bool:
        """Whether that many meters are read by paths."""
        by_paths = self.plan.gathered or self.plan.by_paths(meters)
        return by_paths and any(lum.lumens for lum in self.scene.luminaires)

    def batch(self, spots: list[PathStart], areas: bool = False, straight: bool = True) -> BatchReading:
        """Read meters together, by paths. areas, straight : as in `read_batch`"""
        return read_batch(self, self.gather_fields, spots, self.plan.accuracy, self.quadrature, areas,
                          self.watch, straight=straight)

    @cached_property
    def gather_fields(self) -> GatherFields:
        """The light at the ends of paths, and on other meshes and in other bands for its errors."""
        return gather_fields(self)

    def make_ready(self) -> None:
        """Compute on every core what all readings share, before meters are divided among cores."""
        mesh_sequence = self.mesh_sequence
        _ = [
            each._luminous_read
            for each in (self, *mesh_sequence.meshes, *mesh_sequence.replicas, *self.by_bands)
        ]

    @property
    def quadrature(self) -> float:
        """Relative error of a reading that is the same on every mesh: of sums over measured luminaires'
        openings, and of the energy balance, which is significant where hardly anything absorbs."""
        opening = any(luminaire.opening for luminaire in self.transport.luminaires)
        # Light through a measured luminaire's opening errs by 4e-4 (docs/decisions.md, D52).
        return float(np.hypot(4e-4 if opening else 0.0, self.energy_balance_error))

    def _errors(self, at: Callable[[RadiosityField], Meter]) -> tuple[float, float, float]:
        """Errors of a reading by mesh, sampling and bands [lx]. The first two are computed in RGB on all
        meshes, the last on the coarsest mesh, where it costs little. at : from `meters`"""
        mesh_sequence = self.mesh_sequence
        meshes, replicas = (np.array([each.read_lx(at(each)) for each in some])
                           for some in (mesh_sequence.meshes, mesh_sequence.replicas))
        counted = at(self).counted
        lumens = self.flux @ self.bands.luminous
        counted = 0.0 if counted is None else float(np.linalg.norm(counted * lumens))
        mesh, sampling = half_widths(meshes, replicas, mesh_sequence.steps, self.quadrature, counted)
        these, narrow = (each.read_lx(at(each)).sum() for each in self.by_bands)
        return mesh, sampling, band_error(float(these), float(narrow))

    @cached_property
    def by_bands(self) -> tuple[RadiosityField, RadiosityField]:
        """This scene on the last mesh of its sequence, in these bands and in bands of 2 nm."""
        last = self.mesh_sequence.meshes[-1].transport
        return tuple(solve_field(self.scene, bands, last) for bands in (self.bands, narrow_bands()))

    @cached_property
    def mesh_sequence(self) -> MeshSequence:
        """This scene in RGB on several meshes."""
        return make_mesh_sequence(self, self.plan, self.store)


def solve(scene: Scene, bands: str | None = None, accuracy: float | None = None,
          seed: int | None = None, store: TransportStore | None = None,
          progress: Progress = lambda step: None, plan: Plan | None = None) -> Solution:
    """Solve a scene. A value not given is taken from the scene's [solver] table.

    bands : one of BAND_SETS; accuracy : of readings [1], which determines mesh and rays
    store : transports to share with other scenes of the same geometry; progress : called with each step
    plan : used instead of the plan for the accuracy Raises InputError (the mesh is too large, or a lamp
    shines into a solid) or SolveError (there is no steady state).
    """
    settings = scene.solver
    accuracy = accuracy or settings.accuracy
    seed = settings.seed if seed is None else seed
    store = store or TransportStore()
    plan = plan or make_plan(scene, accuracy, settings.patch_size)
    transport = store.transport(scene, plan, seed, progress)
    refuse_hidden(scene, transport)  # on this mesh only: coarser ones lose more light
    progress(f"{scene.title}: interreflections, {bands or settings.bands} bands")
    return solve_on(scene, scene.band_set(bands or settings.bands), plan, store, transport)


def solve_on(
    scene: Scene, bands: BandSet, plan: Plan, store: TransportStore, transport: Transport
) -> Solution:
    """Solve a scene on a transport already computed."""
    return Solution(**vars(solve_field(scene, bands, transport)), plan=plan, store=store)
