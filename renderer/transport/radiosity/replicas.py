"""What light each independent part of the rays would give, told from how little it departs from all of them.

A part's operator S + D is nearly the whole one, S. To first order its light departs by what D sends of the
whole's light, once that has gone round the room by S; so all parts are one solve with as many columns.
"""

import numpy as np
from scipy import sparse

from renderer.transport.factors.exchange import Exchange
from renderer.transport.factors.hemisphere_rays import openness, tallied
from renderer.transport.factors.pair_rays import PairVisibility
from renderer.transport.mesh.mesh import Mesh
from renderer.transport.radiosity.solve import rescaled


def half_samples(pair_visibility: PairVisibility, whole: np.ndarray, parts: int, x: np.ndarray) -> np.ndarray:
    """D x (parts, n, k) for half samples of the rays between doubtful pairs, drawn by lot (McCarthy, Rev.
    Int. Stat. Inst. 37, 1969): they depart from the whole by what that itself errs by.

    whole : what the pairs would exchange in plain sight [m²]; x : (n, k)
    """
    pairs = len(whole)
    order = sparse.coo_array(
        (np.arange(1, pairs + 1), tuple(pair_visibility.pairs)), shape=(len(x), len(x))
    ).tocsr()
    by_row = order.data - 1
    seen, apart, whole = (each[by_row] for each in (pair_visibility.seen, pair_visibility.apart, whole))
    more_seen, less_seen = (whole * ((seen + way * apart).clip(0, 1) - seen) for way in (1, -1))
    more = np.empty((parts, *x.shape))
    for part in range(parts):
        lots = np.unpackbits(np.frombuffer(np.random.default_rng(part).bytes(-(-pairs // 8)), dtype=np.uint8))
        half = np.where(lots[:pairs] > 0, more_seen, less_seen)
        above = sparse.csr_array((half, order.indices, order.indptr), shape=order.shape)
        more[part] = above @ x + above.T @ x
    return more


def independent(mesh: Mesh, exchange: Exchange, hits: np.ndarray, parts: int, x: np.ndarray) -> np.ndarray:
    """D x (parts, n, k) for the independent parts of rays all over the hemispheres, of `cast`, each counted
    by itself. x : (n, k)"""
    open_ = openness(hits, mesh.unknowns.exposed_share)
    whole = exchange.matrix @ x
    more = np.empty((parts, *x.shape))
    for part, met in enumerate(np.split(hits, parts, axis=1)):
        given, _ = tallied(mesh, met, exchange.areas, open_.lost)
        more[part] = given @ x + given.T @ x - whole
    return more


def departures(exchange: Exchange, more, radiosity: np.ndarray) -> np.ndarray:
    """How much more irradiance each part's operator brings of the whole's light (parts, n, n_bands) [W m⁻²].

    more : from x (n, k) to D x (parts, n, k); radiosity : (n, n_bands). Each operator is made to conserve
    energy, as the whole is: with 1 + d on both sides, where (A + S) d = −D 1 to first order.
    """
    ones = np.ones((len(radiosity), 1))
    brought = more(np.hstack([ones, radiosity]))
    missing, brought = -brought[..., 0].T, brought[..., 1:]
    scale = rescaled(exchange, missing)
    sent = (scale.T[..., None] * radiosity).transpose(1, 0, 2).reshape(len(radiosity), -1)
    again = (exchange.matrix @ sent).reshape(len(radiosity), *brought.shape[::2]).transpose(1, 0, 2)
    brought = brought + scale.T[..., None] * (exchange.matrix @ radiosity) + again
    return brought / np.where(exchange.areas > 0, exchange.areas, np.inf)[:, None]
