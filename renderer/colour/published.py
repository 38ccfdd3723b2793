"""Published methods from RGB to a spectrum, with colour-science's data, for many colours at once.

colour-science takes one colour at a time (0.25 s each for Jakob's method). Here each method is solved for
linear BT.709 under D65 with the weights of `bt709_of_samples`, so that any error in colour is the method's
own.
"""

import numpy as np

from renderer.colour.bands import bt709_of_samples


def mallett_2019(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A fixed spectrum for each primary (I. Mallett, C. Yuksel, EGSR 2019, doi:10.2312/sr.20191216)."""
    from colour.recovery import MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019 as PRIMARIES

    nm, basis = PRIMARIES.wavelengths, PRIMARIES.values.T
    basis = basis / basis.sum(axis=0)  # tabulated to 1e-5: a grey must stay grey
    return nm, _with_its_colour(lambda drive: drive @ basis, rgb, nm)


def smits_1999(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The sum of white, one secondary and one primary spectrum, each by its share of the colour (B. Smits,
    J. Graphics Tools 4(4), 1999, doi:10.1080/10867651.1999.10487511)."""
    from colour.recovery import SDS_SMITS1999 as SPECTRA

    nm = SPECTRA["white"].wavelengths
    primaries = np.array([SPECTRA[name].values for name in ("red", "green", "blue")])
    # The secondary without red, without green, without blue.
    secondaries = np.array([SPECTRA[name].values for name in ("cyan", "magenta", "yellow")])

    def mixed(drive: np.ndarray) -> np.ndarray:
        order = np.argsort(drive, axis=1, kind="stable")
        low, middle, high = np.take_along_axis(drive, order, axis=1).T[..., None]
        # White is 1 here: the published white falls to 0.9992, and a grey must stay grey.
        return (low + (middle - low) * secondaries[order[:, 0]]
                + (high - middle) * primaries[order[:, 2]])

    return nm, _with_its_colour(mixed, rgb, nm)


def _with_its_colour(method, rgb: np.ndarray, nm: np.ndarray) -> np.ndarray:
    """Spectra (n, k) of a method, limited to 0 … 1, for the input that brings them nearest to `rgb`."""
    weights = bt709_of_samples(nm)
    drive = rgb.copy()
    best = np.clip(method(drive), 0.0, 1.0)
    least = np.linalg.norm(best @ weights.T - rgb, axis=1)
    for _ in range(30):
        spectra = np.clip(method(drive), 0.0, 1.0)
        missed = rgb - spectra @ weights.T
        better = np.linalg.norm(missed, axis=1) < least
        best[better], least[better] = spectra[better], np.linalg.norm(missed[better], axis=1)
        drive = drive + missed
    return best


def otsu_2018(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The combination, limited to 0 … 1, of three eigenvectors of the measured spectra near the colour's
    chromaticity (H. Otsu, M. Yamamoto, T. Hachisuka, Comput. Graph. Forum 37(6), 2018,
    doi:10.1111/cgf.13332)."""
    from colour.recovery.otsu2018 import DATASET_REFERENCE_OTSU2018 as CLUSTERS

    from renderer.colour.bands import BT709_TO_XYZ

    nm = CLUSTERS.shape.wavelengths
    weights = bt709_of_samples(nm)
    xyz = np.where(rgb.any(axis=1)[:, None], rgb, 1.0) @ BT709_TO_XYZ.T
    xy = xyz[:, :2] / xyz.sum(axis=1, keepdims=True)
    cluster = np.array([CLUSTERS.select(point) for point in xy])
    spectra = np.zeros((len(rgb), len(nm)))
    for index in np.unique(cluster):
        here = cluster == index
        basis, mean = CLUSTERS.basis_functions[index], CLUSTERS.means[index]
        mix = np.linalg.solve(weights @ basis.T, (rgb[here] - weights @ mean).T).T
        spectra[here] = mix @ basis + mean
    spectra[~rgb.any(axis=1)] = 0.0  # else the mean spectrum would leave black a little above 0
    return nm, np.clip(spectra, 0.0, 1.0)


def jakob_2019(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A sigmoid of a parabola in wavelength, always within 0 … 1 (W. Jakob, J. Hanika, Comput. Graph. Forum
    38(2), 2019, eqs. 2 and 3, doi:10.1111/cgf.13626).

    Levenberg–Marquardt steps on linear BT.709 find the three coefficients.
    """
    nm = np.arange(360.0, 831.0, 5.0)
    weights = bt709_of_samples(nm)
    t = (nm - 555.0) / 150.0
    powers = np.stack([np.ones_like(t), t, t * t])

    def spectra(c: np.ndarray) -> np.ndarray:
        x = c @ powers
        return 0.5 + x / (2 * np.sqrt(1 + x * x))

    # Start at the grey whose reflectance is the components' mean.
    grey = np.clip(rgb.mean(axis=1), 1e-4, 1 - 1e-4)
    c = np.zeros_like(rgb)
    c[:, 0] = (grey - 0.5) / np.sqrt(grey * (1 - grey))
    damping = np.full(len(rgb), 1e-3)
    missed = rgb - spectra(c) @ weights.T
    for _ in range(300):
        x = c @ powers
        rise = 0.5 * (1 + x * x) ** -1.5
        jacobian = np.einsum("nk,ik,jk->nij", rise, weights, powers)
        normal = np.einsum("nij,nik->njk", jacobian, jacobian)
        scale = np.einsum("njj->nj", normal) + 1e-300
        right = np.einsum("nij,ni->nj", jacobian, missed)
        step = np.linalg.solve(normal + damping[:, None, None] * scale[:, None] * np.eye(3),
                               right[..., None])[..., 0]
        fresh = rgb - spectra(c + step) @ weights.T
        better = np.linalg.norm(fresh, axis=1) < np.linalg.norm(missed, axis=1)
        c[better] += step[better]
        missed[better] = fresh[better]
        damping = np.where(better, np.maximum(damping / 4, 1e-12), np.minimum(damping * 3, 1e6))
        if (np.linalg.norm(missed, axis=1) < 1e-9).all():
            break
    found = spectra(c)
    found[~rgb.any(axis=1)] = 0.0  # a sigmoid does not reach 0
    return nm, found
