"""The light computed with each replica of the rays, as a small departure from the light with all rays.

The operator S + D of a replica differs little from the operator S of all rays. To first order its light
departs by the solution with S whose direct light is D times the light with S. One solve has a column for each
replica.
"""

import numpy as np

from renderer.transport.factors.exchange import Exchange
from renderer.transport.radiosity.solve import rescaled


def departures(exchange: Exchange, more, radiosity: np.ndarray) -> np.ndarray:
    """Irradiance with the operator of each replica minus irradiance with the whole operator (replicas, n,
    n_bands) [W m⁻²].

    more : returns D x (replicas, n, k) from x (n, k)
    radiosity : (n, n_bands) [W m⁻²]
    Each operator is scaled by 1 + d from both sides so that it conserves energy; to first order (A + S) d =
    −D 1.
    """
    ones = np.ones((len(radiosity), 1))
    brought = more(np.hstack([ones, radiosity]))
    missing, brought = -brought[..., 0].T, brought[..., 1:]
    scale = rescaled(exchange, missing)
    sent = (scale.T[..., None] * radiosity).transpose(1, 0, 2).reshape(len(radiosity), -1)
    again = (exchange.matrix @ sent).reshape(len(radiosity), *brought.shape[::2]).transpose(1, 0, 2)
    brought = brought + scale.T[..., None] * (exchange.matrix @ radiosity) + again
    return brought / np.where(exchange.areas > 0, exchange.areas, np.inf)[:, None]
