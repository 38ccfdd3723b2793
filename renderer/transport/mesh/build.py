"""A scene divided into patches: surfaces of the room, bodies, and faces of luminaires."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from renderer.scene.flat import Polygon
from renderer.scene.geometry import CONTACT_TOLERANCE, Rectangle, rectangle_grid
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.scene.mounting import Mounting
from renderer.scene.scene import Scene, Surface
from renderer.scene.triangle_mesh import divided_to
from renderer.transport.mesh.contacts import (
    Faces,
    Outlines,
    covered_by_contact,
    cut,
    graded,
    standing,
    turned,
)
from renderer.transport.mesh.gathering import gathered
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.mesh.obstacles import blockers, obstacles
from renderer.transport.mesh.triangulation import triangulated, without

GRADING = 1.0
"""Grading of a rectangle's divisions: 0 for even divisions; 1 for cuts at cosines of even angles, finest at
the edges, where light changes fastest. With 1 a corner at ρ = 0.9 converges at second order."""
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
    outlines = Outlines(np.array(own + bodies).reshape(-1, 4, 3), len(own))
    flat = [(index, face) for index, face, _ in (*rectangles, *polygons)]
    faces = Faces(flat + [(index, turned(face)) for index, face in flat if index in two_sided])
    for index, rectangle, sides in rectangles:
        builder.add_rectangle(index, rectangle, outlines, faces, mountings, sides)
    for mounted in mountings:
        if mounted.cut_out:
            builder.add_face(mounted.surface, mounted.face)
    for index, polygon, sides in polygons:
        builder.add_polygon(index, polygon, faces, mountings, sides)
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
        # in_gap limits patches of a solid across a gap, as under a low table, in a shelf or between louvres.
        # Gaps wider than √(room area)/25 have no effect.
        self.close, self.in_gap = close, close * 25.0 / CLOSE_TO_LAMP
        self.shortest_in_gap = patch_size / 2
        self.vertices, self.patches, self.surface = [], [], []
        self.vertex_surface, self.twin, self.exposed, self.facet = [], [], [], []
        self.n_vertices = self.n_patches = 0

    def add(self, vertices, patches, surface, vertex_surface, sides=(True, False), sheet=False, facet=False):
        """Add patches (k, 4) of vertices (n, 3) [m]; for a sheet also their backs.

        sides : (2,) whether the front and the back face air
        facet : whether the patches may be gathered
        """
        a, b, c = vertices[patches[:, :3]].swapaxes(0, 1)
        longest2 = np.maximum(((b - a)**2).sum(axis=1), ((c - a)**2).sum(axis=1))
        keep = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-9 * longest2  # others have no area
        patches, surface = patches[keep], surface[keep]
        k, front = len(patches), self.n_patches
        self._append(vertices, patches, surface, vertex_surface, sides[0])
        self.facet += [np.full(k, facet)] * (1 + sheet)
        if not sheet:
            self.twin.append(np.full(k, -1))
            return
        triangular = patches[:, 2] == patches[:, 3]
        back = np.where(triangular[:, None], patches[:, [0, 2, 1, 1]], patches[:, [0, 3, 2, 1]])
        self._append(vertices, back, surface, vertex_surface, sides[1])
        self.twin += [front + k + np.arange(k), front + np.arange(k)]

    def _append(self, vertices, patches, surface, vertex_surface, exposed):
        self.vertices.append(vertices)
        self.patches.append(patches + self.n_vertices)
        self.surface.append(surface)
        self.vertex_surface.append(np.full(len(vertices), vertex_surface))
        self.exposed.append(np.full(len(patches), exposed))
        self.n_vertices += len(vertices)
        self.n_patches += len(patches)

    def add_rectangle(self, index: int, rectangle: Rectangle, outlines: Outlines, faces: Faces,
                      mountings: list[Mounting], sides: np.ndarray) -> None:
        """Divide a rectangle along the outlines of the room, of mounted luminaires and of solids that touch
        it.

        Where outlines of solids would make too many cells, their feet (areas of contact) are cut out one by
        one instead.
        """
        edges, own = outlines.along(rectangle, self.touch)
        us, vs = self.grid_lines(rectangle, edges)
        most = 16  # ratio of the number of cells with outlines to that without
        crowded = len(us) * len(vs) > 4 * most
        if crowded:  # relative to the cells without outlines, of which there are at least four corners
            alone = self.grid_lines(rectangle, edges[:, :, own])
            crowded = len(us) * len(vs) > most * len(alone[0]) * len(alone[1])
            us, vs = alone if crowded else (us, vs)
        covers = self.on(index, rectangle.corner, rectangle.normal, mountings)
        feet = standing(rectangle, faces.against(index, rectangle, self.touch), crowded,
                        [m.outline for m in covers if m.cut_out], self.patch_size, self.touch)
        vertices, patches = self.divided(rectangle, us, vs, feet, self.over_gaps(index, rectangle, faces))
        surface = np.full(len(patches), index)
        middles = vertices[patches].mean(axis=1)
        for cover in covers:
            if cover.cut_out:
                continue
            o, e, f = cover.outline[0], *(cover.outline[k] - cover.outline[0] for k in (1, 3))
            s, t = (middles - o) @ e / (e @ e), (middles - o) @ f / (f @ f)
            surface[(s > 0) & (s < 1) & (t > 0) & (t < 1)] = cover.surface
        self.add(vertices, patches, surface, index, sides, self.two_sided[index])

    def on(self, index: int, corner, normal, mountings: list[Mounting]) -> list[Mounting]:
        """The luminaires mounted on a flat part of the room."""
        return [m for m in mountings if self.of_room[index] and m.on(corner, normal, self.touch)]

    def add_polygon(self, index: int, polygon: Polygon, faces: Faces, mountings: list[Mounting],
                    sides: np.ndarray) -> None:
        """Divide a polygon into triangles, without the feet of solids on it; a small polygon keeps its own
        triangles."""
        feet = [[m.outline] for m in self.on(index, polygon.origin, polygon.normal, mountings)]
        feet += faces.against(index, polygon, self.touch)
        gaps = [((corners - polygon.origin) @ polygon.normal).min()
                for corners in self.over_gaps(index, polygon, faces)]
        long = np.clip(min(gaps, default=np.inf) * self.in_gap, self.shortest_in_gap, self.patch_size)
        small = np.ptp(polygon.frame, axis=0).max() < long
        if small and not feet and len(polygon.triangles) <= 4:
            self.add_triangles(index, polygon.triangles, sides)
            return
        for part in without(polygon, feet, self.touch):
            points, triangles = triangulated(part, float(long))
            self.add(polygon.solid(points), np.column_stack([triangles, triangles[:, 2]]),
                     np.full(len(triangles), index), index, sides, self.two_sided[index])

    def over_gaps(self, index: int, face: Rectangle | Polygon, faces: Faces) -> list[np.ndarray]:
        """Corners (k, 3) [m] of each face across a narrow gap from a flat part, with a body on at least one
        side.
        """
        if np.isinf(self.close):
            return []  # patches are not made smaller anywhere
        beside = ~self.of_room if self.of_room[index] else np.ones_like(self.of_room)
        return faces.across(face, self.touch, self.patch_size / self.in_gap, beside)

    def divided(self, rectangle: Rectangle, us: np.ndarray, vs: np.ndarray, feet,
                facing: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Vertices (k, 3) [m] and patches (m, 4) of a rectangle cut at `us` and `vs`, finer near lamps and
        near faces across a gap.

        feet : from `standing`, cut out of the patches; None where there are none
        facing : from `over_gaps`
        """
        s, t = (np.column_stack([x[:-1], x[1:]]) for x in (us, vs))
        cells = np.concatenate([np.repeat(s, len(t), axis=0), np.tile(t, (len(s), 1))], axis=1)
        finer = self.toward(rectangle, cells, facing)
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

    def grid_lines(self, rectangle: Rectangle, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Cuts of a rectangle along each of its two edges (k,), from 0 to 1. edges : from `Outlines.along`"""
        length, width = np.linalg.norm(rectangle.u), np.linalg.norm(rectangle.v)
        return self.divisions(length, width, *edges), self.divisions(width, length, *edges[::-1])

    def divisions(self, length: float, width: float, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Cuts of a rectangle along one edge (k,), from 0 to 1, at outlines and between them.

        length, width : of that edge and of the other [m]
        x, y : (2, m) [m], coordinates of both ends of each outline along that edge and across it
        """
        cuts = (abs(x[0] - x[1]) < self.touch) & (y.max(axis=0) > self.touch) & (
            y.min(axis=0) < width - self.touch)
        inner = np.sort(x[0, cuts & (x[0] > self.touch) & (x[0] < length - self.touch)])
        stops = [0.0]
        for x in [*inner, length]:
            if x - stops[-1] > self.touch:
                stops.append(float(x))
        stops[-1] = length
        pieces = [np.zeros(1)]
        for start, end in pairwise(stops):
            n = max(1, int(np.ceil((end - start) / self.patch_size - 0.01)))
            # A whole edge of a small object is cut in two with the patches of 1 % accuracy, in more for finer
            # patches.
            if len(stops) == 2 and end - start > 0.2 * self.patch_size:
                n = max(n, round(2 / self.close))
            even = np.linspace(0, 1, n + 1)[1:]
            eased = (1 - GRADING) * even + GRADING * (1 - np.cos(np.pi * even)) / 2
            pieces.append(start + (end - start) * eased)
        return np.concatenate(pieces) / length

    def toward(self, rectangle: Rectangle, cells: np.ndarray, facing: list[np.ndarray]) -> np.ndarray:
        """Cells (m, 4) of a rectangle, from and to in s and in t, quartered until each is small relative to
        its distance from lamps that light the rectangle and from faces across a gap."""
        if np.isinf(self.close):
            return cells
        sides = np.linalg.norm(rectangle.u), np.linalg.norm(rectangle.v)
        axes = np.stack([rectangle.u / sides[0], rectangle.v / sides[1], rectangle.normal])
        near = []
        for lum in self.luminaires:
            points = np.vstack([lum.center, lum.corners])
            points = (points - rectangle.corner) @ axes.T
            lit = ((rectangle.corners - lum.center) @ lum.normal).max() > self.touch
            if points[:, 2].max() <= self.touch or (lum.forward_only and not lit):
                continue
            near.append((points, points, self.close, self.patch_size / 64))
        for corners in facing:
            local = (corners - rectangle.corner) @ axes.T
            near.append((local.min(axis=0)[None], local.max(axis=0)[None], self.in_gap,
                         self.shortest_in_gap))
        return graded(cells, sides, near) if near else cells

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
        self.add(vertices, np.column_stack([faces, faces[:, 2]]), np.full(len(faces), index), index, sides,
                 self.two_sided[index], facet=True)

    def add_face(self, index: int, luminaire: Luminaire, sides=(True, False)) -> None:
        """Add a luminaire's front, and its back where both sides face air."""
        vertices, patches = luminaire.body.divided(self.patch_size)
        self.add(vertices, patches, np.full(len(patches), index), index, sides, all(sides))

    def finish(self, faces: Faces, obstacles: np.ndarray, blockers: np.ndarray, shell: np.ndarray,
               solids: np.ndarray) -> Mesh:
        """The mesh of all patches added, with covered ones marked and facets gathered."""
        arrays = (np.concatenate(x) for x in (self.vertices, self.patches, self.surface,
                                              self.vertex_surface, self.twin))
        covered = ~np.concatenate(self.exposed)
        mesh = Mesh(*arrays, covered, obstacles, blockers, shell, solids)
        sides = np.linalg.norm(mesh.corners - np.roll(mesh.corners, 1, axis=1), axis=2)
        slivers = mesh.area < 10 * self.touch * sides.max(axis=1)  # slivers are cut off beside contacts
        covered, partly = covered_by_contact(replace(mesh, covered=covered | slivers), faces, self.touch)
        group = gathered(mesh.centroid, mesh.normal, mesh.area, mesh.surface, np.concatenate(self.facet),
                         self.patch_size)
        return replace(mesh, covered=covered, partly=partly, group=group)
