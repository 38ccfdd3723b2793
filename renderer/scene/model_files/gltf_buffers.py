"""The numbers of a glTF file: buffers, views, accessors, and the two compressions of views."""

import numpy as np

from renderer.scene.model_files.record import Beside, Unreadable

MAX_ELEMENTS = 100_000_000


class Buffers:
    """The numbers of a file.

    root : the file's JSON
    binary : binary chunk of a GLB, or None
    beside : reads files that the file names
    """

    def __init__(self, root: dict, binary: bytes | None, beside: Beside):
        self.root, self.binary, self.beside = root, binary, beside
        self.buffers: dict[int, bytes] = {}
        self.views: dict[int, tuple[bytes, int]] = {}

    def buffer(self, index: int) -> bytes:
        """The bytes of a buffer. Raises Unreadable."""
        if index not in self.buffers:
            uri = self.root["buffers"][index].get("uri")
            if uri is not None:
                self.buffers[index] = self.beside(uri)
            elif index == 0 and self.binary is not None:
                self.buffers[index] = self.binary
            else:
                raise Unreadable("holds no data for its buffer; export it again")
        return self.buffers[index]

    def view(self, index: int) -> tuple[bytes, int]:
        """The bytes of a view, and its stride (0 for packed ones). Raises Unreadable."""
        if index not in self.views:
            view = self.root["bufferViews"][index]
            extensions = view.get("extensions", {})
            packed = next((extensions[name] for name in ("EXT_meshopt_compression", "KHR_meshopt_compression")
                           if name in extensions), None)
            if packed is not None:
                self.views[index] = _meshopt(self._slice(packed), packed), packed["byteStride"]
            else:
                self.views[index] = self._slice(view), view.get("byteStride", 0)
        return self.views[index]

    def _slice(self, view: dict) -> bytes:
        start, length = view.get("byteOffset", 0), view["byteLength"]
        data = self.buffer(view["buffer"])
        if start < 0 or length < 0 or start + length > len(data):
            raise Unreadable("is cut short: a buffer ends before its data; copy it again with all its files")
        return data[start:start + length]

    def accessor(self, index: int) -> np.ndarray:
        """The values (count, width) of an accessor, normalized integers as 0 … 1 or −1 … 1. Raises
        Unreadable."""
        given = self.root["accessors"][index]
        widths = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
        count, width = given["count"], widths[given["type"]]
        if not 0 <= count <= MAX_ELEMENTS:
            raise Unreadable(f"claims {count} numbers in one list; export it again")
        types = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
        kind = np.dtype(types[given["componentType"]])
        if "bufferView" in given:
            values = self._strided(given["bufferView"], given.get("byteOffset", 0), kind, count, width)
        else:
            values = np.zeros((count, width), dtype=kind)
        sparse = given.get("sparse")
        if sparse:
            some, place = sparse["count"], sparse["indices"]
            at = self._strided(place["bufferView"], place.get("byteOffset", 0),
                               np.dtype(types[place["componentType"]]), some, 1)[:, 0]
            values = values.copy()
            values[at] = self._strided(sparse["values"]["bufferView"], sparse["values"].get("byteOffset", 0),
                                       kind, some, width)
        return _normalized(values, given)

    def _strided(self, view: int, offset: int, kind: np.dtype, count: int, width: int) -> np.ndarray:
        data, stride = self.view(view)
        packed = kind.itemsize * width
        stride = stride or packed
        if count and (offset < 0 or offset + (count - 1) * stride + packed > len(data)):
            raise Unreadable("is cut short: a list of numbers ends before its last; export it again")
        if not count:
            return np.zeros((0, width), dtype=kind)
        return np.ndarray((count, width), kind, data, offset, (stride, kind.itemsize)).copy()


def _meshopt(data: bytes, said: dict) -> bytes:
    """The bytes of a view compressed by meshoptimizer (EXT_meshopt_compression). Raises Unreadable."""
    try:
        import meshoptimizer
    except ImportError:
        raise Unreadable('uses meshopt compression; install the package "meshoptimizer", or export it '
                         "uncompressed") from None
    count, stride, mode = said["count"], said["byteStride"], said["mode"]
    sizes = range(4, 257, 4) if mode == "ATTRIBUTES" else (2, 4)
    whole = mode != "TRIANGLES" or count % 3 == 0
    if not 0 <= count * stride <= 8 * MAX_ELEMENTS or stride not in sizes or not whole:
        raise Unreadable(f"claims {count} numbers of {stride} bytes in a compressed list; export it again")
    # The library decodes to single precision and to 32-bit integers for every stride.
    if mode == "ATTRIBUTES":
        values = np.ascontiguousarray(meshoptimizer.decode_vertex_buffer(count, stride, data))
        if said.get("filter") == "EXPONENTIAL":
            values = values.view("<i4")
            values = np.ldexp((values << 8 >> 8).astype("<f4"), values >> 24).astype("<f4")
        return values.tobytes()
    decode = {"TRIANGLES": meshoptimizer.decode_index_buffer,
              "INDICES": meshoptimizer.decode_index_sequence}[mode]
    return np.asarray(decode(count, 4, data)).astype(f"<u{stride}").tobytes()


class Attributes:
    """The values of a primitive's vertices by their names in the file, from accessors or from Draco's bytes.

    triangles : (k, 3), of Draco's bytes; else None
    """

    def __init__(self, primitive: dict, buffers: Buffers):
        self.accessors, self.buffers = primitive["attributes"], buffers
        self.packed, self.triangles = {}, None
        said = primitive.get("extensions", {}).get("KHR_draco_mesh_compression")
        if said is not None:
            mesh = _draco(buffers.view(said["bufferView"])[0])
            by_id = {each["unique_id"]: each["data"] for each in mesh.attributes}
            self.packed = {name: by_id[key] for name, key in said["attributes"].items() if key in by_id}
            self.triangles = np.asarray(getattr(mesh, "faces", np.zeros((0, 3))), np.int64).reshape(-1, 3)

    def __contains__(self, name: str) -> bool:
        return name in self.accessors

    def get(self, name: str) -> np.ndarray | None:
        """Values (n, width) as from `[name]`; None where there is no such attribute."""
        return self[name] if name in self else None  # noqa: SIM401

    def __getitem__(self, name: str) -> np.ndarray:
        """Values (n, width), normalized integers as 0 … 1 or −1 … 1. Raises Unreadable."""
        if name not in self.packed:
            return self.buffers.accessor(self.accessors[name]).astype(float)
        said = self.buffers.root["accessors"][self.accessors[name]]
        return _normalized(np.asarray(self.packed[name]), said).astype(float)


def _normalized(values: np.ndarray, accessor: dict) -> np.ndarray:
    if accessor.get("normalized") and values.dtype.kind in "iu":
        return np.maximum(values.astype(float) / np.iinfo(values.dtype).max, -1.0)
    return values


def _draco(data: bytes):
    """The mesh of Draco's bytes. Raises Unreadable."""
    try:
        import DracoPy
    except ImportError:
        raise Unreadable('uses Draco compression; install the package "DracoPy", or export it '
                         "uncompressed") from None
    return DracoPy.decode(data)
