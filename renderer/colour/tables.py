"""The package's tables of spectra (data/README.md), and the command that computes some of them.

`python -m renderer.colour.tables` writes cie_1nm.csv, cie_illuminants.csv and colour_rendering_1nm.csv.gz in
data/ from colour-science, and munsell_eigenvectors.csv from the measured chips.
"""

from functools import cache
from pathlib import Path

import numpy as np

DATA = Path(__file__).parent / "data"


@cache
def _table(name: str) -> np.ndarray:
    return np.loadtxt(DATA / name, delimiter=",", skiprows=1)


@cache
def cie_1931() -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths (471,) [nm], 360–830, and the CIE 1931 2° observer x̄ȳz̄ (471, 3)."""
    table = _table("cie_1nm.csv")
    return table[:, 0], table[:, 1:4]


@cache
def d65() -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths (471,) [nm] and CIE illuminant D65 (471,), relative; 0 where not tabulated."""
    table = _table("cie_1nm.csv")
    return table[:, 0], table[:, 4]


def cie_illuminants() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """The CIE illuminants by name, as `cie_illuminant`."""
    return {name: cie_illuminant(name) for name in illuminant_columns()}


@cache
def illuminant_columns() -> dict[str, int]:
    """Column of each CIE illuminant in the package's table, by name."""
    with (DATA / "cie_illuminants.csv").open(encoding="utf-8") as file:
        _, *names = file.readline().strip().split(",")
    return {name: k for k, name in enumerate(names, 1)}


@cache
def cie_illuminant(name: str) -> tuple[np.ndarray, np.ndarray]:
    """A CIE illuminant: wavelengths (k,) [nm] at 1 nm over the tabulated range, and relative power (k,).

    The tables have steps of 5 nm. Between them the D series is linear (CIE 15:2018, 4.1); the others follow
    Sprague's formula (CIE 15:2018, 7.2.1; CIE 167:2005), with negative values removed.
    """
    table, k = _table("cie_illuminants.csv"), illuminant_columns()[name]
    nm, power = table[~np.isnan(table[:, k])][:, [0, k]].T
    return _at_1_nm(nm, power, linear=name.startswith(("D", "ID")))


def _at_1_nm(nm: np.ndarray, power: np.ndarray, linear: bool) -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths [nm] and power at every 1 nm, from a table of even steps whose samples stay unchanged."""
    fine = np.arange(nm[0], nm[-1] + 0.5)
    if linear:
        return fine, np.interp(fine, nm, power)
    steps = (len(fine) - 1) // (len(nm) - 1)
    return fine, _not_below_0(_sprague(power, steps), steps)


def _not_below_0(power: np.ndarray, steps: int) -> np.ndarray:
    """Power (n,) without the negative values that Sprague's quintic has beside a spectral line.

    Each negative value is divided between its neighbours until these absorb it, so that the sum and the
    centre of the power stay the same. Every `steps`-th sample is the table's own and stays unchanged.
    """
    kept = np.arange(len(power)) % steps == 0
    at = np.flatnonzero(~kept)
    if (power[kept] < 0).any() or not (power[at] < 0).any():
        return power
    gaps = np.diff(at, prepend=at[0] - 1, append=at[-1] + 1)
    upward = gaps[:-1] / (gaps[:-1] + gaps[1:])
    padded = np.pad(power[at], 1)
    while (padded < 0).any():
        below = np.minimum(padded[1:-1], 0.0)
        padded = np.maximum(padded, 0.0)
        padded[2:] += below * upward
        padded[:-2] += below * (1 - upward)
        padded[[0, -1]] = 0.0
        padded[np.abs(padded) < 1e-12 * power.max()] = 0.0
    result = power.copy()
    result[at] = padded[1:-1]
    return result


def _sprague(values: np.ndarray, steps: int) -> np.ndarray:
    """Values (steps (n − 1) + 1,) interpolated by Sprague's quintic, `steps` from each given value (n,) to
    the next.

    Between the third and the fourth of six values the quintic is Σ aⱼ tʲ with a = quintic @ values; two
    values past each end are extension @ the six end values (CIE 167:2005, eqs. 3 and 4).
    """
    quintic = np.array([[0, 0, 24, 0, 0, 0], [2, -16, 0, 16, -2, 0], [-1, 16, -30, 16, -1, 0],
                        [-9, 39, -70, 66, -33, 7], [13, -64, 126, -124, 61, -12],
                        [-5, 25, -50, 50, -25, 5]]) / 24
    extension = np.array([[884, -1960, 3033, -2648, 1080, -180], [508, -540, 488, -367, 144, -24]]) / 209
    before, after = extension @ values[:6], extension[::-1] @ values[:-7:-1]
    padded = np.concatenate([before, values, after])
    six = np.lib.stride_tricks.sliding_window_view(padded, 6)
    t = np.arange(steps) / steps
    between = (six @ quintic.T) @ t ** np.arange(6)[:, None]
    return np.append(between.ravel(), values[-1])


def cie_1964() -> np.ndarray:
    """The CIE 1964 10° observer x̄ȳz̄ (471, 3) at 360–830 nm, 1 nm."""
    return _rendering()[:, 1:4]


def daylight_series() -> np.ndarray:
    """S0, S1 and S2 of the CIE D series (471, 3) at 360–830 nm, 1 nm, linear between samples of 5 nm (CIE
    15:2018)."""
    return _rendering()[:, 4:7]


def cri_samples() -> np.ndarray:
    """Radiance factors (14, 471) of the test colours of CIE 13.3 at 360–830 nm, 1 nm."""
    return _rendering()[:, 7:21].T


def evaluation_samples() -> np.ndarray:
    """Radiance factors (99, 401) of the colour evaluation samples of ANSI/IES TM-30-18 and CIE 224:2017 at
    380–780 nm, 1 nm."""
    return _rendering()[20:421, 21:].T


@cache
def _rendering() -> np.ndarray:
    return _table("colour_rendering_1nm.csv.gz")


@cache
def alpha_opic_action() -> np.ndarray:
    """α-opic action spectra of CIE S 026:2018 (471, 5) at 360–830 nm, 1 nm: S-cone, M-cone, L-cone, rhodopic,
    melanopic; 0 where not tabulated."""
    table, (nm, _) = _table("cie_s026_alpha_opic_1nm.csv"), cie_1931()
    return np.column_stack([np.interp(nm, table[:, 0], column, left=0.0, right=0.0)
                            for column in table.T[1:]])


@cache
def munsell_chips() -> tuple[list[str], np.ndarray, np.ndarray]:
    """Notations (1269), wavelengths (81,) [nm] and reflectances (1269, 81) of the matte Munsell chips."""
    raw = np.loadtxt(DATA / "munsell_matte_1269.csv.gz", delimiter=",", dtype=str)
    return raw[1:, 0].tolist(), raw[0, 1:].astype(float), raw[1:, 1:].astype(float)


@cache
def munsell_eigenvectors() -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths (81,) [nm] and the first three eigenvectors (81, 3) of the chips' spectra."""
    table = _table("munsell_eigenvectors.csv")
    return table[:, 0], table[:, 1:4]


def _write_cie() -> None:
    import colour

    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    source = colour.SDS_ILLUMINANTS["D65"]
    nm = observer.wavelengths
    # CIE 15:2018: D65 is interpolated linearly between its tabulated values.
    power = np.interp(nm, source.wavelengths, source.values, left=0.0, right=0.0)
    np.savetxt(DATA / "cie_1nm.csv", np.column_stack([nm, observer.values, power]), fmt="%.10g",
               delimiter=",", header="wavelength_nm,x_bar,y_bar,z_bar,D65", comments="")


def _write_illuminants() -> None:
    import colour

    nm = np.arange(300, 831, 5)
    names = [name for name in colour.SDS_ILLUMINANTS if not name.startswith("ISO")]
    columns = []
    for name in names:
        source = dict(zip(colour.SDS_ILLUMINANTS[name].wavelengths, colour.SDS_ILLUMINANTS[name].values,
                          strict=True))
        columns.append([source.get(float(at), np.nan) for at in nm])
    np.savetxt(DATA / "cie_illuminants.csv", np.column_stack([nm, *columns]), fmt="%.10g", delimiter=",",
               header=",".join(["wavelength_nm", *names]), comments="")


def _write_rendering() -> None:
    import colour
    from colour.quality.cfi2017 import load_TCS_CIE2017
    from colour.quality.cri import SDS_TCS

    observer = colour.MSDS_CMFS["CIE 1964 10 Degree Standard Observer"]
    nm, samples = observer.wavelengths, load_TCS_CIE2017(colour.SpectralShape(380, 780, 1)).values
    basis = colour.colorimetry.SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES
    series = [basis[name] for name in ("S0", "S1", "S2")]
    linear = [np.interp(nm, sd.wavelengths, sd.values)
              for sd in (*series, *[*SDS_TCS["CIE 1995"].values()][:14])]
    samples = np.pad(samples, ((20, 50), (0, 0)))
    names = ["S0", "S1", "S2", *(f"TCS{k:02}" for k in range(1, 15)), *(f"CES{k:02}" for k in range(1, 100))]
    np.savetxt(DATA / "colour_rendering_1nm.csv.gz", np.column_stack([nm, observer.values, *linear, samples]),
               fmt="%.7g", delimiter=",", header=",".join(["wavelength_nm,x10_bar,y10_bar,z10_bar", *names]),
               comments="")


def _write_eigenvectors() -> None:
    _, nm, reflectance = munsell_chips()
    # Not centred on the mean: black is then the combination with all coefficients 0.
    _, _, rows = np.linalg.svd(reflectance, full_matrices=False)
    vectors = rows[:3].T * np.sign(rows[:3].sum(axis=1))
    np.savetxt(DATA / "munsell_eigenvectors.csv", np.column_stack([nm, vectors]), fmt="%.10g",
               delimiter=",", header="wavelength_nm,v1,v2,v3", comments="")


if __name__ == "__main__":
    _write_cie()
    _write_illuminants()
    _write_rendering()
    _write_eigenvectors()
    print(f"wrote cie_1nm.csv, cie_illuminants.csv, colour_rendering_1nm.csv.gz and munsell_eigenvectors.csv "
          f"in {DATA}")
