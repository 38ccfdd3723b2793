"""The parts of a room's flat faces that face air, where closed shells of bodies cut or cover the faces."""

from dataclasses import dataclass, replace

import numpy as np

from renderer.scene.crossings import Crossings
from renderer.scene.doubled import earlier_in_place, overlapping
from renderer.scene.faces_in_axes import FaceInAxes
from renderer.scene.flat import Parts, Polygon, polygon, rectilinear
from renderer.scene.geometry import CONTACT_TOLERANCE, PARALLEL_TOLERANCE, Rectangle, triangle_areas
from renderer.scene.shells import Shell

MANY_LINES = 100
"""Number of lines across a face above which they are joined end to end before their crossings are found."""


@dataclass(frozen=True)
class Exposed:
    """The flat parts of a surface, without those inside solids.

    sides : for each rectangle, polygon and triangle (k, 2), whether its front and its back face air; the back
        of a room's or a solid's face never does
    cut : whether a shell or a sheet cuts some of the parts
    """

    parts: Parts
    sides: tuple[np.ndarray, np.ndarray, np.ndarray]
    cut: bool = False

    @property
    def area(self) -> float:
        """Area [m²] with one side or both exposed."""
        areas = (np.array([np.linalg.norm(np.cross(r.u, r.v)) for r in self.parts.rectangles]),
                 np.array([p.shape.area for p in self.parts.polygons]),
                 triangle_areas(self.parts.triangles))
        return float(sum(each @ side.any(axis=1) for each, side in zip(areas, self.sides, strict=True)))


class Arrangement:
    """All flat faces of a room and its bodies, and the closed shells that may cut or cover them.

    scale : the room's longest side [m]
    shells : the room's own first
    """

    def __init__(self, scale: float, shells: list[Shell], faces: list[FaceInAxes]):
        self.off, self.shells, self.faces = CONTACT_TOLERANCE * scale, shells, faces
        self.low, self.high = np.array([shell.bounds for shell in shells]).swapaxes(0, 1)
        self.crossings = Crossings(faces, shells, self.off)
        self.neighbours = overlapping(self.crossings.boxes, self.off)
        self.earlier = earlier_in_place(faces, self.crossings.boxes, self.off)
        self.levels: dict[tuple[int, int], float] = {}

    def solids_at(self, shell: int, points: np.ndarray) -> np.ndarray:
        """Number of shells (k,) with solid matter at points (k, 3) just off faces that touch no other face.

        shell : the shell of the faces; −1 for a sheet
        """
        total = self.shells[shell].own_at(points) if shell >= 0 else np.zeros(len(points))
        for index, other in enumerate(self.shells):
            near = ((self.low[index] <= points) & (points <= self.high[index])).all(axis=1) | (index == 0)
            if index != shell and near.any():
                total[near] += other.solid_at(points[near])
        return total

    def exposed(self, whole: list[Parts], new: set[int] = frozenset()) -> list[Exposed]:
        """The exposed parts of each surface.

        whole : all flat parts of each surface, cut by nothing
        new : numbers of surfaces whose flat parts are not among the arrangement's faces
        """
        kept: list[list] = [[] for _ in whole]
        changed = [False for _ in whole]
        entire = self._entire()
        for k, face in enumerate(self.faces):
            if k in entire:
                kept[face.surface].append((face.face, (entire[k], False)))
                continue
            for piece, sides, cut in self._pieces(k, face):
                changed[face.surface] |= cut
                if any(sides) or not cut:
                    kept[face.surface].append((piece.face if isinstance(piece, FaceInAxes) else piece, sides))
        return [_gathered(pieces, None if cut or k in new else parts, cut)
                for k, (parts, pieces, cut) in enumerate(zip(whole, kept, changed, strict=True))]

    def _entire(self) -> dict[int, bool]:
        """Whether the front is exposed, by the number of each face of a closed shell that nothing cuts. No
        section reaches into the bounding rectangle of such a face, shrunk as in `_pieces`."""
        across = self.crossings
        whole = (across.shell >= 0) & ~across.cut
        whole[list(self.earlier)] = False
        some = np.flatnonzero(whole)
        middle = np.array([self.faces[k].middle[0] if isinstance(self.faces[k].face, Polygon)
                           else across.middle[k] for k in some]).reshape(-1, 3)
        points, shell = middle + self.off * across.normal[some], across.shell[some]
        total = np.zeros(len(some))
        for index, other in enumerate(self.shells):
            near = ((self.low[index] <= points) & (points <= self.high[index])).all(axis=1) | (index == 0)
            total[shell == index] += other.own_at(points[shell == index])
            near &= shell != index
            asked = near & across.met[index, shell]
            if asked.any():
                total[asked] += other.solid_at(points[asked])
            for s in np.unique(shell[near & ~asked]):
                total[near & ~asked & (shell == s)] += self._level(int(s), index)
        return dict(zip(some.tolist(), (total <= 0).tolist(), strict=True))

    def _pieces(self, k: int, face: FaceInAxes) -> list[tuple]:
        """Pieces of a face, each with its exposed sides and whether it is cut."""
        sheet, twins = face.shell < 0, self._twins(k, face)
        if not sheet and not len(self.crossings.triangles_of(k)) and not twins:
            return [(face, self._sides(face, face.middle), False)]
        lines = self._lines(k, face) + [twin.boundary for twin in twins]
        inner = face.shape.buffer(-2 * self.off)
        if not any(line.intersects(inner) for line in lines):
            point = face.middle
            if (sheet and self._already_covered(k, face, point)) or self._in_some(twins, face, point):
                return [(face, (False, False), False)]
            return [(face, self._sides(face, point), False)]
        cells = self._cells(face, lines)
        points = np.array([cell.representative_point().coords[0] for cell in cells])
        sides = [(False, False) if self._in_some(twins, face, point[None]) else
                 self._sides(face, point[None]) for point in face.solid(points)]
        if sheet:
            sides = [(False, False) if self._already_covered(k, face, point[None]) else side
                     for side, point in zip(sides, face.solid(points), strict=True)]
            return [piece for each in dict.fromkeys(sides) for piece in self._divided(
                face, [c for c, side in zip(cells, sides, strict=True) if side == each], each)]
        return self._beside_contacts(k, face, cells, sides)

    def _beside_contacts(self, k: int, face: FaceInAxes, cells: list, sides: list) -> list[tuple]:
        """Pieces of a solid's or the room's face that are not inside solids. Areas in contact with another
        face stay; the mesh removes them."""
        import shapely

        open_ = [cell for cell, side in zip(cells, sides, strict=True) if side[0]]
        hidden = shapely.union_all([cell for cell, side in zip(cells, sides, strict=True) if not side[0]])
        covers = [other.shape for other in self._coplanar(k, face, -1).values()]
        if covers:
            hidden = hidden.difference(shapely.union_all(covers).buffer(4 * self.off, join_style="mitre"))
        if not open_:
            return [(face, (False, False), False)]
        if hidden.area < self.off * face.shape.length:
            return [(face, (True, False), False)]
        left = face.shape.difference(hidden, grid_size=self.off / 100)
        return self._divided(face, list(getattr(left, "geoms", [left])), (True, False))

    def _divided(self, face: FaceInAxes, cells: list, sides: tuple[bool, bool]) -> list[tuple]:
        """Cells with the same exposed sides, joined into rectangles and polygons, without slivers."""
        import shapely

        joined = shapely.union_all(cells, grid_size=self.off / 100)
        pieces = []
        for shape in getattr(joined, "geoms", [joined]):
            if shape.geom_type != "Polygon" or shape.area < self.off * shape.length:
                continue
            made = polygon(shape.simplify(self.off / 10), face.origin, face.axes)
            pieces += rectilinear(made, self.off) or [made]
        return [(piece, sides, True) for piece in pieces]

    def _lines(self, k: int, face: FaceInAxes) -> list:
        """Lines that divide a face, in its axes, for shapely: the sections of shells just in front of it; for
        a sheet also those just behind it and the outlines of faces in its plane."""
        import shapely

        found = []
        for level in (self.off, -self.off) if face.shell < 0 else (self.off,):
            ends = self.crossings.lines(k, level)
            rounded = np.rint(ends / (self.off / 100))  # as in `_cells`, where some lines become points
            found += list(shapely.linestrings(ends[(rounded[:, 0] != rounded[:, 1]).any(axis=1)]))
        if face.shell < 0:
            found += [other.shape.boundary for side in (1, -1)
                      for other in self._coplanar(k, face, side).values()]
        return found

    def _twins(self, k: int, face: FaceInAxes) -> list:
        """Earlier faces of the same surface that lie on a solid's face, as shapes in its axes."""
        import shapely

        others = [self.faces[j] for j in self.earlier.get(k, ())]
        shapes = [shapely.Polygon(*[face.flat(other.solid(ring)) for ring in other.rings[:1]],
                                  [face.flat(other.solid(ring)) for ring in other.rings[1:]])
                  for other in others]
        return [shape for shape in shapes if shape.intersection(face.shape).area > self.off * shape.length]

    @staticmethod
    def _in_some(shapes: list, face: FaceInAxes, point: np.ndarray) -> bool:
        """Whether a place (1, 3) of a face is in any of the shapes, which are in its axes."""
        import shapely

        return bool(shapes) and any(shape.contains(shapely.Point(face.flat(point)[0])) for shape in shapes)

    def _coplanar(self, k: int, face: FaceInAxes, facing: int) -> dict[int, FaceInAxes]:
        """Faces of other surfaces or shells that lie in the plane of a face and whose extents overlap its
        own: by their numbers, in its axes.

        facing : 1 for faces that look the same way, −1 for those that look the opposite way
        """
        found = {}
        for j, other in ((int(j), self.faces[j]) for j in self.neighbours[k] if j != k):
            if (other.normal @ face.normal * facing > 1 - PARALLEL_TOLERANCE
                    and np.abs((other.corners - face.origin) @ face.normal).max() < 2 * self.off
                    and (face.shell < 0 or other.surface != face.surface)):
                rings = tuple(face.flat(other.solid(ring)) for ring in other.rings)
                found[j] = replace(other, origin=face.origin, axes=face.axes, rings=rings)
        return found

    def _cells(self, face: FaceInAxes, lines: list) -> list:
        """The polygons into which lines divide a face, in its axes."""
        import shapely

        shape = face.shape
        if len(lines) > MANY_LINES:
            short = shapely.set_precision(shapely.get_parts(lines), self.off / 100, mode="pointwise")
            lines = [shapely.line_merge(shapely.multilinestrings(short))]
        noded = shapely.union_all([shape.boundary, *lines], grid_size=self.off / 100)
        cells = shapely.get_parts(shapely.polygonize(list(getattr(noded, "geoms", [noded]))))
        inside = shape.buffer(2 * self.off)
        return [cell for cell in cells if cell.area > self.off * cell.length and inside.contains(cell)]

    def _already_covered(self, k: int, face: FaceInAxes, point: np.ndarray) -> bool:
        """Whether a sheet earlier in the list covers the place (1, 3) of this one."""
        import shapely

        place = shapely.Point(face.flat(point)[0])
        return any(other.shell < 0 and j < k and other.shape.contains(place)
                   for side in (1, -1) for j, other in self._coplanar(k, face, side).items())

    def _sides(self, face: FaceInAxes, point: np.ndarray) -> tuple[bool, bool]:
        """Whether the front and the back of a face are exposed at a place (1, 3)."""
        front = self._solid_at(face, point + self.off * face.normal) <= 0
        if face.shell >= 0:
            return front, False
        return front, self._solid_at(face, point - self.off * face.normal) <= 0

    def _solid_at(self, face: FaceInAxes, point: np.ndarray) -> float:
        """Number of shells with solid matter at a place (1, 3) just off a face."""
        total = 0.0
        for index, shell in enumerate(self.shells):
            near = index == 0 or ((self.low[index] <= point[0]) & (point[0] <= self.high[index])).all()
            met = face.shell < 0 or self.crossings.met[face.shell, index]
            if index == face.shell:
                total += float(shell.own_at(point)[0])
            elif near:
                total += float(shell.solid_at(point)[0]) if met else self._level(face.shell, index)
        return total

    def _level(self, shell: int, of: int) -> float:
        """Number of times that the shell `of` encloses `shell`, which it does not cross."""
        if (shell, of) not in self.levels:
            triangle = self.shells[shell].triangles[0]
            normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
            normal *= self.shells[shell].sign * self.off / np.linalg.norm(normal)
            place = triangle.mean(axis=0) + (normal if shell else 0 * normal)
            self.levels[shell, of] = float(self.shells[of].solid_at(place[None])[0])
        return self.levels[shell, of]


def _gathered(pieces: list[tuple], whole: Parts | None, cut: bool) -> Exposed:
    """The exposed parts of a surface from its pieces and their exposed sides.

    whole : the surface's flat parts where none is cut, else None
    """
    of_kind = [[(face, sides) for face, sides in pieces if isinstance(face, kind)]
               for kind in (Rectangle, Polygon, np.ndarray)]
    sides = tuple(np.array([each for _, each in some], dtype=bool).reshape(-1, 2) for some in of_kind)
    if whole is None:
        rectangles, polygons, triangles = ([face for face, _ in some] for some in of_kind)
        whole = Parts(tuple(rectangles), tuple(polygons), np.array(triangles).reshape(-1, 3, 3))
    return Exposed(whole, sides, cut)
