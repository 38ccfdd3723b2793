"""Readings as the objects that `--json` prints and files hold."""

from dataclasses import dataclass

from renderer.readings.colorimetry import chromaticity, colour_temperature, melanopic_edi
from renderer.solution import Reading, Solution


@dataclass(frozen=True)
class Table:
    """Rows of text to show, under a title."""

    title: str
    columns: list[str]
    rows: list[list[str]]


def reading_record(reading: Reading) -> dict:
    """One photometer; what a mode cannot know is None."""
    bands = reading.bands
    xy = chromaticity(reading.total, bands)
    cct, duv = colour_temperature(xy)
    spectrum = None
    if bands.edges is not None:
        spectrum = {"wavelength_nm": bands.centres.tolist(),
                    "irradiance_W_m2_nm": (reading.total / bands.widths).tolist()}
    return {
        "name": reading.name,
        "position": [float(x) for x in reading.position],
        "normal": [float(x) for x in reading.normal],
        "illuminance_lx": {"direct": reading.direct_lx, "indirect": reading.indirect_lx,
                           "total": reading.total_lx, "uncertainty": reading.uncertainty},
        "errors_lx": {"mesh": reading.mesh_error, "sampling": reading.sampling_error,
                      "bands": reading.band_error},
        "xy": None if xy is None else list(xy), "cct_K": cct, "duv": duv,
        "melanopic_edi_lx": melanopic_edi(reading.total, bands),
        "spectrum": spectrum,
    }


def escaped(solution: Solution) -> list[dict]:
    """What leaves the room through each hole of its mesh [lm], and where that is; [] for a closed room."""
    found = []
    for hole in solution.scene.room.openings:
        mesh, areas = solution.transport.mesh, solution.transport.exchange.areas
        patch = mesh.surface == solution.scene.surfaces.index(hole.name)
        lumens = float(areas[patch] @ (solution.irradiance[patch] @ solution.bands.luminous))
        found.append({"name": hole.name, "middle": [float(x) for x in hole.middle],
                      "area_m2": hole.area, "escaping_lm": lumens})
    return found


def solution_record(solution: Solution, readings: list[Reading], accuracy: float,
                    seconds: float) -> dict:
    """A whole run: its readings, and how far its laws hold."""
    transport = solution.transport
    holes = escaped(solution)
    return {
        "scene": solution.scene.title,
        "bands": solution.bands.name,
        "accuracy": accuracy,
        "patches": len(transport.mesh.patches),
        "readings": [reading_record(reading) for reading in readings],
        "closure_error": transport.exchange.closure_error,
        "reciprocity_error": transport.exchange.reciprocity_error,
        "energy_balance_error": solution.energy_balance_error,
        "rays": transport.rays,
        **({"openings": holes} if holes else {}),
        "bands_solved": solution.bands_solved,
        "seconds": {"form_factors": transport.seconds, "solve": solution.seconds, "total": seconds},
    }
