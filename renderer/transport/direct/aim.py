"""Points on a luminaire's face that rays from a place go to."""

import numpy as np

from renderer.scene.luminaires import Luminaire

TOUCHING = 1e-6
"""Height above a face, relative to its sides, below which a place is as good as in its plane."""


def spread(luminaire: Luminaire, square: np.ndarray) -> np.ndarray:
    """Points all over a luminaire's face (…, 3) [m], evenly, from points of the unit square (…, 2)."""
    if luminaire.rectangle is not None:
        r, s, t = luminaire.rectangle, square[..., 0], square[..., 1]
        return np.stack([c + s * u + t * v for c, u, v in zip(r.corner, r.u, r.v, strict=True)], axis=-1)
    spokes = luminaire.outline - luminaire.center
    turn = square[..., 1] * len(spokes)
    sector = np.minimum(turn.astype(int), len(spokes) - 1)
    part = (turn - sector)[..., None]
    edge = (1 - part) * spokes[sector] + part * spokes[(sector + 1) % len(spokes)]
    return luminaire.center + np.sqrt(square[..., :1]) * edge


def aimed(luminaire: Luminaire, places: np.ndarray, square: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points on a luminaire's face (k, n, 3) [m], densest where it is nearest to the place that looks, and
    the area (k, n) that each stands for, but for a factor.

    places : (k, 1 or n, 3) [m]; square : (k, n, 2) points of the unit square

    Along each side alike in the angle from the point below, so that from h above the face densities are as
    h²/((h² + x²)(h² + y²)): near a large face what a point brings, over that, varies little, where it varies
    by orders of magnitude over points that are spread evenly. On a disc the second side is the chord.
    """
    if luminaire.rectangle is not None:
        corner, sides = luminaire.rectangle.corner, (luminaire.rectangle.u, luminaire.rectangle.v)
    else:
        spoke = luminaire.outline[0] - luminaire.center
        sides = 2 * spoke, 2 * np.cross(luminaire.normal, spoke)
        corner = luminaire.center - (sides[0] + sides[1]) / 2
    offset = places - corner
    lengths = [np.linalg.norm(side) for side in sides]
    height = np.maximum(np.abs(offset @ luminaire.normal), TOUCHING * max(lengths))
    stands, shares, start, stop = 1.0, [], 0.0, 1.0
    for k, (side, length) in enumerate(zip(sides, lengths, strict=True)):
        below = offset @ side / length
        first, last = (np.arctan2(end * length - below, height) for end in (start, stop))
        aside = height * np.tan(first + square[..., k] * (last - first))
        stands = stands * ((height * height + aside * aside) * ((last - first) / height))
        shares.append(((below + aside) / length).clip(start, stop))
        if luminaire.rectangle is None:
            half = np.sqrt(np.maximum(shares[0] * (1 - shares[0]), 0.0))
            start, stop = 0.5 - half, 0.5 + half
    targets = np.stack([c + shares[0] * u + shares[1] * v for c, u, v in zip(corner, *sides, strict=True)],
                       axis=-1)
    return targets, stands
