"""The tables, keys, types and ranges of a scene file, as pydantic models (metres, z up)."""

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from renderer.colour.bands import BAND_SETS
from renderer.colour.upsampling import UPSAMPLING
from renderer.scene.meter_tables import (
    CameraTable,
    ObserverTable,
    PhotometerGridTable,
    PhotometerTable,
    SpotMeterTable,
)
from renderer.scene.model_files.read import METRES_PER_UNIT
from renderer.scene.project import ProjectTable, RequirementTable
from renderer.scene.table_types import (
    Amount,
    Count,
    FileName,
    Fraction,
    Label,
    Number,
    Positive,
    StrictTable,
    Vector,
    has_length,
    one_of,
)


class RoomTable(StrictTable):
    """The room: a box with one corner at the origin, an outline with a height, or a mesh."""

    size: tuple[Positive, Positive, Positive] | None = None
    outline: Annotated[list[tuple[Number, Number]], Field(min_length=3, max_length=1000)] | None = None
    height: Positive | None = None
    mesh: FileName | None = None
    units: Literal[tuple(METRES_PER_UNIT)] | None = None
    up: Literal["z", "y"] | None = None
    inside: Vector | None = None
    floor: str | None = None
    walls: str | None = None
    ceiling: str | None = None
    wall_x0: str | None = None
    wall_x1: str | None = None
    wall_y0: str | None = None
    wall_y1: str | None = None
    surfaces: dict[str, str] = {}

    @model_validator(mode="after")
    def _shape(self):
        given = [key for key in ("size", "outline", "mesh") if getattr(self, key) is not None]
        if len(given) != 1:
            said = "its shape is missing" if not given else f"{' and '.join(given)} are given"
            raise ValueError(f"{said}; give one of room.size, room.outline with room.height, and room.mesh")
        shape = given[0]
        of_box = [f"wall_{side}" for side in ("x0", "x1", "y0", "y1")]
        for keys, owner in ((of_box, "size"), (["height"], "outline"), (["units", "up", "inside"], "mesh")):
            unused = [k for k in keys if getattr(self, k) is not None and shape != owner]
            if unused:
                raise ValueError(f"{unused[0]} is given; only a room with {owner} takes it. "
                                 + ("Name a wall in [room.surfaces]" if owner == "size" else "Remove it"))
        if self.surfaces and shape == "size":
            raise ValueError("surfaces is given; the walls of a box are the keys wall_x0, wall_x1, wall_y0 "
                             "and wall_y1. Use those")
        if shape == "outline" and self.height is None:
            raise ValueError("height is missing; an outline needs it, in metres")
        if shape != "mesh":
            for key in ("floor", "ceiling"):
                if getattr(self, key) is None and key not in self.surfaces:
                    raise ValueError(f"{key} is missing; give the name of its material")
        missing = [k for k in of_box if not getattr(self, k)]
        if shape == "size" and missing and not self.walls:
            raise ValueError(f"{missing[0]} has no material; give it, or give walls for all four")
        return self


class MaterialTable(StrictTable):
    """A diffuse reflectance, given in one of six ways; `lrv` is in percent."""

    reflectance: Fraction | None = None
    spectrum: FileName | None = None
    rgb: tuple[Fraction, Fraction, Fraction] | None = None
    srgb: Annotated[str, Field(pattern="^#[0-9a-fA-F]{6}$")] | None = None
    munsell: str | None = None
    lrv: Annotated[float, Field(strict=True, ge=0, le=100)] | None = None

    @field_validator("srgb", mode="before")
    @classmethod
    def _of_three_bytes(cls, code):
        if isinstance(code, (list, tuple)) and len(code) == 3 and all(
                isinstance(c, int) and not isinstance(c, bool) and 0 <= c <= 255 for c in code):
            return "#" + "".join(f"{c:02x}" for c in code)
        return code

    @model_validator(mode="after")
    def _one_way(self):
        one_of(self, "reflectance", "spectrum", "rgb", "srgb", "munsell", "lrv")
        return self

    @property
    def flat(self) -> float | None:
        """The reflectance of a spectrally flat material; None for others."""
        return self.reflectance if self.lrv is None else self.lrv / 100


class LuminaireTable(StrictTable):
    """A luminaire, or an array of them. Rectangles and discs emit from their front by Lambert's law."""

    name: Label = "luminaire"
    shape: Literal["rectangle", "disc", "point", "ies"]
    file: FileName | None = None
    center: Vector
    normal: Vector | None = None
    up: Vector | None = None
    size: tuple[Positive, Positive] | None = None
    diameter: Positive | None = None
    distribution: Literal["isotropic", "lambertian"] | None = None
    array: tuple[Count, Count] | None = None
    spacing: tuple[Positive, Positive] | None = None
    dimming: Annotated[float, Field(strict=True, ge=0, le=1)] = 1.0
    flux: Amount | None = None
    luminance: Amount | None = None
    intensity: Amount | None = None
    spectrum: FileName | None = None
    cct: Annotated[float, Field(strict=True, ge=1000, le=25000)] | None = None
    watts: Amount | None = None

    @model_validator(mode="before")
    @classmethod
    def _position_is_center(cls, table):
        if isinstance(table, dict) and "position" in table:
            if "center" in table:
                raise ValueError("center and position are given, two names of one key. Remove one")
            table = {("center" if key == "position" else key): value for key, value in table.items()}
        return table

    @model_validator(mode="after")
    def _shape(self):
        sized = ("size", "diameter", "luminance", "intensity", "distribution")
        needs_normal = False
        if self.shape == "ies":
            unused = sized
            if self.file is None:
                raise ValueError('file is missing; give an IES or EULUMDAT file, for example "lamp.ies"')
        elif self.shape == "point":
            one_of(self, "flux", "intensity")
            unused = ("size", "diameter", "luminance", "file") + (() if self.array else ("up",))
            needs_normal = self.distribution == "lambertian"
            if self.normal is not None and not needs_normal:
                raise ValueError('normal is given; an isotropic point has none. Remove it, or add '
                                 'distribution = "lambertian"')
        else:
            one_of(self, "flux", "luminance")
            needs_normal = True
            unused = ("file", "intensity", "distribution",
                      "diameter" if self.shape == "rectangle" else "size")
            needed = "size" if self.shape == "rectangle" else "diameter"
            if getattr(self, needed) is None:
                raise ValueError(f"{needed} is missing; a {self.shape} needs it, in metres")
        for key in unused:
            if getattr(self, key) is not None:
                raise ValueError(f"{key} is given; shape {self.shape!r} has none. Remove it")
        if (self.array is None) != (self.spacing is None):
            raise ValueError("array and spacing go together; give both, as array = [4, 3] and spacing = "
                             "[1.8, 2.4] in metres, or neither")
        if (needs_normal and self.normal is None) or (self.normal and not has_length(self.normal)):
            raise ValueError("normal is missing or of no length; give the direction in which light leaves, "
                             "for example [0, 0, -1]")
        if self.up is not None and not has_length(self.up):
            raise ValueError("up has no length; give any direction across the normal")
        if self.spectrum is not None and self.cct is not None:
            raise ValueError("exactly one of spectrum, cct must be given, not spectrum and cct")
        return self


class ObjectTable(StrictTable):
    """An object in the room: a box, cylinder or sphere, or a model from a file."""

    name: Label = "object"
    shape: Literal["box", "cylinder", "sphere"] | None = None
    mesh: FileName | None = None
    units: Literal[tuple(METRES_PER_UNIT)] | None = None
    up: Literal["z", "y"] | None = None
    scale: Positive | None = None
    position: Vector
    size: tuple[Positive, Positive, Positive] | None = None
    anchor: Literal["corner", "origin", "base"] | None = None
    rotation: Number | Vector = 0.0
    material: str | None = None
    materials: dict[str, str] = {}

    @model_validator(mode="after")
    def _shape(self):
        one_of(self, "shape", "mesh")
        if self.shape and self.size is None:
            raise ValueError("size is missing; give the extents in metres, [x, y, z]")
        if self.mesh and self.size is not None:
            raise ValueError("size is given; a mesh takes scale instead")
        if self.shape and self.material is None:
            raise ValueError("material is missing; give the name of one of [materials.*]")
        for key in ("scale", "units", "up", "materials"):
            if self.shape and getattr(self, key):
                raise ValueError(f"{key} is given; only a mesh takes it. Change size instead")
        return self


class SolverTable(StrictTable):
    """Settings of the solve; those left out follow from the accuracy."""

    accuracy: Annotated[float, Field(strict=True, ge=1e-4, le=0.5)] = 0.01
    bands: Literal[BAND_SETS] = "31"
    upsampling: Literal[tuple(UPSAMPLING)] = "munsell-eigen"
    patch_size: Positive | None = None
    seed: Annotated[int, Field(strict=True, ge=0, le=2**62)] = 0


class SceneTable(StrictTable):
    """A whole scene file."""

    title: Label = "Untitled room"
    room: RoomTable
    materials: dict[str, MaterialTable] = {}
    luminaires: list[LuminaireTable] = []
    objects: list[ObjectTable] = []
    photometers: list[PhotometerTable] = []
    photometer_grids: list[PhotometerGridTable] = []
    spot_meters: list[SpotMeterTable] = []
    observers: list[ObserverTable] = []
    camera: CameraTable | None = None
    project: ProjectTable | None = None
    requirements: list[RequirementTable] = []
    solver: SolverTable = SolverTable()
