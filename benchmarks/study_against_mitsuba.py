"""Readings of `renderer study` against Mitsuba 3, in RGB and in its spectral variant.

    .venv/bin/renderer study
    .venv/bin/python benchmarks/study_against_mitsuba.py [rooms] [seconds]

Chooses random rooms of the study (default 12) that are lit by panels or uplights, and for each one painting
of every palette under one lamp. Mitsuba traces each in both variants for a number of seconds (default 6).
Prints for each the mean illuminance at task, floor and eye here over that in Mitsuba, and the error of RGB by
both programs. Finished rooms are kept in outputs/study_against_mitsuba.jsonl. The peers come with pip install
-e '.[peers]'; DRJIT_LIBLLVM_PATH names an LLVM.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from renderer.colour.tables import cie_1931
from renderer.scene.reading import load, resolved
from renderer.studies.peers import mitsuba3
from renderer.studies.peers.export import CannotRun, Handover, hand_over, light_at_1_nm
from renderer.studies.rgb_in_rooms.drawn_rooms import LIGHTING, drawn_room
from renderer.studies.rgb_in_rooms.gains import READINGS
from renderer.studies.rgb_in_rooms.models import BAND_MODELS, LAMPS, lamp_spectrum, models_under
from renderer.studies.rgb_in_rooms.palettes import WAVELENGTHS, paintings
from renderer.studies.rgb_in_rooms.run import PAINTINGS, RoomTask, studied

OUT = Path("outputs/study_against_mitsuba.jsonl")
AIM = 5e-4
"""Sufficient half-width of a meter, relative to the room's mean."""


def main(rooms: int, seconds: float) -> None:
    """Trace the missing rooms, and print the table."""
    OUT.parent.mkdir(exist_ok=True)
    random = np.random.default_rng(29)
    drawn = random.permutation(300)
    given = [int(n) for n in drawn if LIGHTING[(n // 5) % 4] in ("direct", "indirect")][:rooms]
    done = [json.loads(line) for line in OUT.read_text().splitlines()] if OUT.exists() else []
    left = [number for number in given if number not in {row["room"] for row in done}]

    def trace(in_three, in_spectrum) -> None:
        for number in left:
            done.extend(rows := compared(number, seconds, {"rgb": in_three, "spectral": in_spectrum}))
            with OUT.open("a") as file:
                file.writelines(json.dumps(row) + "\n" for row in rows)
            for row in rows:
                print(line(row), flush=True)

    if left:
        mitsuba3.in_mitsuba(lambda first: mitsuba3.in_mitsuba(lambda second: trace(first, second),
                                                              ("llvm_ad_spectral", "scalar_spectral")))
    table([row for row in done if row["room"] in given])


def compared(number: int, seconds: float, processes: dict) -> list[dict]:
    """One painting of each palette: readings per lumen here and in Mitsuba, by reading (task, floor, eye).

    processes : one with Mitsuba's RGB variant and one with its spectral variant
    """
    scene = resolved(drawn_room(number)[0], load("grey_room").path.parent / "study.toml")
    arrays = studied(RoomTask(number, 0))
    painted = paintings(scene, np.random.default_rng((0, number, False)), PAINTINGS)
    lumens = sum(luminaire.lumens for luminaire in scene.luminaires)
    rows = []
    for palette in range(3):
        k, which = PAINTINGS[0] * palette + number % PAINTINGS[0], (number + 7 * palette) % len(LAMPS)
        lamp, here = list(LAMPS)[which], arrays["totals"][k, which]
        row = {"room": number, "palette": painted[k].palette, "paint": painted[k].name, "lamp": lamp}
        handed = hand_over(scene)
        aim = [AIM * here[0, 1] * lumens] * len(handed.meters)
        for name, room in (("rgb", in_rgb(handed, painted[k].curves, lamp)),
                           ("spectral", in_spectra(handed, painted[k].curves, lamp))):
            got = processes[name].submit(mitsuba3.read_all, room, number, aim, seconds).result()
            means = []
            for reading in READINGS[:-1]:
                one = [g for g, meter in zip(got, scene.photometers, strict=True)
                       if meter.name.startswith(reading)]
                means.append([float(np.mean([g.lx for g in one])) / lumens,
                              float(np.linalg.norm([g.half_width for g in one])) / len(one) / lumens])
            row[f"{name}_theirs"] = means
            row[f"{name}_here"] = here[0 if name == "spectral" else 1 + BAND_MODELS.index("rgb"), :3].tolist()
        rows.append(row)
    return rows


def in_rgb(room: Handover, curves: np.ndarray, lamp: str) -> Handover:
    """The room with these paints (n_surfaces, 81) and this lamp in RGB."""
    model = models_under(lamp)["rgb"]
    light = model.shares / model.bands.luminous
    return _painted(room, model.reflectance(curves), light, room.luminous)


def in_spectra(room: Handover, curves: np.ndarray, lamp: str) -> Handover:
    """The room with these paints and this lamp in spectra at 360–830 nm, 1 nm."""
    fine = np.stack([np.interp(cie_1931()[0], WAVELENGTHS, curve) for curve in curves])
    return _painted(room, fine, light_at_1_nm(lamp_spectrum(lamp)), np.ones(1))


def _painted(room: Handover, reflectance: np.ndarray, light: np.ndarray, luminous: np.ndarray) -> Handover:
    """light : of one lumen."""
    surfaces = []
    for k, surface in enumerate(room.surfaces):
        if surface.radiance is None:
            surfaces.append(replace(surface, reflectance=reflectance[k]))
        else:
            surfaces.append(replace(surface, reflectance=np.zeros(len(light)),
                                    radiance=float(surface.radiance @ room.luminous) * light))
    return replace(room, surfaces=surfaces, luminous=luminous)


def line(row: dict) -> str:
    """Readings here over Mitsuba's, and RGB's error by both programs, in per cent."""
    said = [f"{row['room']:3} {row['palette']:13} {row['lamp']:14}"]
    for k, reading in enumerate(READINGS[:-1]):
        ours, theirs, bar = errors(row, k)
        apart = 100 * (row["spectral_here"][k] / row["spectral_theirs"][k][0] - 1)
        said.append(f"{reading} {apart:+.2f}; RGB {ours:+.2f}, {theirs:+.2f} ± {bar:.2f}")
    return "  |  ".join(said)


def errors(row: dict, k: int) -> tuple[float, float, float]:
    """RGB's error here and in Mitsuba, and its half-width [%]."""
    (rgb, a), (full, b) = row["rgb_theirs"][k], row["spectral_theirs"][k]
    here = 100 * (row["rgb_here"][k] / row["spectral_here"][k] - 1)
    return here, 100 * (rgb / full - 1), 100 * rgb / full * float(np.hypot(a / rgb, b / full))


def table(rows: list[dict]) -> None:
    """Differences of the two programs over all readings."""
    told = np.array([errors(row, k) for row in rows for k in range(3)])
    level = np.array([100 * (row["spectral_here"][k] / row["spectral_theirs"][k][0] - 1)
                      for row in rows for k in range(3)])
    apart, bars = told[:, 0] - told[:, 1], told[:, 2]
    print(f"\n{len({row['room'] for row in rows})} rooms, {len(apart)} readings; error of RGB from "
          f"{told[:, 1].min():+.1f} to {told[:, 1].max():+.1f} % by Mitsuba")
    print(f"spectral reading here over Mitsuba's: {level.mean():+.2f} % in the mean, "
          f"{np.abs(level).max():.2f} % at most")
    print(f"error of RGB here less Mitsuba's: median {np.median(np.abs(apart)):.2f} points, 95 in 100 below "
          f"{np.quantile(np.abs(apart), 0.95):.2f}, largest {np.abs(apart).max():.2f}; Mitsuba's bar "
          f"{np.median(bars):.2f} in the middle; {100 * np.mean(np.abs(apart) <= bars):.0f} of 100 inside it")


if __name__ == "__main__":
    try:
        main(int(sys.argv[1]) if sys.argv[1:] else 12, float(sys.argv[2]) if sys.argv[2:] else 6.0)
    except CannotRun as fault:
        print(fault)
