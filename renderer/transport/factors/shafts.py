"""Pairs of patches, meters or lamps between which something may stand, by tests of boxes without rays.

Patches are grouped in small flat clusters. The shaft between two clusters, the convex hull of both, is clear
of an object if it misses the object's box (Haines and Wallace, Shaft Culling, 1994).
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from renderer.system.threads import in_threads
from renderer.transport.factors.contour import frames
from renderer.transport.mesh.mesh import Mesh

SHAFT_SLACK = 1e-9
"""Depth, relative to the room, to which an object may reach into a shaft and still count as beside it."""


@dataclass(frozen=True)
class Clusters:
    """Clusters of neighbouring patches, each with a box of its own.

    patches : (k,) indices, cluster by cluster; starts : (n_clusters + 1,) where each cluster begins
    middle : (n_clusters, 3) [m]; axes : (n_clusters, 3, 3), the last the normal of a flat cluster
    half : (n_clusters, 3) half the box's sides [m]; flat : (n_clusters,) whether all normals are equal
    """

    patches: np.ndarray
    starts: np.ndarray
    middle: np.ndarray
    axes: np.ndarray
    half: np.ndarray
    flat: np.ndarray

    def along(self, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest coordinate of each cluster along axes (k, 3): two arrays (k, n_clusters) [m]."""
        half = sum(np.abs(axes @ own.T) * side for own, side in zip(self.axes.swapaxes(0, 1), self.half.T,
                                                                    strict=True))
        middle = axes @ self.middle.T
        return middle - half, middle + half


def clusters(mesh: Mesh, patches: np.ndarray, size: int = 8) -> Clusters:
    """Patches (k,) grouped by place and normal in clusters of at most `size`."""
    place = (mesh.centroid[patches] - mesh.middle) / mesh.scale
    # Rounded, so that a room has the same clusters wherever it stands.
    tree = cKDTree(np.round(np.hstack([place, 10 * mesh.normal[patches]]), 6), leafsize=size)
    starts, nodes = [], [tree.tree]
    while nodes:
        node = nodes.pop()
        if node.split_dim < 0:
            starts.append(node.start_idx)
        else:
            nodes += [node.lesser, node.greater]
    starts = np.sort(starts)
    patches, sizes = patches[tree.indices], np.diff([*starts, len(patches)])
    own = np.repeat(np.arange(len(starts)), sizes)
    axes = frames(mesh.normal[patches[starts]])
    local = np.einsum("kci,kai->kca", mesh.corners[patches] - mesh.middle, axes[own])
    low = np.minimum.reduceat(local.min(axis=1), starts)
    high = np.maximum.reduceat(local.max(axis=1), starts)
    middle = np.einsum("ka,kai->ki", (low + high) / 2, axes) + mesh.middle
    turned = 1 - np.einsum("ki,ki->k", mesh.normal[patches], axes[own, 2])
    flat = (np.maximum.reduceat(turned, starts) < SHAFT_SLACK) & (high - low < SHAFT_SLACK * mesh.scale)[:, 2]
    return Clusters(patches, np.append(starts, len(patches)), middle, axes, (high - low) / 2, flat)


def doubtful_pairs(mesh: Mesh, patches: np.ndarray, partly: np.ndarray) -> np.ndarray:
    """Pairs of patches that face each other and between which something may stand (2, k), each once.

    patches : (m,) patches to test
    partly : (n_patches,) whether a patch is covered in part; all its pairs are doubtful
    """
    groups, slack = clusters(mesh, patches), SHAFT_SLACK * mesh.scale
    first, second = np.nonzero(np.triu(_facing(groups, slack)))
    some = np.logical_or.reduceat(partly[groups.patches], groups.starts[:-1])
    doubtful = some[first] | some[second]
    asked = np.flatnonzero(~doubtful)

    def work(start: int, stop: int) -> None:
        part = asked[start:stop]
        doubtful[part] = _hindered(groups, first[part], second[part], mesh.obstacles, slack)

    in_threads(work, len(asked), 1 << 14)
    return _each(groups, first[doubtful], second[doubtful])


def _facing(groups: Clusters, slack: float) -> np.ndarray:
    """Whether each cluster is at least partly in front of the other (n_clusters, n_clusters)."""
    reach = groups.along(groups.axes[:, 2])[1]
    before = (reach > np.diag(reach)[:, None] + slack) | ~groups.flat[:, None]
    return before & before.T


def _hindered(groups: Clusters, first: np.ndarray, second: np.ndarray, boxes: np.ndarray,
              slack: float) -> np.ndarray:
    """Whether a box (m, 8, 3) reaches into the shaft between two clusters (k,).

    first, second : (k,) clusters, each enclosed in a box with sides parallel to the tested box
    """
    found = np.zeros(len(first), dtype=bool)
    frame = np.linalg.qr((boxes[:, [1, 2, 4]] - boxes[:, :1]).swapaxes(1, 2))[0].swapaxes(1, 2)
    for box, axes in zip(boxes, frame, strict=True):
        low, high = groups.along(axes)
        reach = axes @ box.T
        least, most = reach.min(axis=1)[:, None], reach.max(axis=1)[:, None]
        # A wall that a cluster lies on touches the shaft from outside and is no obstacle.
        k = np.flatnonzero(~found)
        a, b = first[k], second[k]
        k = k[((np.maximum(high[:, a], high[:, b]) > least + slack)
               & (np.minimum(low[:, a], low[:, b]) < most - slack)).all(axis=0)]
        a, b = first[k], second[k]
        found[k] = reaches(low[:, b] - low[:, a], high[:, b] - high[:, a],
                           least - slack - high[:, a], most + slack - low[:, a])
    return found


def _each(groups: Clusters, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """All pairs of patches (2, m) from pairs of clusters (k,)."""
    sizes = np.diff(groups.starts)
    counts = sizes[first] * sizes[second]
    pair = np.repeat(np.arange(len(first)), counts)
    place = np.arange(len(pair)) - np.repeat(np.cumsum(counts) - counts, counts)
    row, column = np.divmod(place, sizes[second[pair]])
    one = groups.patches[groups.starts[first[pair]] + row]
    other = groups.patches[groups.starts[second[pair]] + column]
    once = (first[pair] != second[pair]) | (one < other)
    return np.stack([one[once], other[once]]).astype(np.int32)


def may_be_hidden(place: np.ndarray, normal: np.ndarray, corners: np.ndarray, boxes: np.ndarray,
                  scale: float) -> np.ndarray:
    """Whether a box reaches between a place and each polygon (k,).

    place : (3,) [m]; normal : (3,) unit, the direction that the place faces
    corners : (k, c, 3) [m], of the polygons; boxes : (m, 8, 3) [m]; scale : of the room [m]
    """
    slack = SHAFT_SLACK * scale
    low, high = ((bound - place).T for bound in (corners.min(axis=1), corners.max(axis=1)))
    found = np.zeros(len(corners), dtype=bool)
    for box in boxes:
        box = box - place
        if (box @ normal > slack).any():
            k = np.flatnonzero(~found)
            found[k] = reaches(low[:, k], high[:, k], box.min(axis=0) - slack, box.max(axis=0) + slack)
    return found


def reaches(low: np.ndarray, high: np.ndarray, least: np.ndarray, most: np.ndarray) -> np.ndarray:
    """Whether boxes may reach between two sets of places, each set in a box along the room's axes (k,).

    low, high : (3, k) [m] from the first box's lowest and highest corner to the second box's
    least : (3,), (3, 1) or (3, k) [m] from the first box's highest corner to the lowest corner of the box
    between
    most : likewise from the first box's lowest corner to the highest corner of the box between
    At a fraction t of the way, the hull of both sets is a box with corners linear in t. The result is False
    where for no t from 0 to 1 that box meets the box between along all three axes.
    """
    first, last = 0.0, 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        for axis in range(3):
            for reach, bound in ((high[axis], least[axis]), (-low[axis], -most[axis])):
                # t · reach ≥ bound; where reach is 0 the quotient is infinite or, for 0/0, sets no limit.
                t = bound / (reach + 0.0)
                ahead = reach >= 0
                first = np.fmax(first, np.where(ahead, t, -np.inf))
                last = np.fmin(last, np.where(ahead, np.inf, t))
    return first <= last
