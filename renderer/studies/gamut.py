"""Luminance by RGB against luminance by 31 bands: a thousand colours, and every measured chip.

The deck's room is infinitely wide, so light E_D that arrives straight from the lamps becomes
E_D / (1 − ρ) (Sumpner), band by band. A meshed room takes its place in studies/room.py.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from renderer.colour.bands import (
    LUMINANCE_WEIGHTS,
    XYZ_TO_SHARP,
    BandSet,
    band_average,
    band_set,
    bt709_under_d65,
    prefiltered,
)
from renderer.colour.bounds import highest_sum, lowest_sum
from renderer.colour.lamps import band_flux, mean_light
from renderer.colour.materials import reflectances_in_three
from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import cie_1931, d65, munsell_chips
from renderer.colour.upsampling import UPSAMPLING, clipped_eigen, cube
from renderer.readings.finding import in_words

METHODS = {**UPSAMPLING, "eigen-clipped": clipped_eigen}
"""Ways from RGB to a spectrum: those a scene may name, and the deck's merely cut off."""
MODELS = ("rgb", "equal weights", "prefiltered")
"""Three bands: as software has them; with the deck's equal weights; filtered with the lamps' light."""
CEILING = 0.9
"""Largest reflectance for the upper bound: the grid's own; the chips' largest is 0.84."""
TOLERANCES = (0.05, 0.1, 0.2)
NAMED = {"red": (0.9, 0, 0), "green": (0, 0.9, 0), "blue": (0, 0, 0.9),
         "cyan": (0, 0.9, 0.9), "magenta": (0.9, 0, 0.9), "yellow": (0.9, 0.9, 0)}
ILLUMINANCE, LUMINANCE = "total illuminance", "surface luminance"


@dataclass(frozen=True)
class Place:
    """Where light bounces: what a reading there becomes when surfaces take a reflectance.

    bands : the band sets "rgb", "rgb-prefiltered" and "31" under its lamps
    shares : of their lumens in each band, by band set (n_bands,)
    readings : names of what is read
    gains : from a band set's name and reflectances (n, n_bands) to readings per unit of direct light
        in each band (n_readings, n, n_bands) [lx or cd/m²]
    """

    title: str
    bands: dict[str, BandSet]
    shares: dict[str, np.ndarray]
    readings: tuple[str, ...]
    gains: Callable[[str, np.ndarray], np.ndarray]

    @property
    def shown(self) -> tuple[int, int]:
        """The readings that tables and charts show: the first, and the luminance."""
        return 0, len(self.readings) - 1

    def read(self, model: str, reflectance: np.ndarray) -> np.ndarray:
        """Readings (n_readings, n) by "31" or one of MODELS, of reflectances (n, n_bands)."""
        name = {"equal weights": "rgb", "prefiltered": "rgb-prefiltered"}.get(model, model)
        shares = np.full(3, 1 / 3) if model == "equal weights" else self.shares[name]
        used = shares > 0  # light that is not there makes nothing, even of reflectance 1
        return self.gains(name, reflectance)[..., used] @ shares[used]


def sumpner(lamp: Spectrum, primaries: np.ndarray = XYZ_TO_SHARP) -> Place:
    """The deck's room: E_T = E_D/(1 − ρ), L = ρE_T/π, for 1 lx of direct light.

    primaries : of the prefiltered bands (3, 3), from XYZ.
    """
    three = prefiltered(mean_light([lamp], [1.0]), primaries)
    bands = {"rgb": band_set("rgb"), "rgb-prefiltered": three, "31": band_set("31")}
    shares = {name: band_flux(lamp, 1.0, b, "the lamp") * b.luminous for name, b in bands.items()}

    def gains(_name: str, reflectance: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore"):
            total = 1 / (1 - reflectance)
            return np.stack([total, reflectance * total / np.pi])

    return Place("Infinite room", bands, shares, (ILLUMINANCE, LUMINANCE), gains)


@dataclass(frozen=True)
class Spectra:
    """Reflectances of many surfaces in each band set.

    rgb : (n, 3) linear BT.709 of each, as asked or as measured
    """

    names: list[str]
    rgb: np.ndarray
    spectral: np.ndarray
    filtered: np.ndarray

    def of(self, model: str) -> np.ndarray:
        """What a model takes for reflectance (n, n_bands)."""
        return {"31": self.spectral, "prefiltered": self.filtered}.get(model, self.rgb)


def spectra_in(place: Place, names: list[str], nm: np.ndarray, reflectance: np.ndarray,
               rgb: np.ndarray | None = None) -> Spectra:
    """Curves (n, k) at nm (k,), each in every band set of a place; `rgb` where it was given first."""
    fine = np.stack([np.interp(cie_1931()[0], nm, curve) for curve in reflectance])
    three = place.bands["rgb-prefiltered"]
    own = reflectances_in_three(fine @ place.bands["rgb"].filters, place.bands["rgb"])
    return Spectra(names, own if rgb is None else rgb,
                   np.clip(band_average(nm, reflectance.T, place.bands["31"].edges).T, 0.0, 1.0),
                   reflectances_in_three(fine @ three.filters, three))


@dataclass(frozen=True)
class Gamut:
    """Every comparison in one place.

    methods : the thousand colours by each way to a spectrum; chips : the measured ones
    """

    place: Place
    methods: dict[str, Spectra]
    chips: Spectra

    def compared(self, spectra: Spectra, model: str) -> tuple[np.ndarray, np.ndarray]:
        """Readings (n_readings, n) by a model and by 31 bands."""
        return (self.place.read(model, spectra.of(model)), self.place.read("31", spectra.spectral))

    def ratios(self, spectra: Spectra, model: str) -> np.ndarray:
        """Spectral over RGB (n_readings, n), the deck's ε; 1 where both are 0, as for black."""
        return ratio(*self.compared(spectra, model))


def ratio(rgb: np.ndarray, spectral: np.ndarray) -> np.ndarray:
    """Spectral over RGB; 1 where both are 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((rgb == 0) & (spectral == 0), 1.0, spectral / rgb)


def rgb_errors(ratios: np.ndarray) -> np.ndarray:
    """100 (RGB ÷ 31 bands − 1) [%] from ratios of 31 bands to RGB; infinite where RGB alone has light."""
    with np.errstate(divide="ignore"):
        return 100 * (1 / ratios - 1)


def chips_finding(gamut: Gamut) -> str:
    """One sentence on the measured paints: how many RGB gets right to 5 %, and which it gets most wrong."""
    errors = rgb_errors(gamut.ratios(gamut.chips, "rgb")[0])
    worst = int(np.abs(errors).argmax())
    return (f"{gamut.place.title}, {gamut.place.readings[0]}: RGB is right to 5 % for "
            f"{(np.abs(errors) <= 5).mean():.1%} of {len(errors):,} measured paints; it is worst for "
            f"{gamut.chips.names[worst]}, {in_words(errors[worst])}.")


def analyse(place: Place) -> Gamut:
    """The thousand colours by every method, and the chips, in one place."""
    rgb = cube()
    names = [f"{r:.1f} {g:.1f} {b:.1f}" for r, g, b in rgb]
    methods = {name: spectra_in(place, names, *method(rgb), rgb) for name, method in METHODS.items()}
    chips, nm, reflectance = munsell_chips()
    return Gamut(place, methods, spectra_in(place, chips, nm, reflectance))


def within(ratios: np.ndarray) -> np.ndarray:
    """Shares of the last axis within ±5, 10 and 20 % (…, 3)."""
    return np.stack([(np.abs(ratios - 1) <= t + 1e-9).mean(axis=-1) for t in TOLERANCES], axis=-1)


def continuum() -> tuple[np.ndarray, np.ndarray]:
    """At each nm where D65 has light: weights that take reflectances to linear BT.709 (3, k), and to
    luminous reflectance (k,)."""
    _, functional = bt709_under_d65()
    light = cie_1931()[1][:, 1] * d65()[1]
    lit = light > 0
    return functional[lit].T, light[lit] / light.sum()


def smallest_ratios(place: Place, rgb: np.ndarray) -> np.ndarray:
    """Certified smallest ratio (2 readings, n) to RGB of any spectrum 0 ≤ ρ < 1 of each colour (n, 3),
    in the infinite room under D65, at 1 nm: with fewer bands a spectrum has less choice.

    The luminance is (E_T − E_D)/π, so both readings have the same extreme spectra.
    """
    low, _ = lowest_sum(rgb, *continuum())
    return _to_rgb(place, rgb, low)


def largest_ratios(place: Place, rgb: np.ndarray, ceiling: float = CEILING) -> np.ndarray:
    """The same of the largest ratio, over 0 ≤ ρ ≤ ceiling: without one it has no limit."""
    return _to_rgb(place, rgb, highest_sum(rgb @ LUMINANCE_WEIGHTS, ceiling))


def _to_rgb(place: Place, rgb: np.ndarray, total: np.ndarray) -> np.ndarray:
    by_rgb = place.read("rgb", rgb)
    # Black has no luminance; elsewhere a bound below 1 is rounding.
    surface = np.where(by_rgb[1] > 0, np.maximum(total - 1, 0) / np.pi, 0.0)
    return ratio(by_rgb, np.stack([total, surface]))


CLASSES = ("safe beyond doubt", "RGB can only be too low", "RGB can only be too high", "either",
           "unsafe beyond doubt")


def classify(low: np.ndarray, high: np.ndarray, tolerance: float = 0.2) -> np.ndarray:
    """Which of CLASSES an interval of ratios is in, against ± tolerance."""
    down, up = low < 1 - tolerance, high > 1 + tolerance
    outside = (low > 1 + tolerance) | (high < 1 - tolerance)
    return np.where(outside, 4, down * 2 + up * 1)
