"""Error bars for all places of a room, for readings anywhere on the page of a report."""

import numpy as np
from scipy import sparse

from renderer.pictures.camera import View
from renderer.readings.uncertainty import READING_ROUNDING, step_shares, student
from renderer.solving.solution import Solution
from renderer.transport.direct.direct import SHADOW_RAYS, direct_at, unoccluded
from renderer.transport.rays.sampling import REPLICAS, Stream
from renderer.transport.sensors import seen_from


def patch_bars(solution: Solution) -> tuple[np.ndarray, np.ndarray]:
    """95 % half-widths (n_patches,) [lx], of mesh and of sampling, of the indirect illuminance on each patch.

    They are computed as for a photometer (readings/uncertainty.py), from another mesh and from replicas of
    the rays, for the illuminance interpolated between vertices. Each is the largest at a patch's corners and
    centre, because a difference may vanish by chance at one place.
    """
    mesh_sequence, mesh = solution.mesh_sequence, solution.transport.mesh
    luminous = mesh_sequence.meshes[0].bands.luminous
    places = np.concatenate([mesh.corners, mesh.centroid[:, None]], axis=1)
    places[:, :4] += 1e-3 * (places[:, 4:] - places[:, :4])
    here, *there = (each.vertex_irradiance @ luminous for each in mesh_sequence.meshes)
    values = [np.column_stack([here[mesh.patches], _at_middle(mesh, here)])]
    values += [_on(each, places, mesh.normal, light)
               for each, light in zip(mesh_sequence.meshes[1:], there, strict=True)]
    moved = [share * _largest(mesh, np.abs(one - other)) for share, one, other in zip(
        step_shares(mesh_sequence.steps), values, values[1:], strict=False)]
    of_mesh = np.sqrt(np.mean(np.square(moved), axis=0)) + READING_ROUNDING * _at_middle(mesh, here)
    replicas = mesh_sequence.replicas
    if not replicas:
        return of_mesh, np.zeros(len(mesh.patches))
    spread = np.array([each.vertex_irradiance @ luminous for each in replicas]).std(axis=0, ddof=1)
    own = replicas[0].transport is solution.transport  # for a very fine mesh the other mesh has the replicas
    on_patches = spread[mesh.patches] if own else _on(mesh_sequence.meshes[1], places, mesh.normal, spread)
    return of_mesh, student(len(replicas)) / np.sqrt(len(replicas)) * _largest(mesh, on_patches)


def _largest(mesh, at_places: np.ndarray) -> np.ndarray:
    """The largest of each patch's values (n_patches, k); where all are NaN (off the other mesh), the largest
    of its surface.
    """
    found = np.isfinite(at_places)
    largest = np.where(found, at_places, 0.0).max(axis=1)
    of_surface = np.zeros(mesh.surface.max(initial=0) + 1)
    np.maximum.at(of_surface, mesh.surface, largest)
    return np.where(found.any(axis=1), largest, of_surface[mesh.surface])


def _at_middle(mesh, on_vertices: np.ndarray) -> np.ndarray:
    weights = mesh.weights(np.arange(len(mesh.patches)), *mesh.middle_st.T)
    return (weights * on_vertices[mesh.patches]).sum(axis=1)


def _on(other: Solution, places: np.ndarray, normals: np.ndarray, on_vertices: np.ndarray) -> np.ndarray:
    """Values (n, k) on another mesh of the room, at places (n, k, 3) on patches with normals (n, 3); NaN off
    that mesh."""
    eye, mesh = other.transport.eye, other.transport.mesh
    points = places.reshape(-1, 3)
    normals = np.repeat(normals, places.shape[1], axis=0)
    patch = eye.first_hit(eye.off(points, normals), -normals)
    found = np.maximum(patch, 0)
    flat = (mesh.normal[found] * normals).sum(axis=1) > 1 - 1e-6
    weights = mesh.weights(found, *mesh.inside(found, points))
    values = (weights * on_vertices[mesh.patches[found]]).sum(axis=1)
    return np.where((patch >= 0) & flat, values, np.nan).reshape(places.shape[:2])


def shadow_bars(view: View) -> sparse.csr_array:
    """95 % half-widths (n_pixels, n_luminaires) [m⁻²] of the direct illuminance per lumen at each pixel's
    centre.

    They are 0 outside penumbras, where no rays are counted.
    """
    transport, n = view.transport, view.patch.size
    if transport.ray_scene is None or not transport.luminaires:
        return sparse.csr_array((n, len(transport.luminaires)))
    pixel = np.flatnonzero((view.patch.ravel() >= 0) & (view.light > 0).any(axis=1))
    patch, s, t = seen_from(transport, view.eye, view.directions(pixel))
    points, normals = transport.mesh.at(patch, s, t), transport.mesh.normal[patch]
    bare = unoccluded(points, normals, transport.luminaires)
    dimmed = (view.light[pixel] < (1 - 1e-9) * bare) & (view.light[pixel] > 0)
    some = dimmed.any(axis=1)
    pixel, rays = pixel[some], SHADOW_RAYS // 4  # of each replica
    seed = transport.seed, Stream.DIRECT_ON_ELEMENTS, 2
    parts = direct_at(points[some], normals[some], transport.luminaires, transport.ray_scene, seed, rays,
                      replicas=REPLICAS, bare=np.where(dimmed, bare, 0.0)[some])
    half = student(len(parts)) * parts.std(axis=0, ddof=1) * np.sqrt(rays / SHADOW_RAYS)
    # Where all replicas agree, as at the rim of a penumbra, an error of half a ray remains.
    half = np.hypot(half, np.where(dimmed[some], bare[some] / (2 * SHADOW_RAYS), 0.0))
    rows, columns = np.nonzero(half)
    return sparse.csr_array((half[rows, columns], (pixel[rows], columns)), shape=view.light.shape)
