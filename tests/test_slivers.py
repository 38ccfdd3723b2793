"""Slivers and enclosed patches of model files do not change the light on other patches."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from renderer.transport.factors.exchange import SplitSymmetric, balance
from renderer.transport.factors.hemisphere_rays import count
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.radiosity.agglomerate import agglomerated
from renderer.transport.transport import compute_transport

CRATE = {"shape": "box", "position": [1.5, 1.5, 0.0], "size": [1.0, 1.0, 1.0]}
N = 60


def imbalanced():
    """An exchange (N, N) [m²] of which each row misses up to 2 % of its patch's area, and those areas."""
    random = np.random.default_rng(1)
    matrix = random.random((N, N))
    matrix += matrix.T
    np.fill_diagonal(matrix, 0.0)
    return matrix, matrix.sum(axis=1) * random.uniform(0.98, 1.02, N)


def with_more(matrix, areas, rows, more):
    """The exchange with further patches, of the exchange `rows` (k, k) among themselves and areas `more`."""
    k = len(more)
    return np.block([[matrix, np.zeros((N, k))], [np.zeros((k, N)), rows]]), np.append(areas, more)


def whole(matrix):
    return matrix if isinstance(matrix, np.ndarray) else matrix.toarray()


ALONE = np.zeros((1, 1)), [30.0]
"""A patch as large as the others that exchanges nothing, as where all its rays are stopped."""
SLIVER = np.array([[1.3e-9]]), [1e-12]
"""A row that is rounding, 1300 times the patch's area."""
UNEVEN = np.array([[0.0, 2.0], [2.0, 0.0]]), [1.0, 3.0]
"""Two patches that see only each other, which no scaling closes for unequal areas."""


@pytest.mark.parametrize("more", [ALONE, SLIVER, UNEVEN], ids=["alone", "sliver", "uneven"])
@pytest.mark.parametrize("split", [False, True], ids=["dense", "split"])
def test_patches_that_cannot_be_closed_change_nothing_for_the_others(more, split):
    matrix, areas = imbalanced()
    right, scale = balance(matrix.copy(), areas)
    assert np.abs(scale - 1).max() < 0.05  # rows miss 2 %
    larger, all_areas = with_more(matrix, areas, *more)
    if split:
        half = sparse.csr_array(np.triu(larger, 1))
        larger = SplitSymmetric(half, half.T.tocsr(), np.diag(larger).copy())
    balanced, scale = balance(larger, all_areas)
    balanced = whole(balanced)
    assert np.abs(scale[:N] - 1).max() < 0.05
    # Scaling closes a large mesh to 1e-4 of each area, and stops where the worst row stalls; the rest is on
    # the diagonal.
    assert np.abs(balanced[:N, :N] - right).max() < 1e-4 * areas.min()
    assert balanced.sum(axis=1) == pytest.approx(all_areas, rel=1e-9)
    assert np.abs(balanced - balanced.T).max() < 1e-12
    assert balanced.min() > -1e-12


def test_grouping_does_not_change_the_operator(room):
    transport = compute_transport(room(0.5, objects=[CRATE]), 0.5, 256, 0, pair_rays_allowed=False)
    exchange = count(transport.mesh, transport.hits, dense=False)
    given = exchange.matrix.given.copy()
    given.data[::3] *= 1e-13  # as between slivers, below what counts as light between chambers
    # Closed again: the rest of each row is on the diagonal.
    small = SplitSymmetric(given, given.T.tocsr(), np.zeros(len(exchange.areas)))
    small = small.closed(exchange.areas, np.ones(len(exchange.areas)))
    exchange, before = replace(exchange, matrix=small), small.toarray()
    groups = agglomerated(transport.mesh, exchange)
    np.testing.assert_array_equal(exchange.matrix.toarray(), before)
    assert groups.exchange.matrix.sum(axis=1) == pytest.approx(groups.exchange.areas, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("height", [1.0, 1e-4, 1e-9])
def test_places_on_a_sliver_have_the_coordinates_that_they_were_made_from(height):
    corners = np.array([[0.2, 0.1, 0.3], [1.2, 0.5, 0.4], [0.6, 0.26, 0.34]])
    corners[2] += height * np.array([0.0, 0.3, 1.0])
    one, nothing = np.zeros(1, dtype=int), np.zeros((0, 8, 3))
    mesh = Mesh(corners, np.array([[0, 1, 2, 2]]), one, np.zeros(3, int), one - 1, np.zeros(1, bool), nothing,
                nothing[:, :3], nothing[:, :3])
    s, t = np.array([0.2, 0.7, 1 / 3]), np.array([0.3, 0.1, 1 / 3])
    patch = np.zeros(3, dtype=int)
    found = mesh.inside(patch, mesh.at(patch, s, t))
    # A place is rounded by 2e-16 m; across the sliver that is as much of s and t as of its height.
    np.testing.assert_allclose(found, (s, t), atol=1e-15 + 4e-16 / height)
