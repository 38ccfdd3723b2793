"""The reading of a photometer."""

from dataclasses import dataclass, field

import numpy as np

from renderer.colour.bands import BandSet
from renderer.readings.alpha_opic import RECEPTORS, equivalent_daylight
from renderer.readings.colorimetry import COLOUR, chromaticity, colour_of, colour_temperature
from renderer.readings.finding import of_reading, rgb_error_percent
from renderer.readings.uncertainty import Figure
from renderer.system.lazy import cached_property


@dataclass(frozen=True)
class Reading:
    """The reading of a photometer; arrays by band are (n_bands,), in the band set's unit per m².

    direct, indirect : irradiance by the luminaires, and by the surfaces
    power : (471,) spectral irradiance [W m⁻² nm⁻¹] at 360–830 nm, 1 nm; None where the bands give no spectrum
    watts : (n_bands,) irradiance [W m⁻²]; None where the bands give no spectrum
    mesh_error, sampling_error : 95 % half-widths of the total illuminance [lx]
    band_error : difference from the illuminance in bands of 2 nm with equal inputs [lx]
    by_surface_lx : (n_surfaces,) illuminance by each surface [lx], in the order of Scene.surfaces
    by_surface : (n_surfaces, n_bands) irradiance by each surface; None for a reading by paths
    rgb_lx : total illuminance in RGB on the same transport [lx], for readings in 31 bands; else None
    """

    name: str
    position: np.ndarray
    normal: np.ndarray
    direct: np.ndarray
    indirect: np.ndarray
    power: np.ndarray | None
    watts: np.ndarray | None
    bands: BandSet
    mesh_error: float
    sampling_error: float
    band_error: float
    by_surface_lx: np.ndarray
    by_surface: np.ndarray | None = field(default=None, repr=False)
    rgb_lx: float | None = None

    def __repr__(self) -> str:
        return (f"Reading({self.name!r}: {self.total_lx:.2f} ± {self.uncertainty:.2g} lx, of which "
                f"{self.indirect_lx:.2f} indirect; {self.bands.name} bands)")

    @property
    def figure(self) -> Figure:
        """The total illuminance with its error bar [lx]."""
        return Figure(self.name, self.total_lx, self.mesh_error, self.sampling_error)

    @property
    def uncertainty(self) -> float:
        """95 % half-width of the total illuminance [lx]: mesh and sampling together."""
        return self.figure.uncertainty

    @property
    def total(self) -> np.ndarray:
        """Irradiance in each band (n_bands,)."""
        return self.direct + self.indirect

    @property
    def direct_lx(self) -> float:
        """Direct illuminance, by the luminaires [lx]."""
        return float(self.direct @ self.bands.luminous)

    @property
    def indirect_lx(self) -> float:
        """Indirect illuminance, by the surfaces [lx]."""
        return float(self.indirect @ self.bands.luminous)

    @property
    def total_lx(self) -> float:
        """Illuminance [lx]."""
        return self.direct_lx + self.indirect_lx

    @property
    def rgb_error_percent(self) -> float | None:
        """100 (RGB ÷ 31 bands − 1) of the total illuminance [%]; None if dark or not known."""
        return None if self.rgb_lx is None else rgb_error_percent(self.rgb_lx, self.total_lx)

    @property
    def rgb_error_bar_percent(self) -> float | None:
        """95 % half-width of `rgb_error_percent` [%]; None if dark or not known."""
        return None if self.rgb_error_percent is None else of_reading(self)[0].bar_percent

    @cached_property
    def _colour(self) -> dict:
        """Chromaticity, colour temperature and rendering; None for quantities that the bands cannot give."""
        if self.bands.filters is not None:
            xy = chromaticity(self.total, self.bands)
            known = dict(zip(COLOUR, (xy, *colour_temperature(xy)), strict=False))
            return {**dict.fromkeys(COLOUR), **known}
        if self.power is None or not self.total_lx > 0:
            return dict.fromkeys(COLOUR)
        return colour_of(self.power)

    @property
    def xy(self) -> tuple[float, float] | None:
        """CIE 1931 chromaticity; None where there is no light, or the bands carry no colour."""
        return None if self._colour["xy"] is None else tuple(self._colour["xy"])

    @property
    def cct(self) -> float | None:
        """Correlated colour temperature [K]; None where it has no meaning."""
        return self._colour["cct_K"]

    @property
    def duv(self) -> float | None:
        """Distance from the Planckian locus, positive above it; None where there is no light."""
        return self._colour["duv"]

    @property
    def cri(self) -> float | None:
        """CIE R_a of the light that arrives; None where it is not white, or the bands give no spectrum."""
        return self._colour["cri_ra"]

    @property
    def tm30(self) -> tuple[float | None, float | None] | None:
        """ANSI/IES TM-30 R_f and R_g; None where the light is not white, or the bands give no spectrum."""
        found = self._colour["tm30_rf"], self._colour["tm30_rg"]
        return None if found == (None, None) else found

    @property
    def alpha_opic(self) -> dict[str, float] | None:
        """α-opic equivalent daylight illuminances [lx] by receptor (CIE S 026); None where the bands give no
        spectrum."""
        if self.power is None:
            return None
        return dict(zip(RECEPTORS, map(float, equivalent_daylight(self.power)), strict=True))
