"""Cases of spectra and colour: Planck's law, the D series, colour temperature, melanopic light."""

from pathlib import Path

import numpy as np
from scipy import constants

from renderer.colour.bands import band_set
from renderer.colour.lamps import band_flux, correlated, illuminant, power_at_1_nm
from renderer.colour.tables import cie_1931, d65
from renderer.readings.alpha_opic import RECEPTORS, daylight_ratio, efficacy
from renderer.readings.colorimetry import chromaticity, colour_temperature
from renderer.studies.validation.cases import Case
from renderer.studies.validation.photometry import PUBLISHED_VALUES


def planck(_folder: Path) -> list[Case]:
    """Black bodies against Planck's law with SI constants."""
    rows = []
    c2 = constants.h * constants.c / constants.k
    for kelvin in (1500.0, 2856.0, 3900.0):
        lamp = correlated(kelvin)
        for low, high in ((450, 555), (700, 555)):
            got = np.interp(low, lamp.nm, lamp.values) / np.interp(high, lamp.nm, lamp.values)
            a, b = (np.expm1(c2 / (nm * 1e-9 * kelvin)) * nm**5 for nm in (low, high))
            rows.append(Case("Spectra", f"black body, {kelvin:g} K", f"L({low} nm)/L({high} nm)", b / a,
                             float(got), 1e-4 * b / a, source="Planck's law; CIE 15:2018"))
    return rows


def daylight(_folder: Path) -> list[Case]:
    """The D series at 6504 K against the tabulated D65."""
    nm, table = d65()
    lamp = correlated(6504.0)
    rows = []
    for at in (400, 450, 500, 600, 700):
        expected = np.interp(at, nm, table) / np.interp(560, nm, table)
        got = np.interp(at, lamp.nm, lamp.values) / np.interp(560, lamp.nm, lamp.values)
        # The series' coefficients are rounded to three places: 5e-4 of S0's 100, on two terms.
        rows.append(Case("Spectra", "D series, 6504 K", f"S({at} nm)/S(560 nm)", expected, float(got), 2e-3,
                         source="CIE 15:2018, table of D65"))
    return rows


def colorimetry(_folder: Path) -> list[Case]:
    """Lumens, chromaticity, colour temperature and melanopic light of lamps in 31 bands."""
    bands, rows = band_set("31"), []
    for name in ("D65", "A", "FL2", "FL11", "LED-B3"):
        flux = band_flux(illuminant(name, ""), 1000.0, bands, "")
        rows.append(Case("Colorimetry", name, "flux", 1000.0, float(flux @ bands.luminous), 1e-9, "lm",
                         "the stated lumens"))
        lamp = illuminant(name, "")
        nm, observer = cie_1931()
        xyz = np.interp(nm, lamp.nm, lamp.values, left=0, right=0) @ observer
        for axis, expected, got in zip("xy", xyz / xyz.sum(), chromaticity(flux, bands), strict=False):
            # A band spreads a line by up to 5 nm; 0.002 is about the visible difference of two white fields.
            rows.append(Case("Colorimetry", name, f"{axis} from 31 bands", float(expected), float(got), 2e-3,
                             source="chromaticity at 1 nm"))
    fl2 = PUBLISHED_VALUES["colour"]["FL2"]
    cct, duv = colour_temperature(chromaticity(band_flux(illuminant("FL2", ""), 1.0, bands, ""), bands))
    kelvin = fl2["cct_K_ohno2013"]
    rows.append(Case("Colorimetry", "FL2", "CCT", kelvin, cct, 0.005 * kelvin, "K", "Ohno 2013"))
    rows.append(Case("Colorimetry", "FL2", "Duv", fl2["duv"], duv, 5e-4, source="Ohno 2013"))
    for name, expected in PUBLISHED_VALUES["alpha_opic"]["melanopic_daylight_efficacy_ratio"].items():
        got = daylight_ratio(power_at_1_nm(illuminant(name, "")))[RECEPTORS.index("melanopic")]
        # Printed to four places; tables at 5 nm, and from 360 or 380 nm on, differ by the same amount.
        rows.append(Case("Colorimetry", name, "melanopic daylight efficacy ratio", expected, float(got),
                         1e-3 * expected, source="CIE S 026:2018"))
    return rows


def alpha_opic_efficacies(_folder: Path) -> list[Case]:
    """The five α-opic efficacies of four illuminants."""
    rows = []
    for name, published in PUBLISHED_VALUES["alpha_opic"]["efficacies_mW_per_lm"].items():
        got = 1000 * efficacy(power_at_1_nm(illuminant(name, "")))
        for receptor, expected, value in zip(RECEPTORS, published, got, strict=True):
            # Four places are printed. D55 and D75 may have coefficients rounded to three places: 5e-4 on each
            # of two terms.
            tolerance = (1e-3 if name in ("D55", "D75") else 2e-4) * expected + 5e-5
            rows.append(Case("Colorimetry", name, f"{receptor.replace('_', '-')} efficacy", expected,
                             float(value), tolerance, "mW/lm",
                             "CIE S 026:2018; F. Rudawski, Lighting Toolbox"))
    return rows
