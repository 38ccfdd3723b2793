"""Readings in RGB against readings in 31 bands, for a thousand colours and all measured chips.

In an infinite room, direct illuminance E_D becomes E_D / (1 − ρ) (Sumpner) in each band. A meshed room takes
its place in studies/repainted_room.py.
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
"""Methods from RGB to a spectrum: those of scene files, and the combination of eigenvectors limited to 0 …
1."""
MODELS = ("rgb", "equal weights", "prefiltered")
"""Models with three bands: RGB, RGB with equal parts of light, RGB prefiltered with the lamps' light."""
MAX_REFLECTANCE = 0.9
"""Largest reflectance for the upper bounds: that of the thousand colours; the chips' is 0.84."""
TOLERANCES = (0.05, 0.1, 0.2)
NAMED_COLOURS = {"red": (0.9, 0, 0), "green": (0, 0.9, 0), "blue": (0, 0, 0.9),
         "cyan": (0, 0.9, 0.9), "magenta": (0.9, 0, 0.9), "yellow": (0.9, 0.9, 0)}


@dataclass(frozen=True)
class PaintableRoom:
    """A room with readings as functions of the reflectance of its painted surfaces.

    bands : the band sets "rgb", "rgb-prefiltered" and "31" under its lamps
    shares : (n_bands,) of the lamps' lumens, by band set
    readings : their names
    gains : function from a band set's name and reflectances (n, n_bands) to readings (n_readings, n, n_bands)
        per unit of direct light in each band [lx or cd/m²]
    """

    title: str
    bands: dict[str, BandSet]
    shares: dict[str, np.ndarray]
    readings: tuple[str, ...]
    gains: Callable[[str, np.ndarray], np.ndarray]

    @property
    def shown(self) -> tuple[int, int]:
        """Indices of the readings in tables and charts: the first, and the luminance."""
        return 0, len(self.readings) - 1

    def read(self, model: str, reflectance: np.ndarray) -> np.ndarray:
        """Readings (n_readings, n) by "31" or one of MODELS, for reflectances (n, n_bands)."""
        name = {"equal weights": "rgb", "prefiltered": "rgb-prefiltered"}.get(model, model)
        shares = np.full(3, 1 / 3) if model == "equal weights" else self.shares[name]
        used = shares > 0  # a band without light adds nothing, even for a reflectance of 1
        return self.gains(name, reflectance)[..., used] @ shares[used]


def sumpner(lamp: Spectrum, primaries: np.ndarray = XYZ_TO_SHARP) -> PaintableRoom:
    """The infinite room: E_T = E_D/(1 − ρ) and L = ρE_T/π for 1 lx of direct light.

    primaries : (3, 3) from XYZ to the prefiltered bands
    """
    three = prefiltered(mean_light([lamp], [1.0]), primaries)
    bands = {"rgb": band_set("rgb"), "rgb-prefiltered": three, "31": band_set("31")}
    shares = {name: band_flux(lamp, 1.0, b, "the lamp") * b.luminous for name, b in bands.items()}

    def gains(_name: str, reflectance: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore"):
            total = 1 / (1 - reflectance)
            return np.stack([total, reflectance * total / np.pi])

    return PaintableRoom("Infinite room", bands, shares, ("total illuminance", "surface luminance"),
                         gains)


@dataclass(frozen=True)
class Spectra:
    """Reflectances of paints in each band set.

    rgb : (n, 3) linear BT.709, as given or as measured
    spectral : (n, 31)
    filtered : (n, 3) in the prefiltered bands
    """

    names: list[str]
    rgb: np.ndarray
    spectral: np.ndarray
    filtered: np.ndarray

    def of(self, model: str) -> np.ndarray:
        """Reflectances (n, n_bands) in a model."""
        return {"31": self.spectral, "prefiltered": self.filtered}.get(model, self.rgb)


def spectra_in(place: PaintableRoom, names: list[str], nm: np.ndarray, reflectance: np.ndarray,
               rgb: np.ndarray | None = None) -> Spectra:
    """Reflectance curves (n, k) at nm (k,) [nm] in the band sets of a room; rgb : (n, 3) for paints given as
    RGB."""
    fine = np.stack([np.interp(cie_1931()[0], nm, curve) for curve in reflectance])
    three = place.bands["rgb-prefiltered"]
    own = reflectances_in_three(fine @ place.bands["rgb"].filters, place.bands["rgb"])
    return Spectra(names, own if rgb is None else rgb,
                   np.clip(band_average(nm, reflectance.T, place.bands["31"].edges).T, 0.0, 1.0),
                   reflectances_in_three(fine @ three.filters, three))


@dataclass(frozen=True)
class Gamut:
    """All comparisons in one room.

    methods : the thousand colours by each method from RGB to a spectrum
    chips : the measured chips
    """

    place: PaintableRoom
    methods: dict[str, Spectra]
    chips: Spectra

    def compared(self, spectra: Spectra, model: str) -> tuple[np.ndarray, np.ndarray]:
        """Readings (n_readings, n) in a model and in 31 bands."""
        return (self.place.read(model, spectra.of(model)), self.place.read("31", spectra.spectral))

    def ratios(self, spectra: Spectra, model: str) -> np.ndarray:
        """Spectral over RGB readings (n_readings, n); 1 where both are 0, as for black."""
        return ratio(*self.compared(spectra, model))


def ratio(rgb: np.ndarray, spectral: np.ndarray) -> np.ndarray:
    """Spectral over RGB; 1 where both are 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((rgb == 0) & (spectral == 0), 1.0, spectral / rgb)


def rgb_errors(ratios: np.ndarray) -> np.ndarray:
    """100 (RGB ÷ 31 bands − 1) [%] from ratios of 31 bands to RGB; infinite where only RGB has light."""
    with np.errstate(divide="ignore"):
        return 100 * (1 / ratios - 1)


def chips_finding(gamut: Gamut) -> str:
    """One sentence on the measured paints: the share that RGB gets right to 5 %, and the worst paint."""
    errors = rgb_errors(gamut.ratios(gamut.chips, "rgb")[0])
    worst = int(np.abs(errors).argmax())
    return (f"{gamut.place.title}, {gamut.place.readings[0]}: RGB is right to 5 % for "
            f"{(np.abs(errors) <= 5).mean():.1%} of {len(errors):,} measured paints; it is worst for "
            f"{gamut.chips.names[worst]}, {in_words(errors[worst])}.")


def analyse(place: PaintableRoom) -> Gamut:
    """The thousand colours by all methods, and the chips, in one room."""
    rgb = cube()
    names = [f"{r:.1f} {g:.1f} {b:.1f}" for r, g, b in rgb]
    methods = {name: spectra_in(place, names, *method(rgb), rgb) for name, method in METHODS.items()}
    chips, nm, reflectance = munsell_chips()
    return Gamut(place, methods, spectra_in(place, chips, nm, reflectance))


def shares_of_right(ratios: np.ndarray) -> np.ndarray:
    """Shares (…, 3) of ratios (…, n) within ±5, 10 and 20 % of 1."""
    return np.stack([(np.abs(ratios - 1) <= t + 1e-9).mean(axis=-1) for t in TOLERANCES], axis=-1)


def continuum() -> tuple[np.ndarray, np.ndarray]:
    """Weights from reflectances, at each nm where D65 has light, to linear BT.709 (3, k) and to luminous
    reflectance (k,)."""
    _, functional = bt709_under_d65()
    light = cie_1931()[1][:, 1] * d65()[1]
    lit = light > 0
    return functional[lit].T, light[lit] / light.sum()


def smallest_ratios(place: PaintableRoom, rgb: np.ndarray) -> np.ndarray:
    """Certified smallest ratio (2 readings, n) to RGB over all spectra 0 ≤ ρ < 1 of each colour (n, 3).

    It holds for the infinite room under D65, at 1 nm; with fewer bands the range of spectra is smaller. The
    luminance is (E_T − E_D)/π, so both readings have the same extreme spectra.
    """
    low, _ = lowest_sum(rgb, *continuum())
    return _to_rgb(place, rgb, low)


def largest_ratios(place: PaintableRoom, rgb: np.ndarray, ceiling: float = MAX_REFLECTANCE) -> np.ndarray:
    """Certified largest ratio (2 readings, n) over all spectra 0 ≤ ρ ≤ ceiling; otherwise as in
    `smallest_ratios`. Without a ceiling the ratio has no limit."""
    return _to_rgb(place, rgb, highest_sum(rgb @ LUMINANCE_WEIGHTS, ceiling))


def _to_rgb(place: PaintableRoom, rgb: np.ndarray, total: np.ndarray) -> np.ndarray:
    by_rgb = place.read("rgb", rgb)
    # Black has no luminance; for other colours a bound below 1 is rounding.
    surface = np.where(by_rgb[1] > 0, np.maximum(total - 1, 0) / np.pi, 0.0)
    return ratio(by_rgb, np.stack([total, surface]))


BOUND_CLASSES = ("safe beyond doubt", "RGB can only be too low", "RGB can only be too high", "either",
           "unsafe beyond doubt")


def classify(low: np.ndarray, high: np.ndarray, tolerance: float = 0.2) -> np.ndarray:
    """Index into BOUND_CLASSES of intervals of ratios, low to high, for a tolerance around 1."""
    down, up = low < 1 - tolerance, high > 1 + tolerance
    outside = (low > 1 + tolerance) | (high < 1 - tolerance)
    return np.where(outside, 4, down * 2 + up * 1)
