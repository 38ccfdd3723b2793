"""The patches in three dimensions: a .vtp file, and a view without the near walls."""

import os
import sys
import warnings
from pathlib import Path

import numpy as np

from renderer.pictures.pseudocolour import COLOUR_MAP, colour_map, draw_legend
from renderer.pictures.sheet import plain
from renderer.solving.solution import Solution
from renderer.system.files import whole_file


def _pyvista():
    """The pyvista module, set to draw off screen where there is no X server."""
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    import pyvista

    return pyvista


def patches(solution: Solution):
    """The patches as VTK's polygons, with luminance [cd/m²] and illuminance [lx] on each.

    This function uses VTK alone, because pyvista takes half a second to import.
    """
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints, vtkStringArray
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    transport = solution.transport
    mesh, luminous = transport.mesh, solution.bands.luminous
    shown = transport.exchange.areas > 0
    corners = mesh.patches[shown]
    sides = np.where(mesh.triangular[shown], 3, 4)
    points, cells, data = vtkPoints(), vtkCellArray(), vtkPolyData()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(mesh.vertices), deep=True))
    index = corners[np.arange(4) < sides[:, None]].astype(np.int64)
    starts = np.concatenate([[0], np.cumsum(sides)]).astype(np.int64)
    cells.SetData(*(numpy_to_vtkIdTypeArray(each, deep=True) for each in (starts, index)))
    data.SetPoints(points)
    data.SetPolys(cells)
    values = {"luminance_cd_m2": (solution.radiosity @ luminous / np.pi)[shown],
              "illuminance_lx": (solution.irradiance @ luminous)[shown],
              "direct_illuminance_lx": (solution.direct_irradiance @ luminous)[shown],
              "surface": mesh.surface[shown]}
    for name, each in values.items():
        array = numpy_to_vtk(np.ascontiguousarray(each), deep=True)
        array.SetName(name)
        data.GetCellData().AddArray(array)
    names = vtkStringArray()
    names.SetName("surface_names")
    for name in solution.scene.surface_names:
        names.InsertNextValue(name)
    data.GetFieldData().AddArray(names)
    return data


def save_vtp(data, path: Path) -> Path:
    """Write `patches` for ParaView and similar programs."""
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    # Written to memory first, because VTK refuses names that are not UTF-8 and does not report a full disk.
    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(data)
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOn()
    writer.WriteToOutputStringOn()
    writer.Write()
    with whole_file(path) as part:
        part.write_text(writer.GetOutputString(), encoding="utf-8")
    return path


def save_view(solutions: list[tuple[str, Solution]], top: float, path: Path,
              palette: str = COLOUR_MAP) -> Path:
    """Draw rooms side by side from outside, near walls left out, on one scale 0 … top [cd/m²]."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    pyvista = _pyvista()
    shots = []
    for _, solution in solutions:
        plotter = pyvista.Plotter(off_screen=True, window_size=(640, 560))
        plotter.background_color = "white"
        # No lighting: shading would change the colours. No back faces: the near walls are left out.
        plotter.add_mesh(pyvista.wrap(patches(solution)), scalars="luminance_cd_m2", cmap=colour_map(palette),
                         clim=(0, top), lighting=False, show_scalar_bar=False, culling="back",
                         show_edges=True, edge_color="#202020", edge_opacity=0.25)
        plotter.view_vector((0.35, -0.8, 0.5), viewup=(0, 0, 1))
        plotter.camera.zoom(1.02)
        shots.append(plotter.screenshot(return_img=True))
        plotter.close()
    figure = Figure(figsize=(4.6 * len(shots) + 0.9, 4.4), dpi=110)
    FigureCanvasAgg(figure)
    width = 4.6 / (4.6 * len(shots) + 0.9)
    for k, ((title, _), shot) in enumerate(zip(solutions, shots, strict=True)):
        axes = figure.add_axes((k * width, 0, width, 0.9))
        axes.imshow(shot)
        axes.set_title(plain(title), fontsize=11)
        axes.axis("off")
    draw_legend(figure, figure.add_axes((len(shots) * width + 0.1 * (1 - len(shots) * width), 0.12,
                                         0.15 * (1 - len(shots) * width), 0.68)), top,
                palette=palette)
    with whole_file(path) as part, warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph", UserWarning)
        figure.savefig(part)
    return path
