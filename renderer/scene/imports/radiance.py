"""Radiance scene files: polygons, spheres, cylinders and rings with their materials, and luminaires."""

from collections import defaultdict
from pathlib import Path, PurePath

import numpy as np
import shapely

from renderer.scene.imports.modifiers import finish_of, rgb_luminance
from renderer.scene.imports.photometric_file import photometric_file
from renderer.scene.imports.radiance_text import Primitive, RadianceScene
from renderer.scene.imports.record import Imported, ImportedFace, ImportedLamp, NotImported, Thing
from renderer.scene.imports.shape import vector_area
from renderer.scene.model_files.beside import beside

CIRCLE_SIDES = 24
"""Flat sides of a cylinder, a cone or a ring, whose radius keeps the area of the circle."""
LIGHT_MATERIALS = ("light", "glow", "illum", "spotlight")


def read_radiance(path: Path, data: bytes) -> Imported:
    """Read a scene file of Radiance, and the files in its folder that it includes. Raises NotImported."""
    scene = RadianceScene(beside(path, path.parent))
    scene.read(data.decode("utf-8", errors="replace"), np.eye(4), path.name)
    if not scene.primitives:
        raise NotImported("holds no primitives of Radiance's scene language")
    return _Reader(scene, path).read()


class _Reader:
    """Reads a scene's primitives in order; a definition is valid for the primitives after it."""

    def __init__(self, scene: RadianceScene, path: Path):
        self.scene, self.path = scene, path
        self.found = Imported(path.stem, notes=["One unit of the file is read as a metre, its colours as "
                                                 "linear BT.709 reflectances"])
        self.defined: dict[str, Primitive] = {}
        self.skipped: dict[str, int] = defaultdict(int)
        self.shining: dict[tuple, list[tuple[Primitive, np.ndarray]]] = defaultdict(list)
        self.once: set[str] = set()

    def read(self) -> Imported:
        """The contents of the scene."""
        for item in self.scene.primitives:
            if item.kind in ("polygon", "sphere", "bubble", "cylinder", "tube", "cone", "cup", "ring"):
                self._surface(item)
            elif item.kind == "ies2rad":
                self._photometric(item.words[0], item.turn, item.name)
            elif item.kind == "alias":
                self.defined[item.name] = self.defined.get(item.words[0], item)
            else:
                self.defined[item.name] = item
                if item.kind in ("source", "instance", "mesh"):
                    self.skipped[item.kind] += 1
        for key, items in self.shining.items():
            self._panels(key, items)
        lost = self.found.not_carried
        lost += [f"{count} {kind}{'s' * (count > 1)}" for kind, count in self.skipped.items()]
        lost += [f"the command {line!r}" for line in self.scene.skipped]
        return self.found

    def _material(self, name: str) -> Primitive | None:
        """The material of a name; for a pattern or texture the material under it."""
        for _ in range(20):
            item = self.defined.get(name)
            if item is None or item.kind in (
                    "plastic", "plastic2", "metal", "metal2", "mirror", "trans", "trans2", "glass",
                    "dielectric", "interface", "antimatter", *LIGHT_MATERIALS):
                return item
            name = item.modifier
        return item

    def _surface(self, item: Primitive) -> None:
        material = self._material(item.modifier)
        if material is not None and material.kind in LIGHT_MATERIALS:
            self._light(item, material)
            return
        if material is not None and material.kind == "antimatter":
            self.skipped["surface of antimatter"] += 1
            return
        finish = "" if material is None else self._finish(material)
        if item.kind in ("sphere", "bubble"):
            *center, radius = self._numbers(item, 4)
            ball = np.array([*item.points(center)[0], abs(radius) * item.scale])
            self.found.things.append(Thing(item.name, [], ball, finish))
            return
        for ring in self._rings(item):
            self.found.faces.append((item.name.rpartition(".")[0] or item.name, ImportedFace(ring, finish)))

    def _finish(self, material: Primitive) -> str:
        if material.name not in self.found.finishes:
            self.found.finishes[material.name] = finish_of(material.name, material.kind, material.numbers,
                                                           self.found.not_carried)
            if material.modifier != "void":
                self.found.not_carried.append(f"the pattern or texture {material.modifier!r} of "
                                              f"{material.name!r}")
        return material.name

    def _numbers(self, item: Primitive, count: int) -> list[float]:
        if len(item.numbers) < count:
            raise NotImported(f"has the {item.kind} {item.name[:40]!r} with {len(item.numbers)} real "
                              f"arguments; must be {count}")
        return item.numbers[:count]

    def _rings(self, item: Primitive) -> list[tuple[np.ndarray, ...]]:
        """The polygons of a surface in the scene's coordinates, each with its holes. Raises NotImported."""
        if item.kind == "polygon":
            if len(item.numbers) < 9 or len(item.numbers) % 3:
                raise NotImported(f"has the polygon {item.name[:40]!r} with {len(item.numbers)} coordinates; "
                                  "must be three for each of three corners or more")
            return [(ring,) for ring in [item.points(item.numbers)]]
        if item.kind == "ring":
            *numbers, inner, outer = self._numbers(item, 8)
            rings = [_circle(np.array(numbers[:3]), np.array(numbers[3:6]), radius)
                     for radius in sorted((abs(inner), abs(outer)), reverse=True) if radius > 0]
            return [tuple(item.points(ring) for ring in rings)] if rings else []
        if item.kind in ("cylinder", "tube"):
            *numbers, radius = self._numbers(item, 7)
            ends = [radius, radius]
        else:
            *numbers, first, second = self._numbers(item, 8)
            ends = [first, second]
        a, b = np.array(numbers[:3]), np.array(numbers[3:6])
        low, high = (_circle(end, b - a, abs(r)) for end, r in ((a, ends[0]), (b, ends[1])))
        low_next, high_next = (np.roll(ring, -1, axis=0) for ring in (low, high))
        return [(item.points(np.stack(corners)),)
                for corners in zip(low, low_next, high_next, high, strict=True)]

    def _light(self, item: Primitive, material: Primitive) -> None:
        """Add a luminous surface: flat ones of one plane are joined later; any other becomes a point."""
        pattern = self.defined.get(material.modifier)
        if pattern is not None and pattern.kind == "brightdata":
            file = next((w for w in pattern.words if w.endswith(".dat")), "")
            if (pattern.name, item.turn.tobytes()) not in self.once:
                self.once.add((pattern.name, item.turn.tobytes()))
                self._photometric(file, item.turn, item.name)
            return
        if material.kind in ("illum", "spotlight") and material.kind not in self.once:
            self.once.add(material.kind)
            self.found.not_carried.append(f"the {material.kind} {material.name!r}: it is a plain light")
        cd = rgb_luminance((*material.numbers, 0, 0, 0)[:3])
        if len(set(material.numbers[:3])) > 1 and material.name not in self.once:
            self.once.add(material.name)
            self.found.not_carried.append(f"the colour of the light {material.name!r}: give it a spectrum")
        if item.kind == "polygon" or (item.kind == "ring" and min(item.numbers[6:8]) <= 0):
            self.shining[(material.name, material.kind, cd)].append((item, self._rings(item)[0][0]))
            return
        if item.kind in ("sphere", "bubble"):
            *center, radius = self._numbers(item, 4)
            middle, area = item.points(center)[0], 4 * np.pi * (radius * item.scale) ** 2
        else:
            rings = [ring for parts in self._rings(item) for ring in parts]
            middle = np.concatenate(rings).mean(axis=0)
            area = sum(np.linalg.norm(vector_area(ring)) for ring in rings)
            self.found.not_carried.append(f"the shape of the {item.kind} {item.name!r}: it shines as a point")
        self.found.lamps.append(ImportedLamp(item.name, "point", middle, flux=np.pi * cd * area))

    def _panels(self, key: tuple, items: list) -> None:
        """Add rectangles and discs for the polygons of one light material, adjoining ones of one plane as
        one."""
        name, _, cd = key
        planes = defaultdict(list)
        for item, ring in items:
            area = vector_area(ring)
            size = np.linalg.norm(area)
            if size == 0:
                continue
            if item.kind == "ring":
                self.found.lamps.append(ImportedLamp(item.name, "disc", ring.mean(axis=0), area / size,
                                             flux=np.pi * cd * size, diameter=2 * np.sqrt(size / np.pi)))
                continue
            normal = area / size
            plane = *np.round(normal, 5), round(float(normal @ ring[0]), 5)
            planes[plane].append((item.name, ring, normal))
        for rings in planes.values():
            self._of_plane(name, cd, rings)

    def _of_plane(self, name: str, cd: float, rings: list) -> None:
        normal, origin = rings[0][2], rings[0][1][0]
        edges = np.concatenate([np.roll(ring, -1, axis=0) - ring for _, ring, _ in rings])
        lengths = np.round(np.linalg.norm(edges, axis=1) / np.abs(edges).max(), 6)
        along = edges[np.lexsort((np.abs(edges[:, 0]), lengths))[-1]]  # of equal ones that along x
        along = along * np.sign(along[np.abs(along).argmax()])
        axes = np.stack([along, np.cross(normal, along)]) / np.linalg.norm(along)
        flat = [shapely.Polygon((ring - origin) @ axes.T) for _, ring, _ in rings]
        whole = shapely.union_all([shape if shape.is_valid else shape.buffer(0) for shape in flat],
                                  grid_size=1e-6)
        for shape in getattr(whole, "geoms", [whole]):
            if shape.geom_type != "Polygon" or shape.is_empty:
                continue
            own = next((n for (n, _, _), f in zip(rings, flat, strict=True) if f.intersects(shape)), name)
            box = shapely.box(*shape.bounds)
            low_x, low_y, high_x, high_y = shape.bounds
            size, middle, remark = (high_x - low_x, high_y - low_y), box.centroid, ""
            if shape.area < 0.999 * box.area:
                shrink = np.sqrt(shape.area / box.area)
                size, middle = (size[0] * shrink, size[1] * shrink), shape.representative_point()
                remark = "of another shape in the file; a rectangle of its area"
                self.found.not_carried.append(f"the shape of the light {own!r}: a rectangle of its area")
            center = origin + np.array([middle.x, middle.y]) @ axes
            self.found.lamps.append(ImportedLamp(own, "rectangle", center, normal, axes[0], size,
                                         flux=np.pi * cd * shape.area, remark=remark))

    def _photometric(self, file: str, turn: np.ndarray, name: str) -> None:
        """Add a luminaire of ies2rad with its photometric file, where that lies beside the scene."""
        stem = PurePath(file.replace("\\", "/")).with_suffix("")
        for ending in (".ies", ".IES", ".ldt", ".LDT"):
            photometry = photometric_file(f"{stem}{ending}", self.path)
            if photometry is not None:
                rotation = turn[:3, :3] / np.cbrt(abs(np.linalg.det(turn[:3, :3])))
                self.found.lamps.append(ImportedLamp(name, "ies", turn[:3, 3], -rotation[:, 2],
                                                     rotation[:, 0], file=photometry))
                return
        self.found.not_carried.append(f"the luminaire {name!r} ({PurePath(file).name or 'ies2rad'}): put "
                                       f"{stem.name}.ies, from which ies2rad made it, beside the scene")


def _circle(center: np.ndarray, axis: np.ndarray, radius: float) -> np.ndarray:
    """Corners (CIRCLE_SIDES, 3) of a polygon of the area of a circle, counter-clockwise about its axis."""
    length = np.linalg.norm(axis)
    axis = axis / length if length else np.array([0.0, 0.0, 1.0])
    x = np.cross(np.eye(3)[np.abs(axis).argmin()], axis)
    x /= np.linalg.norm(x)
    angle = 2 * np.pi * np.arange(CIRCLE_SIDES) / CIRCLE_SIDES
    outer = radius * np.sqrt(2 * np.pi / (CIRCLE_SIDES * np.sin(2 * np.pi / CIRCLE_SIDES)))
    return center + outer * (np.cos(angle)[:, None] * x + np.sin(angle)[:, None] * np.cross(axis, x))
