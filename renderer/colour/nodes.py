"""Placed nodes: a few wavelengths with weights fitted to a scene's own lamps. They stand in for bands where
only illuminance is wanted.

`benchmarks/placed_nodes.py` finds both and measures their error on other reflectances.
"""

from functools import cache

import numpy as np

from renderer.colour.bands import BandSet
from renderer.colour.tables import cie_1931, munsell_chips

GRID = np.arange(400.0, 701.0, 5.0)
"""Wavelengths that a node may take [nm]."""
FIRST_NODES = (480.0, 515.0, 545.0, 580.0, 615.0, 655.0)
"""Nodes [nm] where the search begins; it ends in the nearest minimum. Lower minima fit the chips better and
other reflectances worse (docs/decisions.md, D62)."""


@cache
def _paints() -> tuple[np.ndarray, np.ndarray]:
    """Values of 1/(1 − tρ) at 1 nm and on GRID, for each measured chip and each share t.

    t is the share of its light that a room sends back to the paint. No ρ exceeds 0.97.
    """
    _, nm, chips = munsell_chips()
    fine, coarse = (np.clip([np.interp(at, nm, chip) for chip in chips], 0.0, 0.97)
                    for at in (cie_1931()[0], GRID))
    return tuple(np.concatenate([1 / (1 - t * rho) for t in (0.5, 0.8, 0.95)]) for rho in (fine, coarse))


@cache
def _normal_equations(seen: bytes) -> tuple[np.ndarray, np.ndarray, float]:
    """AᵀA, Aᵀb and bᵀb of the relative errors over all paints and rooms; one unknown for each wavelength of
    GRID."""
    fine, coarse = _paints()
    light = np.frombuffer(seen)
    rows = coarse / (fine @ (light / light.sum()))[:, None]
    white = 30.0  # weight of the perfect reflector, which holds the sum of the nodes' weights to 1
    rows = np.vstack([rows, np.full((1, len(GRID)), white)])
    wanted = np.append(np.ones(len(rows) - 1), white)
    return rows.T @ rows, rows.T @ wanted, float(wanted @ wanted)


def _fit(light: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, float]:
    """Non-negative least-squares weights at indices of GRID, and the residual sum of squares."""
    from scipy.optimize import nnls

    square, right, wanted = _normal_equations(light.tobytes())
    square, right = square[np.ix_(at, at)], right[at]
    factor = np.linalg.cholesky(square + 1e-12 * np.trace(square) * np.eye(len(at)))
    weights, _ = nnls(factor.T, np.linalg.solve(factor, right))
    left = float(weights @ square @ weights - 2 * weights @ right + wanted)
    return weights, max(left, 1e-9 * wanted)  # the residual of a laser is only rounding


def luminous_at_1_nm(power: np.ndarray) -> np.ndarray:
    """Relative luminous power (471,) at 360–830 nm, 1 nm, from relative power (471,)."""
    return power * cie_1931()[1][:, 1]


def node_weights(light: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Shares (k,) of a lamp's lumens that the nodes stand for, none negative, their sum 1.

    light : (471,) of `luminous_at_1_nm`, not all 0
    nodes : (k,) [nm], on GRID

    The shares w minimise the relative errors of Σ w_k/(1 − tρ(λ_k)) against the mean of 1/(1 − tρ) over the
    lamp's light, for 1,269 measured paints in rooms that send the share t of their light back.
    """
    weights, _ = _fit(np.asarray(light), np.searchsorted(GRID, nodes))
    return weights / weights.sum()


def place_nodes(lights: list[np.ndarray], lumens: list[float], start=FIRST_NODES) -> np.ndarray:
    """Wavelengths (k,) [nm] of least error for the lamps of a scene together.

    lights : (n_lamps, 471) of `luminous_at_1_nm`
    lumens : (n_lamps,) [lm], the lamps' weights in the error
    start : (k,) [nm], on GRID

    Coordinate descent: one node after the other moves to the wavelength of least squared error, each lamp
    having weights of its own, until a round lowers the error by less than 1e-4 of itself.
    """
    kinds: dict[bytes, float] = {}
    for light, amount in zip(lights, lumens, strict=True):
        if light.any() and amount > 0:
            kinds[light.tobytes()] = kinds.get(light.tobytes(), 0.0) + amount
    if not kinds:
        return np.array(start)

    def left(at: list[int]) -> float:
        return sum(share * _fit(np.frombuffer(seen), np.array(at))[1] for seen, share in kinds.items())

    at = [int(k) for k in np.searchsorted(GRID, start)]
    least, before = left(at), np.inf
    while least < before * (1 - 1e-4):
        before = least
        for place in range(len(at)):
            for moved in sorted(set(range(len(GRID))) - set(at)):
                tried = at[:place] + [moved] + at[place + 1:]
                if (error := left(tried)) < least:
                    at, least = tried, error
    return np.sort(GRID[at])


def nodes_for_lamps(lights: list[np.ndarray], lumens: list[float]) -> BandSet:
    """Six nodes for a scene's own lamps, by `place_nodes`. They carry lumens and no colour."""
    nodes = place_nodes(lights, lumens)
    luminous = np.zeros((len(nodes), 3))
    luminous[:, 1] = 1.0
    return BandSet(str(len(nodes)), None, luminous, nodes=nodes)
