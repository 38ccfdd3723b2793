"""OpenEXR files: luminance, and spectral radiance in the layout of Fichet et al.

A. Fichet, R. Pacanowski, A. Wilkie, "An OpenEXR Layout for Spectral Images", JCGT 10(3), 2021:
channels S0.<wavelength>nm with a comma for the point, spectralLayoutVersion and emissiveUnits.
"""

from io import BytesIO
from pathlib import Path

import numpy as np

from renderer.colour.bands import XYZ_TO_BT709, BandSet
from renderer.system.files import whole_file

CHROMATICITIES = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


def save_luminance(luminance: np.ndarray, path: Path) -> Path:
    """Write luminance (height, width) [cd/m²] as the one channel Y."""
    return _save({"Y": luminance}, {"comments": "Y is luminance in cd/m2"}, path)


def save_spectral(radiance: np.ndarray, bands: BandSet, path: Path) -> Path:
    """Write spectral radiance (height, width, n_bands) [W m⁻² sr⁻¹ nm⁻¹], with RGB to look at."""
    channels = {f"S0.{nm:.6f}nm".replace(".", ",").replace("S0,", "S0."): radiance[..., k]
                for k, nm in enumerate(bands.centres)}
    rgb = radiance @ (bands.widths[:, None] * bands.xyz / bands.watts[:, None]) @ XYZ_TO_BT709.T
    channels |= {name: rgb[..., k] for k, name in enumerate("RGB")}
    header = {"spectralLayoutVersion": "1.0", "emissiveUnits": "W.m^-2.sr^-1",
              "comments": "S0 is spectral radiance in W/(m2 sr nm), the mean over 10 nm; "
                          "RGB is linear BT.709 in cd/m2",
              "chromaticities": CHROMATICITIES}
    return _save(channels, header, path)


def _save(channels: dict[str, np.ndarray], header: dict, path: Path) -> Path:
    import OpenEXR

    pixels = {name: np.ascontiguousarray(plane, dtype=np.float32)
              for name, plane in channels.items()}
    # Light varies in its last digits everywhere: ZIPS takes many times as long for 6 % less.
    header = {"compression": OpenEXR.NO_COMPRESSION, "type": OpenEXR.scanlineimage, **header}
    # In memory first: OpenEXR takes no name that is not UTF-8, and its errors do not tell a full disk.
    written = BytesIO()
    with OpenEXR.File(header, pixels) as file:
        file.write(written)
    with whole_file(path) as part:
        part.write_bytes(written.getbuffer())
    return path
