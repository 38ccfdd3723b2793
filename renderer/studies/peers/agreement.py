"""Readings of the same rooms in this program and in other programs, with the error bars of both."""

import json
from dataclasses import dataclass, replace
from importlib.metadata import version
from importlib.util import find_spec
from math import floor, hypot, log10
from pathlib import Path

from renderer.colour.materials import Material
from renderer.scene.reading import load
from renderer.scene.scene import Scene
from renderer.solving.solution import solve
from renderer.solving.transport_store import Progress, TransportStore
from renderer.studies.peers import mitsuba3, radiance
from renderer.studies.peers.export import CannotRun, Value
from renderer.system.files import whole_file


@dataclass(frozen=True)
class ComparedReading:
    """One reading in this program, and in each peer by its name."""

    room: str
    meter: str
    ours: Value
    peers: dict[str, Value]

    def difference(self, peer: str) -> float:
        """Difference of our reading from a peer's, relative to the peer's [1]; in lx where the peer's is
        0."""
        return (self.ours.lx - self.peers[peer].lx) / (self.peers[peer].lx or 1.0)

    def agrees(self, peer: str) -> bool:
        """Whether our reading and a peer's differ by at most 0.5 % or the peer's error bar."""
        other = self.peers[peer]
        return abs(self.ours.lx - other.lx) <= max(0.005 * other.lx, other.half_width)

    def within_bars(self, peer: str) -> bool:
        """Whether both error bars together, and chance, account for the difference.

        The limit is 1.7 combined 95 % bars (3.3 standard errors instead of 1.96, Bonferroni): by chance, one
        of 52 comparisons then exceeds it in one run of twenty.
        """
        other = self.peers[peer]
        both = hypot(self.ours.half_width, other.half_width)
        return abs(self.ours.lx - other.lx) <= 1.7 * both

    @property
    def verdict(self) -> str:
        """`agree`, `within both bars`, or the peers that differ."""
        apart = [peer for peer in self.peers if not self.agrees(peer)]
        against = [peer for peer in apart if not self.within_bars(peer)]
        if against:
            return f"not {', '.join(against)}"
        return "within both bars" if apart else "agree" if self.peers else "–"


@dataclass(frozen=True)
class Agreement:
    """All readings, and a sentence for each peer that could not run."""

    rows: list[ComparedReading]
    skipped: list[str]

    @property
    def failed(self) -> list[ComparedReading]:
        """The readings that differ from a peer's by more than 0.5 %, the error bars and chance."""
        return [row for row in self.rows if row.verdict.startswith("not")]


def rooms() -> list[Scene]:
    """The compared rooms: a box with five reflectances, a partition, an L, an uplight."""
    folder = Path(__file__).parent / "rooms"
    box = load(folder / "box.toml")
    paints = [Material("paint", flat=rho) for rho in (0.05, 0.2, 0.5, 0.8, 0.9)]
    painted = [replace(box, title=f"box, ρ = {paint.flat:g}", materials=[paint] * len(box.room.surfaces))
               for paint in paints]
    return painted + [load(folder / f"{name}.toml") for name in ("occluder", "l_shaped", "uplight")]


def compare_with_peers(scenes: list[Scene], progress: Progress, accuracy: float = 0.005) -> Agreement:
    """Read all photometers of all scenes in RGB, here to an accuracy [1] and in each peer that can run."""
    shared = TransportStore()
    ours = [solve(scene, "rgb", accuracy, store=shared, progress=progress).photometers()
            for scene in scenes]
    theirs, skipped = {}, []
    for name, readings in ((mitsuba3.NAME, mitsuba3.readings_in_mitsuba),
                           (radiance.NAME, radiance.readings_in_radiance)):
        try:
            theirs[name] = readings(scenes, progress)
        except CannotRun as sentence:
            skipped.append(str(sentence))
    rows = [ComparedReading(scene.title, reading.name, Value(reading.total_lx, reading.uncertainty),
                {name: values[k][m] for name, values in theirs.items()})
            for k, scene in enumerate(scenes) for m, reading in enumerate(ours[k])]
    return Agreement(rows, skipped)


def columns(agreement: Agreement) -> list[str]:
    """Headings of the table."""
    peers = [text for name in _ran(agreement) for text in (f"{name} lx", "difference")]
    return ["room", "meter", "renderer lx", *peers, "verdict"]


def table_cells(agreement: Agreement) -> list[list[str]]:
    """The cells of the table as text, one list a reading."""
    table = []
    for row in agreement.rows:
        peers = [text for name in _ran(agreement)
                 for text in (_bar(row.peers[name]), _percent(row.difference(name)))]
        table.append([row.room, row.meter, _bar(row.ours), *peers, row.verdict])
    return table


def peers_markdown(agreement: Agreement) -> str:
    """The table for docs/verification.md, with sentences about peers that did not run."""
    lines = [columns(agreement), ["---"] * len(columns(agreement)), *table_cells(agreement)]
    table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    return "\n\n".join([table, *agreement.skipped]) + "\n"


def record(agreement: Agreement) -> dict:
    """The comparison as an object for JSON."""
    rows = [{"room": row.room, "meter": row.meter, "renderer": row.ours._asdict(), "verdict": row.verdict,
             "peers": {name: {**peer._asdict(), "difference": row.difference(name)}
                       for name, peer in row.peers.items()}} for row in agreement.rows]
    versions = {package: version(package) for package in ("mitsuba", "pyradiance") if find_spec(package)}
    return {"rows": rows, "skipped": agreement.skipped, "versions": versions}


def save_agreement(agreement: Agreement, out: Path) -> list[Path]:
    """Write peers.json, and peers.md with the table of docs/verification.md."""
    files = [out / "peers.json", out / "peers.md"]
    with whole_file(files[0]) as part:
        part.write_text(json.dumps(record(agreement), indent=1, allow_nan=False))
    with whole_file(files[1]) as part:
        part.write_text(peers_markdown(agreement))
    return files


def _ran(agreement: Agreement) -> list[str]:
    return list(agreement.rows[0].peers) if agreement.rows else []


def _bar(read: Value) -> str:
    """A reading with its bar as text, as 142.43 ± 0.21: the half-width to two digits."""
    digits = 4 if read.half_width <= 0 else min(max(1 - floor(log10(read.half_width)), 0), 4)
    return f"{read.lx:.{digits}f} ± {read.half_width:.{digits}f}"


def _percent(difference: float) -> str:
    return f"{difference:+.2%}".replace("-", "−").replace("%", " %")
