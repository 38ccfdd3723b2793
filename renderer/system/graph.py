"""Connected pieces of graphs."""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components


def pieces_of_graph(n: int, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Index (n,) of the connected piece to which each of n nodes belongs, in the order of the pieces' first
    nodes.

    one, other : (m,) nodes at the two ends of each link
    """
    graph = sparse.coo_array((np.ones(len(one)), (one, other)), shape=(n, n))
    return connected_components(graph, directed=False)[1]
