"""The share of a pixel that a luminaire covers, at the luminaire's edge or that of a surface in front of it.

A luminaire is about a hundred times as bright as its surroundings. With 16 rays, which are enough for other
edges, most of a picture's error would lie in the few hundred pixels along luminaires. Many rays are cast for
these pixels; they are cheap because they need no illuminance.
"""

import numpy as np

from renderer.pictures.pinhole import Pinhole
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.system.threads import CHUNK, in_threads
from renderer.transport.transport import Transport


def lamp_shares(transport: Transport, camera: Pinhole, middles: np.ndarray, corners: np.ndarray):
    """Pixels (m,) with an edge of a luminaire, the surfaces (m,) of these luminaires, the shares (m,) of the
    pixels that they cover, and unit directions (m, 3) from the luminaires to the camera.

    Pixels are counted row by row.

    middles : (height, width) surface at the centre of each pixel
    corners : (height + 1, width + 1) surface at the corners
    """
    at = np.stack([middles, corners[:-1, :-1], corners[:-1, 1:], corners[1:, :-1], corners[1:, 1:]])
    pixels, surfaces, lows, highs = [], [], [], []
    for surface, k in transport.faces:
        edges = camera.edges(_face(transport, surface, transport.luminaires[k]))
        if not len(edges):
            continue
        shown = at == surface
        partly = np.flatnonzero(shown.any(axis=0) & ~shown.all(axis=0))
        # Pixels that the outline crosses include those with a luminaire smaller than a pixel.
        pixel = np.union1d(partly, camera.crossed(edges))
        corner = np.stack([pixel % camera.width, pixel // camera.width], axis=1)
        pixels.append(pixel)
        surfaces.append(np.full(len(pixel), surface))
        lows.append(np.maximum(corner, edges.min(axis=(0, 1))))
        highs.append(np.maximum(lows[-1], np.minimum(corner + 1, edges.max(axis=(0, 1)))))
    if not pixels:
        return np.zeros(0, int), np.zeros(0, int), np.zeros(0), np.zeros((0, 3))
    pixel, surface, low, high = (np.concatenate(x) for x in (pixels, surfaces, lows, highs))
    share = np.prod(high - low, axis=1) * _hit(transport, camera, surface, low, high)
    found = share > 0
    away = -camera.directions(*((low + high) / 2)[found].T)
    return pixel[found], surface[found], share[found], away


def _face(transport: Transport, surface: int, luminaire: Luminaire) -> np.ndarray:
    """A luminaire's outline (k, 3) [m] in the plane of its patches in the mesh."""
    mesh = transport.mesh
    first = np.argmax(mesh.surface == surface)
    return luminaire.outline + (mesh.centroid[first] - luminaire.center) @ luminaire.normal * luminaire.normal


def _hit(transport: Transport, camera: Pinhole, surface: np.ndarray, low: np.ndarray,
         high: np.ndarray) -> np.ndarray:
    """Share (k,) of the rays through rectangles of the picture, low to high (k, 2) [pixels], that meet a
    surface (k,).

    The rays form a Fibonacci lattice, which is even with respect to slanted edges and has one ray in each
    column and row, for upright edges (H. Niederreiter and I. H. Sloan, J. Comput. Appl. Math. 51, 1994, 57).
    """
    rays = 987  # a Fibonacci number
    k = np.arange(rays)
    square = np.stack([k + 0.5, k * 610 % rays + 0.5], axis=1) / rays
    share = np.empty(len(surface))

    def work(start: int, stop: int) -> None:
        part = slice(start, stop)
        x, y = np.moveaxis(low[part, None] + square * (high - low)[part, None], 2, 0)
        directions = camera.directions(x.ravel(), y.ravel())
        met = transport.eye.first_hit(np.broadcast_to(camera.position, directions.shape), directions)
        met = np.where(met >= 0, transport.mesh.surface[met], -1).reshape(x.shape)
        share[part] = (met == surface[part, None]).mean(axis=1)

    in_threads(work, len(surface), CHUNK // rays)
    return share
