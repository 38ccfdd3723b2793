"""STL files (3D Systems, 1989), in text or binary; STL defines neither a unit nor an up axis."""

import re

import numpy as np

from renderer.scene.model_files.record import ModelFile, Piece, Unreadable


def read_stl(data: bytes) -> ModelFile:
    """Read an STL file; the solids of a text file are its parts. Raises Unreadable."""
    head, facet = 84, 50  # bytes
    text = re.match(rb"\s*solid\b", data, re.IGNORECASE) is not None
    count = int.from_bytes(data[80:head], "little")
    if text and re.search(rb"\bfacet\b", data[:2000], re.IGNORECASE) and head + facet * count != len(data):
        return ModelFile(_text(data.decode("latin-1")))
    if len(data) >= head and head + facet * count <= len(data):
        kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
        return ModelFile([_piece(np.frombuffer(data, kind, count, head)["corners"], ())])
    if text and len(data) < head + facet:
        return ModelFile(_text(data.decode("latin-1")))
    if len(data) < head:
        raise Unreadable("is no STL: it is shorter than a header; export it again")
    raise Unreadable(f"is cut short: it says {count} triangles and has {(len(data) - head) // facet}; copy "
                     "it again")


def _text(text: str) -> list[Piece]:
    """A piece for each solid. Raises Unreadable."""
    pieces = []
    flags = re.IGNORECASE | re.MULTILINE
    for solid in re.split(r"^[ \t]*solid\b", text.replace("\r", "\n"), flags=flags)[1:]:
        name, _, body = solid.partition("\n")
        found = re.findall(r"^[ \t]*(vertex|endloop)\b(.*)$", body, flags)
        if found and found[-1][0].lower() == "vertex":
            raise Unreadable("is cut short: its last facet does not end; copy it again")
        corners = [numbers.split() for word, numbers in found if word.lower() == "vertex"]
        ends = [k for k, (word, _) in enumerate(found) if word.lower() == "endloop"]
        if ends != list(range(3, len(found), 4)) or any(len(corner) != 3 for corner in corners):
            raise Unreadable("has a facet of other than three corners of three numbers; export it again")
        pieces.append(_piece(np.array(corners, dtype=float), (name.strip(),) if name.strip() else ()))
    return pieces


def _piece(corners: np.ndarray, names: tuple[str, ...]) -> Piece:
    corners = corners.reshape(-1, 3).astype(float)
    return Piece.of_triangles(corners, np.arange(len(corners)), names)
