"""Rooms and objects as trimesh meshes, and their flat parts as rectangles and triangles."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from renderer.errors import InputError

ROOM_SURFACES = ("floor", "ceiling", "wall_x0", "wall_x1", "wall_y0", "wall_y1")
CYLINDER_SECTIONS = 48
SPHERE_SUBDIVISIONS = 3


@dataclass(frozen=True)
class Rectangle:
    """A flat rectangle: corner (3,), edges u and v (3,) [m]; light leaves along u × v."""

    corner: np.ndarray
    u: np.ndarray
    v: np.ndarray

    @property
    def normal(self) -> np.ndarray:
        """Unit normal of the front (3,)."""
        n = np.cross(self.u, self.v)
        return n / np.linalg.norm(n)

    @property
    def corners(self) -> np.ndarray:
        """Corners (4, 3) [m], counter-clockwise seen from the front."""
        return self.corner + np.array([0 * self.u, self.u, self.u + self.v, self.v])


def room_rectangles(size: tuple[float, float, float]) -> dict[str, Rectangle]:
    """The six inner faces of a box with one corner at the origin, by name, normals inward."""
    box = trimesh.creation.box(bounds=[[0, 0, 0], size])
    box = trimesh.Trimesh(box.vertices, box.faces[:, ::-1], process=False)
    rectangles, rest = flat_parts(box)
    assert len(rectangles) == 6
    assert not len(rest)
    names = {(0, 0, 1): "floor", (0, 0, -1): "ceiling", (1, 0, 0): "wall_x0",
             (-1, 0, 0): "wall_x1", (0, 1, 0): "wall_y0", (0, -1, 0): "wall_y1"}
    named = {names[tuple(np.rint(r.normal).astype(int))]: r for r in rectangles}
    return {name: named[name] for name in ROOM_SURFACES}


def object_mesh(shape: str | None, size, position, rotation: float,
                mesh: Path | None = None, scale: float = 1.0, where: str = "") -> trimesh.Trimesh:
    """A solid, outward normals: [m], rotated by `rotation` degrees about z through `position`."""
    if mesh is not None:
        solid = load_mesh(mesh, where)
        solid.apply_scale(scale)
    elif shape == "box":
        solid = trimesh.creation.box(bounds=[[0, 0, 0], size])
    elif shape == "cylinder":
        solid = trimesh.creation.cylinder(radius=0.5, height=1.0, sections=CYLINDER_SECTIONS)
        solid.apply_translation([0.5, 0.5, 0.5])
        solid.apply_scale(size)
    else:
        solid = trimesh.creation.icosphere(subdivisions=SPHERE_SUBDIVISIONS, radius=0.5)
        solid.apply_translation([0.5, 0.5, 0.5])
        solid.apply_scale(size)
    turn = trimesh.transformations.rotation_matrix(np.radians(rotation), [0, 0, 1])
    if rotation % 90 == 0:
        turn = np.rint(turn)
    solid.apply_transform(turn)
    solid.apply_translation(position)
    return solid


def load_mesh(path: Path, where: str) -> trimesh.Trimesh:
    """Read an OBJ, PLY, STL or GLB file as one mesh with outward normals. Raises InputError."""
    if not path.is_file():
        raise InputError(f"{where}: there is no file {str(path)!r}; paths are relative to the "
                         "scene file. Mend the path.")
    try:
        solid = trimesh.load(path, force="mesh", process=False)
    except Exception as error:  # noqa: BLE001  a foreign file may fail in any way in its reader
        raise InputError(f"{where}: {path.name} cannot be read as a mesh "
                         f"({' '.join(str(error).split())}); give OBJ, PLY, STL or GLB.") from None
    if not np.isfinite(solid.vertices).all():
        raise InputError(f"{where}: {path.name} has a vertex that is not a finite number; "
                         "mend the export.")
    solid.merge_vertices(merge_tex=True, merge_norm=True)
    solid.update_faces(solid.nondegenerate_faces())
    if len(solid.faces) == 0:
        raise InputError(f"{where}: {path.name} holds no faces with area; export the mesh with "
                         "its triangles.")
    if not solid.is_watertight:
        raise InputError(f"{where}: {path.name} is not closed, so it has no inside; close its holes and "
                         "give sheets a thickness.")
    trimesh.repair.fix_normals(solid)
    return solid


def flat_parts(solid: trimesh.Trimesh) -> tuple[list[Rectangle], np.ndarray]:
    """A mesh as rectangles, however they were tessellated, and the remaining triangles (k, 3, 3).

    Coplanar neighbours are one facet; a facet that fills its tightest rectangle is one.
    """
    rectangles, taken = [], np.zeros(len(solid.faces), dtype=bool)
    for faces, area in zip(solid.facets, solid.facets_area, strict=True):
        points = solid.vertices[np.unique(solid.faces[faces])]
        # From the winding: Trimesh.invert leaves cached normals as they were (trimesh 5.2).
        a, b, c = solid.triangles[faces[0]]
        normal = np.cross(b - a, c - a)
        rectangle = _tightest_rectangle(points, normal / np.linalg.norm(normal), area)
        if rectangle is not None:
            rectangles.append(rectangle)
            taken[faces] = True
    return rectangles, solid.triangles[~taken]


def _tightest_rectangle(points: np.ndarray, normal: np.ndarray, area: float) -> Rectangle | None:
    """The rectangle whose corners the outermost of the coplanar points (k, 3) are, or None."""
    to_plane = trimesh.geometry.plane_transform(points[0], normal)
    flat = trimesh.transform_points(points, to_plane)
    scale = np.ptp(flat, axis=0).max()
    if abs(flat[:, 2]).max() > 1e-6 * scale:
        return None
    to_box, extents = trimesh.bounds.oriented_bounds_2D(flat[:, :2])
    if abs(extents.prod() - area) > 1e-6 * area:
        return None
    half = extents / 2
    box = np.array([[-half[0], -half[1]], [half[0], -half[1]], [half[0], half[1]],
                    [-half[0], half[1]]])
    ideal = trimesh.transform_points(box, np.linalg.inv(to_box))
    # The vertices themselves, not the fitted corners, so that neighbours meet exactly.
    near = [np.linalg.norm(flat[:, :2] - corner, axis=1).argmin() for corner in ideal]
    corners = points[near]
    u, v = corners[1] - corners[0], corners[3] - corners[0]
    if np.cross(u, v) @ normal < 0:
        u, v = v, u
    return Rectangle(corners[0], u, v)
