"""A camera in a room: the sensor of each pixel."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from renderer.pictures.lamp_edges import lamp_shares
from renderer.pictures.pinhole import Pinhole, pinhole
from renderer.readings.meter_place import off_surfaces, refuse_inside, refuse_outside
from renderer.scene.meter_tables import CameraTable
from renderer.scene.scene import Scene
from renderer.solving.solution import Solution
from renderer.system.threads import in_threads
from renderer.transport.factors.exchange import rows
from renderer.transport.sensors import Sensor, direct_on, emitted, seen_from, sense
from renderer.transport.transport import Transport


@dataclass(frozen=True)
class View:
    """The view of a camera, valid for all materials and bands.

    sensor : one row for each pixel
    emitted : (n_pixels, n_luminaires) radiosity per lumen
    surface : (height, width) index of the surface at each pixel's centre, -1 for none
    share : (n_pixels, n_surfaces) share of each pixel that shows each surface
    patch : (height, width) patch at each pixel's centre, negative for none
    light : (n_pixels, n_luminaires) direct illuminance per lumen at each pixel's centre [m⁻²]
    edge : (height, width) whether a pixel is the mean of several rays
    eye : (3,) [m] position of the camera, off the surfaces that it touches
    """

    sensor: Sensor
    emitted: sparse.csr_array
    surface: np.ndarray
    share: sparse.csr_array
    patch: np.ndarray
    light: np.ndarray
    edge: np.ndarray
    camera: Pinhole
    eye: np.ndarray
    transport: Transport

    @property
    def shows_surface(self) -> np.ndarray:
        """Whether each pixel (height, width) shows no luminaire."""
        return self.image(np.asarray(self.emitted.sum(axis=1)).ravel() == 0)

    def directions(self, pixel: np.ndarray) -> np.ndarray:
        """Directions (k, 3) through the centres of pixels (k,), counted row by row."""
        y, x = np.divmod(pixel, self.camera.width)
        return self.camera.directions(x + 0.5, y + 0.5)

    def marks(self, scene: Scene) -> list[tuple[float, float]]:
        """Places [pixels] of the scene's visible photometers in the picture."""
        places = [np.array(p.position) for p in scene.photometers]
        seen = [self.transport.eye.clear(self.eye[None], place[None])[0] for place in places]
        found = [self.camera.project(place) for place, free in zip(places, seen, strict=True) if free]
        return [mark for mark in found if mark is not None]

    def image(self, values: np.ndarray) -> np.ndarray:
        """Values of pixels (n_pixels, …) as a picture (height, width, …)."""
        return values.reshape(*self.surface.shape, *values.shape[1:])

    def direct(self, solution: Solution, weights: np.ndarray) -> np.ndarray:
        """Radiance (height, width, k) from luminaires and from direct light on surfaces, as weighted sums of
        bands.

        weights : (n_bands, k), for example BandSet.xyz for cd/m² (X, Y, Z)
        """
        return self._added(self._direct(solution, weights))

    def indirect(self, solution: Solution, weights: np.ndarray) -> np.ndarray:
        """Radiance (height, width, k) from interreflection; weights as for `direct`."""
        return self._added(self._indirect(solution, weights))

    def spectral(self, solution: Solution) -> np.ndarray:
        """Spectral radiance (height, width, n_bands) [W m⁻² sr⁻¹ nm⁻¹]."""
        bands = solution.bands
        direct = self._from_lamps(solution, solution.scene.watts(bands), np.diag(1 / bands.widths))
        return self._added(direct + self._indirect(solution, np.diag(bands.watts / bands.widths)))

    def _direct(self, solution: Solution, weights: np.ndarray) -> list[tuple]:
        return self._from_lamps(solution, solution.flux, weights)

    def _from_lamps(self, solution: Solution, flux: np.ndarray, weights: np.ndarray) -> list[tuple]:
        reflected = solution.reflectance[:, None, :] * flux[None]
        light = reflected.reshape(-1, reflected.shape[-1]) @ weights
        return [(self.sensor.direct, light), (self.emitted, flux @ weights)]

    def _indirect(self, solution: Solution, weights: np.ndarray) -> list[tuple]:
        return [(self.sensor.indirect, solution.vertex_radiosity @ weights)]

    def _added(self, terms: list[tuple]) -> np.ndarray:
        """Σ matrix @ light / π as a picture, from pairs (matrix, light); a matrix has a row for each
        pixel."""
        seen = np.empty((self.surface.size, terms[0][1].shape[1]))

        def work(start: int, stop: int) -> None:
            seen[start:stop] = sum(rows(matrix, start, stop) @ light for matrix, light in terms) / np.pi

        in_threads(work, len(seen), 1 << 13)
        return self.image(seen)

    def reflectances(self, solution: Solution) -> np.ndarray:
        """Luminous reflectance (height, width) of the surfaces in each pixel, under the lamps' light."""
        light = solution.flux.sum(axis=0) * solution.bands.luminous
        total = light.sum()
        luminous = solution.reflectance @ light / (total if total > 0 else 1.0)
        return self.image(self.share @ luminous)


def look(transport: Transport, table: CameraTable, where: str) -> View:
    """The view of a camera. Raises InputError for a camera outside the room or inside a solid.

    A pixel on an edge of a surface or a shadow is the mean of 4 × 4 rays, each with 16 shadow rays to each
    luminaire.
    """
    camera = pinhole(table)
    refuse_outside(transport, camera.position, f"{where}: camera")
    eye = off_surfaces(transport, camera.position, camera.axes[2]).origin
    refuse_inside(transport, eye, f"{where}: camera", camera.position)
    width, height = camera.width, camera.height
    n = width * height
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    middles = _hits(transport, camera, eye, x.ravel(), y.ravel())
    x_corner, y_corner = np.meshgrid(np.arange(width + 1.0), np.arange(height + 1.0))
    corners = _hits(transport, camera, eye, x_corner.ravel(), y_corner.ravel())[0]
    corners = corners.reshape(height + 1, width + 1)
    shown = _surface(transport, middles[0]).reshape(height, width)
    lamp, face, cover, away = lamp_shares(transport, replace(camera, position=eye), shown,
                                          _surface(transport, corners))
    corners = _plane(transport, corners)
    plane = _plane(transport, middles[0]).reshape(height, width)
    edge = np.zeros((height, width), dtype=bool)
    for corner in (corners[:-1, :-1], corners[:-1, 1:], corners[1:, :-1], corners[1:, 1:]):
        edge |= corner != plane
    edge.flat[lamp] = True
    found = middles[0] >= 0
    patch, s, t = (m[found] for m in middles)
    light = direct_on(transport, patch, s, t, 0)[0]
    at_middle = np.zeros((n, light.shape[1]))
    at_middle[found] = light
    if transport.ray_scene is not None:
        lumens = np.array([luminaire.lumens for luminaire in transport.luminaires])
        edge |= _shadow_edges(light @ lumens, found, edge.shape)
    plain = ~edge.ravel()[found]
    fine = np.flatnonzero(edge.ravel())
    sub = (np.arange(4) + 0.5) / 4 - 0.5
    dx, dy = (d.ravel() for d in np.meshgrid(sub, sub))
    x_fine, y_fine = (x.ravel()[fine, None] + dx).ravel(), (y.ravel()[fine, None] + dy).ravel()
    extra = _hits(transport, camera, eye, x_fine, y_fine)
    weight = _rest(n, fine, _surface(transport, extra[0]).reshape(-1, dx.size), lamp, face, cover).ravel()
    hit = (extra[0] >= 0) & (weight > 0)
    extra = [e[hit] for e in extra]
    row = np.concatenate([np.flatnonzero(found)[plain], np.repeat(fine, dx.size)[hit]])
    light = np.concatenate([light[plain], direct_on(transport, *extra, 1, 16)[0]])
    patch, s, t = (np.concatenate([m[plain], e])
                   for m, e in zip((patch, s, t), extra, strict=True))
    weight = np.concatenate([np.ones(plain.sum()), weight[hit]])
    sensor = sense(transport, n, row, patch, s, t, weight[None], light[None])[0]
    away = np.concatenate([-camera.directions(x.ravel()[row[:plain.sum()]], y.ravel()[row[:plain.sum()]]),
                           -camera.directions(x_fine[hit], y_fine[hit]), away])
    row, weight = np.concatenate([row, lamp]), np.concatenate([weight, cover])
    surface = np.concatenate([transport.mesh.surface[patch], face])
    share = sparse.coo_array((weight, (row, surface)), shape=(n, transport.n_surfaces)).tocsr()
    return View(sensor, emitted(transport, n, row, surface, weight, away), shown, share,
                middles[0].reshape(height, width), at_middle, edge, camera, eye, transport)


def _rest(n: int, fine: np.ndarray, surface: np.ndarray, lamp: np.ndarray, face: np.ndarray,
          cover: np.ndarray) -> np.ndarray:
    """Weights (k, rays) of the rays through pixels `fine` (k,), which meet surfaces (k, rays).

    cover : (m,) known share of pixels `lamp` (m,) that the luminaire surfaces `face` (m,) cover

    Rays that meet such a face have weight 0; the others divide the rest of the pixel equally. Where every ray
    meets a face, the rest (up to an eighth of the pixel, and dim beside the luminaire) is neglected.
    """
    top = surface.max(initial=0) + face.max(initial=0) + 1
    known = np.isin(fine[:, None] * top + surface, lamp * top + face) & (surface >= 0)
    left = np.clip(1 - np.bincount(lamp, cover, n)[fine], 0, 1)
    return np.where(known, 0, (left / np.maximum((~known).sum(axis=1), 1))[:, None])


def _hits(transport: Transport, camera: Pinhole, eye: np.ndarray, x: np.ndarray, y: np.ndarray):
    """Patch (k,), negative for none, and place (s, t) on it, at points of the picture."""
    return seen_from(transport, eye, camera.directions(x, y))


def _surface(transport: Transport, patch: np.ndarray) -> np.ndarray:
    """Index of the surface of each patch, -1 for none; an array of any shape."""
    return np.where(patch >= 0, transport.mesh.surface[patch], -1)


def _plane(transport: Transport, patch: np.ndarray) -> np.ndarray:
    """Number of the flat part of a surface on which each patch lies; an array of any shape."""
    mesh = transport.mesh
    keys = np.column_stack([mesh.surface, np.round(mesh.normal, 4)])
    _, part = np.unique(keys, axis=0, return_inverse=True)
    return np.where(patch >= 0, part.ravel()[patch], -1)


def _shadow_edges(light: np.ndarray, found: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Whether direct light at a pixel differs by over 10 % from a neighbour's (height, width). light : (k,)
    at the pixels `found`"""
    picture = np.zeros(found.size)
    picture[found] = light
    picture = picture.reshape(shape)
    edge = np.zeros(shape, dtype=bool)
    for a, b in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        steep = np.abs(picture[a] - picture[b]) > 0.1 * np.maximum(picture[a], picture[b])
        edge[a] |= steep
        edge[b] |= steep
    return edge
