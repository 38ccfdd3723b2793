"""3MF files (3MF Core Specification 1.3, Production Extension 1.1): z up, in their stated unit."""

import io
import zipfile
from xml.etree import ElementTree

import numpy as np

from renderer.scene.model_files.record import ModelFile, Piece, Unreadable
from renderer.scene.model_files.textures import srgb_decoded
from renderer.scene.model_files.xml_safety import refuse_entities

METRES = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 0.01, "inch": 0.0254, "foot": 0.3048,
          "meter": 1.0}


def read_3mf(data: bytes) -> ModelFile:
    """Read the build items of a 3MF file: objects with their components and colours. Raises Unreadable."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > 1 << 30:
                raise Unreadable("unpacks to more than 1 GiB")
            texts = {f"/{entry.filename}".lower(): archive.read(entry) for entry in archive.infolist()
                     if entry.filename.lower().endswith((".model", ".rels"))}
    except zipfile.BadZipFile:
        raise Unreadable("is no 3MF: it is not a ZIP archive; export it again") from None
    for text in texts.values():
        refuse_entities(text)
    return _Package(texts).file()


class _Package:
    """The model parts of a package, by their paths in lower case."""

    def __init__(self, texts: dict[str, bytes]):
        self.texts, self.roots = texts, {}
        self.colours: dict[tuple[str, str], list[np.ndarray]] = {}
        self.lattice, self.placed = False, 0

    def root(self, path: str) -> ElementTree.Element:
        if path not in self.texts:
            raise Unreadable(f"names its part {path[:60]!r}, which it does not hold; export it again")
        if path not in self.roots:
            root = ElementTree.fromstring(self.texts[path])
            self.roots[path] = root
            for group in (*root.iterfind(".//{*}basematerials"), *root.iterfind(".//{*}colorgroup")):
                self.colours[path, group.get("id")] = [_colour(each) for each in group]
        return self.roots[path]

    def file(self) -> ModelFile:
        """All items that the package builds."""
        start = "/3d/3dmodel.model"
        for name, text in self.texts.items():
            if name.endswith("_rels/.rels"):
                for said in ElementTree.fromstring(text):
                    if said.get("Type", "").endswith("/3dmodel"):
                        start = "/" + said.get("Target").lower().lstrip("/")
        root, pieces = self.root(start), []
        for item in root.find("{*}build"):
            pieces += self.object(_path(item, start), item.get("objectid"), _matrix(item), (), 0)
        instead = "a lattice of beams" if self.lattice else ""
        return ModelFile(pieces, metres=METRES[root.get("unit", "millimeter")], said=True, instead=instead)

    def object(self, path: str, index: str, matrix: np.ndarray, names: tuple[str, ...], depth: int
               ) -> list[Piece]:
        """Pieces of an object and its components by a transform (4, 4). Raises Unreadable."""
        self.placed += 1
        if depth > 200 or self.placed > 100_000:
            raise Unreadable("has objects that are their own components, or too many; export it again")
        objects = self.root(path).iterfind(".//{*}object")
        found = next((each for each in objects if each.get("id") == index), None)
        if found is None:
            raise Unreadable(f"builds the object {str(index)[:20]!r}, which it does not hold; export it "
                             "again")
        names = (found.get("name"), *names) if found.get("name") else names
        pieces = []
        for part in found.iterfind("{*}components/{*}component"):
            pieces += self.object(_path(part, path), part.get("objectid"), matrix @ _matrix(part), names,
                                  depth + 1)
        mesh = found.find("{*}mesh")
        return pieces if mesh is None else [*pieces, *self.mesh(found, mesh, path, matrix, names)]

    def mesh(self, owner, mesh, path: str, matrix: np.ndarray, names: tuple[str, ...]) -> list[Piece]:
        """A piece for each colour of a mesh."""
        self.lattice |= mesh.find("{*}beamlattice") is not None
        corners = np.array([[float(v.get(k)) for k in "xyz"] for v in mesh.iterfind("{*}vertices/{*}vertex")])
        vertices = corners.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        turn = (0, 2, 1) if np.linalg.det(matrix[:3, :3]) < 0 else (0, 1, 2)
        of_colour: dict[tuple, list] = {}
        for t in mesh.iterfind("{*}triangles/{*}triangle"):
            group = t.get("pid", owner.get("pid")) if t.get("p1") else owner.get("pid")
            key = (group, t.get("p1") or owner.get("pindex", "0"))
            of_colour.setdefault(key, []).append([int(t.get("v1")), int(t.get("v2")), int(t.get("v3"))])
        pieces = []
        for (group, place), triangles in of_colour.items():
            known, number = self.colours.get((path, group), []), int(place)
            colour = known[number] if 0 <= number < len(known) else None
            used, local = np.unique(np.array(triangles)[:, turn], return_inverse=True)
            if not 0 <= used[0] <= used[-1] < len(vertices):
                raise Unreadable("has a face whose vertex it does not hold; export it again")
            pieces.append(Piece.of_triangles(vertices[used], local, names, colour))
        return pieces


def _path(element, own: str) -> str:
    """The part of the package in which a named object is."""
    said = next((value for key, value in element.attrib.items() if key.endswith("}path")), None)
    return own if said is None else said.lower()


def _matrix(element) -> np.ndarray:
    """The transform (4, 4) of an item or a component, which is given by its columns."""
    matrix = np.eye(4)
    if element.get("transform"):
        matrix[:3] = np.array(element.get("transform").split(), dtype=float).reshape(4, 3).T
    return matrix


def _colour(element) -> np.ndarray | None:
    """Linear BT.709 reflectance (3,) of an sRGB colour "#rrggbb" or "#rrggbbaa"."""
    said = (element.get("displaycolor") or element.get("color") or "").lstrip("#")
    return srgb_decoded(np.array(list(bytes.fromhex(said[:6]))) / 255) if len(said) >= 6 else None
