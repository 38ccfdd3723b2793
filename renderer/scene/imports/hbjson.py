"""HBJSON files, the models of Honeybee (Ladybug Tools): rooms, the Radiance modifiers of their faces, shades.

They are read as plain JSON by the published schema (honeybee-schema, "Model"), without Honeybee.
"""

import json
from pathlib import Path

import numpy as np

from renderer.scene.imports.modifiers import finish_of_modifier
from renderer.scene.imports.record import Imported, ImportedFace, ImportedFinish, NotImported, Space, Thing

FACE_KINDS = {"Wall": "walls", "Floor": "floor", "RoofCeiling": "ceiling", "AirBoundary": "walls"}


def read_hbjson(path: Path, data: bytes) -> Imported:
    """Read a model of Honeybee. Raises NotImported."""
    try:
        model = json.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as fault:
        raise NotImported(f"is no JSON that can be parsed ({' '.join(str(fault).split())[:80]})") from None
    if not isinstance(model, dict) or model.get("type") != "Model":
        raise NotImported("is JSON, but no HBJSON model (its \"type\" is not \"Model\"); export the model")
    try:
        return _Model(model, path).read()
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError) as fault:
        raise NotImported(f"does not follow the schema of HBJSON models ({type(fault).__name__}: "
                          f"{' '.join(str(fault).split())[:80]}); export it again"
                          ) from None


class _Model:
    """A model's tables; scale : metres in the model's unit of length."""

    def __init__(self, model: dict, path: Path):
        units = model.get("units", "Meters")
        metres = {"Meters": 1.0, "Millimeters": 0.001, "Centimeters": 0.01, "Feet": 0.3048, "Inches": 0.0254}
        if units not in metres:
            raise NotImported(f"has the units {units!r}; known are {', '.join(metres)}")
        self.model, self.scale = model, metres[units]
        self.radiance = (model.get("properties") or {}).get("radiance") or {}
        self.modifiers = {m["identifier"]: m for m in self.radiance.get("modifiers") or []}
        self.sets = {s["identifier"]: s for s in self.radiance.get("modifier_sets") or []}
        self.found = Imported(model.get("display_name") or model.get("identifier") or path.stem)
        self.apertures = self.doors = self.air = 0

    def read(self) -> Imported:
        """The contents of the model."""
        names = set()
        for room in self.model.get("rooms") or []:
            name = room.get("display_name") or room["identifier"]
            if name in names:
                name = room["identifier"]
            names.add(name)
            self.found.spaces.append(Space(name, [self._face(face, room) for face in room["faces"]]))
            for shade in room.get("indoor_shades") or []:
                self._shade(shade)
            for face in room["faces"]:
                for shade in face.get("indoor_shades") or []:
                    self._shade(shade)
        for shade in self.model.get("orphaned_shades") or []:
            self._shade(shade)
        for mesh in self.model.get("shade_meshes") or []:
            self._mesh(mesh)
        for face in self.model.get("orphaned_faces") or []:
            self.found.faces.append((str(face.get("identifier")), self._face(face, {})))
        self._left_out()
        return self.found

    def _points(self, points) -> np.ndarray:
        ring = np.array(points, dtype=float).reshape(-1, 3) * self.scale
        if len(ring) < 3 or not np.isfinite(ring).all() or np.abs(ring).max() > 1e9:
            raise NotImported("has a face with fewer than three corners, or one that is not a finite number")
        return ring

    def _rings(self, geometry: dict) -> tuple[np.ndarray, ...]:
        return tuple(self._points(ring) for ring in (geometry["boundary"], *(geometry.get("holes") or ())))

    def _face(self, face: dict, room: dict) -> ImportedFace:
        self.apertures += len(face.get("apertures") or ())
        self.doors += len(face.get("doors") or ())
        kind = face.get("face_type", "Wall")
        self.air += kind == "AirBoundary"
        own = ((face.get("properties") or {}).get("radiance") or {}).get("modifier")
        finish = self._finish(own or self._of_set(room, kind, face), kind)
        return ImportedFace(self._rings(face["geometry"]), finish, FACE_KINDS.get(kind, ""))

    def _of_set(self, room: dict, kind: str, face: dict):
        """The modifier of a kind of face in the room's set, else in the model's."""
        sets = {"Wall": "wall_set", "Floor": "floor_set", "RoofCeiling": "roof_ceiling_set"}
        name = ((room.get("properties") or {}).get("radiance") or {}).get("modifier_set")
        for chosen in (name, self.radiance.get("global_modifier_set")):
            table = chosen if isinstance(chosen, dict) else self.sets.get(chosen, {})
            of_kind = table.get(sets.get(kind, "")) or {}
            outdoors = (face.get("boundary_condition") or {}).get("type") in ("Outdoors", "Ground")
            for side in (("exterior", "interior") if outdoors else ("interior", "exterior")):
                if of_kind.get(f"{side}_modifier"):
                    return of_kind[f"{side}_modifier"]
        return None

    def _finish(self, modifier, kind: str) -> str:
        """Name of a modifier's finish; for None that of Honeybee's generic modifier of the kind of face."""
        if isinstance(modifier, str):
            modifier = self.modifiers.get(modifier)
        if modifier is None:
            generic = {"Wall": 0.5, "Floor": 0.2, "RoofCeiling": 0.8}
            if kind not in generic:
                return ""
            name = f"generic_{FACE_KINDS[kind]}"
            self.found.finishes[name] = ImportedFinish(name, generic[kind],
                                                       remark="Honeybee's generic modifier")
            return name
        name = str(modifier["identifier"])
        if name not in self.found.finishes:
            self.found.finishes[name] = finish_of_modifier(name, modifier, self.found.not_carried)
        return name

    def _shade(self, shade: dict) -> None:
        own = ((shade.get("properties") or {}).get("radiance") or {}).get("modifier")
        name = shade.get("display_name") or shade["identifier"]
        self.found.things.append(Thing(str(name), [ImportedFace(self._rings(shade["geometry"]),
                                                        self._finish(own, ""))]))

    def _mesh(self, mesh: dict) -> None:
        own = ((mesh.get("properties") or {}).get("radiance") or {}).get("modifier")
        geometry, finish = mesh["geometry"], self._finish(own, "")
        vertices = self._points(geometry["vertices"])
        faces = []
        for index in geometry["faces"]:
            if min(index) < 0 or max(index) >= len(vertices):
                raise NotImported("has a mesh whose face names a vertex that it does not hold")
            faces.append(ImportedFace((vertices[list(index)],), finish))
        self.found.things.append(Thing(str(mesh.get("display_name") or mesh["identifier"]), faces))

    def _left_out(self) -> None:
        """List the contents that a scene cannot hold."""
        lost, radiance = self.found.not_carried, self.radiance
        if self.apertures:
            lost.append(f"{_count(self.apertures, 'aperture')}: the wall continues over them")
        if self.doors:
            lost.append(f"{_count(self.doors, 'door')}: the wall continues over them")
        if self.air:
            lost.append(f"{_count(self.air, 'air boundary')}, taken for walls: give the rooms as one in the "
                        "modeller")
        for key, word in (("sensor_grids", "sensor grid"), ("views", "view")):
            if radiance.get(key):
                lost.append(f"{_count(len(radiance[key]), word)}: grids and cameras of the scene are its own")
        others = [key for key in ("orphaned_apertures", "orphaned_doors") if self.model.get(key)]
        lost += [f"{len(self.model[key])} {key.replace('_', ' ')}" for key in others]
        if any(key in (self.model.get("properties") or {}) for key in ("energy",)):
            lost.append("energy properties (constructions, schedules, loads)")


def _count(n: int, word: str) -> str:
    plural = f"{word[:-1]}ies" if word.endswith("y") else f"{word}s"
    return f"{n} {word if n == 1 else plural}"
