"""What a scene file may say: keys, types and ranges, as pydantic models (metres, z up)."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from renderer.colour.bands import BAND_SETS
from renderer.colour.upsampling import UPSAMPLING
from renderer.scene.model_files.read import UNITS
from renderer.scene.project import ProjectTable, RequirementTable

FARTHEST = 1e9
"""Largest coordinate or length [m]; the smallest length is its inverse."""
Number = Annotated[float, Field(strict=True, ge=-FARTHEST, le=FARTHEST)]
Positive = Annotated[float, Field(strict=True, ge=1 / FARTHEST, le=FARTHEST)]
Amount = Annotated[float, Field(strict=True, ge=0, le=1e30)]
Reflectance = Annotated[float, Field(strict=True, ge=0, le=1)]
Count = Annotated[int, Field(strict=True, ge=1, le=50)]
Vector = tuple[Number, Number, Number]


class Table(BaseModel):
    """A TOML table: an unknown key, NaN or infinity is an error."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)


def one_of(table: BaseModel, *keys: str) -> None:
    """Refuse a table in which not exactly one of the keys is given."""
    given = [key for key in keys if getattr(table, key) is not None]
    if len(given) != 1:
        raise ValueError(f"exactly one of {', '.join(keys)} must be given, not "
                         f"{' and '.join(given) or 'none'}")


def has_length(direction: Vector) -> bool:
    """Whether a vector is long enough to give a direction."""
    return max(abs(x) for x in direction) >= 1 / FARTHEST


class RoomTable(Table):
    """The inside of a closed box with one corner at the origin, of an outline, or of a mesh."""

    size: tuple[Positive, Positive, Positive] | None = None
    outline: Annotated[list[tuple[Number, Number]], Field(min_length=3, max_length=1000)] | None = None
    height: Positive | None = None
    mesh: str | None = None
    units: Literal[tuple(UNITS)] | None = None
    up: Literal["z", "y"] | None = None
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
        for keys, owner in ((of_box, "size"), (["height"], "outline"), (["units", "up"], "mesh")):
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


class MaterialTable(Table):
    """A diffuse reflectance, in one of six ways; `lrv` in percent becomes `reflectance`."""

    reflectance: Reflectance | None = None
    spectrum: str | None = None
    rgb: tuple[Reflectance, Reflectance, Reflectance] | None = None
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
        """Its reflectance where that is the same at every wavelength."""
        return self.reflectance if self.lrv is None else self.lrv / 100


class LuminaireTable(Table):
    """A light source, or an array of them. Rectangles and discs emit from their front by Lambert's law."""

    name: str = "luminaire"
    shape: Literal["rectangle", "disc", "point", "ies"]
    file: str | None = None
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
    spectrum: str | None = None
    cct: Annotated[float, Field(strict=True, ge=1000, le=25000)] | None = None
    watts: Amount | None = None

    @model_validator(mode="before")
    @classmethod
    def _position_is_center(cls, table):
        if isinstance(table, dict) and "position" in table:
            if "center" in table:
                raise ValueError("center and position are given, which mean the same. Remove one")
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
            raise ValueError("normal is missing or of no length; give the direction the light leaves in, "
                             "for example [0, 0, -1]")
        if self.up is not None and not has_length(self.up):
            raise ValueError("up has no length; give any direction across the normal")
        if self.spectrum is not None and self.cct is not None:
            raise ValueError("exactly one of spectrum, cct must be given, not spectrum and cct")
        return self


class ObjectTable(Table):
    """What stands in the room: a box, cylinder or sphere, or a model from a file."""

    name: str = "object"
    shape: Literal["box", "cylinder", "sphere"] | None = None
    mesh: str | None = None
    units: Literal[tuple(UNITS)] | None = None
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


class PhotometerTable(Table):
    """Where a reading is taken, and which way the meter faces."""

    name: str = "photometer"
    position: Vector
    normal: Vector = (0.0, 0.0, 1.0)

    @field_validator("normal")
    @classmethod
    def _has_length(cls, normal):
        if not has_length(normal):
            raise ValueError("has no length; give a direction, for example [0, 0, 1]")
        return normal


class PhotometerGridTable(Table):
    """An area of readings: a corner and two sides at right angles, facing u × v unless told otherwise."""

    name: str = "grid"
    origin: Vector
    u: Vector
    v: Vector
    spacing: Positive | None = None
    border: Annotated[float, Field(strict=True, ge=0, le=FARTHEST)] = 0.0
    normal: Vector | None = None

    @model_validator(mode="after")
    def _is_an_area(self):
        for key in ("u", "v"):
            if not has_length(getattr(self, key)):
                raise ValueError(f"{key} has no length; give a side of the area, for example [3, 0, 0]")
        if self.normal is not None and not has_length(self.normal):
            raise ValueError("normal has no length; give the way the meters face, for example [0, 0, 1]")
        return self


class SightTable(Table):
    """Where an eye is, and which way it looks."""

    name: str
    position: Vector
    look_at: Vector | None = None
    direction: Vector | None = None

    @model_validator(mode="after")
    def _looks_somewhere(self):
        one_of(self, "look_at", "direction")
        if not has_length(self.toward):
            raise ValueError("look_at is the eye's own position; move it to what is looked at"
                             if self.look_at else "direction has no length; give one, for example [0, 1, 0]")
        return self

    @property
    def toward(self) -> Vector:
        """The way it looks, of any length."""
        if self.direction is not None:
            return self.direction
        return tuple(a - b for a, b in zip(self.look_at, self.position, strict=True))


class SpotMeterTable(SightTable):
    """A luminance meter, with its full acceptance angle in degrees."""

    name: str = "spot meter"
    angle: Annotated[float, Field(strict=True, ge=0.01, le=120)] = 1.0


class ObserverTable(SightTable):
    """An observer whose glare is rated."""

    name: str = "observer"


class CameraTable(Table):
    """A pinhole camera; x to the right, z up in the picture."""

    position: Vector
    look_at: Vector
    fov: Annotated[float, Field(strict=True, ge=1, le=170)] = 75.0
    resolution: tuple[Annotated[int, Field(ge=8, le=8192)], Annotated[int, Field(ge=8, le=8192)]] = (
        640, 480)

    @model_validator(mode="after")
    def _looks_somewhere(self):
        if not has_length(tuple(a - b for a, b in zip(self.look_at, self.position, strict=True))):
            raise ValueError("look_at is the camera's own position; move it to what is looked at")
        return self


class SolverTable(Table):
    """How the scene is solved. What is left out follows from the accuracy."""

    accuracy: Annotated[float, Field(strict=True, ge=1e-4, le=0.5)] = 0.01
    bands: Literal[BAND_SETS] = "31"
    upsampling: Literal[tuple(UPSAMPLING)] = "munsell-eigen"
    patch_size: Positive | None = None
    seed: Annotated[int, Field(strict=True, ge=0, le=2**62)] = 0


class SceneTable(Table):
    """A whole scene file."""

    title: str = "Untitled room"
    room: RoomTable
    materials: dict[str, MaterialTable]
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
