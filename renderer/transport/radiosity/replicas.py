"""The light by each replica of the rays, from its small departure from the light by all rays.

The operator of a replica, S + D, is nearly that of all rays, S. To first order its light departs by what D
sends of the light by S, once that has gone round the room by S: one solve with as many columns as there are
replicas.
"""

import numpy as np

from renderer.transport.factors.exchange import Exchange
from renderer.transport.radiosity.solve import rescaled


def departures(exchange: Exchange, more, radiosity: np.ndarray) -> np.ndarray:
    """Irradiance by the operator of each replica less that by the whole one (replicas, n, n_bands) [W m⁻²].

    more : returns D x (replicas, n, k) from x (n, k)
    radiosity : (n, n_bands) [W m⁻²]
    Each operator is made to conserve energy, as the whole one does: scaled by 1 + d from both sides, where (A
    + S) d = −D 1 to first order.
    """
    ones = np.ones((len(radiosity), 1))
    brought = more(np.hstack([ones, radiosity]))
    missing, brought = -brought[..., 0].T, brought[..., 1:]
    scale = rescaled(exchange, missing)
    sent = (scale.T[..., None] * radiosity).transpose(1, 0, 2).reshape(len(radiosity), -1)
    again = (exchange.matrix @ sent).reshape(len(radiosity), *brought.shape[::2]).transpose(1, 0, 2)
    brought = brought + scale.T[..., None] * (exchange.matrix @ radiosity) + again
    return brought / np.where(exchange.areas > 0, exchange.areas, np.inf)[:, None]
