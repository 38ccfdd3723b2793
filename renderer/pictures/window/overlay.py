"""The overlay of the window: lines of text in two corners and the legend in a third."""

import textwrap

import numpy as np

from renderer.pictures.pseudocolour import COLOUR_MAP, LEGEND_WIDTH, legend
from renderer.pictures.sheet import plain

EDGE_DISTANCE = 10
"""Distance of text and legend from the window's edge [pixels]."""


class Overlay:
    """Text in the upper and the lower left corner, the legend in the lower right corner."""

    def __init__(self, plotter):
        self.upper = _text(plotter, 1.0)
        self.lower = _text(plotter, 0.0)
        self.plotter = plotter
        self.legend, self.scale = None, None

    def write_upper(self, lines: list[str]) -> None:
        """Show lines in the upper left corner."""
        _write(self.upper, lines)

    def write_lower(self, lines: list[str]) -> None:
        """Show lines in the lower left corner; hide the box for none."""
        _write(self.lower, lines)

    def show_legend(self, top: float | None, unit: str, palette: str = COLOUR_MAP) -> None:
        """Show a scale from 0 to `top`; None hides it."""
        height = int(np.clip(self.plotter.window_size[1] - 150, 180, 420))  # leaves the upper text free
        if (top, unit, height) == self.scale:
            return
        self.scale = top, unit, height
        if self.legend is not None:
            self.plotter.remove_actor(self.legend, render=False)
        self.legend = None
        if top is not None:
            self.legend = _picture(legend(height, top, unit, palette))
            self.plotter.add_actor(self.legend, render=False, reset_camera=False)

    def come_forward(self) -> None:
        """Draw the overlay in front of names in the room."""
        for actor in (self.legend, self.upper, self.lower):
            if actor is not None:
                self.plotter.renderer.RemoveViewProp(actor)
                self.plotter.renderer.AddViewProp(actor)


def _text(plotter, height: float):
    """An empty box of text at the left edge, at a height relative to the window's."""
    import pyvista

    text = pyvista.Text("")
    prop = text.prop
    prop.font_family, prop.color, prop.background_color = "courier", "white", "black"
    prop.font_size, prop.background_opacity = 15, 0.62
    prop.justification_horizontal, prop.justification_vertical = "left", "top" if height else "bottom"
    _anchor(text, 0.0, height, EDGE_DISTANCE, -EDGE_DISTANCE if height else EDGE_DISTANCE)
    plotter.add_actor(text, render=False, reset_camera=False)
    return text


def _write(text, lines: list[str]) -> None:
    broken = [part for line in lines for part in textwrap.wrap(
        plain(line), 96, subsequent_indent="  ", drop_whitespace=False) or [""]]
    text.input = "\n".join(f" {line} " for line in broken)
    text.SetVisibility(bool(broken))


def _picture(pixels: np.ndarray):
    """An actor with a picture (height, width, 3) in the lower right corner."""
    import pyvista
    from vtkmodules.vtkRenderingCore import vtkActor2D, vtkImageMapper

    height, width = pixels.shape[:2]
    image = pyvista.ImageData(dimensions=(width, height, 1))
    image.point_data["pixels"] = np.ascontiguousarray(pixels[::-1]).reshape(-1, 3)
    mapper = vtkImageMapper()
    mapper.SetInputData(image)
    mapper.SetColorWindow(255)
    mapper.SetColorLevel(127.5)
    actor = vtkActor2D()
    actor.SetMapper(mapper)
    _anchor(actor, 1.0, 0.0, -LEGEND_WIDTH - EDGE_DISTANCE, EDGE_DISTANCE)
    return actor


def _anchor(actor, x: float, y: float, right: float, up: float) -> None:
    """Place an actor `right` and `up` pixels from the point (x, y) of the window, given as shares of its
    size."""
    from vtkmodules.vtkRenderingCore import vtkCoordinate

    corner = vtkCoordinate()
    corner.SetCoordinateSystemToNormalizedViewport()
    corner.SetValue(x, y, 0)
    place = actor.GetPositionCoordinate()
    place.SetCoordinateSystemToViewport()
    place.SetReferenceCoordinate(corner)
    place.SetValue(right, up, 0)
