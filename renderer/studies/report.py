"""The report on rooms: solved and read in RGB and in 31 bands, and written as a page."""

import time
from dataclasses import replace
from pathlib import Path

from renderer.pictures.report.page import ReportRoom, save_report
from renderer.pictures.report.viewpoint import looks
from renderer.records.json_records import solution_record
from renderer.scene.scene import Scene
from renderer.solving.solution import solve_on
from renderer.solving.transport_store import Progress, TransportStore
from renderer.solving.watch import Watch
from renderer.studies.in_31_bands import solved_in_31_bands

MAX_PAGE_BYTES = 10_000_000
"""Largest size of a report [bytes], so that it can be sent by mail."""


def solve_rooms(scenes: list[Scene], accuracy: float | None, seed: int | None, shared: TransportStore,
                progress: Progress, watch: Watch | None = None) -> list[ReportRoom]:
    """Solve each room in 31 bands to the accuracy, and in RGB on the same transport.

    watch : whether an interruption keeps the rooms read so far
    """
    rooms, watch = [], watch or Watch()
    for spectral, readings, record in solved_in_31_bands(scenes, accuracy, seed, shared, progress, watch):
        scene, started = spectral.scene, time.perf_counter()
        rgb = solve_on(scene, scene.band_set("rgb"), spectral.plan, shared, spectral.transport)
        rgb = replace(rgb, watch=watch)
        rgb_readings = rgb.photometers()
        rgb_record = solution_record(rgb, rgb_readings, accuracy or scene.solver.accuracy,
                                     time.perf_counter() - started)
        rooms.append(ReportRoom({"rgb": rgb, "31": spectral}, {"rgb": rgb_readings, "31": readings},
                          {"rgb": rgb_record, "31": record}, None))
    return rooms


def save_page(rooms: list[ReportRoom], command: str, out: Path, progress: Progress,
         outside: bool = False) -> tuple[Path, list[str]]:
    """Write report.html; returns its path, and sentences about departures from the scene files.

    command : the command line, for the page
    outside : include files outside a scene's folder

    The views have fewer pixels where the page would be larger than MAX_PAGE_BYTES.
    """
    most = 4 * 640 * 480  # pixels of all different views together
    path, pixels = out / "report.html", most
    while True:
        progress("views of the cameras")
        views, notes = looks([(room.scene, room.solutions["31"].transport) for room in rooms], pixels)
        progress("the page")
        seen = [replace(room, view=view) for room, view in zip(rooms, views, strict=True)]
        save_report(seen, command, notes, path, outside)
        size = path.stat().st_size
        if size <= MAX_PAGE_BYTES or pixels < most / 16:
            break
        pixels /= 4
    if size > MAX_PAGE_BYTES:
        notes.append(f"report.html has {size / 1e6:.1f} MB, because the rooms have many patches; a looser "
                     "--accuracy makes it smaller.")
    return path, notes
