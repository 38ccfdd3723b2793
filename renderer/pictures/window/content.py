"""The content of a window on a solved room: the colours of its surfaces, with their exposure and scales."""

from dataclasses import dataclass

import numpy as np

from renderer.pictures.camera import Pinhole
from renderer.pictures.image import exposure, tone_map, white_balance
from renderer.pictures.pseudocolour import scale_top
from renderer.pictures.report.viewpoint import looks
from renderer.pictures.window.skin import Skin, light_on, skin
from renderer.solving.solution import Solution
from renderer.solving.transport_store import Progress


@dataclass(frozen=True)
class WindowContent:
    """The colours of a window, computed before it opens.

    colours : (n, 3) bytes or (n,) values on the vertices of `skin`, by mode and index of the solution
    tops : upper ends of the scales, by mode
    camera : of the scene, or in a corner of the room; None where there is no place for one
    """

    solutions: tuple[Solution, ...]
    skin: Skin
    colours: dict[tuple[str, int], np.ndarray]
    tops: dict[str, float]
    camera: Pinhole | None


def window_content(solutions: tuple[Solution, ...], progress: Progress) -> WindowContent:
    """The content of a window on one room in several band sets on one transport.

    Exposure and scale are those of the camera's pictures. Raises InputError where the camera stands inside a
    solid.
    """
    first = solutions[0]
    progress(f"{first.scene.title}: the light on every vertex")
    hull = skin(first.transport)
    light = [light_on(solution, hull) for solution in solutions]
    progress(f"{first.scene.title}: exposure and scale")
    view = looks([(first.scene, first.transport)], 160 * 120)[0][0]
    surfaces = first.transport.reflecting[hull.patch]
    if view is None:
        seen, mask = [xyz for xyz, _ in light], surfaces
    else:
        mask = view.shows_surface
        seen = [view.direct(s, s.bands.xyz) + view.indirect(s, s.bands.xyz) for s in solutions]
    tops = {"luminance": scale_top([xyz[..., 1] for xyz in seen], [mask] * len(seen)),
            "illuminance": scale_top([lx for _, lx in light], [surfaces] * len(light))}
    coloured = [k for k, solution in enumerate(solutions) if solution.bands.nodes is None]
    balance = white_balance(solutions[coloured[0]].flux.sum(axis=0) @ solutions[coloured[0]].bands.xyz).T
    exposed = exposure([seen[k] @ balance for k in coloured], [mask] * len(coloured))
    colours = {}
    for k, (xyz, illuminance) in enumerate(light):
        colours["luminance", k], colours["illuminance", k] = xyz[:, 1], illuminance
        if k in coloured:
            colours["picture", k] = tone_map(xyz @ balance, exposed)
    return WindowContent(solutions, hull, colours, tops, view and view.camera)
