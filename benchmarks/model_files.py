"""Model files: whether they open, and whether their geometry is right.

    .venv/bin/python benchmarks/model_files.py FOLDER … [--csv FILE] [--patches]

Prints for every model file in the folders: whether it opens, or why not; the difference in area between its
triangles and its flat polygons (half the sum of the cross products of neighbouring corners); solids,
triangles of sheets, volume; the number of faces of solids, in a sample of 64, with the solid in front of them
(by winding number); with --patches, the unknowns at 1 % of the model scaled to 1 m in a room of 3 m; seconds.
The repository contains no model files: use your own.
"""

import argparse
import csv
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.scene.model_files.read import MODEL_FORMATS, read_polygons
from renderer.scene.model_files.solids_and_sheets import areas, solids_and_sheets, volumes
from renderer.scene.model_files.triangulate import newell, triangles_of_polygons
from renderer.scene.model_files.weld import facets
from renderer.scene.room import winding

FLAT = 1e-6
"""Polygons that leave their plane by more than this share of their size have no well-defined area."""
ASKED = 64


def examined(path: Path, patches: bool) -> dict:
    """One file's row."""
    started = time.perf_counter()
    row = {"file": str(path), "format": path.suffix.lower().lstrip("."), "opens": True, "why_not": ""}
    try:
        file = read_polygons(path, "", root=path.parent)
        found = solids_and_sheets(facets(file))
    except InputError as refused:
        return {**row, "opens": False, "why_not": str(refused).removeprefix(": "),
                "seconds": round(time.perf_counter() - started, 3)}
    row["seconds"] = round(time.perf_counter() - started, 3)
    closed = found.solid >= 0
    row |= {"polygons": len(file.sizes), "triangles": len(found.faces), "area_error": area_error(file),
            "area_m2": float(areas(found.vertices, found.faces).sum()), "contacts_m2": found.contacts,
            "volume_m3": float(volumes(found.vertices, found.faces[closed],
                                       np.zeros(closed.sum(), int), 1)[0]),
            "solids": int(found.solid.max(initial=-1)) + 1, "sheet_triangles": int((~closed).sum()),
            "turned": found.turned, "inside_out": inside_out(found), "parts": len(file.names),
            "colours": sum(colour is not None for colour in file.colours)}
    if patches:
        row["patches"], row["plan_seconds"] = patches_of(path)
    return row


def area_error(file) -> float:
    """Difference in area between flat polygons and their triangles."""
    vectors = newell(file.vertices, file.corners, file.sizes)
    faces, owner = triangles_of_polygons(file.vertices, file.corners, file.sizes)
    own = np.bincount(owner, areas(file.vertices, faces), len(file.sizes))
    length = np.linalg.norm(vectors, axis=1)
    normals = vectors / np.maximum(length, 1e-300)[:, None]
    starts = np.cumsum(file.sizes) - file.sizes
    first = np.repeat(file.corners[starts], file.sizes)
    offset = file.vertices[file.corners] - file.vertices[first]
    height = np.abs(np.einsum("ki,ki->k", offset, np.repeat(normals, file.sizes, axis=0)))
    size = np.maximum.reduceat(np.linalg.norm(offset, axis=1), starts)
    flat = np.maximum.reduceat(height, starts) < FLAT * size
    apart = np.flatnonzero(flat & (np.abs(own - length) > FLAT * own))
    flat[apart] = [_simple(file, k) for k in apart]
    return float(abs(own[flat].sum() / length[flat].sum() - 1)) if length[flat].sum() > 0 else 0.0


def _simple(file, index: int) -> bool:
    """Whether a polygon does not cross itself."""
    import shapely

    start = file.sizes[:index].sum()
    ring = file.vertices[file.corners[start:start + file.sizes[index]]]
    axes = np.linalg.svd(ring - ring.mean(axis=0), full_matrices=False)[2][:2]
    return bool(shapely.Polygon((ring - ring.mean(axis=0)) @ axes.T).is_valid)


def inside_out(found) -> int:
    """Number of faces of solids, of a sample, with a negative winding number before them."""
    closed = np.flatnonzero(found.solid >= 0)
    if not len(closed):
        return 0
    some = np.random.default_rng(0).choice(closed, min(ASKED, len(closed)), replace=False)
    corners = found.vertices[found.faces[some]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.ptp(found.vertices, axis=0).max()
    points = corners.mean(axis=1) + 1e-6 * size * normals / np.linalg.norm(normals, axis=1)[:, None]
    shell = found.vertices[found.faces[closed]][:, ::-1]
    return int((winding(points, shell) < -0.5).sum())


def patches_of(path: Path) -> tuple[int, float]:
    """Unknowns of a model's own surfaces, and seconds to divide the room."""
    import renderer
    from renderer.scene.model_files.model import read_model
    from renderer.solving.plan import make_plan
    from renderer.transport.mesh.build import build_mesh

    size = np.ptp(read_model(path, "").bounds, axis=0)
    scale = 1.0 / size.max()
    scene = renderer.load({
        "room": {"size": [3.0, 3.0, 3.0], "floor": "a", "walls": "a", "ceiling": "a"},
        "materials": {"a": {"reflectance": 0.5}},
        "objects": [{"mesh": str(path.resolve()), "position": [1.5, 1.5, 0.5], "anchor": "base",
                     "scale": float(scale), "material": "a"}]})
    started = time.perf_counter()
    mesh = build_mesh(scene, make_plan(scene, 0.01, None).patch_size)
    unknown = np.arange(len(mesh.patches)) if mesh.group is None else mesh.group
    return len(np.unique(unknown[mesh.surface >= 6])), round(time.perf_counter() - started, 3)


def summary(rows: list[dict]) -> None:
    """Counts, by format and in total."""
    print(f"{'format':8} {'files':>6} {'open':>6} {'solids':>7} {'sheets':>7} {'both':>6} {'worst area':>11} "
          f"{'inside out':>10} {'seconds':>8}")
    for kind in [*sorted({row["format"] for row in rows}), "all"]:
        some = [row for row in rows if kind in (row["format"], "all")]
        opened = [row for row in some if row["opens"]]
        kinds = Counter((row["solids"] > 0, row["sheet_triangles"] > 0) for row in opened)
        print(f"{kind:8} {len(some):6} {len(opened):6} {kinds[True, False]:7} {kinds[False, True]:7} "
              f"{kinds[True, True]:6} {max((row['area_error'] for row in opened), default=0):11.1e} "
              f"{sum(row['inside_out'] > 0 for row in opened):10} {sum(row['seconds'] for row in some):8.1f}")
    for row in rows:
        if not row["opens"]:
            print(f"not opened: {row['why_not']}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--patches", action="store_true")
    given = parser.parse_args()
    files = sorted(f for folder in given.folders for f in folder.rglob("*")
                   if f.suffix.lower().lstrip(".") in MODEL_FORMATS and f.is_file())
    rows = []
    for file in files:
        rows.append(examined(file, given.patches))
        print(f"\r{len(rows)} of {len(files)}", end="", file=sys.stderr)
    print(file=sys.stderr)
    summary(rows)
    if given.csv:
        keys = list(dict.fromkeys(key for row in rows for key in row))
        with given.csv.open("w", newline="") as out:
            writer = csv.DictWriter(out, keys)
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
