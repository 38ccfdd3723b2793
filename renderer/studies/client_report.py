"""A room's report for a client: the installation, its readings, and the requirements that they meet."""

import base64
import io
import time
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from renderer.colour.bands import XYZ_TO_BT709, band_set
from renderer.pictures.image import encode, exposure, tone_map, white_balance
from renderer.pictures.isolux import save_isolux
from renderer.pictures.report.client import save_client
from renderer.pictures.report.pdf import print_pdf
from renderer.pictures.report.viewpoint import looks
from renderer.readings.glare import Glare
from renderer.readings.grid import GridReading
from renderer.records.json_records import solution_record
from renderer.records.requirements import Check, check_requirements
from renderer.scene.photometric.files import read_photometry
from renderer.scene.scene import Scene
from renderer.scene.schema import SceneTable
from renderer.solving.measure import rate_glare, read_grid
from renderer.solving.refine import solve_until
from renderer.solving.solution import Solution
from renderer.solving.transport_store import Progress, TransportStore


@dataclass(frozen=True)
class Luminaires:
    """One line of the schedule: the luminaires of one table of the scene file.

    lumens : of one new luminaire [lm]
    watts : of one luminaire [W]; None where they are not stated
    """

    name: str
    kind: str
    number: int
    lumens: float
    watts: float | None
    light: str


@dataclass(frozen=True)
class Finish:
    """One material: luminous reflectance under D65, colour as "#rrggbb", area [m²]."""

    name: str
    reflectance: float
    colour: str
    area: float


@dataclass(frozen=True)
class ClientRoom:
    """The contents of a client's report on one room; pictures are PNG files as data addresses."""

    scene: Scene
    solution: Solution
    record: dict
    grids: list[GridReading]
    eyes: list[dict]
    ratings: list[Glare]
    checks: list[Check]
    schedule: list[Luminaires]
    finishes: list[Finish]
    picture: str | None
    plans: list[str]

    @property
    def watts_per_square_metre(self) -> float | None:
        """Connected load per floor area [W/m²]; None where a luminaire's watts are not stated."""
        if not self.schedule or any(line.watts is None for line in self.schedule):
            return None
        return sum(line.number * line.watts for line in self.schedule) / self.floor_area

    @property
    def floor_area(self) -> float:
        """Area of the room's floor [m²]: half of the projected area of its shell."""
        shell = self.scene.room.shell
        (ax, ay), (bx, by) = ((shell[:, k] - shell[:, 0])[:, :2].T for k in (1, 2))
        return float(abs(ax * by - ay * bx).sum() / 4)


def client_report(scene: Scene, accuracy: float | None, seed: int | None, store: TransportStore, out: Path,
                  progress: Progress) -> tuple[ClientRoom, list[Path]]:
    """Solve and read a room, and write <scene>_client.html and, where a browser is installed, .pdf.

    Raises InputError or SolveError.
    """
    room = client_room(scene, accuracy, seed, store, out, progress)
    progress(f"{scene.title}: the pages")
    page = save_client(room, out / f"{scene.path.stem}_client.html")
    printed = print_pdf(page)
    return room, [page] + ([printed] if printed else [])


def client_room(scene: Scene, accuracy: float | None, seed: int | None, store: TransportStore, out: Path,
                progress: Progress) -> ClientRoom:
    """Solve a room in 31 bands and read it for its report. Raises InputError or SolveError."""
    meters = [(p.position, p.normal, p.name) for p in scene.photometers]
    eyes = [(o.position, o.toward, o.name) for o in scene.observers]

    def read(solution: Solution):
        readings = solution.read_at(meters + eyes)
        areas = [read_grid(solution, grid) for grid in scene.grids]
        return (readings, areas), [*(r.figure for r in readings), *(f for a in areas for f in a.figures)]

    started = time.perf_counter()
    solution, (readings, grids), _ = solve_until(scene, read, "31", accuracy, seed, store, progress)
    ratings = rate_glare(solution, eyes)
    record = solution_record(solution, readings, accuracy or scene.solver.accuracy,
                             time.perf_counter() - started, grids)
    by_name = {r["name"]: r for r in record["readings"]}
    progress(f"{scene.title}: pictures")
    plans = []
    for grid in grids:
        plan = save_isolux(scene, grid, out / f"{scene.path.stem}_31_{grid.grid.file_stem}.png")
        plans.append(_address(plan.read_bytes()))
    table = scene.table
    checked = SceneTable.model_validate(table)
    return ClientRoom(scene, solution, record, grids, record["readings"][len(meters):], ratings,
                      check_requirements(scene, by_name, grids, ratings), _schedule(scene, checked),
                      _finishes(scene), _picture(solution), plans)


def _schedule(scene: Scene, table: SceneTable) -> list[Luminaires]:
    """One line for each luminaire table, arrays counted."""
    lines, k = [], 0
    factor = scene.project.maintenance_factor
    for entry in table.luminaires:
        number = entry.array[0] * entry.array[1] if entry.array else 1
        lumens, watts, kind = scene.luminaires[k].lumens / factor, entry.watts, entry.shape
        if entry.file is not None:
            photometry = read_photometry(scene.path.parent / entry.file, entry.file)
            watts = photometry.watts if watts is None else watts
            kind = Path(entry.file).name
        watts = None if watts is None else watts * entry.dimming
        light = f"{entry.cct:.0f} K" if entry.cct else Path(entry.spectrum or "D65").name
        lines.append(Luminaires(entry.name, kind, number, lumens, watts, light))
        k += number
    return lines


def _finishes(scene: Scene) -> list[Finish]:
    bands = band_set("31")
    light = scene_light(bands)
    areas: dict[str, float] = {}
    materials = {}
    for surface in scene.surfaces:
        if surface.material is not None:
            areas[surface.material.name] = areas.get(surface.material.name, 0.0) + surface.area
            materials[surface.material.name] = surface.material
    found = []
    for name, material in materials.items():
        xyz = (material.reflectance(bands) * light) @ bands.xyz / (light @ bands.luminous)
        red, green, blue = encode(XYZ_TO_BT709 @ xyz)
        found.append(Finish(name, float(xyz[1]), f"#{red:02x}{green:02x}{blue:02x}", areas[name]))
    return found


def scene_light(bands):
    """Flux (n_bands,) of 1 lm of D65 in each band."""
    from renderer.colour.lamps import band_flux, illuminant

    return band_flux(illuminant("D65", "report"), 1.0, bands, "report")


def _picture(solution: Solution) -> str | None:
    (view,), _ = looks([(solution.scene, solution.transport)], 640 * 480)
    if view is None:
        return None
    xyz = solution.bands.xyz
    total = view.direct(solution, xyz) + view.indirect(solution, xyz)
    balanced = total @ white_balance(solution.flux.sum(axis=0) @ xyz).T
    pixels = tone_map(balanced, exposure([balanced], [view.shows_surface]))
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG", optimize=True)
    return _address(file.getvalue())


def _address(png: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(png).decode('ascii')}"
