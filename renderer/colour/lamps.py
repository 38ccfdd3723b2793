"""Lamps: the spectrum of a light source, and the flux it puts into each band."""

import difflib

import numpy as np

from renderer.colour.bands import K_M, BandSet, band_average, displayable
from renderer.colour.nodes import GRID, luminous_at_1_nm, node_weights
from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import cie_1931, cie_illuminants, d65
from renderer.errors import InputError


def illuminants(near: str | None = None) -> list[str]:
    """Names of the CIE illuminants, or the three nearest to a name."""
    names = list(cie_illuminants())
    return names if near is None else difflib.get_close_matches(near, names, n=3, cutoff=0.0)


def illuminant(name: str, where: str) -> Spectrum:
    """The CIE illuminant of that name, relative power. An unknown one is refused."""
    if name == "D65":  # at 1 nm
        return Spectrum(*d65())
    if name not in cie_illuminants():
        raise InputError(f"{where} is {name!r}; must be a CIE illuminant or a .csv or .spdx file. "
                         f"Nearest: {', '.join(illuminants(near=name))}.")
    return Spectrum(*cie_illuminants()[name])


def correlated(cct: float) -> Spectrum:
    """Daylight (CIE D-series) from 4000 K, a black body below: relative power, 360–830 nm."""
    import colour

    shape = colour.SpectralShape(360, 830, 5)
    if cct < 4000:
        source = colour.sd_blackbody(cct, shape)
    else:
        # CCTs follow the 1968 radiation constant in which the D series was defined.
        xy = colour.temperature.CCT_to_xy_CIE_D(cct)
        source = colour.sd_CIE_illuminant_D_series(xy, shape=shape)
    return Spectrum(source.wavelengths, source.values / source.values.max())


def power_at_1_nm(spectrum: Spectrum) -> np.ndarray:
    """Relative power (471,) at 360–830 nm, 1 nm; dark outside the samples.

    A line between two of those wavelengths is divided between them: however narrow, it keeps its flux.
    """
    nm, _ = cie_1931()
    nodes = np.union1d(nm, spectrum.nm[(spectrum.nm > nm[0]) & (spectrum.nm < nm[-1])])
    steps = np.diff(nodes, prepend=nodes[0] - 1, append=nodes[-1] + 1)
    power = np.interp(nodes, spectrum.nm, spectrum.values, left=0.0, right=0.0) * (steps[1:] + steps[:-1]) / 2
    below = np.floor(nodes - nm[0]).astype(int)
    above = nodes - nm[0] - below
    return (np.bincount(below, power * (1 - above), len(nm))
            + np.bincount(below + 1, power * above, len(nm) + 1)[:-1])


def spectral_flux(spectrum: Spectrum, lumens: float) -> np.ndarray:
    """Flux (471,) [W/nm] at 360–830 nm, 1 nm, of a source of so many lumens; 0 where it has no light."""
    power = power_at_1_nm(spectrum)
    luminous = K_M * power @ cie_1931()[1][:, 1]
    return power * (lumens / luminous) if luminous > 0 else 0.0 * power


def dark_outside(spectrum: Spectrum) -> Spectrum:
    """The same with a dark sample just past each end, so that averages take it for dark there."""
    dark = 1e-9  # nm
    nm = np.concatenate([[spectrum.nm[0] - dark], spectrum.nm, [spectrum.nm[-1] + dark]])
    return Spectrum(nm, np.concatenate([[0.0], spectrum.values, [0.0]]))


def band_flux(spectrum: Spectrum, lumens: float, bands: BandSet, where: str) -> np.ndarray:
    """Flux of a source in each band (n_bands,), averaged over the band; their lumens are `lumens`.

    A source is dark outside its samples. Raises InputError where no light falls into the bands.
    """
    nm, observer = cie_1931()
    if bands.nodes is not None:
        light = luminous_at_1_nm(power_at_1_nm(spectrum))
        carried = light[(nm > GRID[0] - 5) & (nm < GRID[-1] + 5)].any()
        shares = node_weights(light, bands.nodes) if carried else np.zeros(len(bands.nodes))
    elif bands.edges is None:
        xyz = power_at_1_nm(spectrum) @ observer
        shares = displayable(np.linalg.lstsq(bands.xyz.T, xyz)[0], xyz[1], weights=bands.luminous)
    else:
        ended = dark_outside(spectrum)
        shares = np.clip(band_average(ended.nm, ended.values, bands.edges) * bands.widths, 0.0, None)
    luminous = bands.luminous @ shares
    if not luminous > 0:
        raise InputError(f"{where}: the source has no light between {nm[0]:g} and {nm[-1]:g} nm "
                         "that the bands can carry; give one with light between 400 and 700 nm.")
    return shares * (lumens / luminous)


def mean_light(lamps: list[Spectrum], lumens: list[float]) -> np.ndarray:
    """The lamps' common light (471,), relative power at 360–830 nm, each by its lumens; D65 if none."""
    _, observer = cie_1931()
    light = np.zeros(len(observer))
    for lamp, amount in zip(lamps, lumens, strict=True):
        power = power_at_1_nm(lamp)
        luminous = power @ observer[:, 1]
        light += power * (amount / luminous) if luminous > 0 else 0.0
    return light if light.any() else d65()[1]
