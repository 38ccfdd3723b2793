"""The display of a solution in a notebook: a small picture, and the photometers' readings with error bars."""

import base64
import io
from html import escape

import numpy as np
from PIL import Image

from renderer.errors import InputError
from renderer.pictures.camera import look
from renderer.pictures.image import exposure, tone_map, white_balance
from renderer.pictures.pseudocolour import luminance_colours, scale_top
from renderer.solving.solution import Solution


def html(solution: Solution) -> str:
    """Picture and table of a solution as HTML without other files. A missing one is replaced by the
    reason."""
    scene, bands = solution.scene, solution.bands
    head = (f"<b>{escape(scene.title)}</b>, {escape(bands.name)} bands, "
            f"{len(solution.transport.mesh.patches)} patches")
    return f"<div><p>{head}</p>{_figure(solution)}{_table(solution)}</div>"


def _figure(solution: Solution) -> str:
    camera = solution.scene.camera
    if camera is None:
        return "<p>No picture: the scene has no [camera].</p>"
    try:
        pixels = picture(solution)
    except InputError as error:
        return f"<p>No picture: {escape(str(error))}</p>"
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG", optimize=True)
    data = base64.b64encode(file.getvalue()).decode("ascii")
    return f"<img alt='{escape(solution.scene.title)}' src='data:image/png;base64,{data}'>"


def picture(solution: Solution) -> np.ndarray:
    """The view of the scene's camera as bytes (height, width, 3), at most 360 pixels wide or high.

    It is a luminance map for bands without colour. Raises InputError for a camera inside a solid.
    """
    scene, bands = solution.scene, solution.bands
    width, height = scene.camera.resolution
    smaller = min(1.0, 360 / max(width, height))
    size = tuple(max(8, round(smaller * side)) for side in (width, height))
    view = look(solution.transport, scene.camera.model_copy(update={"resolution": size}), str(scene.path))
    xyz = view.direct(solution, bands.xyz) + view.indirect(solution, bands.xyz)
    if bands.nodes is not None:
        return luminance_colours(xyz[..., 1], scale_top([xyz[..., 1]], [view.shows_surface]))
    balanced = xyz @ white_balance(solution.flux.sum(axis=0) @ bands.xyz).T
    return tone_map(balanced, exposure([balanced], [view.shows_surface]))


def _table(solution: Solution) -> str:
    photometers = solution.scene.photometers
    if not photometers:
        return "<p>No reading: the scene has no [[photometers]].</p>"
    rows = []
    for meter in photometers:
        name = escape(meter.name)
        try:
            reading = solution.photometer(meter.position, meter.normal, meter.name)
        except InputError as error:
            rows.append(f"<tr><td>{name}</td><td colspan='4'>{escape(str(error))}</td></tr>")
            continue
        cells = (f"{reading.direct_lx:.2f}", f"{reading.indirect_lx:.2f}", f"{reading.total_lx:.2f}",
                 f"± {reading.uncertainty:.2g}")
        rows.append(f"<tr><td>{name}</td>" + "".join(
            f"<td style='text-align:right'>{cell}</td>" for cell in cells) + "</tr>")
    heads = ("photometer", "direct lx", "indirect lx", "total lx", "95 %")
    return (f"<table><thead><tr>{''.join(f'<th>{h}</th>' for h in heads)}</tr></thead>"
            f"<tbody>{''.join(rows)}</tbody></table>")
