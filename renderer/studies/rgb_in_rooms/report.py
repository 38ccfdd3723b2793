"""The study's tables, figures and selected data."""

import csv
import gzip
import io
import json
from pathlib import Path

import numpy as np

from renderer.pictures import study_charts
from renderer.studies.rgb_in_rooms.colours import (
    COLOUR_QUANTITIES,
    MODELS_WITH_COLOUR,
    Colours,
    colours_at_the_eye,
)
from renderer.studies.rgb_in_rooms.gains import READINGS
from renderer.studies.rgb_in_rooms.models import BAND_MODELS, LAMPS, REFERENCE
from renderer.studies.rgb_in_rooms.palettes import PALETTES, chips
from renderer.studies.rgb_in_rooms.run import StudiedRoom
from renderer.studies.rgb_in_rooms.summary import (
    ERROR_BOUNDS,
    cheapest,
    fitted_rule,
    model_costs,
    numerical_errors,
    readings_of,
    reds_of_20_percent,
    shares_within,
)
from renderer.system.files import whole_file


def write_report(rooms: list[StudiedRoom], out: Path) -> list[Path]:
    """Write study.json, three tables, five figures and study_readings.csv.gz. Returns the files."""
    bounds = (1.0, 2.0, 5.0)  # of errors [%] in the comparison of models
    readings = readings_of(rooms)
    lux = readings.where(readings.reading != READINGS.index("walls"))
    rule, (of_rgb, of_readings) = fitted_rule(readings), numerical_errors(rooms)
    colours, costs = colours_at_the_eye(rooms), model_costs(rooms)
    reds = reds_of_20_percent(rooms)
    by_palette = [readings.where(readings.palette == p) for p in range(len(PALETTES))]
    within = {palette: {reading: _row(part.where(part.reading == k).error[:, 0])
                        for k, reading in enumerate(READINGS)}
              for palette, part in zip(PALETTES, by_palette, strict=True)}
    for p, palette in enumerate(PALETTES):  # direct light is the same in every model
        part = lux.where((lux.palette == p) & (lux.share > 0))
        within[palette]["indirect light alone"] = _row(part.error[:, 0] / part.share)
    by_lamp = {lamp: {palette: _row(lux.where((lux.lamp == k) & (lux.palette == p)).error[:, 0])
                      for p, palette in enumerate(PALETTES)} for k, lamp in enumerate(LAMPS)}
    enough = {palette: {f"{bound:g}": cheapest(lux.where(lux.palette == p), bound) for bound in bounds}
              for p, palette in enumerate(PALETTES)}
    every = {f"{bound:g}": cheapest(lux, bound) for bound in bounds}
    record = {
        "rooms": sum(not room.fine for room in rooms),
        "readings": len(readings.error),
        "numerical_error_of_rgb_points": _quantiles(of_rgb),
        "numerical_error_of_readings_percent": _quantiles(of_readings),
        "within_percent": within,
        "by_lamp": by_lamp,
        "rule": vars(rule),
        "models": {**enough, "all": every},
        "solve_seconds": costs,
        "colour_at_the_eye_against_the_lamp": _by_quantity(colours.shift, colours),
        "colour_at_the_eye_against_61_bands": {model: _by_quantity(colours.error[model], colours)
                                               for model in MODELS_WITH_COLOUR},
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
             _text(out / "study_models.md", _model_table(record["models"])),
             _text(out / "study_costs.md", _cost_table(costs)),
             _text(out / "study_colour.md", _colour_table(colours)), _data(out, readings)]
    files.append(study_charts.bars_within(
        out / "study_within.png", [f"{p}\n{r}" for p in PALETTES for r in ("floor", "eye")],
        {f"within {b:g} %": [within[p][r]["within"][k] for p in PALETTES for r in ("floor", "eye")]
         for k, b in enumerate(ERROR_BOUNDS)}, "How often RGB is right", "readings [%]"))
    thin = lux.where(np.random.default_rng(0).random(len(lux.error)) < 12_000 / len(lux.error))
    files.append(study_charts.error_against_rule(
        out / "study_rule.png", thin.given[:, 0], thin.error[:, 0], thin.red))
    files.append(
        study_charts.models_by_cost(
            out / "study_models.png",
            {m: (int(m) if m.isdecimal() else 3, [every[f"{b:g}"][m] for b in bounds]) for m in BAND_MODELS},
            bounds,
        )
    )
    files.append(study_charts.boxes(
        out / "study_colour.png", ["archit.", "accent", "extreme"],
        [[_known(colours.shift[colours.palette == p, k]) for p in range(len(PALETTES))] for k in (1, 2, 3)],
        [f"at the eye minus lamp [{unit}]" for unit in ("K", "points", "%")],
        ["CCT", "R_a", "melanopic light per lux"]))
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


def _by_quantity(differences: np.ndarray, colours: Colours) -> dict:
    """Quantiles of absolute differences (n, 4), by quantity and palette."""
    return {name: {palette: _quantiles(np.abs(differences[colours.palette == p, k]))
                   for p, palette in enumerate(PALETTES)} for k, name in enumerate(COLOUR_QUANTITIES)}


def _table(head: list[str], rows: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)) + "\n"


def _within_table(within: dict) -> str:
    head = [
        "palette",
        "reading",
        *(f"within ±{b:g} %" for b in ERROR_BOUNDS),
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
    head = ["palette", "within", *BAND_MODELS]
    return _table(head, [[palette, f"±{bound} %", *(f"**{row[m]:.0f}**" if row[m] >= 95 else f"{row[m]:.0f}"
                                                      for m in BAND_MODELS)]
                         for palette, bounds in models.items() for bound, row in bounds.items()])


def _cost_table(costs: dict) -> str:
    """Processor time of a solve in each model, over that in RGB, and as a share of a room's whole time."""
    return _table(
        ["model", "bands", "solve, RGB = 1", "share of form factors, direct light and solve"],
        [
            [
                name,
                name if name.isdecimal() else "61" if name == REFERENCE else "3",
                f"{seconds / costs['rgb']:.1f}",
                f"{100 * seconds / (seconds + costs['geometry']):.0f} %",
            ]
            for name, seconds in costs.items()
            if name != "geometry" and "," not in name
        ],
    )


def _colour_table(colours: Colours) -> str:
    """95th percentiles of the difference from 61 bands at the eye, by model and palette."""
    rows, forms = [], ("{:.4f}", "{:.0f} K", "{:.1f}", "{:.1f} %")
    for name in MODELS_WITH_COLOUR:
        for p, palette in enumerate(PALETTES):
            part = np.abs(colours.error[name][colours.palette == p])
            ends = [np.quantile(known, 0.95) if len(known := _known(part[:, k])) else None for k in range(4)]
            rows.append([name, palette, *("–" if end is None else form.format(end)
                                          for end, form in zip(ends, forms, strict=True))])
    return _table(["model", "palette", *COLOUR_QUANTITIES], rows)


def _text(path: Path, text: str) -> Path:
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")
    return path


def _data(out: Path, readings) -> Path:
    """Write the floor and eye readings of all paintings under D65 and LED-B3 as gzip-compressed CSV, under 1
    MB."""
    lamps, known, buffer = list(LAMPS), chips(), io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(["room", "palette", "paint", "lamp", "reading", "indirect_share", "colour_excess_percent",
                     "rule_percent",
                     *(f"error_percent_{m.replace(', ', '_').replace(' ', '_')}" for m in BAND_MODELS)])
    chosen = np.isin(readings.lamp, [lamps.index("D65"), lamps.index("LED-B3")]) & np.isin(
        readings.reading, [READINGS.index("floor"), READINGS.index("eye")])
    for k in np.flatnonzero(chosen):
        writer.writerow([readings.room[k], PALETTES[readings.palette[k]], known.names[readings.paint[k]],
                         lamps[readings.lamp[k]], READINGS[readings.reading[k]], f"{readings.share[k]:.3f}",
                         f"{readings.excess[k, 0]:.2f}", f"{readings.given[k, 0]:.2f}",
                         *(f"{e:.2f}" for e in readings.error[k])])
    path = out / "study_readings.csv.gz"
    with whole_file(path) as part:
        part.write_bytes(gzip.compress(buffer.getvalue().encode(), mtime=0))
    return path
