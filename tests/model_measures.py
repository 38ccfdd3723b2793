"""Measures of a model file, and models for tests."""

from pathlib import Path

import numpy as np
import trimesh

from renderer.scene.model_files.model import read_model
from renderer.scene.model_files.solids_and_sheets import areas, volumes

CASES = Path(__file__).parent / "cases" / "geometry"


def model(path, **options):
    return read_model(Path(path), "scene.toml: objects[0].mesh", **options)


def area(found) -> float:
    return float(areas(found.shapes.vertices, found.shapes.faces).sum())


def volume(found) -> float:
    shapes = found.shapes
    closed = shapes.solid >= 0
    return float(volumes(shapes.vertices, shapes.faces[closed], np.zeros(closed.sum(), int), 1)[0])


def sheets(found) -> int:
    return int((found.shapes.solid < 0).sum())


def solids(found) -> int:
    return int(found.shapes.solid.max(initial=-1)) + 1


def box(*bounds):
    return trimesh.creation.box(bounds=bounds)


CHAIR = """mtllib chair.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 0.4 0
vt 0.4 1
vt 0 1
usemtl wood
f 1/1 2/2 3/3 4/4
o leg
usemtl steel
v 0 0 1
f 1 2 5
"""
