"""The page of a report: one HTML file with pictures and readings, without network and other files."""

import base64
import gzip
import hashlib
import json
import platform
from dataclasses import dataclass, field
from html import escape
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from renderer import __version__
from renderer.colour.bands import LUMINANCE_WEIGHTS, XYZ_TO_BT709
from renderer.pictures.camera import View
from renderer.pictures.image import exposure, white_balance
from renderer.pictures.pseudocolour import COLOUR_MAP, DIFFERENCE, RAINBOW, scale_top
from renderer.pictures.report.data import (
    bars_data,
    geometry_data,
    lamps_of,
    solution_data,
    view_data,
)
from renderer.pictures.report.files import scene_files
from renderer.pictures.report.pack import CURVE_ERROR, LOGARITHM_ERROR, Pack
from renderer.pictures.report.tables import files_list, plan_table, readings_table, tiles
from renderer.readings.finding import Finding, headline
from renderer.readings.reading import Reading
from renderer.records.finding import solution_finding
from renderer.solving.solution import Solution
from renderer.system.files import whole_file


@dataclass(frozen=True)
class ReportRoom:
    """A room of the page, solved in RGB and in 31 bands on one transport.

    solutions, readings, records : by band set
    """

    solutions: dict[str, Solution]
    readings: dict[str, list[Reading]]
    records: dict[str, dict]
    view: View | None
    files: list[dict] = field(default_factory=list)

    @property
    def scene(self):
        """The scene of the solutions."""
        return self.solutions["31"].scene

    @property
    def finding(self) -> Finding:
        """RGB's error in the room."""
        return solution_finding(self.solutions["rgb"], self.solutions["31"], self.readings["31"])

    @property
    def title(self) -> str:
        """The scene's title."""
        return self.scene.title


def save_report(
    rooms: list[ReportRoom], command: str, notes: list[str], path: Path, outside: bool = False
) -> Path:
    """Write the page.

    command : the command line for it
    notes : sentences about departures from the scene files
    outside : include files outside a scene's folder
    """
    with whole_file(path) as part:
        part.write_text(page(rooms, command, notes, outside), encoding="utf-8")
    return path


def page(rooms: list[ReportRoom], command: str, notes: list[str], outside: bool = False) -> str:
    """The page as text; arguments as for `save_report`."""
    rooms = [
        ReportRoom(r.solutions, r.readings, r.records, r.view, scene_files(r.scene, outside)) for r in rooms
    ]
    pack = Pack()
    data = _data(rooms, pack)
    folder = Path(__file__).parent
    three = gzip.decompress((folder / "three.min.js.gz").read_bytes()).decode()
    own = _script(folder)
    titles = " · ".join(dict.fromkeys(room.title for room in rooms))
    filled = {
        "policy": _policy([three, own]), "title": escape(titles),
        "finding": escape(headline([room.finding for room in rooms])), "tiles": tiles(rooms),
        "style": (folder / "report.css").read_text(encoding="utf-8"),
        "notes": "".join(f"<p>{escape(note)}</p>" for note in notes),
        "readings": readings_table(rooms), "plan": plan_table(rooms), "files": files_list(rooms),
        "command": escape(command), "versions": escape(_versions()),
        "data": json.dumps(data, allow_nan=False).replace("<", "\\u003c"), "numbers": pack.base64(),
        "three": three, "own": own,
        "licence": escape((folder / "three.LICENSE.txt").read_text(encoding="utf-8").strip()),
        "error": f"{LOGARITHM_ERROR + CURVE_ERROR:.2%}",
    }
    parts = (folder / "report.html").read_text(encoding="utf-8").split("{{")
    return parts[0] + "".join(filled[name] + rest for name, rest in (p.split("}}", 1) for p in parts[1:]))


def _script(folder: Path) -> str:
    """The page's own scripts as one function, in the order of their dependence; three.js comes before
    them."""
    names = ("decode", "light", "colour", "readings", "pictures", "pins", "space", "page")
    end = """})().catch(problem => {
  const said = document.getElementById("failure");
  said.hidden = false;
  said.textContent = `The pictures cannot be shown by this browser (${problem.message}); the tables can.`;
  throw problem;
});
"""
    return "\n".join(['"use strict";\n(async () => {',
                      *((folder / f"{name}.js").read_text(encoding="utf-8") for name in names), end])


def _data(rooms: list[ReportRoom], pack: Pack) -> dict:
    geometries, views, lamps = {}, {}, {}
    shown = []
    for room in rooms:
        transport = room.solutions["31"].transport
        if id(transport) not in geometries:
            same = [s for r in rooms for s in r.solutions.values() if s.transport is transport]
            lamps[id(transport)] = lamps_of(same)
            geometries[id(transport)] = geometry_data(transport, lamps[id(transport)], pack)
        of = lamps[id(transport)]
        if room.view is not None and id(room.view) not in views:
            views[id(room.view)] = view_data(room.view, of, pack)
        shown.append({
            "title": room.title, "percent": room.finding.percent,
            "geometry": list(geometries).index(id(transport)),
            "view": None if room.view is None else list(views).index(id(room.view)),
            "surfaces": room.scene.surface_names,
            "materials": [s.material.name if s.material else "luminaire" for s in room.scene.surfaces],
            "solutions": {name: solution_data(s, of, pack) for name, s in room.solutions.items()},
            "bars": bars_data(room.solutions["31"], pack),
            "photometers": _photometers(room),
            "files": room.files,
        })
    return {"rooms": shown, "geometries": list(geometries.values()), "views": list(views.values()),
            "quantisation": LOGARITHM_ERROR + CURVE_ERROR, **_look(rooms), "palettes": _palettes()}


def _photometers(room: ReportRoom) -> list[dict]:
    """Name, place and reading of each photometer, for the picture and the room in three dimensions."""
    scene, view = room.scene, room.view
    places = [np.array(p.position) for p in scene.photometers]
    marks = [None if view is None or not view.transport.eye.clear(view.eye[None], place[None])[0]
             else view.camera.project(place) for place in places]
    return [{"name": p.name, "position": list(p.position), "normal": list(p.normal),
             "mark": None if mark is None else [mark[0] / view.camera.width, mark[1] / view.camera.height],
             "lx": {name: readings[k].total_lx for name, readings in room.readings.items()},
             "bar": room.readings["31"][k].uncertainty,
             "percent": room.readings["31"][k].rgb_error_percent}
            for k, (p, mark) in enumerate(zip(scene.photometers, marks, strict=True))]


def _look(rooms: list[ReportRoom]) -> dict:
    """One exposure, white balance and scale for all pictures of the page."""
    first = rooms[0].solutions["rgb"]
    balance = white_balance(first.flux.sum(axis=0) @ first.bands.xyz).T
    totals, masks = [], []
    brightest = 0.0
    for room in rooms:
        for solution in room.solutions.values():
            brightest = max(brightest, float((solution.irradiance @ solution.bands.luminous).max(initial=0)))
            if room.view is not None:
                xyz = solution.bands.xyz
                totals.append(room.view.direct(solution, xyz) + room.view.indirect(solution, xyz))
                masks.append(room.view.shows_surface)
    exposed = exposure([total @ balance for total in totals], masks)
    lux = scale_top([np.array([brightest])], [np.array([True])])
    return {"toRgb": XYZ_TO_BT709.tolist(), "grey": LUMINANCE_WEIGHTS.tolist(), "balance": balance.tolist(),
            "gain": exposed.gain, "white": exposed.white,
            "top": {"luminance": scale_top([total[..., 1] for total in totals], masks), "illuminance": lux}}


def _palettes() -> dict:
    from matplotlib import colormaps

    steps = np.linspace(0, 1, 256)
    palettes = {"viridis": COLOUR_MAP, "cividis": "cividis", "magma": "magma", "rainbow": RAINBOW,
                "difference": DIFFERENCE}
    return {name: colormaps[of](steps, bytes=True)[:, :3].tobytes().hex() for name, of in palettes.items()}


def _policy(scripts: list[str]) -> str:
    """The content security policy of the page: only these scripts, and nothing from elsewhere."""
    hashes = " ".join(f"'sha256-{base64.b64encode(hashlib.sha256(s.encode()).digest()).decode()}'"
                      for s in scripts)
    return (f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data: blob:; "
            "base-uri 'none'; form-action 'none'")


def _versions() -> str:
    def of(package: str) -> str:
        try:
            return f"{package} {version(package)}"
        except PackageNotFoundError:
            return f"{package} (not installed)"

    return ", ".join([
        f"renderer {__version__}", f"Python {platform.python_version()}", of("numpy"), of("scipy")])
