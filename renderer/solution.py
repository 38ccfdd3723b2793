"""The light in a room, solved, and what follows from it."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from threading import Lock

import numpy as np

from renderer.cache import Cache
from renderer.colour.bands import BandSet, band_set, narrow_bands
from renderer.colour.lamps import spectral_flux
from renderer.lazy import cached_property
from renderer.plan import Plan, make_plan
from renderer.readings.luminance import luminance_meter
from renderer.readings.photometer import Meter, make_meter
from renderer.readings.reading import Reading
from renderer.readings.reconstruction import reconstructed
from renderer.readings.uncertainty import band_error, half_widths
from renderer.scene.reading import Scene
from renderer.transport.hemisphere import Rows
from renderer.transport.solve import ENOUGH, FOR_BARS, TOLERANCE, radiosity
from renderer.transport.threads import in_threads, together
from renderer.transport.transport import Transport, compute, compute_transport, refuse_hidden

Progress = Callable[[str], None]

CHEAP = 4000
"""Patches that a finer mesh may have without a second thought."""
MANY = 30_000
"""Patches, at most, of the mesh that tells another's error."""
QUADRATURE = 4e-4
"""Share of a reading that light through a measured luminaire's opening may err by (docs/decisions.md)."""
KEPT = 100_000_000
"""Factors of the transports kept for other rooms, some 2 GB; past that the oldest go."""
COARSER = 1.25
"""How many times as long patches of one mesh are as those of another, at least, to tell its error."""


@dataclass
class Rooms:
    """Transports already computed: rooms of one shape share one, whatever their materials.

    cache : where they are kept between runs; None for nowhere
    elsewhere : as in `Transport`
    """

    cache: Cache | None = None
    kept: dict = field(default_factory=dict)
    elsewhere: Rows | None = None
    _changing: Lock = field(default_factory=Lock, repr=False)

    def transport(self, scene: Scene, plan: Plan, seed: int,
                  progress: Progress = lambda step: None) -> Transport:
        """The transport of that scene's geometry, computed once."""
        key = (scene.geometry_key, plan.patch_size, plan.rays, seed, plan.across)
        with self._changing:
            found = self.kept.get(key)
            while found is None and sum(each.factors for each in self.kept.values()) > KEPT:
                del self.kept[next(iter(self.kept))]
        if found is None:
            progress(f"{scene.title}: form factors; {'; '.join(plan.reasons)}")
            found = compute_transport(scene, plan.patch_size, plan.rays, seed, self._remember(key),
                                      self.elsewhere, plan.across)
            with self._changing:
                self.kept[key] = found
        return found

    def _remember(self, key: tuple):
        if self.cache is None:
            return compute
        return lambda name, make: self.cache.arrays(f"{key} {name}", make)


@dataclass(frozen=True)
class Solution:
    """Radiosity of every patch in every band.

    reflectance : (n_surfaces, n_bands); flux : (n_luminaires, n_bands)
    radiosity, received : what each patch sends, and receives by way of the others (n_patches, n_bands)
        [W m⁻² per band; weighted integrals in RGB]
    sample : which independent part of the rays this is solved with; None for all of them
    bands_solved : how many distinct systems of equations that took
    """

    scene: Scene
    bands: BandSet
    plan: Plan
    rooms: Rooms
    transport: Transport
    reflectance: np.ndarray
    flux: np.ndarray
    radiosity: np.ndarray
    received: np.ndarray
    sample: int | None
    bands_solved: int
    seconds: float

    def __repr__(self) -> str:
        return (f"Solution({self.scene.title!r}, {self.bands.name} bands, "
                f"{len(self.transport.mesh.patches)} patches)")

    @property
    def direct_irradiance(self) -> np.ndarray:
        """What each patch receives straight from the luminaires (n_patches, n_bands)."""
        return self.transport.direct @ self.flux

    @property
    def irradiance(self) -> np.ndarray:
        """What each patch receives, direct and indirect (n_patches, n_bands)."""
        return self.direct_irradiance + self.received

    @cached_property
    def vertex_irradiance(self) -> np.ndarray:
        """Indirect light that each vertex receives (n_vertices, n_bands)."""
        return self.transport.at_vertices(self.radiosity, self.received, self.sample, shown=True)

    @cached_property
    def vertex_radiosity(self) -> np.ndarray:
        """Indirect light that each vertex reflects (n_vertices, n_bands)."""
        return self.reflectance[self.transport.mesh.vertex_surface] * self.vertex_irradiance

    @cached_property
    def vertices_read(self) -> np.ndarray:
        """The same as readings take it, about the patches' means (n_vertices, n_bands)."""
        received = self.transport.at_vertices(self.radiosity, self.received, self.sample, shown=False)
        return self.reflectance[self.transport.mesh.vertex_surface] * received

    @cached_property
    def patch_radiosity(self) -> np.ndarray:
        """Indirect light that each patch reflects (n_patches, n_bands)."""
        return self.reflectance[self.transport.mesh.surface] * self.received

    @property
    def energy_balance_error(self) -> float:
        """Largest |absorbed − emitted| / emitted over the bands."""
        absorbed = (1 - self.reflectance[self.transport.mesh.surface]) * self.irradiance
        emitted = self.flux.sum(axis=0)
        apart = np.abs(self.transport.exchange.areas @ absorbed - emitted)
        return float((apart / np.where(emitted > 0, emitted, 1.0)).max(initial=0.0))

    @property
    def worst_patch(self) -> int:
        """Where the equation is solved least well."""
        left = self.reflectance[self.transport.mesh.surface] * self.irradiance - self.radiosity
        return int((self.transport.exchange.areas * np.abs(left).sum(axis=1)).argmax())

    def photometer(self, position, normal, name: str = "photometer") -> Reading:
        """Read a meter at a point (3,) [m] that faces along normal (3,). Raises InputError."""
        where = f"{self.scene.path}: photometer {name!r}"
        position, normal = np.asarray(position, dtype=float), np.asarray(normal, dtype=float)
        facing = normal / np.linalg.norm(normal)
        at = self.meters(position, facing, where)
        meter = at(self)
        direct, indirect = self.read(meter)
        return Reading(name, position, normal, direct, indirect.sum(axis=0),
                       self._power(meter, indirect.sum(axis=0)), self.bands,
                       *self._errors(at))

    def meters(self, position: np.ndarray, normal: np.ndarray, where: str) -> "Callable[[Solution], Meter]":
        """The meter at a point (3,) that faces along a unit normal (3,), on this mesh and on those that tell
        its error. Raises InputError."""
        own = make_meter(self.transport, position, normal, where)
        return placed(lambda transport: own if transport is self.transport else make_meter(
            transport, position, normal, where, own))

    def _power(self, meter: Meter, indirect: np.ndarray) -> np.ndarray | None:
        """What arrives at a meter at 1 nm (471,) [W m⁻² nm⁻¹]: straight from each lamp exactly, by way of the
        surfaces as the bands say (n_bands,); None where these know no spectrum."""
        if not self.bands.knows_spectrum:
            return None
        lamps = np.array([spectral_flux(lamp, lum.lumens) for lum, lamp in
                          zip(self.scene.luminaires, self.scene.lamps, strict=True)]).reshape(-1, 471)
        reflected = reconstructed(indirect, self.flux.sum(axis=0), lamps.sum(axis=0), self.bands)
        return meter.direct.mean(axis=0) @ lamps + reflected

    def photometers(self) -> list[Reading]:
        """Read the scene's own photometers."""
        return self.read_at([(p.position, p.normal, p.name) for p in self.scene.photometers])

    def read_at(self, spots: list[tuple]) -> list[Reading]:
        """Read a meter at each (position, normal, name), on every core. Raises InputError."""
        readings = [None] * len(spots)

        def work(start: int, stop: int) -> None:
            for k in range(start, stop):
                readings[k] = self.photometer(*spots[k])

        if spots:
            self.make_ready()
        in_threads(work, len(spots), 1)
        return readings

    def make_ready(self) -> None:
        """Make what all readings share, on every core, before each core has one to read."""
        family = self.family
        _ = [each._luminous_read for each in (self, *family.meshes, *family.samples, *self.by_bands)]

    def luminance(self, position, direction) -> float:
        """Luminance [cd/m²] that an eye at a point (3,) [m] sees along a direction (3,).

        Raises InputError where the eye is outside the room or inside a solid.
        """
        direction = np.asarray(direction, dtype=float)
        one = (direction / np.linalg.norm(direction))[None, None]
        meter = luminance_meter(self.transport, np.asarray(position, dtype=float), one,
                                f"{self.scene.path}: eye")
        return float(self.read_lx(meter).sum())

    def read(self, meter: Meter) -> tuple[np.ndarray, np.ndarray]:
        """Direct irradiance (n_bands,), and what each surface sends (n_surfaces, n_bands)."""
        samples = slice(None) if self.sample is None else slice(self.sample, self.sample + 1)
        direct = meter.direct[samples].mean(axis=0) @ self.flux
        sensors = meter.sensors[samples]
        indirect = sum(sensor.direct_radiosity(self.reflectance, self.flux) + sensor.indirect_radiosity(
            self.vertices_read if sensor.about_means else self.vertex_radiosity, self.patch_radiosity)
            for sensor in sensors) / len(sensors)
        return direct, indirect

    def read_lx(self, meter: Meter, part: int | None = None) -> np.ndarray:
        """What the luminaires and each surface send [lx] (1 + n_surfaces,), by one part of a meter or all."""
        flux, once, patches = self._luminous
        part = self.sample if part is None else part
        samples = slice(None) if part is None else slice(part, part + 1)
        sensors = meter.sensors[samples]
        indirect = sum(sensor.direct @ once + sensor.means @ patches + sensor.indirect @ (
            self._luminous_read if sensor.about_means else self._luminous_shown)
            for sensor in sensors) / len(sensors)
        return np.concatenate([[meter.direct[samples].mean(axis=0) @ flux], indirect])

    @cached_property
    def _luminous(self) -> tuple[np.ndarray, ...]:
        """What sensors add up, in lumens: flux of each luminaire, direct light reflected once (surface ×
        luminaire), indirect light that patches reflect."""
        luminous = self.bands.luminous
        once = (self.reflectance[:, None, :] * self.flux[None]) @ luminous
        return self.flux @ luminous, once.ravel(), self.patch_radiosity @ luminous

    @cached_property
    def _luminous_read(self) -> np.ndarray:
        return self.vertices_read @ self.bands.luminous

    @cached_property
    def _luminous_shown(self) -> np.ndarray:
        return self.vertex_radiosity @ self.bands.luminous

    @property
    def quadrature(self) -> float:
        """Share of a reading that sums over measured luminaires' openings may err by."""
        return QUADRATURE if any(luminaire.opening for luminaire in self.transport.luminaires) else 0.0

    def _errors(self, at: "Callable[[Solution], Meter]") -> tuple[float, float, float]:
        """Of a reading, by mesh, sampling and bands [lx]: the first two in RGB, which costs little, the
        last on the last mesh, likewise. at : as from `meters`"""
        family = self.family
        meshes, samples = (np.array([each.read_lx(at(each)) for each in some])
                           for some in (family.meshes, family.samples))
        mesh, sampling = half_widths(meshes, samples, family.steps, self.quadrature)
        these, narrow = (solution.read_lx(at(solution)).sum() for solution in self.by_bands)
        return mesh, sampling, band_error(float(these), float(narrow))

    @cached_property
    def by_bands(self) -> tuple["Solution", "Solution"]:
        """This scene on the last mesh of its family, in these bands and in narrow ones."""
        last = self.family.meshes[-1]
        return tuple(solve_on(self.scene, bands, last.plan, self.rooms, last.transport)
                     for bands in (self.bands, narrow_bands()))

    @cached_property
    def family(self) -> "Family":
        """This scene in RGB, solved as error bars need it: on this mesh and on two, each coarser than the one
        before, or as many as can be; on a finer one where none can."""
        rgb = band_set("rgb")

        def on_this() -> tuple[Solution, list[Solution]]:
            fine = replace(self) if self.bands.name == rgb.name else solve_on(  # a copy, lest it hold itself
                self.scene, rgb, self.plan, self.rooms, self.transport, FOR_BARS)
            return fine, fine.by_parts() if self.transport.parts > 1 else []

        # Like with like: factors of middles and of whole patches err apart, and might err together by chance.
        like = replace(self.plan, across=self.transport.sight is not None or not self.plan.rays)
        patches = len(self.transport.mesh.patches)
        times = max(2.0, float(np.sqrt(patches / MANY)))
        coarser = [partial(self._on_another, like.times(k * times)) for k in (1, 2)]
        (fine, samples), *others = together(on_this, *coarser)
        meshes = [fine]
        for each in others:
            if each.transport.mesh.size < COARSER * meshes[-1].transport.mesh.size:
                break  # what has one patch a wall, or is made of facets, cannot be coarser
            meshes.append(each)
        if len(meshes) == 1:  # only finer: as far as that is cheap
            shorter = next((k for k in (8, 4) if patches * k * k < CHEAP), 2)
            finer = like.times(self.transport.mesh.size / self.plan.patch_size / shorter)
            meshes.append(self._on_another(finer))
        return Family(tuple(meshes), samples if self.transport.parts > 1 else meshes[1].by_parts())

    def _on_another(self, plan: Plan) -> "Solution":
        """This scene in RGB on another mesh, for error bars alone."""
        transport = self.rooms.transport(self.scene, plan, self.transport.seed + 1)
        return solve_on(self.scene, band_set("rgb"), plan, self.rooms, transport, FOR_BARS)

    def by_parts(self) -> list["Solution"]:
        """The same by each independent part of the rays, to first order; none where no ray is cast."""
        transport, bands = self.transport, self.flux.shape[1]
        parts, stretch = transport.samples, transport.stretch
        if not parts:
            return []
        brought = transport.departures(self.radiosity)
        more = brought + (transport.direct_parts - transport.direct) @ self.flux / stretch
        rho = self.reflectance[transport.mesh.surface]
        light = radiosity(transport.exchange, np.tile(rho, parts), np.hstack(more), ENOUGH)
        sent, received = (stretch * each.reshape(len(rho), parts, bands).transpose(1, 0, 2) for each in light)
        received += stretch * brought
        return [replace(self, radiosity=self.radiosity + sent[k], received=self.received + received[k],
                        sample=k) for k in range(parts)]


@dataclass(frozen=True)
class Family:
    """One scene in RGB, solved several times: how far apart these are tells how far a reading may err.

    meshes : as it is, and on one or two other meshes, each coarser than the one before; or on a finer one
    samples : with each part of the rays, none where none is cast; of the second mesh, whose rays are fewer,
        where the first has no parts
    """

    meshes: tuple[Solution, ...]
    samples: list[Solution]

    @property
    def steps(self) -> tuple[float, ...]:
        """How many times as long patches are from each mesh to the next."""
        sizes = [each.transport.mesh.size for each in self.meshes]
        return tuple(longer / shorter for shorter, longer in pairwise(sizes))


def placed(make: Callable) -> Callable[[Solution], Meter]:
    """The meter that make(transport) puts in a room, for each solution on its own transport, put once."""
    meters = {}

    def of(solution: Solution) -> Meter:
        transport = solution.transport
        if id(transport) not in meters:
            meters[id(transport)] = make(transport)
        return meters[id(transport)]

    return of


def solve(scene: Scene, bands: str | None = None, accuracy: float | None = None,
          seed: int | None = None, rooms: Rooms | None = None,
          progress: Progress = lambda step: None, plan: Plan | None = None) -> Solution:
    """Solve a scene; what is not given here is taken from its [solver] table.

    bands : one of BAND_SETS; accuracy : of readings [1], what mesh and rays are chosen for;
    rooms : transports to share with other scenes of the same geometry; progress : told each step.
    Raises InputError (too large, or a lamp shines into a solid) or SolveError (it has no steady state).
    """
    settings = scene.solver
    accuracy = accuracy or settings.accuracy
    seed = settings.seed if seed is None else seed
    rooms = rooms or Rooms()
    plan = plan or make_plan(scene, accuracy, settings.patch_size)
    transport = rooms.transport(scene, plan, seed, progress)
    refuse_hidden(scene, transport)  # not on the meshes that tell its error, the coarsest of which lose more
    progress(f"{scene.title}: interreflections, {bands or settings.bands} bands")
    return solve_on(scene, scene.band_set(bands or settings.bands), plan, rooms, transport)


def solve_on(scene: Scene, bands: BandSet, plan: Plan, rooms: Rooms, transport: Transport,
             tolerance: float = TOLERANCE) -> Solution:
    """Solve a scene on a transport already computed; tolerance : as for `radiosity`."""
    started = time.perf_counter()
    light, solved = _light(scene, bands, transport, tolerance)
    return Solution(scene, bands, plan, rooms, transport, scene.reflectance(bands), scene.flux(bands), *light,
                    None, solved, time.perf_counter() - started)


def _light(scene: Scene, bands: BandSet, transport: Transport, tolerance: float) -> tuple:
    """What each patch sends, and receives by way of the others, both (n_patches, n_bands); and how many
    systems of equations that took."""
    reflectance, flux = scene.reflectance(bands), scene.flux(bands)
    first, index, scale = distinct_bands(reflectance, flux)
    light = radiosity(transport.exchange, reflectance[transport.mesh.surface][:, first],
                      transport.direct @ flux[:, first], tolerance)
    if len(first) < len(index):
        light = tuple(each[:, index] * scale for each in light)
    return light, len(first)


def distinct_bands(reflectance: np.ndarray, flux: np.ndarray):
    """Bands whose answers are multiples of each other are solved once: a grey room is one band.

    Returns the bands to solve (k,), which of them each band follows (n_bands,), and its multiple.
    """
    total = flux.sum(axis=0)
    shape = flux / np.where(total > 0, total, 1.0)
    _, first, index = np.unique(np.vstack([reflectance, np.round(shape, 14)]), axis=1,
                                return_index=True, return_inverse=True)
    if len(first) == len(index):
        first = index = np.arange(len(index))
    index = index.ravel()
    base = total[first][index]
    return first, index, np.where(base > 0, total / np.where(base > 0, base, 1.0), 0.0)
