"""Patches: the room's faces, the solids and the luminaires' faces, divided."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import trimesh

from renderer.errors import InputError
from renderer.scene.geometry import Rectangle, flat_parts
from renderer.scene.luminaires import Luminaire
from renderer.scene.reading import Scene

COPLANAR = 1e-7
"""Distance from a plane, relative to the room's longest side, that counts as touching it."""
MOUNTED = 0.005
"""A luminaire this near to the face behind it, relative to its shorter side, is mounted on it:
the little light that would enter the gap is left out, its face covers that part of the surface."""
GRADING = 0.8
"""0 divides a rectangle evenly; 1 as cos, finest where light changes fastest: at edges."""
NEAREST_LAMP = 64
"""Near a lamp, patches are this much smaller than elsewhere, at the most."""


@dataclass(frozen=True)
class Mesh:
    """Flat patches, each a parallelogram or a triangle.

    vertices : (n_vertices, 3) [m]; a vertex belongs to one flat part, so it has one normal
    patches : (n_patches, 4) indices, counter-clockwise seen from the front; a triangle repeats
        its last vertex
    surface : (n_patches,) index into Scene.surfaces
    vertex_surface : (n_vertices,) likewise
    twin : (n_patches,) the patch on the other side of a sheet (a luminaire in mid-air), else -1
    covered : (n_patches,) lies face to face on another surface, or again where one already is
    obstacles : (m, 8, 3) corners of boxes around whatever stands in the room [m]
    bounds : (2, 3) lowest and highest corner of the room [m]
    """

    vertices: np.ndarray
    patches: np.ndarray
    surface: np.ndarray
    vertex_surface: np.ndarray
    twin: np.ndarray
    covered: np.ndarray
    obstacles: np.ndarray
    bounds: np.ndarray

    @property
    def scale(self) -> float:
        """The room's longest side [m], what tolerances are relative to."""
        return float(np.ptp(self.bounds, axis=0).max())

    @property
    def middle(self) -> np.ndarray:
        """The room's middle (3,) [m]: coordinates are counted from it where digits are scarce."""
        return self.bounds.mean(axis=0)

    @cached_property
    def corners(self) -> np.ndarray:
        """Corners of each patch (n_patches, 4, 3) [m]."""
        return self.vertices[self.patches]

    @cached_property
    def triangular(self) -> np.ndarray:
        """Which patches are triangles (n_patches,)."""
        return self.patches[:, 2] == self.patches[:, 3]

    @cached_property
    def u(self) -> np.ndarray:
        """First edge of each patch (n_patches, 3) [m]."""
        return self.corners[:, 1] - self.corners[:, 0]

    @cached_property
    def v(self) -> np.ndarray:
        """Last edge, from the same corner (n_patches, 3) [m]."""
        return self.corners[:, 3] - self.corners[:, 0]

    @cached_property
    def area(self) -> np.ndarray:
        """Area of each patch (n_patches,) [m²]."""
        cross = np.linalg.norm(np.cross(self.u, self.v), axis=1)
        return np.where(self.triangular, cross / 2, cross)

    @cached_property
    def normal(self) -> np.ndarray:
        """Unit normal of each patch (n_patches, 3)."""
        cross = np.cross(self.u, self.v)
        return cross / np.linalg.norm(cross, axis=1)[:, None]

    @cached_property
    def centroid(self) -> np.ndarray:
        """Middle of each patch (n_patches, 3) [m]."""
        return self.at(np.arange(len(self.patches)), *self.middle_st.T)

    @cached_property
    def middle_st(self) -> np.ndarray:
        """Coordinates (s, t) of each patch's middle (n_patches, 2)."""
        return np.where(self.triangular[:, None], 1 / 3, 1 / 2) * np.ones(2)

    def at(self, patch: np.ndarray, s: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Points corner + s u + t v of the patches (k, 3) [m]; s and t from 0 to 1."""
        return (self.corners[patch, 0] + s[..., None] * self.u[patch] + t[..., None] * self.v[patch])

    def spread(self, patch: np.ndarray, square: np.ndarray) -> np.ndarray:
        """Points all over each patch (k, n, 3), evenly, from points of the unit square (k, n, 2)."""
        s, t = square[..., 0], square[..., 1]
        fold = self.triangular[patch][:, None] & (s + t > 1)
        return self.at(patch[:, None], np.where(fold, 1 - s, s), np.where(fold, 1 - t, t))

    def inside(self, patch: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The (s, t) of points on the patches' planes."""
        u, v, offset = self.u[patch], self.v[patch], points - self.corners[patch, 0]
        uu, uv, vv = _dot(u, u), _dot(u, v), _dot(v, v)
        ou, ov = _dot(offset, u), _dot(offset, v)
        det = uu * vv - uv * uv
        return (ou * vv - ov * uv) / det, (ov * uu - ou * uv) / det

    def weights(self, patch: np.ndarray, s: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Linear interpolation between a patch's four vertices (k, 4); its rows sum to 1."""
        s, t = np.clip(s, 0, 1), np.clip(t, 0, 1)
        quad = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=-1)
        triangle = np.stack([1 - s - t, s, t, np.zeros_like(s)], axis=-1)
        return np.where(self.triangular[patch][:, None], triangle, quad)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", a, b)


@dataclass(frozen=True)
class Mounting:
    """Where a luminaire covers part of a face: `face` names it, `outline` (4, 3) lies in it."""

    face: str
    outline: np.ndarray
    surface: int


def mounting(scene: Scene, luminaire: Luminaire, surface: int) -> Mounting | None:
    """The room face that a rectangular luminaire is mounted on and aligned with, if any."""
    lamp = luminaire.rectangle
    if lamp is None:
        return None
    for name, face in scene.room.items():
        gap = (luminaire.center - face.corner) @ face.normal
        near = MOUNTED * min(np.linalg.norm(lamp.u), np.linalg.norm(lamp.v))
        aligned = min(np.linalg.norm(np.cross(lamp.u, edge)) / np.linalg.norm(edge)
                      for edge in (face.u, face.v)) < COPLANAR * np.linalg.norm(lamp.u)
        if aligned and gap <= near and luminaire.normal @ face.normal > 1 - 1e-12:
            return Mounting(name, lamp.corners - gap * face.normal, surface)
    return None


SHEET_OFF = 2e-5
"""How far a luminaire that is not mounted stands off a wall, relative to the longest side."""


def stand_off(scene: Scene, luminaire: Luminaire) -> Luminaire:
    """A luminaire in a wall's plane but not mounted on it (a disc, a turned rectangle), moved off
    it by more than the rays' tolerance, so that it is a sheet before the wall."""
    if luminaire.outline is None or mounting(scene, luminaire, 0) is not None:
        return luminaire
    shift = np.zeros(3)
    for face in scene.room.values():
        gap = ((luminaire.outline - face.corner) @ face.normal).min()
        if gap < SHEET_OFF * float(scene.size.max()) and luminaire.normal @ face.normal < -1 + 1e-9:
            raise InputError(f"{scene.path}: luminaires {luminaire.name!r} faces the surface it lies on, "
                             "so none of its light enters the room. Turn its normal round.")
        shift += max(0.0, SHEET_OFF * float(scene.size.max()) - gap) * face.normal
    rectangle = luminaire.rectangle
    return replace(luminaire, center=luminaire.center + shift, outline=luminaire.outline + shift,
                   rectangle=rectangle and replace(rectangle, corner=rectangle.corner + shift))


def build_mesh(scene: Scene, luminaires: list[Luminaire], patch_size: float) -> Mesh:
    """Divide a scene into patches of about `patch_size` [m], graded toward edges and contacts.

    luminaires : the scene's, each through `stand_off`.
    """
    first_face = len(scene.room) + len(scene.solids)
    mountings, sheets = [], []
    for index, luminaire in enumerate(lum for lum in luminaires if lum.outline is not None):
        found = mounting(scene, luminaire, first_face + index)
        if found is not None:
            mountings.append(found)
        else:
            sheets.append((first_face + index, luminaire))
    touch = COPLANAR * float(scene.size.max())
    rectangles = [(index, name, face) for index, (name, face) in enumerate(scene.room.items())]
    builder = _Builder(patch_size, touch, luminaires)
    loose = []
    for index, solid in enumerate(scene.solids, start=len(scene.room)):
        flats, triangles = flat_parts(solid.mesh)
        rectangles += [(index, None, flat) for flat in flats]
        loose.append((index, triangles))
    outlines = np.array([r.corners for _, _, r in rectangles] + [m.outline for m in mountings])
    for index, name, rectangle in rectangles:
        covers = [m for m in mountings if m.face == name]
        builder.add_rectangle(index, rectangle, outlines, covers)
    for index, triangles in loose:
        builder.add_triangles(index, triangles)
    for index, luminaire in sheets:
        builder.add_sheet(index, luminaire)
    around = [solid.mesh.bounds for solid in scene.solids]
    around += [np.array([lum.outline.min(axis=0), lum.outline.max(axis=0)]) for _, lum in sheets]
    corners = np.array(list(np.ndindex(2, 2, 2)))
    boxes = np.array([bounds[corners, np.arange(3)] for bounds in around]).reshape(-1, 8, 3)
    faces = [(index, rectangle) for index, _, rectangle in rectangles]
    return builder.finish(faces, boxes, np.array([np.zeros(3), scene.size]))


class _Builder:
    def __init__(self, patch_size: float, touch: float, luminaires: list[Luminaire]):
        self.patch_size = patch_size
        self.touch = touch
        self.luminaires = luminaires
        self.vertices, self.patches, self.surface = [], [], []
        self.vertex_surface, self.twin = [], []
        self.n_vertices = self.n_patches = 0

    def add(self, vertices, patches, surface, vertex_surface, twin=None):
        self.vertices.append(vertices)
        self.patches.append(patches + self.n_vertices)
        self.surface.append(surface)
        self.vertex_surface.append(np.full(len(vertices), vertex_surface))
        self.twin.append(np.full(len(patches), -1) if twin is None else twin + self.n_patches)
        self.n_vertices += len(vertices)
        self.n_patches += len(patches)

    def add_rectangle(self, index: int, rectangle: Rectangle, outlines: np.ndarray,
                      covers: list[Mounting]) -> None:
        us = self.divisions(rectangle.corner, rectangle.u, rectangle.v, rectangle.normal, outlines)
        vs = self.divisions(rectangle.corner, rectangle.v, rectangle.u, rectangle.normal, outlines)
        vertices, patches = self.divided(rectangle, us, vs)
        surface = np.full(len(patches), index)
        middles = vertices[patches].mean(axis=1)
        for cover in covers:
            o, e, f = cover.outline[0], *(cover.outline[k] - cover.outline[0] for k in (1, 3))
            s, t = (middles - o) @ e / (e @ e), (middles - o) @ f / (f @ f)
            surface[(s > 0) & (s < 1) & (t > 0) & (t < 1)] = cover.surface
        self.add(vertices, patches, surface, index)

    def divided(self, rectangle: Rectangle, us: np.ndarray, vs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Vertices (k, 3) and patches (m, 4) of a rectangle cut at `us` and `vs`, and finer near lamps."""
        s, t = (np.column_stack([x[:-1], x[1:]]) for x in (us, vs))
        cells = np.concatenate([np.repeat(s, len(t), axis=0), np.tile(t, (len(s), 1))], axis=1)
        finer = self.toward_lamps(rectangle, cells)
        if len(finer) == len(cells):
            return grid(rectangle, us, vs)
        corners = finer[:, [[0, 2], [1, 2], [1, 3], [0, 3]]].reshape(-1, 2)
        places, index = np.unique(corners, axis=0, return_inverse=True)
        return rectangle.corner + places @ np.stack([rectangle.u, rectangle.v]), index.reshape(-1, 4)

    def divisions(self, corner, along, across, normal, outlines) -> np.ndarray:
        """Where a rectangle is cut along one edge (k,), 0 to 1: at what touches it, and between."""
        length, width = np.linalg.norm(along), np.linalg.norm(across)
        a = outlines - corner
        b = np.roll(a, -1, axis=1)
        flat = (abs(a @ normal) < self.touch) & (abs(b @ normal) < self.touch)
        xa, xb = a @ along / length, b @ along / length
        ya, yb = a @ across / width, b @ across / width
        cuts = flat & (abs(xa - xb) < self.touch) & (np.maximum(ya, yb) > self.touch) & (
            np.minimum(ya, yb) < width - self.touch)
        inner = np.sort(xa[cuts & (xa > self.touch) & (xa < length - self.touch)])
        stops = [0.0]
        for x in [*inner, length]:
            if x - stops[-1] > self.touch:
                stops.append(float(x))
        stops[-1] = length
        pieces = [np.zeros(1)]
        for start, end in pairwise(stops):
            n = max(1, int(np.ceil((end - start) / self.patch_size - 0.01)))
            even = np.linspace(0, 1, n + 1)[1:]
            graded = (1 - GRADING) * even + GRADING * (1 - np.cos(np.pi * even)) / 2
            pieces.append(start + (end - start) * graded)
        return np.concatenate(pieces) / length

    def toward_lamps(self, rectangle: Rectangle, cells: np.ndarray) -> np.ndarray:
        """Cells (m, 4) of a rectangle, s and t from and to, quartered until none is longer than it is
        far from a lamp that lights the rectangle: near a lamp, light varies over that distance."""
        sides = np.linalg.norm(rectangle.u), np.linalg.norm(rectangle.v)
        axes = np.stack([rectangle.u / sides[0], rectangle.v / sides[1], rectangle.normal])
        smallest = self.patch_size / NEAREST_LAMP
        for lum in self.luminaires:
            points = lum.center[None] if lum.outline is None else np.vstack([lum.center, lum.outline])
            points = (points - rectangle.corner) @ axes.T
            lit = ((rectangle.corners - lum.center) @ lum.normal).max() > self.touch
            if points[:, 2].max() <= self.touch or (lum.lambertian and not lit):
                continue
            for point in points:
                while True:
                    beside = [np.maximum(np.maximum(cells[:, i] * side - x, x - cells[:, i + 1] * side), 0.0)
                              for i, side, x in zip((0, 2), sides, point[:2], strict=True)]
                    away = np.sqrt(beside[0] ** 2 + beside[1] ** 2 + point[2] ** 2)
                    length = np.maximum((cells[:, 1] - cells[:, 0]) * sides[0],
                                        (cells[:, 3] - cells[:, 2]) * sides[1])
                    long = length > 1.01 * np.maximum(away, smallest)
                    if not long.any():
                        break
                    cells = np.vstack([cells[~long], _quartered(cells[long])])
        return cells

    def add_triangles(self, index: int, triangles: np.ndarray) -> None:
        if not len(triangles):
            return
        faces = np.arange(3 * len(triangles)).reshape(-1, 3)
        vertices, faces = trimesh.remesh.subdivide_to_size(
            triangles.reshape(-1, 3), faces, max_edge=2 * self.patch_size, max_iter=20)
        corners = vertices[faces]
        sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        faces = faces[np.linalg.norm(sides, axis=1) > self.touch**2]
        self.add(vertices, np.column_stack([faces, faces[:, 2]]), np.full(len(faces), index), index)

    def add_sheet(self, index: int, luminaire: Luminaire) -> None:
        if luminaire.rectangle is not None:
            rectangle = luminaire.rectangle
            steps = [np.linspace(0, 1, 1 + int(np.ceil(np.linalg.norm(edge) / self.patch_size)))
                     for edge in (rectangle.u, rectangle.v)]
            vertices, patches = grid(rectangle, *steps)
        else:
            k = len(luminaire.outline)
            vertices = np.vstack([luminaire.outline, luminaire.center])
            patches = np.array([[k, i, (i + 1) % k, (i + 1) % k] for i in range(k)])
        triangular = patches[:, 2] == patches[:, 3]
        back = np.where(triangular[:, None], patches[:, [0, 2, 1, 1]], patches[:, [0, 3, 2, 1]])
        n = len(patches)
        self.add(vertices, patches, np.full(n, index), index, np.arange(n) + n)
        self.add(vertices, back, np.full(n, index), index, np.arange(n) - n)

    def finish(self, faces: list[tuple[int, Rectangle]], obstacles: np.ndarray,
               bounds: np.ndarray) -> Mesh:
        arrays = (np.concatenate(x) for x in (self.vertices, self.patches, self.surface,
                                              self.vertex_surface, self.twin))
        mesh = Mesh(*arrays, np.zeros(self.n_patches, dtype=bool), obstacles, bounds)
        return replace(mesh, covered=covered_by_contact(mesh, faces, self.touch))


def _quartered(cells: np.ndarray) -> np.ndarray:
    """Each cell (m, 4), s and t from and to, divided into four (4m, 4)."""
    a, b, c, d = cells.T
    s, t = (a + b) / 2, (c + d) / 2
    return np.concatenate([np.column_stack(quarter) for quarter in (
        (a, s, c, t), (s, b, c, t), (s, b, t, d), (a, s, t, d))])


def covered_by_contact(mesh: Mesh, faces: list[tuple[int, Rectangle]], touch: float) -> np.ndarray:
    """Which patches lie wholly in another surface's face (n_patches,): face to face with it, as a crate
    and the floor, or a second time where an earlier surface already is.

    faces : (surface, rectangle) of the room and the solids.
    """
    covered = np.zeros(len(mesh.patches), dtype=bool)
    shrunk = mesh.corners + 1e-5 * (mesh.centroid[:, None] - mesh.corners)
    last = max(index for index, _ in faces)  # luminaires come after: their faces stand in a wall's
    for index, face in faces:
        u2, v2 = face.u @ face.u, face.v @ face.v
        facing = mesh.normal @ face.normal
        offset = shrunk - face.corner
        s, t = offset @ face.u / u2, offset @ face.v / v2
        within = ((np.abs(offset @ face.normal) < touch) & (s > 0) & (s < 1)
                  & (t > 0) & (t < 1)).all(axis=1)
        other = (mesh.surface != index) & (mesh.twin < 0)
        covered |= within & other & (facing < -1 + 1e-9)
        covered |= within & other & (facing > 1 - 1e-9) & (mesh.surface > index) & (mesh.surface <= last)
    return covered


def grid(rectangle: Rectangle, us: np.ndarray, vs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (k, 3) and patches (m, 4) of a rectangle cut at `us` and `vs` (fractions)."""
    vertices = (rectangle.corner + us[:, None, None] * rectangle.u
                + vs[None, :, None] * rectangle.v).reshape(-1, 3)
    index = np.arange(len(us) * len(vs)).reshape(len(us), len(vs))
    patches = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1)
    return vertices, patches.reshape(-1, 4)
