"""A public name is defined in one module only."""

import ast
from collections import defaultdict
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "renderer"
SHARED = {
    "NAME", "read",  # of each program in studies/peers
    "Scene", "Solution", "load", "solve",  # renderer/python_interface.py derives its own
}
"""Public names of two modules on purpose."""


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
    assert {name: where for name, where in twice.items() if name not in SHARED} == {}


def test_every_exception_is_needed():
    modules = modules_by_name()
    assert {name for name in SHARED if len(modules[name]) < 2} == set()
