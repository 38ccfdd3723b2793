"""A trade-off of cost and accuracy as a table, a chart and a paragraph."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from renderer.pictures.front import save_front
from renderer.records.json_records import Table
from renderer.studies.tradeoff import TARGETS, Setting, Tradeoff
from renderer.system.files import whole_file
from renderer.system.text import CsvWriter


def save_tradeoff(found: Tradeoff, out: Path) -> list[Path]:
    """Write <scene>_tradeoff.csv, .md and .png; returns the files."""
    stem = f"{found.scene.path.stem}_tradeoff"
    front, files = found.front, [out / f"{stem}.csv", out / f"{stem}.md"]
    columns = ("bands", "method", "patch_size_m", "rays_per_patch", "patches", "seconds_geometry",
               "seconds_bands", "seconds", "error_photometers", "error_surfaces", "on_front")
    with whole_file(files[0]) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = CsvWriter(file)
        writer.writerow(columns)
        for s in found.settings:
            seconds = (f"{x:.4g}" for x in (s.transport, s.solve, s.seconds))
            writer.writerow([s.bands, s.method, f"{s.patch_size:.4g}", s.rays, s.patches, *seconds,
                             f"{s.photometers:.3g}", f"{s.surfaces:.3g}", int(s in front)])
    with whole_file(files[1]) as part:
        part.write_text("\n".join(_markdown(found)) + "\n", encoding="utf-8")
    marked = list(dict.fromkeys(s for s in map(found.recommended, TARGETS) if s))
    note = ", Lambertian lamps" if found.asked.lambertian else ""
    return [*files, save_front(found.scene.title, found.settings, front, marked, found.floor,
                               out / f"{stem}.png", found.asked.asked, found.asked.peers, note)]


def recommendations(found: Tradeoff) -> Table:
    """The recommended setting for each of TARGETS."""
    rows = []
    for target in TARGETS:
        best = found.recommended(target)
        none = "none of these" if target >= found.floor else _beyond(found)
        rows.append([f"{target:.1%}", *([none] + ["–"] * 5 if best is None else _cells(best))])
    return Table(f"{found.scene.title}: recommended settings",
                 ["error", "bands", "factors", "patch m", "patches", "time s", "its error"], rows)


def _beyond(found: Tradeoff) -> str:
    """The reason why there is no recommendation for a target below the reference's own error."""
    return f"the reference is known to {_percent(found.floor)} only"


def _cells(s: Setting) -> list[str]:
    factors = f"{s.rays} rays, accuracy {s.accuracy:g}" if s.rays else "exact"
    return [s.bands, factors, f"{s.patch_size:.3g}", str(s.patches), f"{s.seconds:.2g}", _percent(s.error)]


def _markdown(found: Tradeoff) -> list[str]:
    table = asked_table(found)
    return [f"| {' | '.join(table.columns)} |", "|" + "---|" * len(table.columns),
            *(f"| {' | '.join(row)} |" for row in table.rows), "", " ".join(three_sentences(found))]


def asked_table(found: Tradeoff) -> Table:
    """Times and errors of `--accuracy`."""
    rows = [[f"{100 * a.accuracy:g} %", f"{a.seconds:.2g}", _percent(a.bar), _percent(a.error)]
            for a in found.asked.asked]
    return Table(f"{found.scene.title}: time and error with --accuracy, against readings known to "
                 f"{_percent(found.asked.floor)}",
                 ["--accuracy", "time s", "widest bar", "largest error"], rows)


def three_sentences(found: Tradeoff) -> list[str]:
    """Captions of the picture: on `--accuracy`, on other programs, on the settings."""
    asked, floor = found.asked.asked, found.asked.floor
    off = [a for a in asked if a.error > a.bar + floor]
    span = (f"From --accuracy {100 * asked[0].accuracy:g} % to {100 * asked[-1].accuracy:g} % the time of "
            f"all readings rises from {asked[0].seconds:.2g} to {asked[-1].seconds:.2g} s")
    if off:
        said = (f"{span}; with {_listed(a.accuracy for a in off)} the error of a reading is larger than the "
                f"widest bar: {_percent(max(a.error for a in off))} at most.")
    else:
        said = (f"{span}; no error is larger than the widest bar, against a much finer solution that is "
                f"known to {_percent(floor)}.")
    return [said, _of_peers(found), _of_bands(found)]


def _of_peers(found: Tradeoff) -> str:
    own = next((a for a in found.asked.asked if a.accuracy == 0.01), None)
    if own is None or not found.asked.peers:
        return " ".join(found.asked.skipped)
    given = ", with Lambertian lamps of the same outlines in place of files" if found.asked.lambertian else ""
    times = " and ".join(f"about {_seconds_to(peer.points, own.bar):.2g} s of {peer.name} {peer.version}"
                         for peer in found.asked.peers)
    ours = f"With 1 % this program needs {own.seconds:.2g} s, and its bars are {_percent(own.bar)} at most"
    theirs = f"for errors of that size, with all meters in one run, {times} are needed{given}."
    return " ".join([f"{ours}; {theirs}", *found.asked.skipped])


def _seconds_to(points: Sequence[tuple[float, float]], error: float) -> float:
    """Time [s] from which a curve of (seconds, error) stays within an error. Between points the curve is
    straight in logarithms; past its end the error falls as 1/√seconds."""
    outside = [k for k, (_, e) in enumerate(points) if e > error]
    if not outside:
        return points[0][0]
    seconds, above = points[outside[-1]]
    if outside[-1] == len(points) - 1:
        return seconds * (above / error) ** 2
    later, below = points[outside[-1] + 1]
    share = np.log(above / error) / np.log(above / max(below, 1e-12))
    return float(seconds * (later / seconds) ** share)


def _of_bands(found: Tradeoff) -> str:
    by = {name: [s for s in found.settings if s.bands == name] for name in ("31", "rgb")}
    dearer = np.median([a.seconds / b.seconds for a, b in zip(by["31"], by["rgb"], strict=True)])
    target, best = next(((t, s) for t in (0.01, 0.05) if (s := found.recommended(t))), (None, None))
    exact = {name: _percent(min(s.error for s in of)) for name, of in by.items()}
    said = (f"On one mesh 31 bands take {dearer:.3g} times as long as RGB; the smallest error is "
            f"{exact['rgb']} in RGB and {exact['31']} in 31 bands")
    if best is None:
        return f"{said}."
    return (f"{said}. Of {len(found.settings)} settings without bars, bands = \"{best.bands}\" and "
            f"patch_size = {best.patch_size:.3g} are recommended for {100 * target:g} %: {best.seconds:.2g} "
            f"s, error {_percent(best.error)}.")


def words(found: Tradeoff) -> str:
    """The trade-off in one paragraph."""
    by = {name: [s for s in found.settings if s.bands == name] for name in {s.bands for s in found.settings}}
    dearer = np.median([a.seconds / b.seconds for a, b in zip(by["31"], by["rgb"], strict=True)])
    share = np.median([s.transport / s.seconds for s in found.settings])
    exact = {name: min(s.error for s in of) for name, of in by.items()}
    said = [f"{found.scene.title}: {len(found.settings)} settings, compared with {found.reference}, whose "
            f"readings are known to {_percent(found.floor)}.",
            f"Half of the settings spend more than {share:.0%} of their time on form factors and meters, "
            f"which are the same for every band set: 31 bands take {dearer:.3g} times as long as RGB.",
            f"The smallest errors are {_percent(exact['rgb'])} in RGB, {_percent(exact['rgb-prefiltered'])} "
            f"prefiltered, {_percent(exact['6'])} with six nodes, {_percent(exact['9'])} in 9 bands, "
            f"{_percent(exact['16'])} in 16 and {_percent(exact['31'])} in 31."]
    beyond = [t for t in TARGETS if t < found.floor]
    for best in dict.fromkeys(found.recommended(t) for t in TARGETS if t not in beyond):
        targets = _listed(t for t in TARGETS if t not in beyond and found.recommended(t) is best)
        if best is None:
            said.append(f"None of these settings is within {targets}.")
            continue
        factors = f"accuracy = {best.accuracy:g}, {best.rays} rays a patch" if best.rays else "exact factors"
        said.append(f"For {targets} take bands = \"{best.bands}\" and patch_size = {best.patch_size:.3g} "
                    f"({factors}): {best.seconds:.2g} s, error {_percent(best.error)}.")
    if beyond:
        said.append(f"For {_listed(beyond)} nothing is recommended: {_beyond(found)}.")
    return " ".join(said)


def _listed(targets: Iterable[float]) -> str:
    return " and ".join(f"{100 * t:g} %" for t in targets)


def _percent(x: float) -> str:
    return f"{100 * x:.2g} %" if x >= 1e-4 else "under 0.01 %"
