"""The light on a room's vertices, and which place a line of sight meets first."""

from dataclasses import dataclass

import numpy as np

from renderer.solution import Solution
from renderer.transport.field import direct_on
from renderer.transport.transport import Transport

INSET = 1e-3
"""How far inside a patch its corner is lit, relative to the patch: an edge has no one answer."""
EDGE = 1e-9
"""How far beside a patch a line of sight may pass and still meet it, relative to the patch."""


@dataclass(frozen=True)
class Skin:
    """What is seen of a room: its exposed patches, between vertices that belong to one surface each.

    points : (n, 3), the room's longest side being 1 and its middle 0: a room of 1 mm is one of 10 km
    patches : (m, 4) corners, a triangle repeating its last
    lamp : (n,) which luminaire a point belongs to, else -1
    toward : (n, 3) the way that luminaire's face looks
    source : (n,) the mesh's vertex of each point, where it belongs to no luminaire
    light : (n_vertices, n_luminaires) illuminance per lumen straight from each, there [m⁻²]
    """

    points: np.ndarray
    patches: np.ndarray
    lamp: np.ndarray
    toward: np.ndarray
    source: np.ndarray
    light: np.ndarray


def skin(transport: Transport) -> Skin:
    """The skin of a room. A mounted luminaire's face shares vertices with the ceiling, so it gets its own."""
    mesh = transport.mesh
    exposed = transport.exchange.areas > 0
    surfaces = mesh.patches[exposed & transport.reflecting]
    faces = np.flatnonzero(exposed & ~transport.reflecting)
    n, used = len(mesh.vertices), np.unique(surfaces)
    number = np.zeros(n, dtype=int)
    number[used] = np.arange(len(used))
    own = len(used) + np.arange(4 * len(faces)).reshape(-1, 4)
    own[mesh.triangular[faces], 3] = own[mesh.triangular[faces], 2]
    with_face = [k for k, lum in enumerate(transport.luminaires) if lum.outline is not None]
    lamp = np.array(with_face, dtype=int)[mesh.surface[faces] - (transport.n_surfaces - len(with_face))]
    points = np.vstack([mesh.vertices[used], mesh.corners[faces].reshape(-1, 3)])
    return Skin((points - mesh.middle) / mesh.scale, np.vstack([number[surfaces], own]),
                np.concatenate([np.full(len(used), -1), np.repeat(lamp, 4)]),
                np.vstack([np.zeros((len(used), 3)), np.repeat(mesh.normal[faces], 4, axis=0)]), used,
                _direct(transport)[used])


def _direct(transport: Transport) -> np.ndarray:
    """Direct light at each vertex per lumen (n_vertices, n_luminaires) [m⁻²], a little inside a patch at it
    that is exposed."""
    mesh = transport.mesh
    # What comes last stays: the largest exposed part of the patches around a vertex.
    share = np.where(transport.reflecting, transport.exchange.areas / mesh.area, 0.0)
    order = np.argsort(share, kind="stable")
    patch, corner = np.zeros((2, len(mesh.vertices)), dtype=int)
    patch[mesh.patches[order]] = order[:, None]
    corner[mesh.patches[order]] = np.arange(4)
    triangular = mesh.triangular[patch]
    corner = np.where(triangular, np.minimum(corner, 2), corner)
    st = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])[corner]
    st[triangular & (corner == 2)] = (0.0, 1.0)
    st += INSET * (mesh.middle_st[patch] - st)
    return direct_on(transport, patch, *st.T, 3)[0]


def light_on(solution: Solution, skin: Skin) -> tuple[np.ndarray, np.ndarray]:
    """Light toward the eye, X, Y, Z (n, 3) [cd/m²], and illuminance (n,) [lx], at each point of a skin; of a
    luminaire the light along its face's normal, and no illuminance (NaN)."""
    bands, mesh = solution.bands, solution.transport.mesh
    received = skin.light @ solution.flux + solution.vertex_irradiance[skin.source]
    received = np.maximum(received, 0.0)
    reflectance = solution.reflectance[mesh.vertex_surface[skin.source]]
    n, lamps = len(received), skin.lamp[len(received):]
    xyz, illuminance = np.zeros((len(skin.points), 3)), np.full(len(skin.points), np.nan)
    xyz[:n] = (reflectance * received) @ bands.xyz / np.pi
    illuminance[:n] = received @ bands.luminous
    luminance = np.zeros(len(lamps))
    for k in np.unique(lamps):
        luminance[lamps == k] = solution.transport.luminaires[k].luminance(skin.toward[n:][lamps == k])
    xyz[n:] = luminance[:, None] * (solution.flux @ bands.xyz)[lamps]
    return xyz, illuminance


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
