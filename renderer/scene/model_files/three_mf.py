"""3MF files, by trimesh."""

import io
import zipfile

import numpy as np
import trimesh

from renderer.scene.model_files.record import ModelFile, Piece, Unreadable
from renderer.scene.model_files.xml_safety import refuse_entities


def read_3mf(data: bytes) -> ModelFile:
    """Read a 3MF file, z up, in its stated unit. Raises Unreadable."""
    try:
        import lxml  # noqa: F401
        import networkx  # noqa: F401
    except ImportError:
        raise Unreadable('is 3MF; install the packages "lxml" and "networkx", or export it as STL or OBJ'
                         ) from None
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > 1 << 30:
                raise Unreadable("unpacks to more than 1 GiB")
            for entry in archive.infolist():
                if entry.filename.lower().endswith((".model", ".rels")):
                    refuse_entities(archive.read(entry))
    except zipfile.BadZipFile:
        raise Unreadable("is no 3MF: it is not a ZIP archive; export it again") from None
    loaded = trimesh.load(io.BytesIO(data), file_type="3mf", process=False)
    unit = str(loaded.metadata.get("units", "millimeter")).lower()
    metres = {"micron": 1e-6, "millimeter": 1e-3, "millimeters": 1e-3, "centimeter": 0.01, "inch": 0.0254,
              "foot": 0.3048, "meter": 1.0}  # 3MF Core Specification 1.3, 3.4
    return ModelFile(_pieces(loaded), metres=metres.get(unit, 1e-3), said=True)


def _pieces(loaded) -> list[Piece]:
    scene = loaded if isinstance(loaded, trimesh.Scene) else trimesh.Scene(loaded)
    pieces = []
    for node in scene.graph.nodes_geometry:
        turn, name = scene.graph[node]
        mesh = scene.geometry[name]
        if not isinstance(mesh, trimesh.Trimesh):
            continue
        vertices = trimesh.transform_points(np.array(mesh.vertices, dtype=float), turn)
        faces = np.array(mesh.faces, dtype=np.int64).reshape(-1, 3)
        if np.linalg.det(turn[:3, :3]) < 0:
            faces = faces[:, ::-1]
        names = tuple(dict.fromkeys(str(n) for n in (name, node) if n))
        pieces.append(Piece.of_triangles(vertices, faces, names))
    return pieces
