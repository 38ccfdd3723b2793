"""The light on a room's vertices, and the first surface on a line of sight."""

from dataclasses import dataclass

import numpy as np

from renderer.solving.solution import Solution
from renderer.transport.sensors import Sensor, direct_on, sense
from renderer.transport.transport import Transport

CORNER_INSET = 1e-3
"""Distance inside a patch, relative to the patch, at which the light at its corner is computed, because an
edge has no unique illuminance."""


@dataclass(frozen=True)
class Skin:
    """The visible surfaces of a room as triangles, with a sensor at each of their corners.

    A patch with four sides is four triangles about its centre.

    points : (n, 3) from the room's centre, in units of its longest side
    triangles : (m, 3) indices of points, counter-clockwise seen from the front
    patch : (n,) patch of each point
    sensor : one row for each point, valid for all materials and bands
    """

    points: np.ndarray
    triangles: np.ndarray
    patch: np.ndarray
    sensor: Sensor


def skin(transport: Transport) -> Skin:
    """The skin of a room. A luminaire's face has separate points where it shares corners with its surface."""
    mesh = transport.mesh
    exposed = transport.exchange.areas > 0
    surfaces = np.flatnonzero(exposed & transport.reflecting)
    faces = np.flatnonzero(exposed & ~transport.reflecting)
    triangular = mesh.triangular[surfaces]
    quads = surfaces[~triangular]
    used = np.unique(mesh.patches[surfaces])
    number = np.zeros(len(mesh.vertices), dtype=int)
    number[used] = np.arange(len(used))
    ring = number[mesh.patches[quads]]
    middle = len(used) + np.arange(len(quads))
    fans = np.stack([ring, np.roll(ring, -1, axis=1), np.repeat(middle[:, None], 4, axis=1)], axis=-1)
    own = len(used) + len(quads) + np.arange(4 * len(faces)).reshape(-1, 4)
    triangles = np.vstack([number[mesh.patches[surfaces[triangular], :3]], fans.reshape(-1, 3), own[:, :3],
                           own[~mesh.triangular[faces]][:, [0, 2, 3]]])
    patch, corner = _patches_at(transport, used)
    st = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])[corner]
    st[mesh.triangular[patch] & (corner == 2)] = (0.0, 1.0)
    st += CORNER_INSET * (mesh.middle_st[patch] - st)
    patch = np.concatenate([patch, quads, np.repeat(faces, 4)])
    s, t = np.vstack([st, mesh.middle_st[quads], mesh.middle_st[np.repeat(faces, 4)]]).T
    n = len(patch)
    light = direct_on(transport, patch, s, t, 3)
    sensor = sense(transport, n, np.arange(n), patch, s, t, np.ones((1, n)), light)[0]
    points = np.vstack([mesh.vertices[used], mesh.centroid[quads], mesh.corners[faces].reshape(-1, 3)])
    return Skin((points - mesh.middle) / mesh.scale, triangles, patch, sensor)


def _patches_at(transport: Transport, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least covered of the patches around each vertex, and the number of its corner at the vertex."""
    mesh = transport.mesh
    share = np.where(transport.reflecting, transport.exchange.areas / mesh.area, 0.0)
    order = np.argsort(share, kind="stable")  # the last write to a vertex stays
    patch = np.zeros(len(mesh.vertices), dtype=int)
    patch[mesh.patches[order].ravel()] = np.repeat(order, 4)
    return patch[vertices], (mesh.patches[patch[vertices]] == vertices[:, None]).argmax(axis=1)


def lamp_of(transport: Transport, surface: int) -> int | None:
    """Index of the luminaire whose face a surface of the mesh is; None for other surfaces."""
    return dict(transport.faces).get(surface)


def light_on(solution: Solution, skin: Skin) -> tuple[np.ndarray, np.ndarray]:
    """X, Y, Z (n, 3) [cd/m²] of the light toward the eye, and illuminance (n,) [lx], at the points of a skin.

    For a luminaire it is the luminance along its normal, and NaN for illuminance.
    """
    bands, transport, sensor = solution.bands, solution.transport, skin.sensor
    once = (solution.reflectance[:, None, :] * solution.flux[None]) @ bands.xyz
    xyz = sensor.direct @ once.reshape(-1, 3) + sensor.indirect @ (solution.vertex_radiosity @ bands.xyz)
    xyz = np.maximum(xyz, 0.0) / np.pi
    lumens = np.tile(solution.flux @ bands.luminous, transport.n_surfaces)
    illuminance = sensor.direct @ lumens + sensor.indirect @ (solution.vertex_irradiance @ bands.luminous)
    shining = np.flatnonzero(~transport.reflecting[skin.patch])
    surface = transport.mesh.surface[skin.patch[shining]]
    for each in np.unique(surface):
        lamp, points = lamp_of(transport, each), shining[surface == each]
        toward = transport.mesh.normal[skin.patch[points]]
        xyz[points] = np.outer(transport.luminaires[lamp].luminance(toward), solution.flux[lamp] @ bands.xyz)
    illuminance[shining] = np.nan
    return xyz, np.maximum(illuminance, 0.0)


def first_front(transport: Transport, eye: np.ndarray, direction: np.ndarray) -> tuple | None:
    """The first patch that faces an eye (3,) [m] along a unit direction (3,), and the place (3,) [m] on it.

    Backs of patches are transparent, as in the window. None where no patch is met.
    """
    mesh = transport.mesh
    slope = mesh.normal @ direction
    height = np.einsum("ki,ki->k", mesh.corners[:, 0] - eye, mesh.normal)
    patch = np.flatnonzero((transport.exchange.areas > 0) & (slope < 0) & (height < 0))
    reach = height[patch] / slope[patch]
    s, t = mesh.inside(patch, eye + reach[:, None] * direction)
    far = np.where(mesh.triangular[patch], s + t, np.maximum(s, t))
    beside = 1e-9  # relative to the patch, so that no line passes between two patches
    on = (s >= -beside) & (t >= -beside) & (far <= 1 + beside)
    if not on.any():
        return None
    k = np.flatnonzero(on)[reach[on].argmin()]
    st = np.clip([s[k], t[k]], 0, 1)
    return int(patch[k]), mesh.at(patch[k:k + 1], *st[:, None])[0]
