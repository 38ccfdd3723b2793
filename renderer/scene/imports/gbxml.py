"""Files of gbXML, the rooms of energy models (www.gbxml.org): spaces, surfaces, reflectances of
constructions."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

from renderer.scene.imports.record import Imported, ImportedFace, ImportedFinish, NotImported, Space
from renderer.scene.imports.sorting import encloses
from renderer.scene.model_files.record import Unreadable
from renderer.scene.model_files.xml_safety import refuse_entities


def read_gbxml(path: Path, data: bytes) -> Imported:
    """Read a gbXML file. Raises NotImported."""
    try:
        refuse_entities(data)
        root = ElementTree.fromstring(data)
    except Unreadable as fault:
        raise NotImported(str(fault)) from None
    except (ElementTree.ParseError, ValueError, LookupError) as fault:
        raise NotImported(f"is no XML that can be parsed ({' '.join(str(fault).split())[:80]})") from None
    for element in root.iter():
        if isinstance(element.tag, str):
            element.tag = element.tag.rpartition("}")[2]
    if root.tag != "gbXML":
        raise NotImported(f"is XML, but no gbXML: its root is {root.tag[:40]!r}")
    return _File(root, path).read()


class _File:
    """A file's elements; scale : metres in the file's unit of length."""

    def __init__(self, root, path: Path):
        units = root.get("lengthUnit", "Meters")
        metres = {"Meters": 1.0, "Kilometers": 1000.0, "Centimeters": 0.01, "Millimeters": 0.001,
                  "Feet": 0.3048, "Inches": 0.0254, "Yards": 0.9144, "Miles": 1609.344}
        if units not in metres:
            raise NotImported(f"has the lengthUnit {units[:40]!r}; known are {', '.join(metres)}")
        self.root, self.scale = root, metres[units]
        self.found = Imported(_text(root.find("Campus/Building/Name")) or _text(root.find("Campus/Name"))
                              or path.stem)
        self.constructions = {item.get("id"): item for item in root.iter("Construction")}
        self.surfaces = {item.get("id"): item for item in root.iter("Surface")}
        self.openings = self.air = self.solar = 0

    def read(self) -> Imported:
        """The contents of the file."""
        names = set()
        for space in self.root.iter("Space"):
            name = _text(space.find("Name")) or space.get("id") or "space"
            if name in names:
                name = f"{name} {space.get('id')}"
            names.add(name)
            faces = self._faces(space)
            if faces:
                self.found.spaces.append(Space(name, faces))
            else:
                self.found.not_carried.append(f"the space {name!r}, which has no faces")
        if not self.found.spaces:
            raise NotImported("holds no space with faces; export it with its geometry (spaces as volumes)")
        self._left_out()
        return self.found

    def _faces(self, space) -> list[ImportedFace]:
        """The faces around a space: its boundaries, its shell or the surfaces beside it, whichever closes
        first."""
        boundaries = [(self.surfaces.get(item.get("surfaceIdRef")), item)
                      for item in space.findall("SpaceBoundary")]
        beside = [(surface, surface) for surface in self.surfaces.values()
                  if space.get("id") in [item.get("spaceIdRef") for item in surface.iter("AdjacentSpaceId")]]
        for surface, _ in beside:
            self.openings += len(surface.findall("Opening"))
            self.air += surface.get("surfaceType") == "Air"
        shell = space.find("ShellGeometry/ClosedShell")
        loops = [] if shell is None else [(None, item) for item in shell.findall("PolyLoop")]
        first: list[ImportedFace] = []
        for chosen in (boundaries, loops, beside):
            faces = [face for surface, item in chosen for face in self._face(surface, item)]
            if len(faces) >= 4 and encloses(faces):
                return self._with_finishes(faces, beside)
            first = first or faces
        return self._with_finishes(first, beside) if len(first) >= 4 else []

    def _face(self, surface, item) -> list[ImportedFace]:
        loop = item if item.tag == "PolyLoop" else item.find("PlanarGeometry/PolyLoop")
        if loop is None:
            return []
        try:
            points = [[float(_text(x)) for x in point.findall("Coordinate")]
                      for point in loop.findall("CartesianPoint")]
            ring = np.array(points, dtype=float).reshape(-1, 3) * self.scale
        except (TypeError, ValueError):
            raise NotImported("has a PolyLoop whose points are not three numbers each; export it again"
                              ) from None
        if len(ring) < 3 or not np.isfinite(ring).all() or np.abs(ring).max() > 1e9:
            raise NotImported("has a PolyLoop with fewer than three points, or one that is not finite")
        # InteriorFloor is not listed: it is the floor of one space and the ceiling of another.
        kinds = {
            "Ceiling": "ceiling", "Roof": "ceiling", "UndergroundCeiling": "ceiling", "SlabOnGrade": "floor",
            "UndergroundSlab": "floor", "RaisedFloor": "floor", "ExposedFloor": "floor",
            "InteriorWall": "walls", "ExteriorWall": "walls", "UndergroundWall": "walls", "Air": "walls"}
        kind = "" if surface is None else kinds.get(surface.get("surfaceType"), "")
        return [ImportedFace((ring,), "" if surface is None else self._finish(surface), kind)]

    def _with_finishes(self, faces: list[ImportedFace], beside: list) -> list[ImportedFace]:
        """Faces of a shell, which refers to no surface, with the finish of the surface in the same place."""
        if all(face.finish or face.kind for face in faces):
            return faces
        known = [face for surface, item in beside for face in self._face(surface, item)]
        result = []
        for face in faces:
            middle, extent = face.rings[0].mean(axis=0), np.ptp(face.rings[0], axis=0).max()
            same = [k for k in known if np.linalg.norm(k.rings[0].mean(axis=0) - middle) < 0.05 * extent]
            result.append(face if face.finish or not same else
                          ImportedFace(face.rings, same[0].finish, face.kind or same[0].kind))
        return result

    def _finish(self, surface) -> str:
        """Name of the finish of a surface's construction; "" for one without a reflectance of visible
        light."""
        item = self.constructions.get(surface.get("constructionIdRef"))
        visible = ("IntVisible", "ExtVisible")  # the inner side before the outer
        places = [surface] if item is None else [surface, item]
        for place in places:
            given = {each.get("type"): each for each in place.findall("Reflectance")}
            self.solar += any(kind not in visible for kind in given)
            for kind in visible:
                if kind in given:
                    name = _text(place.find("Name")) or place.get("id")
                    finish = ImportedFinish(name, _share(given[kind]), remark=kind)
                    self.found.finishes.setdefault(name, finish)
                    return name
        return ""

    def _left_out(self) -> None:
        lost = self.found.not_carried
        if self.openings:
            lost.append("openings (windows, doors, skylights): the wall continues over them")
        if self.air:
            lost.append("surfaces of air, taken for walls")
        if self.solar:
            lost.append("solar reflectances (IntSolar, ExtSolar): light is reflected by IntVisible")
        counts = {tag: len(list(self.root.iter(tag))) for tag in
                  ("LightingSystem", "Lighting", "IntEquip", "ExtEquip", "HydronicLoop", "AirLoop",
                   "Schedule")}
        said = [f"{count} {tag}" for tag, count in counts.items() if count]
        if said:
            lost.append(f"{', '.join(said)}: gbXML places no luminaires")
        if any(self.root.iter("LightPowerPerArea")):
            lost.append("lighting power per area")


def _text(element) -> str:
    return "" if element is None or element.text is None else " ".join(element.text.split())


def _share(element) -> float:
    """A Reflectance as a fraction. Many files give a fraction the unit Percent. Raises NotImported."""
    try:
        number = float(_text(element))
    except ValueError:
        raise NotImported(f"has a Reflectance of {_text(element)[:40]!r}; must be a number") from None
    if element.get("unit") == "Percent" and number > 1:
        number /= 100
    if not 0 <= number <= 1:
        raise NotImported(f"has a Reflectance of {number:g}; must be from 0 to 1, or in Percent")
    return number
