"""A model file of any known format as polygons in metres, z up."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.model_files.beside import beside
from renderer.scene.model_files.record import ModelFile, Unreadable
from renderer.system.input_files import read_input

MODEL_FORMATS = ("obj", "ply", "stl", "glb", "gltf", "dae", "3mf")
METRES_PER_UNIT = {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0, "in": 0.0254, "ft": 0.3048, "yd": 0.9144}
MAX_COORDINATE_M = 1e9
"""Largest coordinate [m]; its inverse is the smallest length."""


@dataclass(frozen=True)
class Polygons:
    """The polygons of a model file, in metres and z up.

    vertices : (n, 3) [m]
    corners : (m,) index of a vertex, polygon after polygon
    sizes : (p,) corners of each polygon
    part : (p,) index into `names` and `colours`
    names : of each part in the file, the most specific first
    colours : linear BT.709 reflectance (3,) of each part, or None
    taken : axis and unit, as "z up and metres assumed"
    notes : sentences about contents that were not read
    """

    vertices: np.ndarray
    corners: np.ndarray
    sizes: np.ndarray
    part: np.ndarray
    names: list[tuple[str, ...]]
    colours: list[np.ndarray | None]
    taken: str = ""
    notes: list[str] = field(default_factory=list)


def read_polygons(path: Path, where: str, scale: float = 1.0, units: str | None = None, up: str | None = None,
                  root: Path | None = None) -> Polygons:
    """Read a model file. Raises InputError.

    where : scene file and key, for messages
    scale : factor on all lengths
    units, up : unit and up axis to use instead of the file's own; None for the file's own
    root : the scene's folder, in which the file may name others; None for only the file's own folder
    """
    kind = path.suffix.lower().lstrip(".")
    called = {"gltf": "glTF", "dae": "COLLADA"}.get(kind, kind.upper())
    known = "OBJ, PLY, STL, GLB, glTF, COLLADA (.dae) or 3MF"
    if kind not in MODEL_FORMATS:
        raise InputError(f"{where}: {path.name} is {_unread_format(kind)}; export it as {known}.")
    data = read_input(path, "model", where, "Paths are relative to the scene file; correct this one.")
    try:
        with np.errstate(all="ignore"):
            found = _parsed(data, path, kind, root or path.parent)
    except Unreadable as fault:
        raise InputError(f"{where}: {path.name} {fault}.") from None
    except (LookupError, TypeError, AttributeError):
        raise InputError(f"{where}: {path.name} lacks a value that {called} demands, "
                         f"or has one of a wrong kind; export it again, or as {known}.") from None
    except Exception as error:  # noqa: BLE001  readers raise errors of any class for faulty files
        reason = " ".join(f"{error}".split())[:200] or type(error).__name__
        raise InputError(f"{where}: {path.name} cannot be read as {called} ({reason}); export it "
                         f"again, or as {known}.") from None
    return _in_metres(found, path, where, scale, units, up)


def _unread_format(ending: str) -> str:
    """The format of a file with the suffix of a program whose files are not read, for a message."""
    names = {"skp": "SketchUp", "3ds": "3D Studio", "fbx": "FBX", "blend": "Blender", "ifc": "IFC",
             "dwg": "AutoCAD", "dxf": "DXF", "step": "STEP", "stp": "STEP", "iges": "IGES", "igs": "IGES",
             "3dm": "Rhino", "usdz": "USD", "usd": "USD", "usda": "USD", "usdc": "USD", "x3d": "X3D",
             "wrl": "VRML", "off": "OFF", "rvt": "Revit", "max": "3ds Max", "c4d": "Cinema 4D", "zip": "ZIP",
             "zae": "zipped COLLADA"}
    return names.get(ending, "of a format that is not read")


def _parsed(data: bytes, path: Path, kind: str, root: Path) -> ModelFile:
    if not data:
        raise Unreadable("is empty; copy it again")
    if data.startswith(b"version https://git-lfs"):
        raise Unreadable("is a pointer of Git LFS, not the model itself; download that")
    # Each reader is imported for its own files: pycollada takes half a second.
    match kind:
        case "stl":
            from renderer.scene.model_files.stl import read_stl

            return read_stl(data)
        case "3mf":
            from renderer.scene.model_files.three_mf import read_3mf

            return read_3mf(data)
        case "ply":
            from renderer.scene.model_files.ply import read_ply

            return read_ply(data)
        case "obj":
            from renderer.scene.model_files.obj import read_obj as read
        case "dae":
            from renderer.scene.model_files.collada_file import read_collada as read
        case _:
            from renderer.scene.model_files.gltf import read_gltf as read
    return read(data, beside(path, root))


def _in_metres(found: ModelFile, path: Path, where: str, scale: float, units: str | None,
               up: str | None) -> Polygons:
    pieces = [piece for piece in found.pieces if len(piece.sizes)]
    if not pieces:
        held = f"{found.instead} and " if found.instead else ""
        raise InputError(f"{where}: {path.name} holds {held}no faces; export the model with its polygons.")
    for piece in pieces:
        if piece.corners.min() < 0 or piece.corners.max() >= len(piece.vertices):
            raise InputError(f"{where}: {path.name} has a face whose vertex it does not hold; export it "
                             "again.")
    metres = scale * (METRES_PER_UNIT[units] if units else found.metres)
    used = [piece.vertices[np.unique(piece.corners)] for piece in pieces]
    reach = max(np.abs(points).max() for points in used) * metres
    if not np.isfinite(reach):
        raise InputError(f"{where}: {path.name} has a vertex that is not a finite number; correct the "
                         "export.")
    if reach > MAX_COORDINATE_M:
        raise InputError(f"{where}: {path.name} reaches {reach:.3g} m from its origin; at most "
                         f"{MAX_COORDINATE_M:g} m is allowed. Give its units, or move it nearer in the "
                         "export.")
    low, high = np.min([p.min(axis=0) for p in used], axis=0), np.max([p.max(axis=0) for p in used], axis=0)
    longest = (high - low).max() * metres
    if longest < 1 / MAX_COORDINATE_M:
        raise InputError(f"{where}: {path.name} is {longest:.3g} m long; at least {1 / MAX_COORDINATE_M:g} m "
                         "is allowed. Give its units, or scale it in the export.")
    vertices = np.concatenate([np.where(np.isfinite(p.vertices), p.vertices, 0.0) for p in pieces]) * metres
    given_up, up = up, up or found.up
    if up == "y":
        vertices = np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], axis=1)
    starts = np.cumsum([0] + [len(p.vertices) for p in pieces])
    corners = np.concatenate([p.corners + start for p, start in zip(pieces, starts, strict=False)])
    part = np.repeat(np.arange(len(pieces)), [len(p.sizes) for p in pieces])
    colours = [None if p.colour is None else np.clip(p.colour, 0.0, 1.0) for p in pieces]
    return Polygons(vertices, corners.astype(np.int64), np.concatenate([p.sizes for p in pieces]), part,
                    [p.names for p in pieces], colours, _taken(found, units, given_up, up), found.notes)


def _taken(found: ModelFile, units: str | None, given_up: str | None, up: str) -> str:
    """The up axis, and the axis and unit that were assumed because neither the file nor the scene states
    them."""
    unsaid = [] if found.said else [word for word, given in ((f"{up} up", given_up), ("metres", units))
                                    if given is None]
    return f"{up} up" if not unsaid else f"{' and '.join(unsaid)} assumed"
