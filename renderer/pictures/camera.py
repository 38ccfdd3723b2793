"""A camera in a room: which places on the surfaces each pixel adds up."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from renderer.pictures.lamp_edges import lamp_shares
from renderer.pictures.pinhole import Pinhole, pinhole
from renderer.readings.photometer import off_surfaces, refuse_inside, refuse_outside
from renderer.scene.meter_tables import CameraTable
from renderer.scene.scene import Scene
from renderer.solving.solution import Solution
from renderer.system.threads import in_threads
from renderer.transport.factors.exchange import rows
from renderer.transport.sensors import Sensor, direct_on, emitted, seen_from, sense
from renderer.transport.transport import Transport

SUBPIXELS = 4
"""A pixel on an edge, of a surface or of a shadow, is the mean of 4 × 4 rays."""
SUBPIXEL_RAYS = 16
"""Shadow rays of each of those, to each luminaire."""
PIXELS = 1 << 13
"""Pixels whose light is added up at once."""
CONTRAST = 0.1
"""Direct light that differs by this share between neighbouring pixels is an edge of a shadow."""


@dataclass(frozen=True)
class View:
    """What a camera sees of a room, for any material and any band.

    sensor : one row a pixel, on radiosity; emitted : (n_pixels, n_luminaires) radiosity per lumen
    surface : (height, width) index of the surface at each pixel's middle, -1 for none
    share : (n_pixels, n_surfaces) how much of each pixel shows each surface
    patch : (height, width) patch at each pixel's middle, negative for none
    light : (n_pixels, n_luminaires) illuminance per lumen straight from each, there [m⁻²]
    edge : (height, width) pixels that are the mean of several rays
    camera : where it was seen from, and what it was seen through
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
        """Where a pixel shows no part of a lamp's light (height, width)."""
        return self.image(np.asarray(self.emitted.sum(axis=1)).ravel() == 0)

    def directions(self, pixel: np.ndarray) -> np.ndarray:
        """Directions (k, 3) through the middles of pixels (k,), counted row by row."""
        y, x = np.divmod(pixel, self.camera.width)
        return self.camera.directions(x + 0.5, y + 0.5)

    def marks(self, scene: Scene) -> list[tuple[float, float]]:
        """Where the scene's photometers appear [pixels]; hidden ones are left out."""
        places = [np.array(p.position) for p in scene.photometers]
        seen = [self.transport.eye.clear(self.eye[None], place[None])[0] for place in places]
        found = [self.camera.project(place) for place, free in zip(places, seen, strict=True) if free]
        return [mark for mark in found if mark is not None]

    def image(self, values: np.ndarray) -> np.ndarray:
        """Rows as a picture (height, width, …)."""
        return values.reshape(*self.surface.shape, *values.shape[1:])

    def direct(self, solution: Solution, weights: np.ndarray) -> np.ndarray:
        """Radiance by direct light alone, lamps included (height, width, k), weighted sums of bands.

        weights : (n_bands, k), for example BandSet.xyz for cd/m² (X, Y, Z).
        """
        return self._added(self._direct(solution, weights))

    def indirect(self, solution: Solution, weights: np.ndarray) -> np.ndarray:
        """Radiance by interreflection (height, width, k); as `direct`."""
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
        """Σ matrix @ light / π as a picture, from (matrix, light) with a row of the matrix for each pixel."""
        seen = np.empty((self.surface.size, terms[0][1].shape[1]))

        def work(start: int, stop: int) -> None:
            seen[start:stop] = sum(rows(matrix, start, stop) @ light for matrix, light in terms) / np.pi

        in_threads(work, len(seen), PIXELS)
        return self.image(seen)

    def reflectances(self, solution: Solution) -> np.ndarray:
        """Luminous reflectance of what each pixel shows (height, width), under the lamps' light."""
        light = solution.flux.sum(axis=0) * solution.bands.luminous
        total = light.sum()
        luminous = solution.reflectance @ light / (total if total > 0 else 1.0)
        return self.image(self.share @ luminous)


def look(transport: Transport, table: CameraTable, where: str) -> View:
    """Find what every pixel of a camera sees. Raises InputError where it stands inside a solid."""
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
    sub = (np.arange(SUBPIXELS) + 0.5) / SUBPIXELS - 0.5
    dx, dy = (d.ravel() for d in np.meshgrid(sub, sub))
    x_fine, y_fine = (x.ravel()[fine, None] + dx).ravel(), (y.ravel()[fine, None] + dy).ravel()
    extra = _hits(transport, camera, eye, x_fine, y_fine)
    weight = _rest(n, fine, _surface(transport, extra[0]).reshape(-1, dx.size), lamp, face, cover).ravel()
    hit = (extra[0] >= 0) & (weight > 0)
    extra = [e[hit] for e in extra]
    row = np.concatenate([np.flatnonzero(found)[plain], np.repeat(fine, dx.size)[hit]])
    light = np.concatenate([light[plain], direct_on(transport, *extra, 1, SUBPIXEL_RAYS)[0]])
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
    """Weights (k, rays) of rays through pixels (k,) that meet surfaces (k, rays): equal parts of what is left
    by luminaires whose cover (m,) of a pixel (m,) is known, and 0 where they meet such a face (m,).

    Where every ray meets one, up to an eighth of the pixel is left out, of what is dim beside it."""
    top = surface.max(initial=0) + face.max(initial=0) + 1
    known = np.isin(fine[:, None] * top + surface, lamp * top + face) & (surface >= 0)
    left = np.clip(1 - np.bincount(lamp, cover, n)[fine], 0, 1)
    return np.where(known, 0, (left / np.maximum((~known).sum(axis=1), 1))[:, None])


def _hits(transport: Transport, camera: Pinhole, eye: np.ndarray, x: np.ndarray, y: np.ndarray):
    """Patch (k,) or a negative number, and (s, t) there, for points of the picture."""
    return seen_from(transport, eye, camera.directions(x, y))


def _surface(transport: Transport, patch: np.ndarray) -> np.ndarray:
    """The surface that each patch belongs to, -1 for none; of any shape."""
    return np.where(patch >= 0, transport.mesh.surface[patch], -1)


def _plane(transport: Transport, patch: np.ndarray) -> np.ndarray:
    """A number for the flat part of a surface that each patch belongs to; of any shape."""
    mesh = transport.mesh
    keys = np.column_stack([mesh.surface, np.round(mesh.normal, 4)])
    _, part = np.unique(keys, axis=0, return_inverse=True)
    return np.where(patch >= 0, part.ravel()[patch], -1)


def _shadow_edges(light: np.ndarray, found: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Pixels (height, width) next to which direct light (k,) changes steeply."""
    picture = np.zeros(found.size)
    picture[found] = light
    picture = picture.reshape(shape)
    edge = np.zeros(shape, dtype=bool)
    for a, b in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        steep = np.abs(picture[a] - picture[b]) > CONTRAST * np.maximum(picture[a], picture[b])
        edge[a] |= steep
        edge[b] |= steep
    return edge
