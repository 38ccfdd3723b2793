"""The contents of an IFC file, read by ifcopenshell in the process that `ifc` starts."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from renderer.scene.imports.ifc_lamps import fixture_lamps
from renderer.scene.imports.ifc_plan import rooms_of_walls
from renderer.scene.imports.record import Imported, ImportedFace, ImportedFinish, NotImported, Space, Thing
from renderer.scene.model_files.textures import srgb_decoded


def read_ifc_model(path: Path) -> Imported:
    """Read an IFC file. Raises NotImported."""
    import ifcopenshell
    import ifcopenshell.geom

    try:
        model = ifcopenshell.open(str(path))
    except Exception as fault:  # noqa: BLE001  ifcopenshell raises errors of any class for faulty files
        reason = " ".join(str(fault).split())[:80]
        raise NotImported(f"is no IFC file that can be parsed ({reason})") from None
    if not hasattr(model, "by_type"):
        raise NotImported("is no IFC file that can be parsed")
    reader = _Reader(model, path)
    return reader.read()


class _Reader:
    """A model and the contents read from it."""

    def __init__(self, model, path: Path):
        self.model, self.path = model, path
        projects = self.of_type("IfcProject")
        title = next((p.LongName or p.Name for p in projects if p.LongName or p.Name), path.stem)
        self.found = Imported(title, notes=[f"{path.name}: {model.schema}, by ifcopenshell"])
        self.reflectances = self._given_reflectances()

    def of_type(self, *kinds: str) -> list:
        """All things of some classes, each once; classes that the file's schema does not have count as
        empty."""
        found = {}
        for kind in kinds:
            try:
                found.update((item.id(), item) for item in self.model.by_type(kind))
            except RuntimeError:  # the schema has no such class
                continue
        return list(found.values())

    def read(self) -> Imported:
        """Rooms, furniture and lamps of the model."""
        fixtures = self._fixtures()
        chosen = {item.id() for item in fixtures}
        spaces = [space for space in self.of_type("IfcSpace")
                  if getattr(space, "PredefinedType", None) != "EXTERNAL"]
        boxes = {}
        for item, faces in self._shapes(spaces):
            name = " ".join(dict.fromkeys(x for x in (item.Name, item.LongName) if x)) or item.GlobalId
            self.found.spaces.append(Space(self._once(name), faces))
        # Plates and members are missing: most are parts of curtain walls.
        classes = (
            "IfcFurnishingElement", "IfcBuildingElementProxy", "IfcColumn", "IfcBeam", "IfcStair",
            "IfcStairFlight", "IfcRamp", "IfcRampFlight", "IfcRailing", "IfcSanitaryTerminal",
            "IfcElectricAppliance", "IfcFlowTerminal", "IfcAudioVisualAppliance",
            "IfcTransportElement", "IfcSpaceHeater")
        furniture = [item for item in self.of_type(*classes) if item.id() not in chosen]
        for item, faces in self._shapes(furniture, colours=True):
            self.found.things.append(Thing(item.Name or item.is_a(), faces))
        for item, faces in self._shapes(fixtures):
            points = np.concatenate([face.rings[0] for face in faces])
            boxes[item.id()] = np.array([points.min(axis=0), points.max(axis=0)])
        self.found.lamps.extend(fixture_lamps(self.model, fixtures, boxes, self.path, self.found.not_carried))
        if not self.found.spaces:
            self._rooms_of_walls(len(spaces))
        elif len(self.found.spaces) < len(spaces):
            self.found.not_carried.append(f"{len(spaces) - len(self.found.spaces)} spaces without a shape")
        counts = [(kind, len(self.of_type(kind))) for kind in (
            "IfcWindow", "IfcDoor", "IfcOpeningElement", "IfcCurtainWall", "IfcPlate", "IfcMember")]
        said = [f"{count} {kind}" for kind, count in counts if count]
        if said:
            self.found.not_carried.append(f"{', '.join(said)}: the wall continues over them")
        return self.found

    def _once(self, name: str) -> str:
        names, k, plain = {space.name for space in self.found.spaces}, 2, name
        while name in names:
            name, k = f"{plain} {k}", k + 1
        return name

    def _fixtures(self) -> list:
        """Light fixtures; in IFC2x3 these are flow terminals with a light fixture's type. Switches are left
        out."""
        found = self.of_type("IfcLightFixture")
        for kind in self.of_type("IfcLightFixtureType"):
            for relation in (*getattr(kind, "ObjectTypeOf", ()), *getattr(kind, "Types", ())):
                found += [item for item in relation.RelatedObjects if item not in found]
        return [item for item in found if "switch" not in (item.Name or "").lower()]

    def _shapes(self, items: list, colours: bool = False) -> Iterator[tuple]:
        """Each thing with a shape, and its triangles [m]."""
        import ifcopenshell.geom

        if not items:
            return
        settings = ifcopenshell.geom.settings()
        settings.set("use-world-coords", True)
        settings.set("weld-vertices", True)
        iterator = ifcopenshell.geom.iterator(settings, self.model, 2, include=items)
        if not iterator.initialize():
            return
        while True:
            shape = iterator.get()
            geometry = shape.geometry
            vertices = np.array(geometry.verts, dtype=float).reshape(-1, 3)
            triangles = np.array(geometry.faces, dtype=int).reshape(-1, 3)
            if len(triangles) and np.isfinite(vertices).all() and np.abs(vertices).max() < 1e9:
                item = self.model.by_id(shape.id)
                names = [self._finish(item, style, colours) for style in geometry.materials] or [""]
                index = list(geometry.material_ids) or [-1] * len(triangles)
                yield item, [ImportedFace((vertices[t],), names[k] if 0 <= k < len(names) else "")
                             for t, k in zip(triangles, index, strict=True)]
            if not iterator.next():
                return

    def _finish(self, item, style, colours: bool) -> str:
        """Name of a style's finish: of its stated reflectance, else of its colour where `colours` is set."""
        given = self.reflectances.get(style.instance_id())
        if given is None and not colours:
            return ""
        if given is not None:
            self.found.finishes.setdefault(given.name, given)
            return given.name
        colour = np.array([style.diffuse.r(), style.diffuse.g(), style.diffuse.b()])
        if style.instance_id() == 0 or not np.isfinite(colour).all():
            return ""  # the default of ifcopenshell for things without a style
        styles = self._style_name(style.instance_id())
        name, k = styles or style.name, 2
        finish = ImportedFinish.of(name, srgb_decoded(np.clip(colour, 0.0, 1.0)), "its colour on screen")
        while name in self.found.finishes and self.found.finishes[name] != finish:
            name, k = f"{styles or style.name}_{k}", k + 1
            finish = ImportedFinish(name, finish.reflectance, finish.rgb, finish.remark)
        self.found.finishes[name] = finish
        return name

    def _style_name(self, number: int) -> str | None:
        """Name of the surface style of the rendering with that number."""
        item = self.model.by_id(number)
        if item.is_a("IfcSurfaceStyle"):
            return item.Name
        return next((other.Name for other in self.model.get_inverse(item) if other.is_a("IfcSurfaceStyle")),
                    None)

    def _given_reflectances(self) -> dict[int, ImportedFinish]:
        """Finishes of surface styles with diffuse reflectances (IfcSurfaceStyleLighting), by the numbers of
        the styles and of their parts."""
        found = {}
        for style in self.of_type("IfcSurfaceStyle"):
            for part in style.Styles:
                if part.is_a("IfcSurfaceStyleLighting"):
                    colour = part.DiffuseReflectionColour
                    finish = ImportedFinish.of(style.Name or f"style_{style.id()}",
                                       [colour.Red, colour.Green, colour.Blue],
                                       "diffuse reflectance in the file")
                    found.update((each.id(), finish) for each in (style, *style.Styles))
        return found

    def _rooms_of_walls(self, spaces: int) -> None:
        """Add the rooms between walls, for a file without spaces that have a shape. Raises NotImported."""
        walls = list(self._shapes(self.of_type("IfcWall", "IfcDoor", "IfcWindow", "IfcCurtainWall",
                                               "IfcPlate", "IfcMember", "IfcColumn")))
        slabs = list(self._shapes(self.of_type("IfcSlab", "IfcRoof", "IfcCovering")))
        self.found.spaces.extend(rooms_of_walls(
            [np.array([face.rings[0] for face in faces]) for _, faces in walls],
            np.array([face.rings[0] for _, faces in slabs for face in faces]).reshape(-1, 3, 3)))
        if self.found.spaces:
            self.found.notes.append("The file has no spaces: rooms are the areas between its walls")
            return
        self.found.faces.extend((item.Name or item.is_a(), face) for item, faces in [*walls, *slabs]
                                for face in faces)
        if not self.found.things and not self.found.faces:
            raise NotImported(f"has {spaces} spaces, none with a shape, and no walls that enclose a room; "
                              "export it with its rooms (IfcSpace) as volumes")
        self.found.notes.append("The file has no spaces, and its walls enclose none in plan: rooms are the "
                                "cavities between walls and slabs, where there are any")
