"""Surfaces that stand face to face, such as a crate and the floor under it, or a cupboard and the wall."""

import numpy as np

from renderer.scene.flat import Polygon
from renderer.scene.geometry import PARALLEL_TOLERANCE, Rectangle, dot, near_boxes
from renderer.transport.mesh.mesh import Mesh

FlatFace = Rectangle | Polygon


class Faces:
    """The flat parts of the room and the bodies.

    flat : (surface, face) of each; touch : distance that counts as contact [m]
    """

    def __init__(self, flat: list[tuple[int, FlatFace]], touch: float):
        self.faces = [face for _, face in flat]
        self.surface = np.array([index for index, _ in flat], dtype=int)
        self.normals = np.array([face.normal for face in self.faces]).reshape(-1, 3)
        self.corners = np.array([_corner(face) for face in self.faces]).reshape(-1, 3)
        self.outlines = [_rings(face)[0] for face in self.faces]
        boxes = np.array([[ring.min(axis=0), ring.max(axis=0)] for ring in self.outlines])
        self.boxes = boxes.reshape(-1, 2, 3)
        self.middles = self.boxes.mean(axis=1)
        self.radii = np.linalg.norm(np.diff(self.boxes, axis=1)[:, 0], axis=1) / 2
        # Relative to one corner, because coordinates far from the origin have few digits left.
        self.origin = self.corners[:1].sum(axis=0)
        self.facing, self.about = (np.ascontiguousarray(each.T) for each in (
            self.normals, self.middles - self.origin))
        one, other = near_boxes(self.boxes, self.boxes, touch)
        height = dot(self.corners[other] - self.corners[one], self.normals[one])
        meet = ((np.abs(height) < touch) & (self.surface[one] != self.surface[other])
                & (dot(self.normals[one], self.normals[other]) < -1 + PARALLEL_TOLERANCE))
        self._other, self._first = other[meet], np.searchsorted(one[meet], np.arange(len(flat) + 1))

    def against(self, face: int) -> list[list[np.ndarray]]:
        """Rings (k, 3) [m], outer first, of each face of another surface that stands face to face in the
        plane of a face, given by its number."""
        return [_rings(self.faces[k]) for k in self._other[self._first[face]:self._first[face + 1]]]

    def across(self, face: FlatFace, touch: float, gap: float, asked: np.ndarray) -> list[np.ndarray]:
        """Outlines (k, 3) [m] of faces that `face` faces across less than about `gap` [m].

        asked : (n_surfaces,) whether each surface counts
        """
        own = _rings(face)[0]
        middle = (own.min(axis=0) + own.max(axis=0)) / 2
        radius = np.linalg.norm(np.ptp(own, axis=0)) / 2
        before = face.normal @ self.about - (middle - self.origin) @ face.normal
        near = np.flatnonzero((before > touch) & (before - self.radii < gap) & asked[self.surface]
                              & (face.normal @ self.facing < -0.5))
        apart = np.linalg.norm(self.middles[near] - middle, axis=1)
        outlines = [self.outlines[k] for k in near[apart < self.radii[near] + radius + gap]]
        lowest, _ = extent(outlines, _corner(face), face.normal[None])
        return [outline for outline, height in zip(outlines, lowest[:, 0].tolist(), strict=True)
                if touch < height < gap]


def extent(outlines: list[np.ndarray], origin: np.ndarray, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates (m, d) [m] of m outlines (k, 3) along axes (d, 3) from an origin."""
    if not outlines:
        return np.zeros((0, len(axes))), np.zeros((0, len(axes)))
    counts = [len(outline) for outline in outlines]
    along, starts = (np.concatenate(outlines) - origin) @ axes.T, np.cumsum(counts) - counts
    return np.minimum.reduceat(along, starts), np.maximum.reduceat(along, starts)


def _corner(face: FlatFace) -> np.ndarray:
    return face.corner if isinstance(face, Rectangle) else face.origin


def _rings(face: FlatFace) -> list[np.ndarray]:
    return [face.corners] if isinstance(face, Rectangle) else [*map(face.solid, face.rings)]


def standing(rectangle: Rectangle, feet: list[list[np.ndarray]], every: bool, lamps: list[np.ndarray],
             patch_size: float, touch: float, most_corners: int = 2000):
    """Union of the feet to be cut out of a rectangle, a shapely geometry in metres along its edges; None
    where there are none.

    feet : rings (k, 3) [m] of each area of contact, outer first. Not cut out are feet parallel to the
      rectangle's edges, along which the grid has lines, and feet shorter than a quarter of a patch, which
      hide little light
    every : whether feet parallel to the edges are cut out too
    lamps : outlines (k, 3) [m] that are always cut out
    most_corners : largest number of corners of all feet, the largest feet first; rays account for the others
    """
    if not feet and not lamps:
        return None
    import shapely

    axes = np.stack([rectangle.u, rectangle.v]) / _sides(rectangle)[:, None]
    shapes, always = [], [shapely.Polygon((ring - rectangle.corner) @ axes.T) for ring in lamps]
    for rings in feet:
        flat = [(ring - rectangle.corner) @ axes.T for ring in rings]
        steps = np.abs(np.roll(flat[0], -1, axis=0) - flat[0])
        if (every or (steps.min(axis=1) > touch).any()) and np.ptp(flat[0], axis=0).max() > patch_size / 4:
            shapes.append(shapely.Polygon(flat[0], flat[1:]))
    if not shapes and not always:
        return None
    whole = shapely.box(0, 0, *_sides(rectangle)).buffer(-touch)
    shapes = sorted((s for s in shapes if s.intersects(whole)), key=lambda s: -s.area)
    counts = np.cumsum([len(shapely.get_coordinates(s)) for s in shapes])
    kept = [s for s, count in zip(shapes, counts, strict=True) if count <= most_corners]
    over = [lamp for lamp in always if lamp.intersects(whole)]
    return shapely.union_all(over + kept) if over + kept else None


def cut(rectangle: Rectangle, cells: np.ndarray, feet, patch_size: float,
        touch: float) -> tuple[np.ndarray, np.ndarray]:
    """Cells of a rectangle without feet: cells (m, 4), from and to in s and in t, and triangles (k, 3, 2) in
    s and t.

    Cells that an outline crosses are quartered until they are half a patch long; their remaining parts are
    cut into triangles.
    cells : (m, 4); feet : from `standing`
    """
    import shapely

    sides, line = _sides(rectangle), feet.boundary
    shapely.prepare(line)
    shapely.prepare(feet)
    while True:
        boxes = _boxes(cells, sides)
        crossed = shapely.intersects(boxes, line)
        length = np.maximum((cells[:, 1] - cells[:, 0]) * sides[0], (cells[:, 3] - cells[:, 2]) * sides[1])
        long = crossed & (length > 1.01 * patch_size / 2)
        if not long.any():
            break
        cells = np.vstack([cells[~long], quartered(cells[long])])
    middle = np.column_stack([cells[:, :2].mean(axis=1), cells[:, 2:].mean(axis=1)]) * sides
    free = ~crossed & ~shapely.contains_xy(feet, *middle.T)
    left = shapely.difference(boxes[crossed], feet, grid_size=touch / 100)
    whole = shapely.area(left) > shapely.area(boxes[crossed]) - touch**2
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(left[~whole]))
    parts = shapely.orient_polygons(parts[shapely.area(parts) > touch**2])
    triangles = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3] / sides
    return np.vstack([cells[free], cells[crossed][whole]]), triangles


def _sides(rectangle: Rectangle) -> np.ndarray:
    return np.array([np.linalg.norm(rectangle.u), np.linalg.norm(rectangle.v)])


def _boxes(cells: np.ndarray, sides: np.ndarray) -> np.ndarray:
    import shapely

    s, t = cells[:, :2] * sides[0], cells[:, 2:] * sides[1]
    return shapely.box(s[:, 0], t[:, 0], s[:, 1], t[:, 1])


def graded(cells: np.ndarray, sides: tuple[float, float], near: list[tuple]) -> np.ndarray:
    """Cells (m, 4) of a rectangle quartered until each is small relative to its distance from boxes.

    cells : (m, 4), from and to in s and in t; sides : of the rectangle [m]
    near : for each set of boxes: lowest and highest corners (b, 3) [m] along the rectangle's edges and
        normal, largest length of a cell over its distance from a box, and length below which no cell is
        quartered [m]
    """
    low, high = (np.concatenate([boxes[k] for boxes in near]) for k in range(2))
    close, shortest = (np.repeat([boxes[k] for boxes in near], [len(boxes[0]) for boxes in near])
                       for k in (2, 3))
    level = np.maximum(np.maximum(low[:, 2], -high[:, 2]), 0.0)
    whole = np.array([[0.0, 1.0, 0.0, 1.0]])
    longest = (np.diff(cells)[:, [0, 2]] * sides).max()
    needed = longest > 1.01 * np.maximum(close * _apart(whole, sides, low, high, level)[0], shortest)
    for first in range(0, len(low), 16):
        some = first + np.flatnonzero(needed[first:first + 16])
        if not len(some):
            continue
        done = []
        while len(cells):
            away = _apart(cells, sides, low[some], high[some], level[some])
            limit = np.maximum(close[some] * away, shortest[some]).min(axis=1)
            sizes = [cells[:, 2 * axis + 1] * sides[axis] - cells[:, 2 * axis] * sides[axis]
                     for axis in range(2)]
            long = np.maximum(*sizes) > 1.01 * limit
            done.append(cells[~long])
            cells = quartered(cells[long])
        cells = np.vstack(done)
    return cells


def _apart(cells: np.ndarray, sides: tuple[float, float], low: np.ndarray, high: np.ndarray,
           level: np.ndarray) -> np.ndarray:
    """Distance (m, b) [m] of each cell from each box; level : (b,) [m] of the box above the rectangle or
    below it"""
    beside = []
    for axis in range(2):
        start, end = (cells[:, 2 * axis + k, None] * sides[axis] for k in range(2))
        beside.append(np.maximum(np.maximum(start - high[:, axis], low[:, axis] - end), 0.0))
    return np.sqrt(beside[0]**2 + beside[1]**2 + level**2)


def quartered(cells: np.ndarray) -> np.ndarray:
    """Each cell (m, 4), from and to in s and in t, divided into four (4m, 4)."""
    a, b, c, d = cells.T
    s, t = (a + b) / 2, (c + d) / 2
    return np.concatenate([np.column_stack(quarter) for quarter in (
        (a, s, c, t), (s, b, c, t), (s, b, t, d), (a, s, t, d))])


def covered_by_contact(mesh: Mesh, faces: Faces, starts: np.ndarray, flat: np.ndarray,
                       touch: float) -> tuple[np.ndarray, dict[int, object]]:
    """Whether each patch is covered (n_patches,), and the uncovered parts of patches covered in part, as in
    `Mesh.partly`.

    A patch is covered where it is buried, face to face with another surface, as a crate and the floor, or
    where an earlier surface already lies in its place.
    starts, flat : (n_parts,) first patch of each part of a surface, and whether the part is in one plane
    """
    import shapely

    covered = mesh.covered.copy()
    low, high = mesh.corners.min(axis=1), mesh.corners.max(axis=1)
    boxes = np.stack([np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)], axis=1)
    one, part = near_boxes(faces.boxes, boxes, touch)
    parallel = np.abs(dot(faces.normals[one], mesh.normal[starts[part]])) > 1 - 1e-6
    own = mesh.vertex_surface[mesh.patches[starts, 0]]
    meet = (parallel | ~flat[part]) & (faces.surface[one] != own[part])
    one, part, ends = one[meet], part[meet], np.append(starts[1:], len(mesh.patches))
    # Surfaces after `last` are luminaires, whose faces lie in a wall's plane. Sheets are cut where they are
    # covered.
    last = faces.surface.max(initial=-1)
    feet: dict[int, list] = {}
    for k in np.unique(one):
        index, face = faces.surface[k], faces.faces[k]
        near = np.concatenate([np.arange(starts[p], ends[p]) for p in part[one == k]])
        near = near[(mesh.surface[near] != index) & (mesh.twin[near] < 0) & ~covered[near]]
        lowest, highest = faces.boxes[k]
        near = near[((low[near] <= highest + touch) & (high[near] >= lowest - touch)).all(axis=1)]
        shrunk = mesh.corners[near] + 1e-5 * (mesh.centroid[near, None] - mesh.corners[near])
        facing, offset = mesh.normal[near] @ face.normal, shrunk - _corner(face)
        level = (np.abs(offset @ face.normal) < touch).all(axis=1)
        again = ((facing > 1 - PARALLEL_TOLERANCE) & (mesh.surface[near] > index)
                 & (mesh.surface[near] <= last))
        asked = level & ((facing < -1 + PARALLEL_TOLERANCE) | again)
        shrunk, asked, offset = shrunk[asked], near[asked], offset[asked]
        if isinstance(face, Rectangle):
            places = np.stack([offset @ edge / (edge @ edge) for edge in (face.u, face.v)], axis=-1)
            inside, shape = ((places > 0) & (places < 1)).all(axis=(1, 2)), shapely.box(0, 0, 1, 1)
        else:
            places, inside, shape = face.flat(shrunk), face.contains(shrunk).all(axis=1), face.shape
        covered[asked] = inside
        shapely.prepare(shape)
        for patch in asked[~inside & shapely.intersects(shape, shapely.polygons(places))]:
            feet.setdefault(int(patch), []).append(face)
    return covered, _left(mesh, covered, feet)


def _left(mesh: Mesh, covered: np.ndarray, feet: dict[int, list[FlatFace]]) -> dict[int, object]:
    """The uncovered part, in s and t, of each patch with faces in contact; patches without any are added to
    `covered`."""
    import shapely

    found, rounding = {}, 1e-5
    for patch, faces in feet.items():
        if covered[patch]:
            continue
        whole = shapely.Polygon([(0, 0), (1, 0), (0, 1)] if mesh.triangular[patch]
                                else [(0, 0), (1, 0), (1, 1), (0, 1)])
        rings = [[np.stack(mesh.inside(np.full(len(ring), patch), ring), axis=-1) for ring in _rings(face)]
                 for face in faces]
        left = whole.difference(shapely.union_all([shapely.Polygon(outer, holes).buffer(0)
                                                   for outer, *holes in rings]))
        if left.area < rounding * whole.area:
            covered[patch] = True
        elif left.area < (1 - rounding) * whole.area:
            found[patch] = left
    return found


def turned(face: FlatFace) -> FlatFace:
    """The face with its normal reversed."""
    if isinstance(face, Rectangle):
        return Rectangle(face.corner, face.v, face.u)
    rings = tuple(ring[::-1, ::-1] for ring in face.rings)
    return Polygon(face.origin, face.axes[::-1], rings, face.triangles[:, ::-1])
