"""Connected pieces of graphs."""

import numpy as np

NODES_WORTH_SCIPY = 5000
"""Number of nodes above which scipy finds the pieces; below it, importing scipy (0.2 s) takes longer than it
saves."""


def pieces_of_graph(n: int, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Index (n,) of the connected piece to which each of n nodes belongs, in the order of the pieces' first
    nodes.

    one, other : (m,) nodes at the two ends of each link
    """
    if n > NODES_WORTH_SCIPY:
        from scipy import sparse
        from scipy.sparse.csgraph import connected_components

        graph = sparse.coo_array((np.ones(len(one)), (one, other)), shape=(n, n))
        return connected_components(graph, directed=False)[1]
    first = np.arange(n)
    while True:  # each node takes the least of its piece so far
        least, before = np.minimum(first[one], first[other]), first.copy()
        np.minimum.at(first, before[one], least)
        np.minimum.at(first, before[other], least)
        while (first != first[first]).any():
            first = first[first]
        if (first == before).all():
            return np.unique(first, return_inverse=True)[1]
