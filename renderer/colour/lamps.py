"""Lamps: the spectrum of a light source, and the flux it puts into each band."""

import difflib
from dataclasses import replace

import numpy as np

from renderer.colour.bands import K_M, BandSet, displayable
from renderer.colour.nodes import GRID, luminous_at_1_nm, node_weights
from renderer.colour.reference_light import black_body, phase_of_daylight
from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import cie_1931, cie_illuminant, d65, illuminant_columns
from renderer.errors import InputError


def illuminants(near: str | None = None) -> list[str]:
    """Names of the CIE illuminants; with `near`, the three most like it."""
    names = list(illuminant_columns())
    return names if near is None else difflib.get_close_matches(near, names, n=3, cutoff=0.0)


def illuminant(name: str, where: str) -> Spectrum:
    """Relative power of a CIE illuminant. Raises InputError for an unknown name."""
    if name == "D65":  # at 1 nm
        return Spectrum(*d65())
    if name not in illuminant_columns():
        raise InputError(f"{where} is {name!r}; must be a CIE illuminant or a spectral file (.csv, .txt, "
                         f".spdx …). Nearest: {', '.join(illuminants(near=name))}.")
    return Spectrum(*cie_illuminant(name))


def correlated(cct: float) -> Spectrum:
    """Relative power of daylight (CIE D series) from 4000 K, of a black body below; 360–830 nm."""
    if cct < 4000:
        return Spectrum(cie_1931()[0], black_body(cct))
    # The D series was defined with the radiation constant of 1968.
    power = phase_of_daylight(cct)[::5]
    return Spectrum(cie_1931()[0][::5], power / power.max())


def power_at_1_nm(spectrum: Spectrum) -> np.ndarray:
    """Relative power (471,) at 360–830 nm, 1 nm; 0 outside the samples.

    A line between two of those wavelengths is divided between them and keeps its flux, however narrow it is.
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
    """Spectral flux (471,) [W/nm] at 360–830 nm, 1 nm, of a source of given lumens; 0 for one without
    light."""
    power = power_at_1_nm(spectrum)
    luminous = K_M * power @ cie_1931()[1][:, 1]
    return power * (lumens / luminous) if luminous > 0 else 0.0 * power


def dark_outside(spectrum: Spectrum) -> Spectrum:
    """The spectrum with a sample of 0 just past each end: averages then take it as 0 outside its samples."""
    dark = 1e-9  # nm
    nm = np.concatenate([[spectrum.nm[0] - dark], spectrum.nm, [spectrum.nm[-1] + dark]])
    return Spectrum(nm, np.concatenate([[0.0], spectrum.values, [0.0]]))


def power_in_bands(spectrum: Spectrum, edges: np.ndarray) -> np.ndarray:
    """Relative power (n_bands, 471) in each band at 360–830 nm, 1 nm; 0 outside the samples.

    edges : (n_bands + 1,) [nm], within 360 to 830

    Power between two of those wavelengths is divided between them but stays in its band.
    """
    nm, _ = cie_1931()
    ended = dark_outside(spectrum)
    nodes = np.unique(np.concatenate([nm, edges, ended.nm]))
    nodes = nodes[(nodes >= edges[0]) & (nodes <= edges[-1])]
    curve = np.interp(nodes, ended.nm, ended.values, left=0.0, right=0.0)
    half = np.diff(nodes) / 2
    band = np.searchsorted(edges, nodes[:-1] + half) - 1
    power, at = np.concatenate([half * curve[:-1], half * curve[1:]]), np.concatenate([nodes[:-1], nodes[1:]])
    below = np.floor(at - nm[0]).astype(int)
    above = at - nm[0] - below
    place = np.tile(band, 2) * (len(nm) + 1) + below
    size = (len(edges) - 1) * (len(nm) + 1)
    found = np.bincount(place, power * (1 - above), size)
    found += np.bincount(place + 1, power * above, size + 1)[:-1]
    return found.reshape(-1, len(nm) + 1)[:, :-1]


def band_watts(spectrum: Spectrum, lumens: float, bands: BandSet) -> np.ndarray:
    """Power (n_bands,) [W] of a source of given lumens in each interval of wavelengths."""
    power = power_in_bands(spectrum, bands.edges)
    luminous = K_M * float((power @ cie_1931()[1][:, 1]).sum())
    return power.sum(axis=1) * (lumens / luminous) if luminous > 0 else np.zeros(len(power))


def for_lamps(bands: BandSet, lamps: list[Spectrum], lumens: list[float]) -> BandSet:
    """The intervals `bands` with X, Z and power per unit as the lamps together have them.

    lumens : of each lamp [lm]

    Lumens per band are exact for each lamp; X, Z and power are exact where all lamps have one spectrum.
    """
    _, observer = cie_1931()
    kinds: dict[int, list] = {}
    for lamp, amount in zip(lamps, lumens, strict=True):
        kinds.setdefault(id(lamp), [lamp, 0.0])[1] += amount
    seen = np.zeros((len(bands.xyz), 4))
    for lamp, amount in kinds.values():
        power = power_in_bands(lamp, bands.edges)
        found = np.column_stack([K_M * (power @ observer), power.sum(axis=1)])
        seen += found * (amount / found[:, 1].sum() if found[:, 1].sum() > 0 else 0.0)
    units = seen[:, 1] / bands.luminous
    lit = units > 1e-9 * units.max(initial=0.0)  # a darker band keeps the colour of an even spectrum
    xyz, watts = bands.xyz.copy(), np.ones(len(units))
    xyz[lit, 0], xyz[lit, 2] = seen[lit, 0] / units[lit], seen[lit, 2] / units[lit]
    watts[lit] = seen[lit, 3] / units[lit]
    return replace(bands, xyz=xyz, watts=watts)


def band_flux(spectrum: Spectrum, lumens: float, bands: BandSet, where: str) -> np.ndarray:
    """Flux (n_bands,) of a source in each band, in the band set's unit; `lumens` [lm] in total.

    An interval of wavelengths has the lumens of its own part of the spectrum, with V(λ) at every 1 nm. A
    source is dark outside its samples. Raises InputError where no light falls into the bands.
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
        shares = K_M * (power_in_bands(spectrum, bands.edges) @ observer[:, 1]) / bands.luminous
    luminous = bands.luminous @ shares
    if not luminous > 0:
        raise InputError(f"{where}: the source has no light between {nm[0]:g} and {nm[-1]:g} nm "
                         "that the bands can carry; give one with light between 400 and 700 nm.")
    return shares * (lumens / luminous)


def mean_light(lamps: list[Spectrum], lumens: list[float]) -> np.ndarray:
    """Mean light of the lamps (471,): relative power at 360–830 nm, 1 nm, each lamp by its lumens; D65 for
    none."""
    _, observer = cie_1931()
    light = np.zeros(len(observer))
    for lamp, amount in zip(lamps, lumens, strict=True):
        power = power_at_1_nm(lamp)
        luminous = power @ observer[:, 1]
        light += power * (amount / luminous) if luminous > 0 else 0.0
    return light if light.any() else d65()[1]
