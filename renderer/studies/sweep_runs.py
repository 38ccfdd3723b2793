"""The runs of a sweep: batches of rooms on this machine's cores or on Dask, and a journal of finished
rooms."""

import json
import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import active_children, get_context, parent_process
from pathlib import Path
from signal import SIG_IGN, SIGINT, signal
from threading import Thread

from renderer.colour.tables import cie_1931
from renderer.errors import InputError, SolveError
from renderer.readings.alpha_opic import equivalent_daylight
from renderer.solving.refine import solve_and_read
from renderer.solving.transport_store import Progress, TransportStore
from renderer.studies.cluster import as_done, connected_client
from renderer.studies.sweep import Base, Study, StudyCase, contents, identity, scene_of
from renderer.system.cache import user_cache
from renderer.system.files import whole_file
from renderer.system.text import CsvWriter

MAX_WORKER_DEATHS = 3
"""Number of workers that may die in a row, without a finished batch, before the run ends."""
READING_COLUMNS = (
    "photometer",
    "direct_lx",
    "indirect_lx",
    "total_lx",
    "uncertainty_lx",
    "bands_lx",
    "x",
    "y",
    "melanopic_edi_lx",
    "rgb_error_percent",
    "fault",
)

ReadingRows = list[dict]


@dataclass(frozen=True)
class Batch:
    """Rooms of one base by identity; they share their form factors where the geometry is not varied."""

    base: Base
    cases: dict[str, StudyCase]
    cached: bool

    def run(self) -> list[tuple[str, ReadingRows]]:
        """Identity and rows of each case. Raises InputError where a file has changed since the study was
        read."""
        done = [(name, case_rows(self.base, case, rooms_for(self))) for name, case in self.cases.items()]
        path, files = self.base.scene.path, self.base.files
        if contents((path.parent, self.base.folder), files) != files:
            raise InputError(f"{path}: a file that it names has changed since the study was read. Give "
                             "the same command again.")
        return done


_kept: dict[str, TransportStore] = {}


def rooms_for(batch: Batch) -> TransportStore:
    """The store of form factors for a batch's base on this worker, shared by all batches of that base."""
    key = f"{batch.base.scene.geometry_key} {batch.cached}"
    if key not in _kept:
        _kept.clear()
        _kept[key] = TransportStore(user_cache() if batch.cached else None)
    return _kept[key]


def case_rows(base: Base, case: StudyCase, store: TransportStore) -> ReadingRows:
    """One row for each reading of a room; one row with the reason for a room that cannot be solved."""
    try:
        scene = scene_of(base, case.values)
        if scene.geometry_key != base.scene.geometry_key:
            store = TransportStore(store.cache)
        _, readings = solve_and_read(scene, store=store)
    except (InputError, SolveError) as error:
        fault = str(error).removeprefix(f"{base.scene.path}: ")  # the row names the room
        return [{**dict.fromkeys(READING_COLUMNS), "fault": fault}]
    rows = []
    for reading in readings:
        x = y = opic = None
        if reading.power is not None and reading.total_lx > 0:
            xyz = reading.power @ cie_1931()[1]
            x, y = (float(part) for part in xyz[:2] / xyz.sum())
            opic = float(equivalent_daylight(reading.power)[-1])
        rows.append(
            dict(
                zip(
                    READING_COLUMNS,
                    (
                        reading.name,
                        reading.direct_lx,
                        reading.indirect_lx,
                        reading.total_lx,
                        reading.uncertainty,
                        reading.band_error,
                        x,
                        y,
                        opic,
                        reading.rgb_error_percent,
                        None,
                    ),
                    strict=True,
                )
            )
        )
    return rows


class Journal:
    """The finished rooms of a study, one line for each; a room with an incomplete or damaged line counts as
    not finished.

    study : path, relative to the journal's folder, of the study whose table lies beside it; None for an
        unknown one
    """

    def __init__(self, path: Path):
        self.path, self.done, self.study = path, {}, None
        for line in path.read_bytes().splitlines() if path.is_file() else ():
            try:
                said = json.loads(line)
            except (ValueError, RecursionError):
                continue
            match said:
                case {"study": str(study)}:
                    self.study = study
                case [str(name), [_, *_] as rows] if all(
                    isinstance(r, dict) and r.keys() >= set(READING_COLUMNS) for r in rows
                ):
                    self.done[name] = rows

    def own(self, study: Path, table: Path) -> None:
        """Record the study of the table. Raises InputError for another study's table."""
        folder, mine = self.path.parent.resolve(), study.resolve()
        owner = folder / self.study if self.study is not None else mine
        if table.is_file() and owner.is_file() and not owner.samefile(mine):
            raise InputError(f"{table} is of another study, {owner.resolve()}. Give another --out, or rename "
                             "one of them.")
        said = os.path.relpath(mine, folder) if mine.anchor == folder.anchor else str(mine)
        if said != self.study:
            self._write([{"study": said}])
            self.study = said

    def add(self, results: list[tuple[str, ReadingRows]]) -> None:
        """Record finished rooms on disk."""
        new = [(name, rows) for name, rows in results if name not in self.done]
        self._write(new)
        self.done.update(new)

    def _write(self, lines: list) -> None:
        torn = self.path.is_file() and self.path.stat().st_size and self.path.read_bytes()[-1:] != b"\n"
        with self.path.open("a", encoding="utf-8") as file:
            file.write("\n" * bool(torn))
            file.writelines(json.dumps(line, allow_nan=False) + "\n" for line in lines)
            file.flush()
            os.fsync(file.fileno())


def run_sweep(study: Study, out: Path, cached: bool, scheduler: str | None,
          progress: Progress) -> tuple[list[Path], int, int]:
    """Solve the rooms that are not finished, and write the table.

    scheduler : address of a Dask scheduler; None for this machine's cores

    Returns the files, the number of rooms solved now, and that of all rooms. Raises InputError or SolveError.
    """
    journal, table = Journal(out / f".{study.path.stem}.journal"), out / f"{study.path.stem}.csv"
    journal.own(study.path, table)
    todo = {name: case for case in study.cases()
            if (name := identity(study.bases[case.base], case)) not in journal.done}
    size = max(1, min(16, len(todo) // (4 * (os.cpu_count() or 1))))  # at least four batches a core
    batches = [Batch(base, dict(cases[k : k + size]), cached) for number, base in enumerate(study.bases)
               if (cases := [each for each in todo.items() if each[1].base == number])
               for k in range(0, len(cases), size)]
    total, finished = len(study), len(study) - len(todo)
    progress(f"{study.path.name}: {finished} of {total} rooms are done already")
    elsewhere = scheduler is not None and batches
    for results in on_cluster(batches, scheduler) if elsewhere else on_cores(batches):
        journal.add(results)
        finished += len(results)
        progress(f"{study.path.name}: {finished} of {total} rooms")
    return [_table(study, journal, table)], len(todo), total


def on_cores(batches: list) -> Iterator[list]:
    """Results of batches in the order of completion; the batches of a dead worker are repeated. Raises
    SolveError."""
    left, deaths = dict(enumerate(batches)), 0
    workers = max(1, min(os.cpu_count() or 1, len(batches)))
    while left:
        pool = ProcessPoolExecutor(workers, get_context("spawn"), _heed_parent)
        try:
            with _each_on(max(1, (os.cpu_count() or 1) // workers)):
                running = {pool.submit(batch.run): number for number, batch in left.items()}
            for future in as_completed(running):
                results = future.result()
                del left[running[future]]
                deaths = 0
                yield results
        except BrokenProcessPool:
            deaths += 1
            if deaths == MAX_WORKER_DEATHS:
                raise SolveError(f"a worker died {MAX_WORKER_DEATHS} times without finishing a batch, "
                                 "perhaps because memory ran out. Give a looser --accuracy; finished work "
                                 "is kept.") from None
        finally:
            for worker in active_children() if left else ():
                worker.terminate()
            pool.shutdown(wait=not left, cancel_futures=True)


@contextmanager
def _each_on(cores: int) -> Iterator[None]:
    """Set the number of cores for processes that start within the context, and for their BLAS, which reads it
    from the environment when it is imported."""
    ours = dict.fromkeys(("RENDERER_CORES", "OPENBLAS_NUM_THREADS"), str(cores))
    before = {name: os.environ.get(name) for name in ours}
    os.environ.update(ours)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _heed_parent() -> None:
    """Let a worker ignore Ctrl-C, because the parent then ends its workers, and let it end when the parent
    dies."""
    signal(SIGINT, SIG_IGN)

    def end_with_it() -> None:
        parent_process().join()
        os._exit(1)

    Thread(target=end_with_it, daemon=True).start()


def on_cluster(batches: list, scheduler: str) -> Iterator[list]:
    """Results of batches from Dask workers with the same program and the same files. Raises InputError or
    SolveError."""
    with connected_client(scheduler) as client:
        yield from as_done(
            [client.submit(_run, batch, pure=False, retries=MAX_WORKER_DEATHS) for batch in batches], client
        )


def _run(batch) -> list:
    return batch.run()


def _table(study: Study, journal: Journal, path: Path) -> Path:
    """Write all rows in the study's order: the room, the value of each key, the reading."""
    with whole_file(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = CsvWriter(file)
        writer.writerow(["scene", *study.vary, *READING_COLUMNS])
        for case in study.cases():
            base = study.bases[case.base]
            values = [v if isinstance(v, (str, int, float)) else json.dumps(v) for v in case.values.values()]
            for row in journal.done[identity(base, case)]:
                writer.writerow([base.name, *values, *(row[key] for key in READING_COLUMNS)])
    return path
