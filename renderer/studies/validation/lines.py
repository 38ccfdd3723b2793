"""Light in lines, and the numbers of lamps that CIE publishes."""

from pathlib import Path

from renderer.colour.bands import K_M
from renderer.colour.lamps import illuminant, power_at_1_nm
from renderer.colour.reference_light import black_body
from renderer.colour.tables import cie_1931
from renderer.readings.colorimetry import colour_of
from renderer.solving.solution import solve
from renderer.studies.spectrum import lamp_record, resolve
from renderer.studies.validation.cases import Case, box_scene, meter
from renderer.studies.validation.photometry import PUBLISHED_VALUES


def lines_of_light(folder: Path) -> list[Case]:
    """Lumens of a spectral line follow V(λ) at its wavelength; a lamp of several lines equals several lamps
    of one line."""
    v, rows = cie_1931()[1][:, 1], []
    for nm in (446, 555, 589, 654):
        _line(folder, nm)
        got = lamp_record(resolve(str(folder / f"l{nm}.csv"), True))["luminous_efficacy_lm_W"]
        # A triangle of 1 nm: V's curvature over half a nm.
        rows.append(Case("Light in lines", f"{nm} nm", "luminous efficacy", K_M * v[nm - 360], got,
                         5e-4 * K_M * v[nm - 360], "lm/W", "K_m V(λ); light is linear in its lamps"))
    _line(folder, 446, 654, powers=(1.0, 0.5), name="two.csv")
    (folder / "step.csv").write_text("400,0.1\n580,0.1\n600,0.7\n700,0.7\n")
    one = _read(folder, 'spectrum = "step.csv"', {"two.csv": 1000.0})
    share = 0.420600  # V(446)/(V(446) + 0.5 V(654)), of powers 1 and 0.5
    apart = {"l446.csv": 1000 * share, "l654.csv": 1000 * (1 - share)}
    two = _read(folder, 'spectrum = "step.csv"', apart)
    grey = [_read(folder, f"reflectance = {rho}", {"l446.csv": 1000.0}) for rho in (0.1, 0.7)]
    for name, a, b, low, high in zip(("facing down", "facing up"), one, two, *grey, strict=True):
        mixed = share * low + (1 - share) * high
        for other, expected in (("of two lamps of one line", b), ("of two grey rooms", mixed)):
            # Rounding of factors in single precision, which differs from band to band.
            rows.append(Case("Light in lines", f"one lamp of two lines, {name}", f"total, {other}", expected,
                             a, 2e-6 * expected, "lx"))
    return rows


def _line(folder: Path, *nm: int, powers=(1.0,), name: str = "") -> None:
    text = "".join(f"{at - 0.5},0\n{at},{power}\n{at + 0.5},0\n"
                   for at, power in zip(nm, powers, strict=True))
    (folder / (name or f"l{nm[0]}.csv")).write_text(text)


def _read(folder: Path, paint: str, lamps: dict[str, float]) -> list[float]:
    """Illuminance [lx] of two meters in a room of one paint, lit by points of spectra and lumens."""
    points = "".join(f'\n[[luminaires]]\nshape = "point"\ncenter = [2, 2, 2]\nflux = {flux!r}\n'
                     f'spectrum = "{file}"\n' for file, flux in lamps.items())
    meters = meter(2, 2, 1, normal=(0, 0, -1)) + meter(1, 2, 1)
    scene = box_scene(folder, points + meters, paint=paint)
    return [reading.total_lx for reading in solve(scene, "31", 0.05).photometers()]


def published_colours(_folder: Path) -> list[Case]:
    """Chromaticities and R_a of CIE's lamps; black bodies however cold render perfectly."""
    rows = []
    for name, published in PUBLISHED_VALUES["cie_015"]["xy"].items():
        record = colour_of(power_at_1_nm(illuminant(name, "")))
        for axis, expected, got in zip("xy", published, record["xy"], strict=True):
            rows.append(Case("Lamps of CIE 015", name, axis, expected, got, 1e-4, source="CIE 015:2018"))
    for name, published in PUBLISHED_VALUES["cie_015"]["R_a"].items():
        got = colour_of(power_at_1_nm(illuminant(name, "")))["cri_ra"]
        # Printed as whole numbers; sums at 5 nm, as in 1995, and at 1 nm differ by up to 0.05.
        rows.append(Case("Lamps of CIE 015", name, "R_a", published, got, 0.55))
    for kelvin in (1000.0, 1200.0, 1667.0, 4000.0):
        record = colour_of(black_body(kelvin))
        name = f"black body, {kelvin:g} K"
        rows.append(Case("Lamps of CIE 015", name, "CCT", kelvin, record["cct_K"], 1e-5 * kelvin, "K"))
        rows.append(Case("Lamps of CIE 015", name, "R_a", 100.0, record["cri_ra"], 1e-2))
    return rows
