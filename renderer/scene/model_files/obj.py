"""The reader of Wavefront OBJ files, with the colours of their material libraries."""

from collections import defaultdict
from pathlib import PurePath

import numpy as np

from renderer.scene.model_files.record import Beside, ModelFile, Piece, Unreadable
from renderer.scene.model_files.textures import mean_colour, srgb_decoded, without_texture
from renderer.scene.model_files.triangulate import newell


def read_obj(data: bytes, beside: Beside) -> ModelFile:
    """Read an OBJ file with relative indices, groups and MTL colours. Raises Unreadable."""
    reader = _Reader()
    wide = data[:2] in (b"\xff\xfe", b"\xfe\xff")
    text = data.decode("utf-16" if wide else "utf-8-sig", errors="replace")
    text = text.replace("\\\r\n", " ").replace("\\\n", " ")
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if words and words[0] in ("v", "vt", "f", "fo"):
            words = line.partition("#")[0].split()
        if words:
            try:
                reader.take(words, line)
            except (ValueError, IndexError) as fault:
                raise Unreadable(f"has a faulty line {number}, {' '.join(line.split())[:60]!r}"
                                 f"{_because(fault)}; export it again") from None
    colours, notes = _Colours(beside), []
    for library in reader.libraries:
        colours.load(library, notes)
    vertices = np.array(reader.vertices, dtype=float).reshape(-1, 3)
    places = np.array(reader.places, dtype=float).reshape(-1, 2)
    pieces, most = [], max((max(c, default=0) for c, _, _ in reader.groups.values()), default=0)
    if most >= len(vertices) > 0:
        raise Unreadable(f"has a face with vertex {most + 1} of {len(vertices)}; export it again")
    for names, (corners, sizes, textured) in reader.groups.items():
        corners, sizes = np.array(corners, dtype=np.int64), np.array(sizes, dtype=np.int64)
        used, local = np.unique(corners, return_inverse=True)
        piece = Piece(vertices[used], local.ravel(), sizes, tuple(n for n in names if n))
        lowest, highest = min(textured, default=-1), max(textured, default=-1)
        whole = len(textured) == len(corners) and 0 <= lowest <= highest < len(places)
        uv = places[textured] if whole else None
        colour = colours.of(names[0], piece, uv)
        pieces.append(Piece(piece.vertices, piece.corners, sizes, piece.names, colour))
    if reader.curved:
        if not any(len(piece.sizes) for piece in pieces):
            raise Unreadable("holds free-form surfaces (surf) and no polygons; export it as polygons")
        are = "s are" if reader.curved > 1 else " is"
        notes.append(f"its {reader.curved} free-form surface{are} not read")
    return ModelFile(pieces, notes=notes + colours.notes + colours.missing(reader.used),
                     instead="points or lines" if len(vertices) else "")


def _because(fault: Exception) -> str:
    return f" ({fault})" if fault.args and "literal" not in str(fault) and "index" not in str(fault) else ""


class _Reader:
    """State of the reader from line to line; a group is a combination of material, group and object."""

    def __init__(self):
        self.vertices, self.places, self.libraries = [], [], []
        self.groups = defaultdict(lambda: ([], [], []))
        self.state = {"usemtl": "", "g": "", "o": ""}
        self.used, self.curved = set(), 0

    def take(self, words: list[str], line: str) -> None:
        word = words[0]
        if word == "v":
            self.vertices.append((float(words[1]), float(words[2]), float(words[3])))
        elif word == "vt":
            self.places.append((float(words[1]), float(words[2]) if len(words) > 2 else 0.0))
        elif word in ("f", "fo"):  # fo: of old files
            self.face(words[1:])
        elif word == "surf":
            self.curved += 1
        elif word in self.state:
            self.state[word] = line.strip()[len(word):].strip()
            if word == "usemtl":
                self.used.add(self.state[word])
        elif word == "mtllib":
            self.libraries.append(line.strip()[len(word):].strip())

    def face(self, words: list[str]) -> None:
        corners, sizes, textured = self.groups[tuple(self.state.values())]
        if len(words) < 3:
            return  # a point or a line
        for word in words:
            place, _, rest = word.partition("/")
            corners.append(_index(place, len(self.vertices)))
            place = rest.partition("/")[0]
            textured.append(_index(place, len(self.places)) if place else -1)
        sizes.append(len(words))


def _index(word: str, count: int) -> int:
    """Index into a list of `count` entries, from a number that counts from 1, or from the end where
    negative."""
    index = int(word)
    if index == 0 or index < -count:
        raise ValueError(f"it names number {index} of {count} given before it")
    return index - 1 if index > 0 else count + index


class _Colours:
    """Diffuse colours of material libraries (MTL): Kd and map_Kd, both in sRGB."""

    def __init__(self, beside: Beside):
        self.beside = beside
        self.materials: dict[str, dict[str, str]] = {}
        self.images: dict[str, bytes | None] = {}
        self.notes: list[str] = []

    def load(self, library: str, notes: list[str]) -> None:
        """Add the materials of a library; `library` may name several files."""
        try:
            texts = [self.beside(library)]
        except Unreadable as fault:
            if len(library.split()) < 2:
                notes.append(f"it {fault}: its colours are not known")
                return
            texts = []
            for name in library.split():
                try:
                    texts.append(self.beside(name))
                except Unreadable as missing:
                    notes.append(f"it {missing}: its colours are not known")
        for text in texts:
            current: dict[str, str] = {}
            for line in text.decode("utf-8-sig", errors="replace").splitlines():
                word, *rest = line.split(None, 1) or [""]
                if word == "newmtl":
                    current = self.materials.setdefault("".join(rest).strip(), {})
                elif word.lower() in ("kd", "map_kd"):
                    current[word.lower()] = "".join(rest).strip()

    def of(self, name: str, piece: Piece, uv: np.ndarray | None) -> np.ndarray | None:
        """Linear BT.709 reflectance (3,) of a material; None where it has no colour.

        uv : (m, 2) texture coordinates of the piece's corners, for the mean over a texture
        """
        material = self.materials.get(name, {})
        colour = None
        if "kd" in material:
            try:
                values = [float(x) for x in material["kd"].split()[:3]]
                colour = srgb_decoded(np.resize(values, 3)) if values else None
            except ValueError:
                colour = None
            if colour is not None and not np.isfinite(colour).all():
                colour = None
        texture = self._texture(material.get("map_kd", ""), piece, uv)
        if texture is None:
            return without_texture(colour) if material.get("map_kd") else colour
        # Exporters leave Kd black, or leave it out, beside a texture.
        return texture if colour is None or not colour.any() else texture * colour

    def _texture(self, said: str, piece: Piece, uv: np.ndarray | None) -> np.ndarray | None:
        words = said.split()
        for name in dict.fromkeys((said, words[-1] if words else "")):  # options come before the name
            if name and name not in self.images:
                try:
                    self.images[name] = self.beside(name)
                except Unreadable:
                    try:
                        self.images[name] = self.beside(PurePath(name.replace("\\", "/")).name)
                    except Unreadable:
                        self.images[name] = None
            if name and self.images[name] is not None:
                found = mean_colour(self.images[name], *fans(piece, uv))
                if found is not None:
                    return found
        shown = PurePath(words[-1] if said.startswith("-") else said or ".").name
        note = f"its texture {shown!r} cannot be read, and is left out of its colours"
        if said and note not in self.notes:
            self.notes.append(note)
        return None

    def missing(self, used: set[str]) -> list[str]:
        """A note on the materials that no library has."""
        names = sorted(name for name in used if name and name not in self.materials)
        if not names or not self.materials:
            return []
        return [f"its material library has no {', '.join(map(repr, names[:4]))}"
                f"{' …' if len(names) > 4 else ''}"]


def fans(piece: Piece, uv: np.ndarray | None) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Areas (k,) and texture coordinates (k, 3, 2) of a piece's polygons as fans; None without coordinates.

    uv : (m, 2) of each corner
    """
    if uv is None:
        return None, None
    areas = np.linalg.norm(newell(piece.vertices, piece.corners, piece.sizes), axis=1)
    starts = np.cumsum(piece.sizes) - piece.sizes
    count = np.maximum(piece.sizes - 2, 0)
    polygon = np.repeat(np.arange(len(count)), count)
    step = np.arange(len(polygon)) - np.repeat(np.cumsum(count) - count, count)
    first = starts[polygon]
    triangles = np.stack([first, first + step + 1, first + step + 2], axis=1)
    return (areas / np.maximum(count, 1))[polygon], uv[triangles]
