"""Readings and pictures as linear functions of the light on the surfaces.

A pixel or a photometer is a weighted sum of radiosity over places on patches. Direct light at these places is
computed exactly, with shadows; indirect light is interpolated between vertices. The weights depend on
geometry alone, so one sensor serves all materials and bands.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from renderer.system.threads import in_threads
from renderer.transport.direct.direct import SHADOW_RAYS, direct_at
from renderer.transport.rays.sampling import Stream
from renderer.transport.transport import Transport


@dataclass(frozen=True)
class Sensor:
    """Weights on the light that leaves the surfaces; one row for each pixel or photometer.

    direct : (rows, n_surfaces · n_luminaires) [m⁻²] per unit reflectance and lumen
    indirect : (rows, n_vertices) of the indirect light that each vertex reflects
    means : (rows, n_patches) of the mean indirect light that each patch reflects
    """

    direct: sparse.csr_array
    indirect: sparse.csr_array
    means: sparse.csr_array

    @property
    def about_means(self) -> bool:
        """Whether indirect light is read from means over patches, with only the variation across them from
        vertices."""
        return self.means.nnz > 0

    def direct_radiosity(self, reflectance: np.ndarray, flux: np.ndarray) -> np.ndarray:
        """Weighted sum of direct light reflected once (rows, n_bands).

        reflectance : (n_surfaces, n_bands); flux : (n_luminaires, n_bands)
        """
        once = reflectance[:, None, :] * flux[None, :, :]
        return self.direct @ once.reshape(-1, once.shape[-1])

    def indirect_radiosity(self, vertex_radiosity: np.ndarray,
                           patch_radiosity: np.ndarray | None = None) -> np.ndarray:
        """Weighted sum of light reflected more than once (rows, n_bands).

        vertex_radiosity : (n_vertices, n_bands)
        patch_radiosity : (n_patches, n_bands), for a sensor that reads indirect light from patches
        """
        smooth = self.indirect @ vertex_radiosity
        return smooth if patch_radiosity is None else smooth + self.means @ patch_radiosity


@dataclass(frozen=True)
class Spread:
    """Pieces of patches that are each represented by a point.

    corners : (k, 4, 2) s and t of the pieces' corners
    places : (k, replicas, 2) s and t of the places from which shadow rays start
    bare : (k, n_luminaires) mean unobstructed illuminance per lumen of each piece [m⁻²]
    """

    corners: np.ndarray
    places: np.ndarray
    bare: np.ndarray


def direct_on(transport: Transport, patch: np.ndarray, s: np.ndarray, t: np.ndarray, seed: int,
              rays: int = SHADOW_RAYS, replicas: int = 1, spread: Spread | None = None) -> np.ndarray:
    """Illuminance per lumen at points (s, t) on patches (replicas, k, n_luminaires) [m⁻²]; 0 on luminaires.

    seed : a different one for each use; rays : number of shadow rays to each luminaire; spread : pieces that
      the points represent
    """
    mesh = transport.mesh
    bright = transport.reflecting[patch]
    light = np.zeros((replicas, len(patch), len(transport.luminaires)))
    patch, s, t = patch[bright], s[bright], t[bright]
    normals, seeds, more = mesh.normal[patch], (transport.seed, Stream.DIRECT_ON_ELEMENTS, seed), {}
    if spread is not None:
        more["bare"] = spread.bare[bright]
    if spread is not None and transport.ray_scene is not None:
        around, places = (mesh.at(patch[:, None], *np.moveaxis(x[bright], 2, 0))
                          for x in (spread.corners, spread.places))
        more |= {"origins": transport.ray_scene.off(places, normals[:, None]), "around": around}
    light[:, bright] = direct_at(mesh.at(patch, s, t), normals, transport.luminaires, transport.ray_scene,
                                 seeds, rays, replicas=replicas, **more)
    return light


def sense(transport: Transport, n_rows: int, row: np.ndarray, patch: np.ndarray, s: np.ndarray,
          t: np.ndarray, weight: np.ndarray, per_lumen: np.ndarray, conserving: bool = False) -> list[Sensor]:
    """Sensors that add up `weight` × radiosity at points (s, t) on patches in each row. There is one sensor
    for each replica of the weights.

    row, patch, s, t : (k,); weight : (replicas, k)
    per_lumen : (replicas, k, n_luminaires), from `direct_on`
    conserving : whether indirect light is interpolated about each patch's mean, so that each patch reflects
      what it received; else it is interpolated between vertices alone, so that pictures show no seams
    """
    mesh, n_luminaires = transport.mesh, len(transport.luminaires)
    bright = np.flatnonzero(transport.reflecting[patch])
    order = bright[np.argsort(row[bright], kind="stable")]
    row, patch, s, t = (x[order] for x in (row, patch, s, t))
    weight, per_lumen = weight[:, order, None], per_lumen[:, order]
    corners = mesh.weights(patch, s, t)
    if conserving:
        corners = corners - mesh.weights(patch, *mesh.middle_st[patch].T)
    # Weights of neighbouring points on one patch are added up first.
    first = np.flatnonzero((np.diff(row, prepend=-1) != 0) | (np.diff(patch, prepend=-1) != 0))
    patch, ends = patch[first], np.concatenate([[0], np.cumsum(np.bincount(row[first], minlength=n_rows))])

    def gathered(values: np.ndarray, columns: np.ndarray, width: int) -> list[sparse.csr_array]:
        each = np.add.reduceat(values, first, axis=1) if len(first) else values
        return [sparse.csr_array((replica.ravel(), columns.ravel(), columns.shape[1] * ends),
                                 shape=(n_rows, width)) for replica in each]

    columns = mesh.surface[patch][:, None] * n_luminaires + np.arange(n_luminaires)
    direct = gathered(weight * per_lumen, columns, transport.n_surfaces * n_luminaires)
    indirect = gathered(weight * corners, mesh.patches[patch], len(mesh.vertices))
    means = [sparse.csr_array((n_rows, len(mesh.patches)))] * len(weight)
    if conserving:
        means = gathered(weight, patch[:, None], len(mesh.patches))
    return [Sensor(*each) for each in zip(direct, indirect, means, strict=True)]


def seen_from(transport: Transport, eye: np.ndarray, directions: np.ndarray):
    """The patch (k,) that an eye (3,) [m] sees along each of directions (k, 3), or a negative number for
    none, and the place (s, t) on it."""
    mesh, n = transport.mesh, len(directions)
    patch, s, t = np.empty(n, dtype=np.int64), np.empty(n), np.empty(n)

    def work(start: int, stop: int) -> None:
        some, toward = slice(start, stop), directions[start:stop]
        patch[some] = transport.eye.first_hit(np.broadcast_to(eye, toward.shape), toward)
        found = np.maximum(patch[some], 0)
        normal = mesh.normal[found]
        slope = np.einsum("ki,ki->k", toward, normal)
        height = np.einsum("ki,ki->k", mesh.corners[found, 0] - eye, normal)
        reach = height / np.where(slope == 0, 1.0, slope)
        s[some], t[some] = mesh.inside(found, eye + reach[:, None] * toward)

    in_threads(work, n, 1 << 14)
    return patch, np.clip(s, 0, 1), np.clip(t, 0, 1)


def emitted(transport: Transport, n: int, row: np.ndarray, surface: np.ndarray, weight: np.ndarray,
            away: np.ndarray) -> sparse.csr_array:
    """Weighted sum of π times the luminance per lumen of luminaires' faces toward the eye (n, n_luminaires)
    [m⁻²], by row.

    row, surface, weight : (k,); away : (k, 3) unit, from each surface to the eye
    """
    rows, values, columns = [], [], []
    for face, k in transport.faces:
        seen = np.flatnonzero(surface == face)
        rows.append(row[seen])
        values.append(np.pi * weight[seen] * transport.luminaires[k].luminance(away[seen]))
        columns.append(np.full(len(seen), k))
    if not rows:
        return sparse.csr_array((n, len(transport.luminaires)))
    return sparse.coo_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
                            shape=(n, len(transport.luminaires))).tocsr()
