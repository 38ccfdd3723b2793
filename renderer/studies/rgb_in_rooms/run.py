"""The run of the study: one room at a time on all cores or on Dask workers. Each room is recorded when it is
finished."""

import hashlib
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.reading import load, resolved
from renderer.scene.scene import Scene
from renderer.solving.transport_store import Progress
from renderer.studies.rgb_in_rooms.drawn_rooms import drawn_room
from renderer.studies.rgb_in_rooms.gains import RoomGains, room_gains
from renderer.studies.rgb_in_rooms.models import BAND_MODELS, LAMPS, REFERENCE, BandModel, models_under
from renderer.studies.rgb_in_rooms.palettes import Painting, one_paint, paintings
from renderer.studies.sweep_runs import on_cluster, on_cores
from renderer.system.cache import program
from renderer.system.files import whole_file

PACKAGED_ROOMS = ("grey_room", "furnished_room", "l_shaped", "office", "classroom", "gallery")
"""Packaged rooms for the study's paints, lamps and meters, without the red rooms, which have the shape of the
grey one."""
PAINTINGS = (4, 4, 4)
"""Paintings of each room: architectural, accent, extreme."""
LAMP_DEPENDENT_MODELS = ("6", "prefiltered")
"""Models whose bands depend on the lamp."""


@dataclass(frozen=True)
class RoomTask:
    """One room of the study.

    number : of a drawn room, or −k for the k-th packaged one
    seed : of the study
    fine : whether it is solved on the finer mesh
    """

    number: int
    seed: int
    fine: bool = False

    @property
    def name(self) -> str:
        """Name of the room's file."""
        return f"{self.number:+05d}{'_fine' if self.fine else ''}"

    def run(self) -> list[tuple[str, dict[str, np.ndarray]]]:
        """The room's name and arrays."""
        return [(self.name, studied(self))]


def studied(task: RoomTask) -> dict[str, np.ndarray]:
    """The arrays of one room.

    totals : (n_paintings, n_lamps, 1 + n_models, 4) READINGS per lumen, the reference first
    direct : (4,) READINGS of direct light per lumen
    gains_61, gains_31, gains_16, gains_9, gains_rgb : (n_paintings, 4, n_bands) READINGS of reflected light
        per lumen in each band
    gains_6, gains_prefiltered : (n_paintings, n_lamps, 4, n_bands) gains for LAMP_DEPENDENT_MODELS
    one_paint : (4, 16) indirect gains of the room in one paint, at Chebyshev points of its reflectance
    mean_rgb : (n_paintings, 3) mean linear BT.709 reflectance of all surfaces by area
    geometry_seconds : processor time [s] of form factors, direct light and meters
    solve_seconds : (1 + n_models,) processor time [s] of one painting in each model
    palette, name, paint : of each painting
    kind : of the room, with its lighting
    """
    scene, kind = _scene(task)
    size, rays = patches_and_rays(scene, kind)
    began = time.process_time()
    gains = room_gains(scene, size / np.sqrt(1 + task.fine), rays * (1 + task.fine), task.seed + task.fine)
    geometry_seconds = time.process_time() - began
    random = np.random.default_rng((task.seed, abs(task.number), task.number < 0))
    painted = paintings(scene, random, PAINTINGS)
    solved = [solve_painting(gains, painting) for painting in painted]
    nodes = 0.5 + 0.5 * np.cos(np.pi * (np.arange(16) + 0.5) / 16)
    reflecting = one_paint(scene, np.ones(81), "", "", 0).curves[:, :1]
    return {
        "totals": np.array([totals for totals, _ in solved]),
        "direct": gains.direct,
        **{f"gains_{name}": np.array([parts[name] for _, parts in solved])
           for name in solved[0][1]},
        "one_paint": gains.indirect(reflecting * nodes),
        "mean_rgb": np.array([_mean_rgb(gains, lamp_models()["D65"]["rgb"], each) for each in painted]),
        "geometry_seconds": np.array(geometry_seconds),
        "solve_seconds": _solve_seconds(gains, painted[0]),
        "kind": np.array(kind),
        **{key: np.array([getattr(each, key) for each in painted]) for key in ("palette", "name", "paint")},
    }


def patches_and_rays(scene: Scene, kind: str) -> tuple[float, int]:
    """Length of the study's patches in a room [m], and rays per patch; none in an empty convex room.

    kind : of the room, with its lighting
    """
    # A ceiling above uplights is brightest just above them.
    count = 1800 if kind.endswith("indirect") else 450
    empty = scene.room.convex and len(scene.surfaces) == len(scene.room.surfaces)
    return float(np.sqrt(scene.room.area / count)), 0 if empty else 128


@cache
def lamp_models() -> dict[str, dict[str, BandModel]]:
    """Every model under every lamp of the study."""
    return {lamp: models_under(lamp) for lamp in LAMPS}


def _solve_seconds(gains: RoomGains, painting: Painting) -> np.ndarray:
    """Processor time [s] of one painting in the reference and each model (1 + n_models,)."""
    seconds, models = [], lamp_models()["LED-B3"]
    for name in (REFERENCE, *BAND_MODELS):
        reflectance = models[name].reflectance(painting.curves)
        began = time.process_time()
        gains.indirect(reflectance)
        seconds.append(time.process_time() - began)
    return np.array(seconds)


def _mean_rgb(gains: RoomGains, rgb: BandModel, painting: Painting) -> np.ndarray:
    """Mean linear BT.709 reflectance (3,) of all surfaces by area; luminaires are black."""
    areas, surface = gains.transport.exchange.areas, gains.transport.mesh.surface
    return areas @ rgb.reflectance(painting.curves)[surface] / areas.sum()


def _scene(task: RoomTask) -> tuple[Scene, str]:
    """The room of a task with the study's meters, and its kind."""
    folder = load(PACKAGED_ROOMS[0]).path.parent
    if task.number >= 0:
        table, kind, lighting = drawn_room(task.number, task.seed)
        return resolved(table, folder / "study.toml"), f"{kind}, {lighting}"
    name = PACKAGED_ROOMS[-task.number - 1]
    return _with_meters(load(name)), f"packaged, {name}"


def _with_meters(scene: Scene) -> Scene:
    """A packaged room with the study's meters, where these stand free."""
    from dataclasses import replace

    table, _, _ = drawn_room(2)  # a corridor, without furniture, has all meters
    low, high = scene.room.bounds
    drawn = np.array(table["room"]["size"])
    meters = []
    for meter in table["photometers"]:
        share = np.array(meter["position"]) / drawn
        height = meter["position"][2]
        point = np.array([*(low + share * (high - low))[:2], low[2] + height])
        where = type(scene.photometers[0]) if scene.photometers else None
        made = where(name=meter["name"], position=point.tolist(), normal=meter["normal"])
        if _stands_free(scene, point):
            meters.append(made)
    return replace(scene, photometers=meters)


def _stands_free(scene: Scene, point: np.ndarray) -> bool:
    from renderer.scene.buried import refuse_buried
    from renderer.scene.room import refuse_place_outside

    try:
        refuse_place_outside(scene.room, point, "meter", "")
        refuse_buried(scene.bodies, point + [0, 0, 1e-3], scene.room.scale, "meter")
    except InputError:
        return False
    return True


def solve_painting(gains: RoomGains, painting: Painting) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Totals (n_lamps, 1 + n_models, 4) of one painting, and its indirect gains by the name of the model."""
    lamps = lamp_models()
    columns: dict[tuple[str, str], np.ndarray] = {}
    for lamp, models in lamps.items():
        for name, model in models.items():
            if (key := _columns_of(name, lamp)) not in columns:
                columns[key] = model.reflectance(painting.curves)
    widths = np.cumsum([each.shape[1] for each in columns.values()])[:-1]
    parts = dict(zip(columns, np.split(gains.indirect(np.hstack(list(columns.values()))), widths, axis=1),
                     strict=True))
    totals = np.array([[gains.direct + parts[_columns_of(name, lamp)] @ models[name].shares
                        for name in (REFERENCE, *BAND_MODELS)] for lamp, models in lamps.items()])
    kept = {name: parts[name, ""] for name, lamp in columns if not lamp}
    for name in LAMP_DEPENDENT_MODELS:
        kept[name] = np.array([parts[name, lamp] for lamp in lamps])
    return totals, kept


def _columns_of(name: str, lamp: str) -> tuple[str, str]:
    """Key of a model's reflectances: three models share those of RGB, and most models serve all lamps."""
    return (name, lamp) if name in LAMP_DEPENDENT_MODELS else (name.partition(",")[0], "")


def run_study(rooms: int, seed: int, out: Path, scheduler: str | None, progress: Progress) -> Path:
    """Solve the rooms that are not solved yet, and write the arrays of each into a folder under `out`.

    rooms : number of drawn rooms, beside the packaged ones

    Every 11th room is also solved with twice the patches and other rays, for the numerical error. 11 has no
    factor in common with the numbers of kinds and lightings, so that rooms of each are checked. Returns the
    folder. Raises InputError or SolveError.
    """
    folder = out / f"study_{program_and_rule(seed)}"
    tasks = [RoomTask(-k, seed) for k in range(1, len(PACKAGED_ROOMS) + 1)]
    for number in range(rooms):
        tasks.append(RoomTask(number, seed))
        if number % 11 == 0:
            tasks.append(RoomTask(number, seed, fine=True))
    todo = [task for task in tasks if not (folder / f"{task.name}.npz").is_file()]
    finished, total = len(tasks) - len(todo), len(tasks)
    progress(f"study: {finished} of {total} rooms are done already")
    for results in on_cluster(todo, scheduler) if scheduler and todo else on_cores(todo):
        for name, arrays in results:
            with whole_file(folder / f"{name}.npz") as part, part.open("wb") as file:
                np.savez_compressed(file, **arrays)
        finished += len(results)
        progress(f"study: {finished} of {total} rooms")
    return folder


def program_and_rule(seed: int) -> str:
    """Digest, in eight characters, of the program and the seed."""
    return hashlib.blake2b(f"{program()} {seed}".encode(), digest_size=4).hexdigest()


@dataclass(frozen=True)
class StudiedRoom:
    """The arrays of one room, as in `studied`."""

    number: int
    fine: bool
    arrays: dict[str, np.ndarray]

    @property
    def kind(self) -> str:
        """The room's kind with its lighting."""
        return str(self.arrays["kind"])


def read_rooms(folder: Path) -> Iterator[StudiedRoom]:
    """The rooms of a folder, packaged ones first."""
    for path in sorted(folder.glob("*.npz"), key=lambda p: (p.stem.endswith("_fine"), int(p.stem[:5]))):
        with np.load(path, allow_pickle=False) as file:
            yield StudiedRoom(int(path.stem[:5]), path.stem.endswith("_fine"), dict(file))


