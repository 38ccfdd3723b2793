"""A scene: a room with its surfaces, bodies, luminaires and meters."""

import hashlib
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from renderer.colour.bands import BandSet, band_set, prefiltered
from renderer.colour.lamps import band_flux, band_watts, for_lamps, mean_light, power_at_1_nm
from renderer.colour.materials import Material
from renderer.colour.nodes import luminous_at_1_nm, nodes_for_lamps
from renderer.colour.spectrum import Spectrum
from renderer.scene.arrangement import Exposed
from renderer.scene.exposed import exposed_parts
from renderer.scene.flat import Parts, flat_parts
from renderer.scene.grids import Grid
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.scene.meter_tables import CameraTable, ObserverTable, PhotometerTable, SpotMeterTable
from renderer.scene.mounting import Placement, place_luminaires
from renderer.scene.project import ProjectTable, RequirementTable
from renderer.scene.room import Room
from renderer.scene.schema import SolverTable
from renderer.scene.triangle_mesh import TriangleMesh
from renderer.system.input_files import OpenedFile
from renderer.system.lazy import cached_property

STAND_OFF = 4e-6
"""Distance from a surface, relative to the room's longest side, at which rays start and end: about 60 times
the resolution of single precision, or 20 µm in a room of 5 m."""


@dataclass(frozen=True)
class Body:
    """Faces of an object with one material.

    mesh : [m], normals of closed bodies outward
    closed : whether the faces enclose a volume, alone or with the object's other bodies; else they are
        sheets: without thickness, opaque, the material on both sides
    of_room : whether the body is a wall, slab or other part of the room's own file; luminaires are mounted on
        it
    over_gaps : whether the body was added to close gaps between the faces of the room's file
    """

    name: str
    mesh: TriangleMesh
    closed: bool = True
    of_room: bool = False
    over_gaps: bool = False

    @cached_property
    def parts(self) -> Parts:
        """The flat parts of the faces."""
        return flat_parts(self.mesh)


@dataclass(frozen=True)
class Surface:
    """A surface of the scene: one row of every array over surfaces.

    kind : "room", "solid", "sheet" or "luminaire"
    parts : flat parts; None for a luminaire's face
    material : None for a luminaire's face, which is black
    luminaire : index in Scene.luminaires of the luminaire with this face; None for other surfaces
    of_room : whether the surface is from the room's own table or file
    """

    name: str
    kind: str
    parts: Parts | None = None
    material: Material | None = None
    luminaire: int | None = None
    of_room: bool = False

    @property
    def two_sided(self) -> bool:
        """Whether light leaves it on both sides."""
        return self.kind == "sheet"

    @property
    def area(self) -> float:
        """Area of one side [m²], covered parts included; 0 for a luminaire's face."""
        return float(self.parts.area) if self.parts is not None else 0.0


@dataclass(frozen=True)
class Scene:
    """A scene ready to be solved.

    room : the inner surfaces
    bodies : the objects in the room
    materials : one for each surface of the room and each body
    lamps : relative spectral power, one for each luminaire
    faults : sentences about faults of photometric files
    files : sentences about the reading of model files and the colours from them
    project : for the report; its maintenance factor is contained in the luminaires' lumens
    requirements : values that a report compares readings with
    opened : the files that were read, the scene's own first
    table : the table of the scene file, or the dict that the scene was made from
    """

    title: str
    path: Path
    room: Room
    bodies: list[Body]
    materials: list[Material]
    luminaires: list[Luminaire]
    lamps: list[Spectrum]
    photometers: list[PhotometerTable]
    grids: list[Grid]
    spot_meters: list[SpotMeterTable]
    observers: list[ObserverTable]
    camera: CameraTable | None
    solver: SolverTable
    faults: list[str] = field(default_factory=list)
    files: list[str] = field(default_factory=list)
    project: ProjectTable = field(default_factory=ProjectTable)
    requirements: list[RequirementTable] = field(default_factory=list)
    opened: tuple[OpenedFile, ...] = ()
    table: dict = field(default_factory=dict, repr=False)

    @property
    def size(self) -> np.ndarray:
        """The room's extents (3,) [m]."""
        return np.ptp(self.room.bounds, axis=0)

    @cached_property
    def surfaces(self) -> list[Surface]:
        """All surfaces (n_surfaces,): the room's, the bodies', the faces of luminaires."""
        found = [Surface(name, "room", parts, of_room=True) for name, parts in self.room.surfaces.items()]
        found += [Surface(body.name, "solid" if body.closed else "sheet", body.parts, of_room=body.of_room)
                  for body in self.bodies]
        found = [replace(surface, material=material)
                 for surface, material in zip(found, self.materials, strict=True)]
        return found + [Surface(lum.name, "luminaire", luminaire=k)
                        for k, lum in enumerate(self.luminaires) if not lum.is_point]

    @cached_property
    def exposed(self) -> list[Exposed]:
        """The parts of each surface of the room and of each body that face air."""
        return exposed_parts(self.room, self.bodies)

    @property
    def surface_names(self) -> list[str]:
        """Names of all surfaces (n_surfaces,)."""
        return [surface.name for surface in self.surfaces]

    @property
    def faces(self) -> list[Luminaire]:
        """The luminaires with a face: all but points."""
        return [lum for lum in self.luminaires if not lum.is_point]

    def band_set(self, name: str) -> BandSet:
        """The band set of a name; all but "rgb" are fitted to this scene's lamps."""
        if name == "6":
            lights = [luminous_at_1_nm(power_at_1_nm(lamp)) for lamp in self.lamps]
            return nodes_for_lamps(lights, [lum.lumens for lum in self.luminaires])
        if name != "rgb-prefiltered":
            bands = band_set(name)
            return bands if bands.edges is None else for_lamps(
                bands, self.lamps, [lum.lumens for lum in self.luminaires])
        return prefiltered(mean_light(self.lamps, [lum.lumens for lum in self.luminaires]))

    def reflectance(self, bands: BandSet) -> np.ndarray:
        """Reflectance (n_surfaces, n_bands) of each surface in each band; luminaires are black."""
        once = {material.name: material.reflectance(bands) for material in self.materials}
        black = np.zeros(len(bands.xyz))
        return np.array([once[s.material.name] if s.material else black for s in self.surfaces])

    def watts(self, bands: BandSet) -> np.ndarray:
        """Power (n_luminaires, n_bands) [W] of each luminaire in each interval of wavelengths."""
        of_a_lumen = {id(lamp): lamp for lamp in self.lamps}
        of_a_lumen = {key: band_watts(lamp, 1.0, bands) for key, lamp in of_a_lumen.items()}
        rows = [lum.lumens * of_a_lumen[id(lamp)]
                for lum, lamp in zip(self.luminaires, self.lamps, strict=True)]
        return np.array(rows).reshape(len(rows), len(bands.xyz))

    def flux(self, bands: BandSet) -> np.ndarray:
        """Flux (n_luminaires, n_bands) of each luminaire in each band, in the band set's unit; lumens are
        exact."""
        of_a_lumen: dict[int, np.ndarray] = {}  # by spectrum, because many luminaires share one
        for lum, lamp in zip(self.luminaires, self.lamps, strict=True):
            if id(lamp) not in of_a_lumen:
                of_a_lumen[id(lamp)] = band_flux(lamp, 1.0, bands, f"{self.path}: luminaires {lum.name!r}")
        rows = [lum.lumens * of_a_lumen[id(lamp)]
                for lum, lamp in zip(self.luminaires, self.lamps, strict=True)]
        return np.array(rows).reshape(len(rows), len(bands.xyz))

    @cached_property
    def placement(self) -> Placement:
        """The luminaires placed against the surfaces. Raises InputError for one that shines into its
        surface."""
        return place_luminaires(self)

    @cached_property
    def geometry_key(self) -> str:
        """Digest of the geometry on which form factors depend; paints and lamps do not change it."""
        parts = [self.room.shell, np.array([len(p.shell) for p in self.room.surfaces.values()])]
        for body in self.bodies:
            parts += [body.mesh.vertices, body.mesh.faces]
            parts += [] if body.closed else [np.array("sheet")]
        for lum in self.luminaires:
            parts += lum.geometry
        digest = hashlib.sha256()
        for part in parts:
            digest.update(repr((part.shape, str(part.dtype))).encode() + part.tobytes())
        return digest.hexdigest()
