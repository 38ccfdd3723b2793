"""OpenEXR files of luminance and of spectral radiance.

Spectral files have the layout of A. Fichet, R. Pacanowski and A. Wilkie, "An OpenEXR Layout for Spectral
Images", JCGT 10(3), 2021: channels S0.<wavelength>nm with a decimal comma, spectralLayoutVersion and
emissiveUnits.
"""

from io import BytesIO
from pathlib import Path

import numpy as np

from renderer.colour.bands import XYZ_TO_BT709, BandSet
from renderer.system.files import whole_file


def save_luminance(luminance: np.ndarray, path: Path) -> Path:
    """Write luminance (height, width) [cd/m²] as the only channel, Y."""
    return _save({"Y": luminance}, {"comments": "Y is luminance in cd/m2"}, path)


def save_spectral(radiance: np.ndarray, bands: BandSet, path: Path) -> Path:
    """Write spectral radiance (height, width, n_bands) [W m⁻² sr⁻¹ nm⁻¹], and its RGB for viewers."""
    channels = {f"S0.{nm:.6f}nm".replace(".", ",").replace("S0,", "S0."): radiance[..., k]
                for k, nm in enumerate(bands.centres)}
    rgb = radiance @ (bands.widths[:, None] * bands.xyz / bands.watts[:, None]) @ XYZ_TO_BT709.T
    channels |= {name: rgb[..., k] for k, name in enumerate("RGB")}
    header = {"spectralLayoutVersion": "1.0", "emissiveUnits": "W.m^-2.sr^-1",
              "comments": "S0 is spectral radiance in W/(m2 sr nm), the mean over 10 nm; "
                          "RGB is linear BT.709 in cd/m2",
              "chromaticities": (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)}  # BT.709, D65
    return _save(channels, header, path)


def _save(channels: dict[str, np.ndarray], header: dict, path: Path) -> Path:
    import OpenEXR

    pixels = {name: np.ascontiguousarray(plane, dtype=np.float32)
              for name, plane in channels.items()}
    # Not compressed: ZIPS saves only 6 % of files with noise in the last digits, and is slow.
    header = {"compression": OpenEXR.NO_COMPRESSION, "type": OpenEXR.scanlineimage, **header}
    # Written to memory first, because OpenEXR refuses names that are not UTF-8 and does not report a full
    # disk.
    written = BytesIO()
    with OpenEXR.File(header, pixels) as file:
        file.write(written)
    with whole_file(path) as part:
        part.write_bytes(written.getbuffer())
    return path
