"""The order of folders: a module imports only from folders that stand before its own."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "renderer"
ORDER = ["errors", "system", "colour", "radiometry", "scene", "transport.mesh", "transport.rays",
         "transport.factors", "transport.direct", "transport.radiosity", "transport.transport",
         "transport.sensors", "readings",
         "solving.plan", "solving.transport_store", "solving.radiosity_field", "solving.watch",
         "solving.straight_light", "solving.gathered",
         "solving.mesh_sequence",
         "solving.solution", "solving.measure", "solving.refine", "solving.pilot_solve", "solving.forecast",
         "records", "pictures", "studies", "python_interface", "cli.terminal", "cli.options", "cli"]
FILES = sorted(p for p in PACKAGE.rglob("*.py") if p.name not in ("__init__.py", "__main__.py"))


def module(path: Path) -> str:
    return ".".join(path.relative_to(PACKAGE).with_suffix("").parts)


def rank(name: str) -> int:
    return max(k for k, prefix in enumerate(ORDER) if name == prefix or name.startswith(prefix + "."))


def imported(path: Path) -> list[str]:
    names = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("renderer."):
            names.append(node.module.removeprefix("renderer."))
    return names


@pytest.mark.parametrize("path", FILES, ids=module)
def test_a_room_imports_only_what_comes_before_it(path):
    for name in imported(path):
        assert rank(name) <= rank(module(path)), f"{module(path)} imports {name}"


def calls(path: Path) -> set[str]:
    return {node.func.id for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}


def test_only_the_command_line_prints():
    printing = {module(p) for p in FILES if "print" in calls(p)}
    assert all(name.startswith("cli.") or name == "colour.tables" for name in printing)  # itself a command


def test_only_visibility_knows_embree():
    for path in FILES:
        assert module(path) == "transport.rays.ray_scene" or "embreex import" not in path.read_text(), path
        assert "import embreex" not in path.read_text(), path


def test_single_precision_is_where_it_was_measured_harmless():
    # Embree's own, and what rays follow; Lambert's sum; factors of large meshes, and steps towards their
    # solution; a file format's.
    known = {"transport.rays.ray_scene", "transport.rays.sampling", "transport.factors.contour",
             "transport.mesh.edge_lines", "transport.factors.exchange", "transport.radiosity.solve",
             "readings.final_gather", "readings.path_starts", "pictures.exr", "scene.model_files.ply"}
    assert known == {module(path) for path in FILES if "float32" in path.read_text()}


IMPORTED_WHEN_USED = {"studies.validation.extremes", "studies.validation.photometry"}
"""Modules that functions import, and that import trimesh at once."""


@pytest.mark.parametrize("path", FILES, ids=module)
def test_heavy_packages_are_imported_where_they_are_used(path):
    for node in ast.parse(path.read_text()).body:
        names = [a.name for a in node.names] if isinstance(node, ast.Import) else [
            node.module or ""] if isinstance(node, ast.ImportFrom) else []
        heavy = {n.split(".")[0] for n in names} & {"colour", "pyvista", "matplotlib", "OpenEXR", "trimesh"}
        assert not heavy or (heavy == {"trimesh"} and module(path) in IMPORTED_WHEN_USED)


def test_plots_of_colour_science_are_imported_when_first_used():
    said = subprocess.run([sys.executable, "-c", """
import sys
import renderer.colour, colour
print("matplotlib.pyplot" in sys.modules)
from colour.plotting import plot_single_sd
print(colour.plotting.plot_single_sd is plot_single_sd, colour.plotting is sys.modules["colour.plotting"])
"""], capture_output=True, text=True, check=True).stdout
    assert said.split() == ["False", "True", "True"]
