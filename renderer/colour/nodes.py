"""Placed nodes: a few wavelengths, and weights fitted to a scene's own lamps, that tell illuminance.

`benchmarks/placed_nodes.py` shows how both are found and how far they err on other reflectances.
"""

from functools import cache

import numpy as np

from renderer.colour.bands import BandSet
from renderer.colour.tables import cie_1931, munsell_chips

GRID = np.arange(400.0, 701.0, 5.0)
"""Wavelengths that a node may take [nm]."""
START = (480.0, 515.0, 545.0, 580.0, 615.0, 655.0)
"""Where the search begins [nm]; it ends in the nearest hollow. Deeper ones fit the chips better, and other
reflectances worse (docs/decisions.md, D62)."""
ROOMS = (0.5, 0.8, 0.95)
"""How much of its light a room sends back to a paint, for the rooms that the weights are fitted to."""
BRIGHTEST = 0.97
"""Reflectance that no paint of the fit exceeds at any wavelength."""
WHITE = 30.0
"""Weight in the fit of the perfect reflector, whose light the nodes' weights then add up to."""
IMPROVED = 1e-4
"""The search ends where a round through the nodes lowers the squared error by less than this share."""


@cache
def _paints() -> tuple[np.ndarray, np.ndarray]:
    """What 1/(1 − tρ) is for each measured chip and each t of ROOMS: at 1 nm, and on GRID."""
    _, nm, chips = munsell_chips()
    fine, coarse = (np.clip([np.interp(at, nm, chip) for chip in chips], 0.0, BRIGHTEST)
                    for at in (cie_1931()[0], GRID))
    return tuple(np.concatenate([1 / (1 - t * rho) for t in ROOMS]) for rho in (fine, coarse))


@cache
def _normal_equations(seen: bytes) -> tuple[np.ndarray, np.ndarray, float]:
    """AᵀA, Aᵀb and bᵀb of the relative errors over every paint and room, one unknown a wavelength of GRID."""
    fine, coarse = _paints()
    light = np.frombuffer(seen)
    rows = coarse / (fine @ (light / light.sum()))[:, None]
    rows = np.vstack([rows, np.full((1, len(GRID)), WHITE)])
    wanted = np.append(np.ones(len(rows) - 1), WHITE)
    return rows.T @ rows, rows.T @ wanted, float(wanted @ wanted)


def _fit(light: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, float]:
    """Least-squares weights, none negative, at indices of GRID, and the sum of squares that is left."""
    from scipy.optimize import nnls

    square, right, wanted = _normal_equations(light.tobytes())
    square, right = square[np.ix_(at, at)], right[at]
    factor = np.linalg.cholesky(square + 1e-12 * np.trace(square) * np.eye(len(at)))
    weights, _ = nnls(factor.T, np.linalg.solve(factor, right))
    left = float(weights @ square @ weights - 2 * weights @ right + wanted)
    return weights, max(left, 1e-9 * wanted)  # a laser leaves nothing but rounding


def luminous_at_1_nm(power: np.ndarray) -> np.ndarray:
    """Relative light (471,) at 360–830 nm, 1 nm, from relative power; ȳ of power."""
    return power * cie_1931()[1][:, 1]


def node_weights(light: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Share of a lamp's lumens that each node stands for (k,), none negative, adding up to 1.

    light : (471,) of `luminous_at_1_nm`, not all dark; nodes : (k,) [nm], on GRID

    So that Σ w_k/(1 − tρ(λ_k)) is as near as can be, relatively, to the mean of 1/(1 − tρ) over the lamp's
    light, for 1,269 measured paints in rooms that send t of their light back.
    """
    weights, _ = _fit(np.asarray(light), np.searchsorted(GRID, nodes))
    return weights / weights.sum()


def place_nodes(lights: list[np.ndarray], lumens: list[float], start=START) -> np.ndarray:
    """Wavelengths (k,) [nm] that do best for the lamps of a scene together.

    lights : (n_lamps, 471) of `luminous_at_1_nm`; lumens : (n_lamps,) [lm], by which they count
    start : (k,) [nm], on GRID

    One node after the other goes where the squared errors, each lamp with weights of its own, are least.
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
    while least < before * (1 - IMPROVED):
        before = least
        for place in range(len(at)):
            for moved in sorted(set(range(len(GRID))) - set(at)):
                tried = at[:place] + [moved] + at[place + 1:]
                if (error := left(tried)) < least:
                    at, least = tried, error
    return np.sort(GRID[at])


def nodes_for_lamps(lights: list[np.ndarray], lumens: list[float]) -> BandSet:
    """Six nodes for a scene's own lamps, as in `place_nodes`. They know lumens, and no colour."""
    nodes = place_nodes(lights, lumens)
    luminous = np.zeros((len(nodes), 3))
    luminous[:, 1] = 1.0
    return BandSet(str(len(nodes)), None, luminous, nodes=nodes)
