"""A solved room: its readings with error bars."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from renderer import side_by_side
from renderer.colour.bands import BandSet, narrow_bands
from renderer.colour.lamps import spectral_flux
from renderer.family import Family, make_family, placed
from renderer.lazy import cached_property
from renderer.light import Light, light_on
from renderer.plan import Plan, make_plan
from renderer.readings.luminance import luminance_meter
from renderer.readings.photometer import Meter, make_meter
from renderer.readings.reading import Reading
from renderer.readings.reconstruction import reconstructed
from renderer.readings.uncertainty import band_error, half_widths
from renderer.rooms import Progress, Rooms
from renderer.scene.reading import Scene
from renderer.transport.transport import Transport, refuse_hidden

QUADRATURE = 4e-4
"""Share of a reading that light through a measured luminaire's opening may err by (docs/decisions.md)."""


@dataclass(frozen=True)
class Solution(Light):
    """Light in a room, and what it takes to tell how well it is known.

    plan : how it was solved; rooms : where transports of this and of other meshes are shared
    """

    plan: Plan
    rooms: Rooms

    def __repr__(self) -> str:
        return (f"Solution({self.scene.title!r}, {self.bands.name} bands, "
                f"{len(self.transport.mesh.patches)} patches)")

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

    def meters(self, position: np.ndarray, normal: np.ndarray, where: str) -> Callable[[Light], Meter]:
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
        if not spots:
            return []
        self.make_ready()
        return side_by_side.each(lambda k: self.photometer(*spots[k]), len(spots), self.transports)

    @property
    def transports(self) -> list[Transport]:
        """Of this mesh, and of those that tell its error."""
        return list({id(each.transport): each.transport for each in (self, *self.family.meshes)}.values())

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

    @property
    def quadrature(self) -> float:
        """Share of a reading that sums over measured luminaires' openings may err by."""
        return QUADRATURE if any(luminaire.opening for luminaire in self.transport.luminaires) else 0.0

    def _errors(self, at: Callable[[Light], Meter]) -> tuple[float, float, float]:
        """Of a reading, by mesh, sampling and bands [lx]: the first two in RGB, which costs little, the
        last on the last mesh, likewise. at : as from `meters`"""
        family = self.family
        meshes, samples = (np.array([each.read_lx(at(each)) for each in some])
                           for some in (family.meshes, family.samples))
        mesh, sampling = half_widths(meshes, samples, family.steps, self.quadrature)
        these, narrow = (each.read_lx(at(each)).sum() for each in self.by_bands)
        return mesh, sampling, band_error(float(these), float(narrow))

    @cached_property
    def by_bands(self) -> tuple[Light, Light]:
        """This scene on the last mesh of its family, in these bands and in narrow ones."""
        last = self.family.meshes[-1].transport
        return tuple(light_on(self.scene, bands, last) for bands in (self.bands, narrow_bands()))

    @cached_property
    def family(self) -> Family:
        """This scene in RGB on several meshes."""
        return make_family(self, self.plan, self.rooms)


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


def solve_on(scene: Scene, bands: BandSet, plan: Plan, rooms: Rooms, transport: Transport) -> Solution:
    """Solve a scene on a transport already computed."""
    return Solution(**vars(light_on(scene, bands, transport)), plan=plan, rooms=rooms)
