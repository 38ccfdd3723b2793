"""Readings as JSON objects, for `--json` and for files."""

from dataclasses import dataclass

import numpy as np

from renderer import __version__
from renderer.colour.lamps import mean_light
from renderer.readings.alpha_opic import RECEPTORS, alpha_opic_irradiance, daylight_ratio, equivalent_daylight
from renderer.readings.colorimetry import COLOUR, MAX_DUV, chromaticity, colour_of, colour_temperature
from renderer.readings.finding import of_grid, rgb_error_percent
from renderer.readings.glare import Glare
from renderer.readings.grid import GridReading
from renderer.readings.reading import Reading
from renderer.readings.uncertainty import Figure
from renderer.records.finding import room_finding
from renderer.scene.scene import Scene
from renderer.solving.solution import Solution


@dataclass(frozen=True)
class Table:
    """Rows of text under a title."""

    title: str
    columns: list[str]
    rows: list[list[str]]


def lamps_record(scene: Scene) -> dict | None:
    """Colour of the light that leaves the scene's lamps, each weighted by its lumens; None where all are
    dark."""
    lumens = [lum.lumens for lum in scene.luminaires]
    return _light_record(mean_light(scene.lamps, lumens)) if sum(lumens) > 0 else None


def _light_record(power: np.ndarray) -> dict:
    """Colour and melanopic daylight efficacy ratio of light (471,) at 1 nm; the light must not be dark."""
    return {**colour_of(power), "melanopic_der": float(daylight_ratio(power)[-1])}


def reading_record(reading: Reading, lamps: dict | None) -> dict:
    """One photometer. A value that the bands cannot give is None, and `unknown` states the reason.

    lamps : from `lamps_record`; the record states how the light differs from it
    """
    bands = reading.bands
    light = dict.fromkeys((*COLOUR, "melanopic_der"))
    opic = spectrum = None
    if bands.filters is not None:
        light["xy"] = chromaticity(reading.total, bands)
        light["cct_K"], light["duv"] = colour_temperature(light["xy"])
        light["xy"] = light["xy"] and list(light["xy"])
    elif reading.power is not None:
        spectrum = {"wavelength_nm": bands.centres.tolist(),
                    "irradiance_W_m2_nm": (reading.watts / bands.widths).tolist()}
        opic = {name: {"irradiance_W_m2": float(irradiance), "edi_lx": float(lux)} for name, irradiance, lux
                in zip(RECEPTORS, alpha_opic_irradiance(reading.power), equivalent_daylight(reading.power),
                    strict=True)}
        if reading.total_lx > 0:
            light = _light_record(reading.power)
    melanopic = opic and opic["melanopic"]["edi_lx"]
    known = {**light, "melanopic_edi_lx": melanopic, "alpha_opic": opic, "spectrum": spectrum}
    return {
        "name": reading.name,
        "position": [float(x) for x in reading.position],
        "normal": [float(x) for x in reading.normal],
        "illuminance_lx": {"direct": reading.direct_lx, "indirect": reading.indirect_lx,
                           "total": reading.total_lx, "uncertainty": reading.uncertainty},
        "errors_lx": {"mesh": reading.mesh_error, "sampling": reading.sampling_error,
                      "bands": reading.band_error},
        "rgb_error_percent": reading.rgb_error_percent,
        "rgb_error_bar_percent": reading.rgb_error_bar_percent,
        **known,
        "change_from_lamps": {key: None if lamps is None or light[key] is None or lamps[key] is None
                              else light[key] - lamps[key] for key in light if key != "xy"},
        "unknown": {key: _why_unknown(reading, key) for key, value in known.items() if value is None},
    }


def _why_unknown(reading: Reading, key: str) -> str:
    bands = reading.bands
    if reading.power is None and (bands.filters is None or key not in ("xy", "cct_K", "duv")):
        if bands.nodes is not None:
            return "placed nodes give illuminance alone; use --bands 31"
        if bands.edges is not None:
            return "bands wider than 10 nm do not give colour as accurately as 31; use --bands 31"
        return "three bands are weighted integrals, not a spectrum; use --bands 31"
    if reading.total_lx > 0:
        return f"the light is too far from white: Duv over {MAX_DUV}, under 1,000 K, or hues missing"
    return "no light arrives"


def grid_record(reading: GridReading) -> dict:
    """One grid: its figures [lx], its points and their readings."""
    grid = reading.grid
    figures = {"mean": reading.mean, "min": reading.least, "max": reading.most}
    return {
        "name": grid.name, "counts": list(grid.counts), "cell_m": list(grid.cell),
        "normal": [float(x) for x in grid.normal], "border_m": grid.border, "left_out": reading.left_out,
        "illuminance_lx": {key: figure.value for key, figure in figures.items()},
        "uncertainty_lx": {key: figure.uncertainty for key, figure in figures.items()},
        "errors_lx": {"mesh": reading.mean.mesh_error, "sampling": reading.mean.sampling_error,
                      "bands": reading.band_error},
        "uniformity": reading.uniformity, "uniformity_uncertainty": reading.uniformity_error,
        "rgb_error_percent": _grid_errors(reading),
        "points": {"position": grid.points[reading.read].tolist(), "direct_lx": reading.direct.tolist(),
                   "indirect_lx": reading.indirect.tolist(), "total_lx": reading.total.tolist(),
                   "uncertainty_lx": reading.uncertainty.tolist(),
                   "rgb_error_percent": None if reading.rgb is None else [
                       rgb_error_percent(*pair) for pair in zip(reading.rgb.tolist(), reading.total.tolist(),
                                                                strict=True)]},
    }


def _grid_errors(reading: GridReading) -> dict | None:
    """Error of RGB against 31 bands [%] and its bar: of the mean, and at the point where it is largest."""
    if reading.rgb is None:
        return None
    mean, worst = of_grid(reading)
    return {"mean": mean.percent, "mean_bar": mean.bar_percent, "worst": worst.percent,
            "worst_bar": worst.bar_percent,
            "worst_position": reading.grid.points[reading.read][reading.worst_point].tolist()}


def escaped(solution: Solution) -> list[dict]:
    """Light that leaves the room through each hole of its mesh [lm], and the hole's place; [] for a closed
    room."""
    found = []
    for hole in solution.scene.room.openings:
        mesh, areas = solution.transport.mesh, solution.transport.exchange.areas
        patch = mesh.surface == solution.scene.surface_names.index(hole.name)
        lumens = float(areas[patch] @ (solution.irradiance[patch] @ solution.bands.luminous))
        found.append({"name": hole.name, "middle": [float(x) for x in hole.middle],
                      "area_m2": hole.area, "escaping_lm": lumens})
    return found


def solution_record(solution: Solution, readings: list[Reading], accuracy: float, seconds: float,
                    grids: list[GridReading] = ()) -> dict:
    """A whole run: its readings, and the errors of closure, reciprocity and energy balance."""
    return {**of_run(solution, accuracy, seconds), "lamps": (lamps := lamps_record(solution.scene)),
            "readings": [reading_record(reading, lamps) for reading in readings],
            "grids": [grid_record(grid) for grid in grids], **_finding_record(solution, readings, grids)}


def take_comparison(record: dict, spectral: dict) -> None:
    """Copy the error of RGB into a record in RGB, from the record of the same meters in 31 bands."""
    for kind in ("readings", "grids"):
        for own, other in zip(record[kind], spectral[kind], strict=True):
            own["rgb_error_percent"] = other["rgb_error_percent"]
            if kind == "readings":
                own["rgb_error_bar_percent"] = other["rgb_error_bar_percent"]
            else:
                own["points"]["rgb_error_percent"] = other["points"]["rgb_error_percent"]
    record.update({key: spectral[key] for key in ("finding",) if key in spectral})


def _finding_record(solution: Solution, readings: list[Reading], grids: list[GridReading]) -> dict:
    """`finding`, a list of one sentence, where the readings are in 31 bands with RGB beside them."""
    found = room_finding(solution.scene.title, readings, grids)
    return {"finding": [found.sentence]} if found.readings else {}


def luminance_record(figure: Figure, position, direction, angle: float | None) -> dict:
    """One spot meter. angle : full angle [degrees]; None for one direction"""
    return {"name": figure.name, "position": [float(x) for x in position],
            "direction": [float(x) for x in direction], "angle_deg": angle,
            "luminance_cd_m2": figure.value, "uncertainty_cd_m2": figure.uncertainty}


def surface_records(solution: Solution, figures: list[Figure]) -> list[dict]:
    """Mean luminance of each surface, and of each luminaire along its normal."""
    lamps = solution.flux @ solution.bands.luminous
    found = [(f.name, f.value, f.uncertainty) for f in figures]
    found += [(lum.name, float(lumens * lum.luminance(lum.normal)), 0.0)
              for lum, lumens in zip(solution.scene.luminaires, lamps, strict=True) if lum.area > 0]
    return [dict(zip(("name", "luminance_cd_m2", "uncertainty_cd_m2"), row, strict=True)) for row in found]


def glare_record(glare: Glare) -> dict:
    """One observer's rating. `reason` states why there is none, `notes` lists cases that CIE 117 does not
    cover.
    """
    return {"name": glare.name, "position": [float(x) for x in glare.position],
            "direction": [float(x) for x in glare.direction], "ugr": glare.rating,
            "uncertainty": glare.uncertainty, "background_luminance_cd_m2": glare.background,
            "indirect_illuminance_lx": glare.indirect.value, "reason": glare.reason, "notes": glare.notes,
            "luminaires": [{"name": s.name, "luminance_cd_m2": s.luminance, "solid_angle_sr": s.solid_angle,
                            "position_index": s.position_index, "share": s.share} for s in glare.sources]}


def of_run(solution: Solution, accuracy: float, seconds: float) -> dict:
    """The part of every record that describes the run: scene, bands, mesh, method, and errors before
    balancing."""
    transport = solution.transport
    holes = escaped(solution)
    return {
        "version": __version__,
        "scene": solution.scene.title,
        "bands": solution.bands.name,
        "accuracy": accuracy,
        "seed": transport.seed,
        "maintenance_factor": solution.scene.project.maintenance_factor,
        "values": "initial" if solution.scene.project.maintenance_factor == 1 else "maintained",
        "patches": transport.mesh.count,
        "method": transport.method.name,
        "closure_error": transport.exchange.closure_error,
        "reciprocity_error": transport.exchange.reciprocity_error,
        "energy_balance_error": solution.energy_balance_error,
        "rays": transport.rays,
        **({"openings": holes} if holes else {}),
        **({"files": solution.scene.files} if solution.scene.files else {}),
        "bands_solved": solution.bands_solved,
        "seconds": {"form_factors": transport.seconds, "solve": solution.seconds, "total": seconds},
    }
