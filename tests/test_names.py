"""One name, one thing: a public name stands in one module only."""

import ast
from collections import defaultdict
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "renderer"
SHARED = {
    "NAME", "read",  # what every other program in studies/peers answers to
}
"""Names that stand in two modules on purpose."""
UNSETTLED = {
    "AROUND", "Amount", "BRIGHT", "Body", "CEILING", "COLOURS", "COLUMNS", "Case", "DARK", "DASH",
    "DEEPEST", "DENSE", "DIRECTIONS", "DISC_CORNERS", "EFFICACY", "ENOUGH", "EYE_HEIGHT",
    "FARTHEST", "FINE", "FINER", "FLAT", "FLOOR", "FORMATS", "FRONT", "FURNITURE", "Face", "Finish",
    "GAP", "GAUSS", "HERE", "INSET", "INSIDE", "INSTEAD", "KEPT", "KEYS", "KINDS", "KNOWN", "LAMPS",
    "LARGEST", "LEAST_HEIGHT", "LEVEL", "LINE", "LONGER", "Lamp", "MARGIN", "MARKERS", "MAX_DEPTH",
    "MAX_PATCHES_DENSE", "MAX_ROUNDS", "MAX_STEPS", "MODELS", "MOST_ANGLES", "MOST_RAYS", "Meter",
    "Model", "NAMES", "NARROWEST", "NEAREST", "NODES", "NO_LIGHT", "OPEN", "OPPOSITE", "ORACLES",
    "OUTSIDE", "PAIRS_PER_SLICE", "PALETTES", "PANEL", "PATCHES", "PATIENCE", "PIXELS", "PLACES",
    "POINT", "POINTS", "Place", "RAYS", "RAYS_PER_SLICE", "READERS", "REPLICAS", "ROUNDING", "Room",
    "Row", "Rows", "SECONDS", "SHADOW_RAYS", "SLACK", "SMALL", "STEEP", "Scene", "Shape", "Shown",
    "Solution", "Source", "Spot", "Surface", "TINY", "TOLERANCE", "TRIED_POINTS", "Table", "UNITS",
    "WALLS", "WEIGHTS", "WELD", "WIDEST", "WIDTH", "WITHIN", "alpha_opic", "box_room", "cells",
    "connected", "grid", "keys", "lamp_tables", "lamps_of", "listed", "load", "luminance",
    "markdown", "normal_of", "number", "place", "pseudocolour", "read_model", "record_of",
    "refuse_outside", "rows_of", "said", "save", "shares", "solve", "sweep", "table",
    "triangulated", "value", "welded", "within",
}
"""Names in two modules that are to be renamed; none may be added."""


def public_names(path: Path) -> list[str]:
    """Public classes, functions and constants that a module defines."""
    names = []
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            names.append(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            walked = (each for target in targets for each in ast.walk(target))
            names += [each.id for each in walked if isinstance(each, ast.Name)]
    return [name for name in names if not name.startswith("_")]


def modules_by_name() -> dict[str, list[str]]:
    found = defaultdict(list)
    for path in sorted(PACKAGE.rglob("*.py")):
        if path.name not in ("__init__.py", "__main__.py"):
            for name in public_names(path):
                found[name].append(str(path.relative_to(PACKAGE)))
    return found


def test_no_public_name_stands_in_two_modules():
    twice = {name: where for name, where in modules_by_name().items() if len(where) > 1}
    assert {name: where for name, where in twice.items() if name not in SHARED | UNSETTLED} == {}


def test_every_exception_is_needed():
    modules = modules_by_name()
    assert {name for name in SHARED | UNSETTLED if len(modules[name]) < 2} == set()
