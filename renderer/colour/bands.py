"""Band sets: what one number per band stands for, and how bands become visible light.

In a set of wavelength intervals, a band's quantity is the power [W] of light of the same lumens spread evenly
over the band. A spectral line therefore counts by V(λ) at its own wavelength; `BandSet.watts` gives its true
power. In the RGB set, a band's quantity is a weighted integral of the spectrum: linear BT.709, scaled so that
its luminance is in lumens. It is not a spectral radiance.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from renderer.colour.tables import cie_1931, d65

K_M = 683.0
"""Maximum luminous efficacy of radiation [lm/W], photopic (CIE 15:2018; SI: 683 at 540 THz)."""


def _bt709_to_xyz() -> np.ndarray:
    """Matrix (3, 3) from linear BT.709 to XYZ, from the primaries and the white point of ITU-R BT.709-6."""
    primaries = np.array([[0.64, 0.33, 0.03], [0.30, 0.60, 0.10], [0.15, 0.06, 0.79]])
    white = np.array([0.3127, 0.3290, 0.3583]) / 0.3290
    return primaries.T * np.linalg.solve(primaries.T, white)


BT709_TO_XYZ = _bt709_to_xyz()
XYZ_TO_BT709 = np.linalg.inv(BT709_TO_XYZ)
LUMINANCE_WEIGHTS = BT709_TO_XYZ[1]

# XYZ to sharpened RGB: S. Süsstrunk, J. Holm, G. D. Finlayson, Proc. SPIE 4300 (2001), 172,
# doi:10.1117/12.410788; the best primaries according to Ward and Eydelberg-Vileshin (2002).
XYZ_TO_SHARP = np.array([[1.2694, -0.0988, -0.1706], [-0.8364, 1.8006, 0.0357],
                         [0.0297, -0.0315, 1.0018]])


@dataclass(frozen=True)
class BandSet:
    """A way to divide light into bands that do not exchange energy.

    name : one of BAND_SETS
    edges : (n_bands + 1,) [nm] of wavelength intervals; None for other kinds of bands
    xyz : (n_bands, 3) tristimulus values per unit of each band, Y in lm; X and Z are 0 for placed nodes,
        which carry no colour
    filters : (471, n_bands) weights on a reflectance at 360–830 nm, 1 nm, each column's sum 1; None for
        intervals and nodes
    nodes : (n_bands,) [nm] where each band is one wavelength, its unit the lumen; None otherwise
    watts : (n_bands,) power [W] of a unit of each interval for the scene's own lamps; None for 1
    """

    name: str
    edges: np.ndarray | None
    xyz: np.ndarray
    filters: np.ndarray | None = None
    nodes: np.ndarray | None = None
    watts: np.ndarray | None = None

    @property
    def knows_spectrum(self) -> bool:
        """Whether a spectrum, and quantities derived from it, can be read: intervals of 10 nm or less."""
        # 10 nm, with room for rounding. With 16 bands (20 nm) CCT errs by up to 1 %, R_a by 1 and α-opic
        # light by 3 %; with 9 bands by 7 %, 4 and 10 % (benchmarks/colour_readings.py).
        return self.edges is not None and self.widths.max() <= 10.001

    @property
    def luminous(self) -> np.ndarray:
        """Lumens per unit of each band (n_bands,)."""
        return self.xyz[:, 1]

    @property
    def centres(self) -> np.ndarray:
        """Middle of each band (n_bands,) [nm]."""
        return (self.edges[1:] + self.edges[:-1]) / 2

    @property
    def widths(self) -> np.ndarray:
        """Width of each band (n_bands,) [nm]."""
        return np.diff(self.edges)


def band_average(nm: np.ndarray, values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Mean over each band of a curve that is linear between its samples.

    nm : (n,) [nm], ascending; values : (n,) or (n, k); edges : (n_bands + 1,) [nm].
    Returns (n_bands,) or (n_bands, k). Outside its samples the curve keeps its end value. The integral is
    exact, so a line narrower than a band keeps its flux.
    """
    nodes = np.union1d(nm, edges)
    columns = np.atleast_2d(values.T).T
    curve = np.column_stack([np.interp(nodes, nm, column) for column in columns.T])
    steps = np.diff(nodes)[:, None] * (curve[1:] + curve[:-1]) / 2
    integral = np.vstack([np.zeros(curve.shape[1]), np.cumsum(steps, axis=0)])
    mean = np.diff(integral[np.searchsorted(nodes, edges)], axis=0) / np.diff(edges)[:, None]
    return mean if values.ndim == 2 else mean[:, 0]


@cache
def band_set(name: str) -> BandSet:
    """The band set "rgb", or a number of bands of equal width with centres from 400 to 700 nm.

    "31" has centres at 400, 410 … 700 nm, each band 10 nm wide; "61", "16" and "9" are 5, 20 and 37.5 nm
    wide.
    """
    if name == "rgb":
        return BandSet("rgb", None, BT709_TO_XYZ.T, bt709_under_d65()[1])
    half = 150.0 / (int(name) - 1)
    edges = np.linspace(400.0 - half, 700.0 + half, int(name) + 1)
    return BandSet(name, edges, K_M * band_average(*cie_1931(), edges))


@cache
def narrow_bands() -> BandSet:
    """Bands of 2 nm over the tabulated range, 360–830 nm: the reference for other band sets."""
    edges = np.arange(360.0, 831.0, 2.0)
    return BandSet("2 nm", edges, K_M * band_average(*cie_1931(), edges))


def prefiltered(light: np.ndarray, primaries: np.ndarray = XYZ_TO_SHARP) -> BandSet:
    """Three bands fitted to a room's own light.

    light : (471,) relative power at 360–830 nm, 1 nm, the mean of the room's lamps
    primaries : (3, 3) XYZ to the three bands

    Each reflectance is weighted with that light before it is reduced to three sharpened primaries, in which
    the light itself is (1, 1, 1). Light reflected once has exactly the right X, Y and Z; only further bounces
    err. G. Ward, E. Eydelberg-Vileshin, Eurographics Workshop on Rendering (2002), 117.
    """
    _, observer = cie_1931()
    seen = (light[:, None] * observer) @ primaries.T
    white = seen.sum(axis=0)
    # A light purer than the primaries (a laser) has none of one of them: that band carries nothing.
    lacking = white <= 1e-6 * white.max()
    filters = np.where(lacking, observer[:, 1:2] * light[:, None], seen)
    xyz = np.linalg.inv(primaries).T * np.where(lacking, 0.0, white)[:, None]
    return BandSet("rgb-prefiltered", None, xyz / xyz[:, 1].sum(), filters / filters.sum(axis=0))


BAND_SETS = ("rgb", "rgb-prefiltered", "6", "9", "16", "31", "61")
"""Band sets that pictures and tables show side by side."""


@cache
def bt709_under_d65() -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths (471,) [nm], and weights (471, 3) with Σ weights · reflectance = linear BT.709 under D65.

    The weights are scaled so that the perfect reflector is exactly (1, 1, 1) and a grey stays grey: the
    tabulated D65 differs from the white of BT.709 by 1e-4.
    """
    nm, observer = cie_1931()
    weights = (observer * d65()[1][:, None]) @ XYZ_TO_BT709.T
    return nm, weights / weights.sum(axis=0)


def bt709_of_samples(nm: np.ndarray) -> np.ndarray:
    """Weights (3, k) from samples of a reflectance at nm (k,) [nm] to linear BT.709 under D65.

    Exact for a curve that is linear between its samples and constant beyond them.
    """
    fine, weights = bt709_under_d65()
    return weights.T @ np.column_stack([np.interp(fine, nm, unit) for unit in np.eye(len(nm))])


def displayable(rgb: np.ndarray, luminance: float, ceiling: float = np.inf,
                weights: np.ndarray = LUMINANCE_WEIGHTS) -> np.ndarray:
    """Linear RGB (3,) within 0 … ceiling and of the given luminance, the sum with `weights`.

    Components below 0 become 0 and the others are scaled to the luminance. Components above the ceiling
    become the ceiling; the others take up the difference in proportion to themselves, or evenly where they
    are 0.
    """
    if not luminance > 0.0:
        return np.zeros(3)
    rgb = np.clip(rgb, 0.0, None)
    rgb = rgb / rgb.max() if rgb.max() > 0 else np.ones(3)
    rgb *= luminance / (weights @ rgb)
    full = rgb > ceiling
    while full.any() and not full.all():
        rest = luminance - ceiling * weights[full].sum()
        free = np.where(full, 0.0, rgb)
        free = np.where(full, 0.0, 1.0) if not free.max() > 1e-9 * ceiling else free
        rgb = np.where(full, ceiling, free * (rest / (weights @ free)))
        if not (rgb > ceiling).any():
            return rgb
        full |= rgb > ceiling
    return np.minimum(rgb, ceiling)
