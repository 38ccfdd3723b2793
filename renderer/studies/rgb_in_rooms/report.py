"""Tables, figures and the thinned data of the study."""

import csv
import gzip
import io
import json
from pathlib import Path

import numpy as np

from renderer.pictures import study_charts
from renderer.studies.rgb_in_rooms.gains import READINGS
from renderer.studies.rgb_in_rooms.models import LAMPS, MODELS
from renderer.studies.rgb_in_rooms.palettes import PALETTES, chips
from renderer.studies.rgb_in_rooms.run import Room
from renderer.studies.rgb_in_rooms.summary import (
    WITHIN,
    cheapest,
    colours_at_the_eye,
    fitted_rule,
    numerical_errors,
    readings_of,
    reds_of_20_percent,
    shares_within,
)
from renderer.system.files import whole_file

BANDS = {"rgb": 3, "rgb, white lamp": 3, "rgb, equal thirds": 3, "prefiltered": 3, "6": 6, "9": 9, "16": 16,
         "31": 31}
COLOUR_ROOMS = 16
"""Rooms whose light at the eye is rated for colour, about: R_a and R_f take a quarter of a second each."""
BOUNDS = (1.0, 2.0, 5.0)
"""Per cent within which the cheapest model is asked for."""


def write_report(rooms: list[Room], out: Path) -> list[Path]:
    """Write study.json, study_tables.md, five figures and study_readings.csv.gz. Returns the files."""
    readings = readings_of(rooms)
    lux = readings.where(readings.reading != READINGS.index("walls"))
    rule, numerical = fitted_rule(readings), numerical_errors(rooms)
    colours = colours_at_the_eye(rooms[:: max(1, len(rooms) // COLOUR_ROOMS)])
    reds = reds_of_20_percent(rooms)
    by_palette = [readings.where(readings.palette == p) for p in range(len(PALETTES))]
    within = {palette: {reading: _row(part.where(part.reading == k).error[:, 0])
                        for k, reading in enumerate(READINGS)}
              for palette, part in zip(PALETTES, by_palette, strict=True)}
    by_lamp = {lamp: {palette: _row(lux.where((lux.lamp == k) & (lux.palette == p)).error[:, 0])
                      for p, palette in enumerate(PALETTES)} for k, lamp in enumerate(LAMPS)}
    enough = {palette: {f"{bound:g}": cheapest(lux.where(lux.palette == p), bound) for bound in BOUNDS}
              for p, palette in enumerate(PALETTES)}
    every = {f"{bound:g}": cheapest(lux, bound) for bound in BOUNDS}
    record = {
        "rooms": sum(not room.fine for room in rooms),
        "readings": len(readings.error),
        "numerical_error_points": _quantiles(numerical),
        "within_percent": within,
        "by_lamp": by_lamp,
        "rule": vars(rule),
        "models": {**enough, "all": every},
        "colour_at_the_eye": {
            name: {
                palette: _quantiles(np.abs(getattr(colours, name)[colours.palette == p]))
                for p, palette in enumerate(PALETTES)
            }
            for name in ("xy_shift", "cct_shift", "ra_shift", "melanopic_shift")
        },
        "reds": {
            "chips": reds.names,
            "spectral_ratio": _quantiles(reds.spectral.ravel()),
            "rgb_ratio": _quantiles(reds.rgb.ravel()),
            "bound_ratio": _quantiles(reds.bound),
            "pure_red_in_rgb": _quantiles(reds.pure),
        },
    }
    files = [_text(out / "study.json", json.dumps(record, indent=1)),
             _text(out / "study_within.md", _within_table(within)),
             _text(out / "study_lamps.md", _lamp_table(by_lamp)),
             _text(out / "study_models.md", _model_table(record["models"])), _data(out, readings)]
    files.append(study_charts.bars_within(
        out / "study_within.png", [f"{p}\n{r}" for p in PALETTES for r in ("floor", "eye")],
        {f"within {b:g} %": [within[p][r]["within"][k] for p in PALETTES for r in ("floor", "eye")]
         for k, b in enumerate(WITHIN)}, "How often RGB is right", "readings [%]"))
    thin = lux.where(np.random.default_rng(0).random(len(lux.error)) < 12_000 / len(lux.error))
    files.append(
        study_charts.error_against_excess(
            out / "study_rule.png",
            thin.excess,
            thin.error[:, 0],
            thin.palette,
            PALETTES,
            rule.slope,
            rule.low,
            rule.high,
        )
    )
    files.append(
        study_charts.models_by_cost(
            out / "study_models.png",
            {m: (BANDS[m], [every[f"{b:g}"][m] for b in BOUNDS]) for m in MODELS},
            BOUNDS,
        )
    )
    shifts = [
        ("cct_shift", "K", "CCT"),
        ("ra_shift", "points", "R_a"),
        ("melanopic_shift", "%", "melanopic EDI"),
    ]
    files.append(
        study_charts.boxes(
            out / "study_colour.png",
            ["archit.", "accent", "extreme"],
            [
                [_known(getattr(colours, name)[colours.palette == p]) for p in range(len(PALETTES))]
                for name, _, _ in shifts
            ],
            [f"at the eye minus lamp [{unit}]" for _, unit, _ in shifts],
            [title for *_, title in shifts],
        )
    )
    files.append(study_charts.reds(out / "study_reds.png", reds.spectral, reds.rgb, reds.bound))
    return files


def _known(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]


def _row(errors: np.ndarray) -> dict:
    return {"within": shares_within(errors), "median": float(np.median(np.abs(errors))),
            "percentile_95": float(np.quantile(np.abs(errors), 0.95)), "worst": float(np.abs(errors).max()),
            "mean": float(errors.mean())}


def _quantiles(values: np.ndarray) -> dict:
    values = _known(values)
    if not len(values):
        return {}
    low, middle, high = np.quantile(values, [0.05, 0.5, 0.95])
    return {"percentile_5": float(low), "median": float(middle), "percentile_95": float(high),
            "largest": float(values.max())}


def _table(head: list[str], rows: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)) + "\n"


def _within_table(within: dict) -> str:
    head = [
        "palette",
        "reading",
        *(f"within ±{b:g} %" for b in WITHIN),
        "median error",
        "95th percentile",
        "worst",
    ]
    return _table(head, [[palette, reading, *(f"{x:.0f}" for x in row["within"]), f"{row['median']:.1f} %",
                          f"{row['percentile_95']:.1f} %", f"{row['worst']:.0f} %"]
                         for palette, rows in within.items() for reading, row in rows.items()])


def _lamp_table(lamps: dict) -> str:
    head = ["lamp", *(f"{palette}: ±5 %, 95th percentile" for palette in PALETTES)]
    return _table(
        head,
        [
            [lamp, *(f"{row['within'][0]:.0f}, {row['percentile_95']:.1f} %" for row in rows.values())]
            for lamp, rows in lamps.items()
        ],
    )


def _model_table(models: dict) -> str:
    head = ["palette", "within", *MODELS]
    return _table(head, [[palette, f"±{bound} %", *(f"**{row[m]:.0f}**" if row[m] >= 95 else f"{row[m]:.0f}"
                                                      for m in MODELS)]
                         for palette, bounds in models.items() for bound, row in bounds.items()])


def _text(path: Path, text: str) -> Path:
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")
    return path


def _data(out: Path, readings) -> Path:
    """The floor and eye readings of every painting under D65 and LED-B3, gzip-compressed CSV, under 1 MB."""
    lamps, known, buffer = list(LAMPS), chips(), io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(["room", "palette", "paint", "lamp", "reading", "indirect_share", "colour_excess_percent",
                     *(f"error_percent_{m.replace(', ', '_').replace(' ', '_')}" for m in MODELS)])
    chosen = np.isin(readings.lamp, [lamps.index("D65"), lamps.index("LED-B3")]) & np.isin(
        readings.reading, [READINGS.index("floor"), READINGS.index("eye")])
    for k in np.flatnonzero(chosen):
        writer.writerow([readings.room[k], PALETTES[readings.palette[k]], known.names[readings.paint[k]],
                         lamps[readings.lamp[k]], READINGS[readings.reading[k]], f"{readings.share[k]:.3f}",
                         f"{readings.excess[k]:.2f}", *(f"{e:.2f}" for e in readings.error[k])])
    path = out / "study_readings.csv.gz"
    with whole_file(path) as part:
        part.write_bytes(gzip.compress(buffer.getvalue().encode(), mtime=0))
    return path
