"""Connected pieces of graphs."""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components


def pieces_of_graph(n: int, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Number (n,) of the connected piece of each of n nodes, by the nodes at both ends of each link (m,);
    pieces are counted by their first nodes."""
    graph = sparse.coo_array((np.ones(len(one)), (one, other)), shape=(n, n))
    return connected_components(graph, directed=False)[1]
