"""A room ready to be solved: its surfaces, what stands in it, what lights it, and what is read."""

import hashlib
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import trimesh

from renderer.colour.bands import BandSet, band_set, prefiltered
from renderer.colour.lamps import band_flux, band_watts, for_lamps, mean_light, power_at_1_nm
from renderer.colour.materials import Material
from renderer.colour.nodes import luminous_at_1_nm, nodes_for_lamps
from renderer.colour.spectrum import Spectrum
from renderer.scene.exposed import Exposed, exposed_parts
from renderer.scene.flat import Parts, flat_parts
from renderer.scene.grids import Grid
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.scene.mounting import Placement, place_luminaires
from renderer.scene.project import ProjectTable, RequirementTable
from renderer.scene.room import Room
from renderer.scene.schema import CameraTable, ObserverTable, PhotometerTable, SolverTable, SpotMeterTable
from renderer.system.input_files import OpenedFile
from renderer.system.lazy import cached_property

STAND_OFF = 4e-6
"""How far rays start off their surface and stop short of their target, relative to the room's
longest side: some 60 times what rays resolve there, and 20 µm in a room of 5 m."""


@dataclass(frozen=True)
class Body:
    """Faces of an object that have one material.

    mesh : [m], the normals of closed bodies outward
    closed : whether they enclose a volume, alone or with the others of the object; else they are sheets:
        no thickness, opaque, the material on both sides
    of_room : whether it is a wall, slab or other part of the room's own file: luminaires are mounted on it
    """

    name: str
    mesh: trimesh.Trimesh
    closed: bool = True
    of_room: bool = False

    @cached_property
    def parts(self) -> Parts:
        """Its flat parts."""
        return flat_parts(self.mesh)


@dataclass(frozen=True)
class Surface:
    """What a mesh numbers as one surface: a row of every array over surfaces.

    kind : "room", "solid", "sheet" or "luminaire"
    parts : its flat parts; None of a luminaire's face
    material : None of a luminaire's face, which is black
    luminaire : index in Scene.luminaires of the one whose face it is; else None
    of_room : whether it is from the room's own table or file
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
        """Area of one side [m²], before anything covers it; 0 of a luminaire's face."""
        return float(self.parts.area) if self.parts is not None else 0.0


@dataclass(frozen=True)
class Scene:
    """A room ready to be solved.

    room : its inner surfaces; bodies : the objects in it
    materials : one Material per surface of the room and body
    lamps : relative spectral power, one per luminaire
    faults : of the luminaires' photometric files, in sentences
    files : how model files were read, and which colours are theirs, in sentences
    project : what a report says of it; its maintenance factor is in the luminaires' lumens
    requirements : what a report holds readings against
    opened : those that were read to load it, the scene's own first
    table : what its file says, or the dict that it was made from
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
        """All surfaces (n_surfaces,): the room's, the bodies, the luminaires with area."""
        found = [Surface(name, "room", parts, of_room=True) for name, parts in self.room.surfaces.items()]
        found += [Surface(body.name, "solid" if body.closed else "sheet", body.parts, of_room=body.of_room)
                  for body in self.bodies]
        found = [replace(surface, material=material)
                 for surface, material in zip(found, self.materials, strict=True)]
        return found + [Surface(lum.name, "luminaire", luminaire=k)
                        for k, lum in enumerate(self.luminaires) if not lum.is_point]

    @cached_property
    def exposed(self) -> list[Exposed]:
        """What of each surface of the room and of each body faces air."""
        return exposed_parts(self.room, self.bodies)

    @property
    def surface_names(self) -> list[str]:
        """Names of all surfaces (n_surfaces,)."""
        return [surface.name for surface in self.surfaces]

    @property
    def faces(self) -> list[Luminaire]:
        """The luminaires that have a face."""
        return [lum for lum in self.luminaires if not lum.is_point]

    def band_set(self, name: str) -> BandSet:
        """The band set of that name, made for this scene's lamps but for "rgb"."""
        if name == "6":
            lights = [luminous_at_1_nm(power_at_1_nm(lamp)) for lamp in self.lamps]
            return nodes_for_lamps(lights, [lum.lumens for lum in self.luminaires])
        if name != "rgb-prefiltered":
            bands = band_set(name)
            return bands if bands.edges is None else for_lamps(
                bands, self.lamps, [lum.lumens for lum in self.luminaires])
        return prefiltered(mean_light(self.lamps, [lum.lumens for lum in self.luminaires]))

    def reflectance(self, bands: BandSet) -> np.ndarray:
        """Reflectance of each surface in each band (n_surfaces, n_bands); luminaires are black."""
        once = {material.name: material.reflectance(bands) for material in self.materials}
        black = np.zeros(len(bands.xyz))
        return np.array([once[s.material.name] if s.material else black for s in self.surfaces])

    def watts(self, bands: BandSet) -> np.ndarray:
        """Power of each luminaire in each interval of wavelengths (n_luminaires, n_bands) [W]."""
        rows = [band_watts(lamp, lum.lumens, bands)
                for lum, lamp in zip(self.luminaires, self.lamps, strict=True)]
        return np.array(rows).reshape(len(rows), len(bands.xyz))

    def flux(self, bands: BandSet) -> np.ndarray:
        """Flux of each luminaire in each band (n_luminaires, n_bands), in that set's unit: lumens are
        exact."""
        rows = [band_flux(lamp, lum.lumens, bands, f"{self.path}: luminaires {lum.name!r}")
                for lum, lamp in zip(self.luminaires, self.lamps, strict=True)]
        return np.array(rows).reshape(len(rows), len(bands.xyz))

    @cached_property
    def placement(self) -> Placement:
        """The luminaires against the surfaces. Raises InputError where one shines into what it lies on."""
        return place_luminaires(self)

    @cached_property
    def geometry_key(self) -> str:
        """What the form factors depend on: equal for a grey and a red room of one shape."""
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
