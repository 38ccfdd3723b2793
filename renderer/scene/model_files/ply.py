"""The reader of PLY files (G. Turk, 1994): polygons and triangle strips, in text or binary."""

from dataclasses import dataclass

import numpy as np

from renderer.scene.model_files.record import ModelFile, Piece, Unreadable
from renderer.scene.model_files.textures import srgb_decoded


@dataclass
class _Element:
    """`count` rows of one kind, with properties (name, type, type of a list's length or "")."""

    name: str
    count: int
    properties: list[tuple[str, str, str]]


def read_ply(data: bytes) -> ModelFile:
    """Read a PLY file; its colour is the mean of its vertex colours. Raises Unreadable."""
    order, elements, body = _header(data)
    read = _Text(body.splitlines()) if not order else _Binary(body, order)
    vertices, colour, found = None, None, []
    for element in elements:
        columns = read.element(element)
        if element.name == "vertex":
            if not {"x", "y", "z"} <= columns.keys():
                raise Unreadable("has vertices without x, y and z; export it again")
            vertices = np.stack([np.asarray(columns[k], dtype=float) for k in "xyz"], axis=1)
            colour = _colour(columns, {p[0]: p[1] for p in element.properties})
        elif element.name == "face":
            lists = columns.get("vertex_indices", columns.get("vertex_index"))
            if lists is not None:
                found.append(lists)
        elif element.name == "tristrips":
            found += [_from_strips(values, sizes) for values, sizes in
                      (columns.get("vertex_indices", columns.get("vertex_index", (np.zeros(0), []))),)]
    if vertices is None or not found:
        return ModelFile([], instead="points" if vertices is not None and len(vertices) else "")
    corners = np.concatenate([np.asarray(values, dtype=np.int64) for values, _ in found])
    sizes = np.concatenate([np.asarray(sizes, dtype=np.int64) for _, sizes in found])
    few = np.repeat(sizes, sizes) < 3
    return ModelFile([Piece(vertices, corners[~few], sizes[sizes >= 3], (), colour)], instead="points")


def _header(data: bytes) -> tuple[str, list[_Element], bytes]:
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise Unreadable("has no PLY header; export it again")
    body = data[end + len(b"end_header"):]
    body = body[2:] if body.startswith(b"\r\n") else body[1:]
    order, elements = None, []
    types = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
             "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
             "float": "f4", "float32": "f4", "double": "f8", "float64": "f8"}
    for line in data[:end].decode("latin-1").splitlines():
        words = line.split()
        if words[:1] == ["format"] and len(words) > 1:
            order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}.get(words[1])
        elif words[:1] == ["element"] and len(words) == 3:
            elements.append(_Element(words[1], int(words[2]), []))
        elif words[:1] == ["property"] and elements:
            length = types[words[2]] if words[1] == "list" else ""
            elements[-1].properties.append((words[-1], types[words[-2]], length))
    if any(not element.properties for element in elements):
        raise Unreadable("has a header that does not describe one of its elements; export it again")
    if order is None:
        raise Unreadable("states a format that PLY does not have; export it again")
    if any(element.count < 0 or element.count > len(data) for element in elements):
        raise Unreadable("is cut short; copy it again")
    return order, elements, body


class _Text:
    """The rows of a text file, one a line."""

    def __init__(self, lines: list[bytes]):
        self.lines, self.at = [line for line in lines if line.strip()], 0

    def element(self, element: _Element) -> dict:
        """Values of each property: an array (count,), or for a list all values and the length of each row's
        list.

        Raises Unreadable.
        """
        rows = [line.split() for line in self.lines[self.at:self.at + element.count]]
        self.at += element.count
        if len(rows) < element.count:
            raise Unreadable("is cut short; copy it again")
        width = len(element.properties)
        if not any(length for *_, length in element.properties):
            table = np.array([row[:width] for row in rows], dtype=float).reshape(element.count, width)
            return {name: table[:, k] for k, (name, *_) in enumerate(element.properties)}
        # Properties after the corners of a face are not needed, and headers are often wrong about them.
        known = next((k for k, (name, *_) in enumerate(element.properties) if name in (
            "vertex_indices", "vertex_index")), width - 1)
        columns = {name: ([], []) if length else [] for name, _, length in element.properties[:known + 1]}
        for row in rows:
            at = 0
            for name, kind, length in element.properties[:known + 1]:
                if length:
                    count = int(row[at])
                    columns[name][0].extend(map(_number(kind), row[at + 1:at + 1 + count]))
                    columns[name][1].append(count)
                    at += 1 + count
                else:
                    columns[name].append(float(row[at]))
                    at += 1
            if at > len(row):
                raise Unreadable("has a face with fewer corners than it states; export it again")
        return columns


def _number(kind: str) -> type:
    return float if kind[0] == "f" else int


class _Binary:
    """The rows of a binary file."""

    def __init__(self, body: bytes, order: str):
        self.body, self.at, self.order = body, 0, order

    def element(self, element: _Element) -> dict:
        """As `_Text.element`."""
        if not any(length for *_, length in element.properties):
            kind = np.dtype([(name, self.order + kind) for name, kind, _ in element.properties])
            rows = self._take(kind, element.count)
            return {name: rows[name] for name, *_ in element.properties}
        same = self._of_one_length(element)
        if same is not None:
            return same
        columns = {name: ([], []) if length else [] for name, _, length in element.properties}
        for _ in range(element.count):
            for name, kind, length in element.properties:
                if length:
                    count = int(self._take(np.dtype(self.order + length), 1)[0])
                    columns[name][0].append(self._take(np.dtype(self.order + kind), count))
                    columns[name][1].append(count)
                else:
                    columns[name].append(self._take(np.dtype(self.order + kind), 1)[0])
        return {name: (np.concatenate(column[0]) if column[0] else np.zeros(0), column[1])
                if isinstance(column, tuple) else column for name, column in columns.items()}

    def _of_one_length(self, element: _Element) -> dict | None:
        """The columns of an element whose lists all have the length of the first row's; None for other
        elements."""
        lengths, at = {}, self.at
        for name, kind, length in element.properties:
            if length:
                size = np.dtype(self.order + length)
                if at + size.itemsize > len(self.body):
                    return None
                lengths[name] = int(np.frombuffer(self.body, size, 1, at)[0])
                if not 0 <= lengths[name] <= 1000:
                    return None
                at += size.itemsize + lengths[name] * np.dtype(kind).itemsize
            else:
                at += np.dtype(kind).itemsize
        fields = []
        for name, kind, length in element.properties:
            if length:
                fields += [(f"{name} length", self.order + length),
                           (name, self.order + kind, (lengths[name],))]
            else:
                fields.append((name, self.order + kind))
        kind = np.dtype(fields)
        if self.at + element.count * kind.itemsize > len(self.body):
            return None
        rows = np.frombuffer(self.body, kind, element.count, self.at)
        if any((rows[f"{name} length"] != count).any() for name, count in lengths.items()):
            return None
        self.at += element.count * kind.itemsize
        return {name: (rows[name].ravel(), np.full(element.count, lengths[name])) if name in lengths
                else rows[name] for name, *_ in element.properties}

    def _take(self, kind: np.dtype, count: int) -> np.ndarray:
        if count < 0 or self.at + count * kind.itemsize > len(self.body):
            raise Unreadable("is cut short; copy it again")
        rows = np.frombuffer(self.body, kind, count, self.at)
        self.at += count * kind.itemsize
        return rows


def _from_strips(values, sizes) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of strips; −1 begins a new strip, and every second triangle has the opposite winding."""
    triangles = []
    values = np.asarray(values, dtype=np.int64)
    for strip in np.split(values, np.cumsum(sizes)[:-1]) if len(sizes) else []:
        for run in np.split(strip, np.flatnonzero(strip < 0)):
            triangles.append(strip_triangles(run[run >= 0]))
    triangles = np.concatenate(triangles) if triangles else np.zeros((0, 3), dtype=np.int64)
    return triangles.ravel(), np.full(len(triangles), 3)


def strip_triangles(run: np.ndarray) -> np.ndarray:
    """Triangles (k, 3) of a strip of vertices (k + 2,), without those that have a vertex twice."""
    if len(run) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    triangles = np.stack([run[:-2], run[1:-1], run[2:]], axis=1)
    triangles[1::2] = triangles[1::2, [1, 0, 2]]
    a, b, c = triangles.T
    return triangles[(a != b) & (b != c) & (c != a)]


def _colour(columns: dict, kinds: dict[str, str]) -> np.ndarray | None:
    """Mean linear BT.709 colour (3,) of vertices with 8-bit colours; None for others."""
    for names in (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue")):
        if all(kinds.get(name) == "u1" for name in names) and len(columns["x"]):
            return np.array([srgb_decoded(np.asarray(columns[name]) / 255.0).mean() for name in names])
    return None
