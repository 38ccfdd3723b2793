"""A scene divided into patches: surfaces of the room, bodies, and faces of luminaires."""

from dataclasses import replace

import numpy as np

from renderer.scene.flat import Polygon
from renderer.scene.geometry import CONTACT_TOLERANCE, Rectangle, rectangle_grid
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.scene.mounting import Mounting
from renderer.scene.scene import Scene, Surface
from renderer.scene.triangle_mesh import divided_to
from renderer.transport.mesh.assembly import Part, assembled
from renderer.transport.mesh.contacts import (
    Faces,
    covered_by_contact,
    cut,
    extent,
    graded,
    standing,
    turned,
)
from renderer.transport.mesh.gathering import gathered
from renderer.transport.mesh.grid_lines import GridLines
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.mesh.obstacles import blockers, obstacles
from renderer.transport.mesh.triangulation import triangulated, without

CLOSE_TO_LAMP = 36.0
"""Largest side of a patch over its distance from a lamp that lights it, divided by (patch size)/√(room area).
With the patches of 1 % accuracy the largest side is the distance itself."""


def build_mesh(scene: Scene, patch_size: float, finer_near: bool = True) -> Mesh:
    """A scene divided into patches of about `patch_size` [m], graded toward edges and contacts.

    finer_near : whether patches are smaller near lamps and in gaps, for readings that interpolate direct
      light between patches
    """
    every = list(enumerate(scene.exposed))
    placement = scene.placement
    mountings, free = placement.mountings, placement.free
    builder = _Builder(patch_size, CONTACT_TOLERANCE * scene.room.scale, scene.surfaces, placement.luminaires,
                       CLOSE_TO_LAMP * patch_size / np.sqrt(scene.room.area) if finer_near else np.inf)
    # A sheet in the place of an earlier sheet is left out: it neither covers nor borders anything.
    two_sided = {index for index, surface in enumerate(scene.surfaces) if surface.two_sided}
    rectangles, polygons = (
        [(index, face, sides) for index, of in every
         for face, sides in zip((of.parts.rectangles, of.parts.polygons)[kind], of.sides[kind], strict=True)
         if index not in two_sided or any(sides)] for kind in (0, 1))
    own = [r.corners for index, r, _ in rectangles if builder.of_room[index]]
    own += [m.outline for m in mountings if not m.cut_out]
    bodies = [r.corners for index, r, _ in rectangles if not builder.of_room[index]]
    flat = [(index, face) for index, face, _ in (*rectangles, *polygons)]
    faces = Faces(flat + [(index, turned(face)) for index, face in flat if index in two_sided], builder.touch)
    builder.add_rectangles(rectangles, np.array(own + bodies).reshape(-1, 4, 3), len(own), faces, mountings)
    for mounted in mountings:
        if mounted.cut_out:
            builder.add_face(mounted.surface, mounted.face)
    for k, (index, polygon, sides) in enumerate(polygons, start=len(rectangles)):
        builder.add_polygon(index, polygon, faces.against(k), faces, mountings, sides)
    for index, of in every:
        for sides in np.unique(of.sides[2], axis=0):
            builder.add_triangles(index, of.parts.triangles[(of.sides[2] == sides).all(axis=1)], sides)
    for index, luminaire in free:
        builder.add_face(index, luminaire, (True, True))
    free = [luminaire for _, luminaire in free]
    solids = [body.mesh.triangles for body in scene.bodies if body.closed]
    return builder.finish(faces, obstacles(scene, free), blockers(scene, free), scene.room.shell,
                          np.concatenate([np.zeros((0, 3, 3)), *solids]))


class _Builder:
    """Patches of a scene as they are added surface by surface.

    touch : distance that counts as contact [m]
    close : largest side of a patch near a lamp, over its distance from it
    """
    def __init__(self, patch_size: float, touch: float, surfaces: list[Surface], luminaires: list[Luminaire],
                 close: float):
        self.patch_size = patch_size
        self.touch = touch
        self.of_room = np.array([surface.of_room for surface in surfaces])
        self.two_sided = [surface.two_sided for surface in surfaces]
        self.luminaires = luminaires
        self.lamp_points = [np.vstack([lum.center, lum.corners]) for lum in luminaires]
        # in_gap limits patches of a solid across a gap, as under a low table, in a shelf or between louvres.
        # Gaps wider than √(room area)/25 have no effect.
        self.close, self.in_gap = close, close * 25.0 / CLOSE_TO_LAMP
        self.shortest_in_gap = patch_size / 2
        self.parts: list[Part] = []

    def add(self, index: int, vertices: np.ndarray, patches: np.ndarray, sides, facet: bool = False) -> None:
        """Add a part of a surface. index, vertices, patches, sides, facet : as in `Part`"""
        self.parts.append(Part(vertices, patches, index, np.full(len(patches), index), sides,
                               self.two_sided[index], facet))

    def add_rectangles(self, rectangles: list[tuple[int, Rectangle, np.ndarray]], outlines: np.ndarray,
                       own: int, faces: Faces, mountings: list[Mounting]) -> None:
        """Divide rectangles along the outlines of the room, of mounted luminaires and of solids that touch
        them.

        Where outlines of solids would make too many cells, their feet (areas of contact) are cut out one by
        one instead.
        rectangles : surface, rectangle and exposed sides of each, in the order of `faces`
        outlines, own : as in `GridLines`
        """
        lines = GridLines([r for _, r, _ in rectangles], outlines, own, self.patch_size, self.touch,
                          round(2 / self.close))
        covers = [self.on(index, r.corner, r.normal, mountings) for index, r, _ in rectangles]
        divided = {}
        for k, (index, rectangle, _) in enumerate(rectangles):
            feet = standing(rectangle, faces.against(k), lines.crowded[k],
                            [m.outline for m in covers[k] if m.cut_out], self.patch_size, self.touch)
            near = self.near(rectangle, self.over_gaps(index, rectangle, faces))
            if feet is not None or near:
                divided[k] = self.divided(rectangle, *lines.of(k), feet, near)
        even = np.array([k for k in range(len(rectangles)) if k not in divided], dtype=int)
        divided.update(zip(even.tolist(), lines.cells(even), strict=True))
        for k, (index, _, sides) in enumerate(rectangles):
            vertices, patches = divided[k]
            surface = np.full(len(patches), index)
            for cover in (each for each in covers[k] if not each.cut_out):
                middles = vertices[patches].mean(axis=1)
                o, e, f = cover.outline[0], *(cover.outline[k] - cover.outline[0] for k in (1, 3))
                s, t = (middles - o) @ e / (e @ e), (middles - o) @ f / (f @ f)
                surface[(s > 0) & (s < 1) & (t > 0) & (t < 1)] = cover.surface
            self.parts.append(Part(vertices, patches, index, surface, sides, self.two_sided[index]))

    def on(self, index: int, corner, normal, mountings: list[Mounting]) -> list[Mounting]:
        """The luminaires mounted on a flat part of the room."""
        return [m for m in mountings if m.on(corner, normal, self.touch)] if self.of_room[index] else []

    def add_polygon(self, index: int, polygon: Polygon, against: list[list[np.ndarray]], faces: Faces,
                    mountings: list[Mounting], sides: np.ndarray) -> None:
        """Divide a polygon into triangles, without the feet of solids on it; a small polygon keeps its own
        triangles. against : from `Faces.against`"""
        feet = [[m.outline] for m in self.on(index, polygon.origin, polygon.normal, mountings)]
        feet += against
        gaps = [((corners - polygon.origin) @ polygon.normal).min()
                for corners in self.over_gaps(index, polygon, faces)]
        long = np.clip(min(gaps, default=np.inf) * self.in_gap, self.shortest_in_gap, self.patch_size)
        small = np.ptp(polygon.frame, axis=0).max() < long
        if small and not feet and len(polygon.triangles) <= 4:
            self.add_triangles(index, polygon.triangles, sides)
            return
        for part in without(polygon, feet, self.touch):
            points, triangles = triangulated(part, float(long))
            self.add(index, polygon.solid(points), np.column_stack([triangles, triangles[:, 2]]), sides)

    def over_gaps(self, index: int, face: Rectangle | Polygon, faces: Faces) -> list[np.ndarray]:
        """Corners (k, 3) [m] of each face across a narrow gap from a flat part, with a body on at least one
        side.
        """
        if np.isinf(self.close):
            return []  # patches are not made smaller anywhere
        beside = ~self.of_room if self.of_room[index] else np.ones_like(self.of_room)
        return faces.across(face, self.touch, self.patch_size / self.in_gap, beside)

    def divided(self, rectangle: Rectangle, us: np.ndarray, vs: np.ndarray, feet,
                near: list[tuple]) -> tuple[np.ndarray, np.ndarray]:
        """Vertices (k, 3) [m] and patches (m, 4) of a rectangle cut at `us` and `vs`, finer near lamps and
        near faces across a gap.

        feet : from `standing`, cut out of the patches; None where there are none
        near : from `near`
        """
        s, t = (np.column_stack([x[:-1], x[1:]]) for x in (us, vs))
        cells = np.concatenate([np.repeat(s, len(t), axis=0), np.tile(t, (len(s), 1))], axis=1)
        sides = np.linalg.norm(rectangle.u), np.linalg.norm(rectangle.v)
        finer = graded(cells, sides, near) if near else cells
        if len(finer) == len(cells) and feet is None:
            return rectangle_grid(rectangle, us, vs)
        triangles = np.zeros((0, 3, 2))
        if feet is not None:
            finer, triangles = cut(rectangle, finer, feet, self.patch_size, self.touch)
        corners = np.concatenate([finer[:, [[0, 2], [1, 2], [1, 3], [0, 3]]],
                                  triangles[:, [0, 1, 2, 2]]]).reshape(-1, 2)
        # Cuts of neighbouring cells coincide only to rounding.
        _, first, index = np.unique(np.round(corners, 8), axis=0, return_index=True, return_inverse=True)
        return (rectangle.corner + corners[first] @ np.stack([rectangle.u, rectangle.v]),
                index.reshape(-1, 4))

    def near(self, rectangle: Rectangle, facing: list[np.ndarray]) -> list[tuple]:
        """The lamps that light a rectangle and the faces across a gap from it, as boxes for `graded`.

        facing : from `over_gaps`
        """
        if np.isinf(self.close):
            return []
        sides = np.linalg.norm(rectangle.u), np.linalg.norm(rectangle.v)
        axes = np.stack([rectangle.u / sides[0], rectangle.v / sides[1], rectangle.normal])
        near = [(*extent(facing, rectangle.corner, axes), self.in_gap, self.shortest_in_gap)]
        if self.luminaires:
            points = (np.concatenate(self.lamp_points) - rectangle.corner) @ axes.T
            counts = [len(each) for each in self.lamp_points]
            above = np.maximum.reduceat(points[:, 2], np.cumsum(counts) - counts) > self.touch
            lit = [not lum.forward_only or ((rectangle.corners - lum.center) @ lum.normal).max() > self.touch
                   for lum in self.luminaires]
            points = points[np.repeat(above & lit, counts)]
            near.insert(0, (points, points, self.close, self.patch_size / 64))
        return near if any(len(low) for low, *_ in near) else []

    def add_triangles(self, index: int, triangles: np.ndarray, sides: np.ndarray) -> None:
        """Add triangles (k, 3, 3) [m], divided until no side is longer than two patches. They may be
        gathered."""
        if not len(triangles):
            return
        faces = np.arange(3 * len(triangles)).reshape(-1, 3)
        vertices, faces = divided_to(triangles.reshape(-1, 3), faces, 2 * self.patch_size)
        corners = vertices[faces]
        doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        faces = faces[np.linalg.norm(doubled, axis=1) > self.touch**2]
        self.add(index, vertices, np.column_stack([faces, faces[:, 2]]), sides, facet=True)

    def add_face(self, index: int, luminaire: Luminaire, sides=(True, False)) -> None:
        """Add a luminaire's front, and its back where both sides face air."""
        vertices, patches = luminaire.body.divided(self.patch_size)
        self.parts.append(Part(vertices, patches, index, np.full(len(patches), index), sides, all(sides)))

    def finish(self, faces: Faces, obstacles: np.ndarray, blockers: np.ndarray, shell: np.ndarray,
               solids: np.ndarray) -> Mesh:
        """The mesh of all patches added, with covered ones marked and facets gathered."""
        of = assembled(self.parts)
        mesh = Mesh(of.vertices, of.patches, of.surface, of.vertex_surface, of.twin, ~of.exposed, obstacles,
                    blockers, shell, solids)
        sides = np.linalg.norm(mesh.corners - np.roll(mesh.corners, 1, axis=1), axis=2)
        slivers = mesh.area < 10 * self.touch * sides.max(axis=1)  # slivers are cut off beside contacts
        covered, partly = covered_by_contact(replace(mesh, covered=mesh.covered | slivers), faces, of.starts,
                                             ~of.facet[of.starts], self.touch)
        group = gathered(mesh.centroid, mesh.normal, mesh.area, mesh.surface, of.facet, self.patch_size)
        return replace(mesh, covered=covered, partly=partly, group=group)
