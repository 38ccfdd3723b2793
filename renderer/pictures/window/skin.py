"""The light on a room's vertices, and which place a line of sight meets first."""

from dataclasses import dataclass

import numpy as np

from renderer.solving.solution import Solution
from renderer.transport.sensors import Sensor, direct_on, sense
from renderer.transport.transport import Transport

INSET = 1e-3
"""How far inside a patch its corner is lit, relative to the patch: an edge has no one answer."""
EDGE = 1e-9
"""How far beside a patch a line of sight may pass and still meet it, relative to the patch."""


@dataclass(frozen=True)
class Skin:
    """What is seen of a room: its exposed patches as triangles, about their middles where they have four
    sides, and the light at each corner of these, for any material and any band.

    points : (n, 3), the room's longest side being 1 and its middle 0: a room of 1 mm is one of 10 km
    triangles : (m, 3) points of each, counter-clockwise seen from the front
    patch : (n,) which patch each point is lit on
    sensor : one row a point, on radiosity
    """

    points: np.ndarray
    triangles: np.ndarray
    patch: np.ndarray
    sensor: Sensor


def skin(transport: Transport) -> Skin:
    """The skin of a room. A luminaire's face has corners of its own: mounted, it shares the ceiling's."""
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
    st += INSET * (mesh.middle_st[patch] - st)
    patch = np.concatenate([patch, quads, np.repeat(faces, 4)])
    s, t = np.vstack([st, mesh.middle_st[quads], mesh.middle_st[np.repeat(faces, 4)]]).T
    n = len(patch)
    light = direct_on(transport, patch, s, t, 3)
    sensor = sense(transport, n, np.arange(n), patch, s, t, np.ones((1, n)), light)[0]
    points = np.vstack([mesh.vertices[used], mesh.centroid[quads], mesh.corners[faces].reshape(-1, 3)])
    return Skin((points - mesh.middle) / mesh.scale, triangles, patch, sensor)


def _patches_at(transport: Transport, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the patches around each vertex the one that is least covered, and which corner of it that is."""
    mesh = transport.mesh
    share = np.where(transport.reflecting, transport.exchange.areas / mesh.area, 0.0)
    order = np.argsort(share, kind="stable")  # what is written last stays
    patch = np.zeros(len(mesh.vertices), dtype=int)
    patch[mesh.patches[order].ravel()] = np.repeat(order, 4)
    return patch[vertices], (mesh.patches[patch[vertices]] == vertices[:, None]).argmax(axis=1)


def lamp_of(transport: Transport, surface: int) -> int | None:
    """The luminaire whose face a surface of the mesh is, or None."""
    return dict(transport.faces).get(surface)


def light_on(solution: Solution, skin: Skin) -> tuple[np.ndarray, np.ndarray]:
    """Light toward the eye, X, Y, Z (n, 3) [cd/m²], and illuminance (n,) [lx], at each point of a skin; of a
    luminaire the light along its face's normal, and no illuminance (NaN)."""
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
    """The patch that an eye (3,) [m] sees first along a unit direction (3,), backs being seen through as in
    the window, and where (3,) [m]; None where it sees nothing."""
    mesh = transport.mesh
    slope = mesh.normal @ direction
    height = np.einsum("ki,ki->k", mesh.corners[:, 0] - eye, mesh.normal)
    patch = np.flatnonzero((transport.exchange.areas > 0) & (slope < 0) & (height < 0))
    reach = height[patch] / slope[patch]
    s, t = mesh.inside(patch, eye + reach[:, None] * direction)
    far = np.where(mesh.triangular[patch], s + t, np.maximum(s, t))
    on = (s >= -EDGE) & (t >= -EDGE) & (far <= 1 + EDGE)
    if not on.any():
        return None
    k = np.flatnonzero(on)[reach[on].argmin()]
    st = np.clip([s[k], t[k]], 0, 1)
    return int(patch[k]), mesh.at(patch[k:k + 1], *st[:, None])[0]
