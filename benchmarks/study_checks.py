"""Tests of docs/answer.md with other rooms, other paints and finer bands.

    .venv/bin/python benchmarks/study_checks.py [rooms]

Draws rooms (default 20) with another seed. Paints them with the measured chips of the study, also in bands of
2 nm over 360–830 nm; and with the 99 colour evaluation samples of ANSI/IES TM-30 (paints, textiles, skins,
plants, prints), sorted into the study's palettes by CIELAB chroma. Prints for both sets of paints the share
of readings with RGB within 5 % and six nodes within 1 %, and the errors of the rule; and the change of RGB's
error in bands of 2 nm.
"""

import sys

import numpy as np

from renderer.colour.bands import narrow_bands
from renderer.colour.colour_excess import MIN_WARNED_PERCENT, colour_excess, error_per_excess, favours_red
from renderer.colour.lamps import band_flux
from renderer.colour.tables import cie_1931, d65
from renderer.scene.reading import load, resolved
from renderer.studies.rgb_in_rooms.drawn_rooms import drawn_room
from renderer.studies.rgb_in_rooms.gains import READINGS, RoomGains, room_gains
from renderer.studies.rgb_in_rooms.models import BAND_MODELS, LAMPS, BandModel, lamp_spectrum, models_under
from renderer.studies.rgb_in_rooms.palettes import PALETTES, WAVELENGTHS, Chips, Painting, chips, paintings
from renderer.studies.rgb_in_rooms.run import (
    PAINTINGS,
    lamp_models,
    patches_and_rays,
    solve_painting,
)

SEED = 1
PER_CHROMA = 5.5
"""Approximate CIELAB chroma of a step of Munsell chroma."""


def evaluation_samples() -> Chips:
    """The 99 samples as paints."""
    import colour
    from colour import XYZ_to_Lab
    from colour.quality.cfi2017 import load_TCS_CIE2017

    samples = load_TCS_CIE2017(colour.SpectralShape(380, 780, 5))
    curves = np.clip(samples.values.T, 0, 1)
    nm, observer = cie_1931()
    fine = np.stack([np.interp(nm, WAVELENGTHS, curve) for curve in curves]) * d65()[1]
    xyz = fine @ observer / (d65()[1] @ observer[:, 1])
    lab = XYZ_to_Lab(xyz, [0.3127, 0.3290])
    names = [f"CES{k + 1:02}" for k in range(len(curves))]
    return Chips(names, curves, xyz[:, 1], np.hypot(lab[:, 1], lab[:, 2]) / PER_CHROMA, [""] * len(names))


def drawn_gains(number: int) -> tuple:
    """A drawn room and its gains, as in the study."""
    table, _, lighting = drawn_room(number, SEED)
    scene = resolved(table, load("grey_room").path.parent / "study.toml")
    return scene, room_gains(scene, *patches_and_rays(scene, lighting), SEED)


def in_bands_of_2_nm(gains: RoomGains, painting: Painting) -> np.ndarray:
    """Readings (n_lamps, 4) of a painting in bands of 2 nm."""
    bands, shares = narrow_bands(), []
    for lamp in LAMPS:
        lumens = band_flux(lamp_spectrum(lamp), 1.0, bands, "the study's lamp") * bands.luminous
        shares.append(lumens / lumens.sum())
    indirect = gains.indirect(BandModel(bands, shares[0]).reflectance(painting.curves))
    return np.array(shares) @ indirect.T + gains.direct


def rows_of(gains: RoomGains, painting: Painting, totals: np.ndarray) -> dict[str, np.ndarray]:
    """Errors of RGB and of six nodes, and the prediction of the rule, for one painting's illuminances."""
    lit = totals[..., :3]
    errors = 100 * (lit[:, 1:] / lit[:, :1] - 1)
    areas, surface = gains.transport.exchange.areas, gains.transport.mesh.surface
    rgb = areas @ models_under("D65")["rgb"].reflectance(painting.curves)[surface] / areas.sum()
    share = 1 - gains.direct[:3] / lit[:, 0]
    red = np.array([lamp_models()[lamp]["rgb"].shares[0] for lamp in LAMPS])
    given = colour_excess(np.broadcast_to(rgb, (*share.shape, 3)), share) * error_per_excess(red)[:, None]
    return {
        "rgb": errors[:, BAND_MODELS.index("rgb")],
        "6": errors[:, BAND_MODELS.index("6")],
        "given": given,
        "red": np.full(given.shape, favours_red(rgb)),
        "palette": np.full(given.shape, PALETTES.index(painting.palette)),
    }


def main(rooms: int) -> None:
    """Print the results."""
    tried: dict[str, list] = {"measured chips": [], "TM-30 samples": []}
    moved = []
    for number in range(rooms):
        scene, gains = drawn_gains(number)
        for paints, known in (("measured chips", chips()), ("TM-30 samples", evaluation_samples())):
            for painting in paintings(scene, np.random.default_rng((SEED, number)), PAINTINGS, known):
                totals, _ = solve_painting(gains, painting)
                tried[paints].append(rows_of(gains, painting, totals))
                if paints == "measured chips":
                    rgb = totals[:, 1 + BAND_MODELS.index("rgb")]
                    moved.append(100 * (rgb / totals[:, 0] - rgb / in_bands_of_2_nm(gains, painting)))
    print("| paints | palette | RGB within ±5 %, task | floor | eye | six nodes within ±1 % |\n"
          "|---|---|---|---|---|---|")
    for paints, parts in tried.items():
        all_of = {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}
        for p, palette in enumerate(PALETTES):
            at = all_of["palette"][:, 0] == p
            print(f"| {paints} | {palette} | " + " | ".join(
                f"{100 * np.mean(np.abs(all_of['rgb'][at, k]) <= 5):.0f}" for k in range(len(READINGS) - 1))
                + f" | {100 * np.mean(np.abs(all_of['6'][at]) <= 1):.0f} |")
        print(told(paints, *(all_of[key].ravel() for key in ("rgb", "given", "red"))))
    apart = np.abs(np.concatenate(moved))
    print(f"bands of 2 nm move the error of RGB by {np.median(apart):.3f} points in the middle, "
          f"{np.quantile(apart, 0.95):.3f} in 95 of 100, {apart.max():.2f} at most")


def told(paints: str, error: np.ndarray, given: np.ndarray, red: np.ndarray) -> str:
    """Errors of the rule in rooms that favour red."""
    error, given = error[red], given[red]
    warned = given >= MIN_WARNED_PERCENT
    explained = 1 - ((error - given) ** 2).sum() / (error**2).sum()
    return (f"{paints}: the rule explains {100 * explained:.0f} % of the variance; it gives "
            f"{100 * warned.mean():.0f} % of readings 5 % or more, of which "
            f"{100 * np.mean(error[warned] < MIN_WARNED_PERCENT / 2):.0f} % are less than 2.5 % too bright; "
            f"{100 * np.mean((error > MIN_WARNED_PERCENT) & ~warned):.1f} % are missed")


if __name__ == "__main__":
    main(int(sys.argv[1]) if sys.argv[1:] else 20)
