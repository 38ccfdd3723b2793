"""The views of a report: the scene's camera, or one in a corner, with a limited number of pixels."""

import numpy as np

from renderer.errors import InputError
from renderer.pictures.camera import View, look
from renderer.scene.meter_tables import CameraTable
from renderer.scene.scene import Scene
from renderer.transport.transport import Transport


def looks(rooms: list[tuple[Scene, Transport]], pixels: int) -> tuple[list[View | None], list[str]]:
    """The view of each room (None for a room without a place for a camera), and sentences about departures
    from the scenes' cameras.

    pixels : largest number of pixels of all different views together

    Rooms of one shape and camera share one View. Raises InputError for a scene's camera inside a solid.
    """
    cameras = [scene.camera or _own_camera(scene, transport) for scene, transport in rooms]
    keys = [(id(transport), repr(camera)) for (_, transport), camera in zip(rooms, cameras, strict=True)]
    share = pixels / max(1, len(set(keys)))
    found: dict = {}
    notes = []
    for (scene, transport), camera, key in zip(rooms, cameras, keys, strict=True):
        if camera is None:
            notes.append(f"{scene.title}: has no camera, and there is no place for one: 3-D only.")
            found[key] = None
            continue
        if scene.camera is None:
            notes.append(f"{scene.title}: has no camera; seen from "
                         f"[{', '.join(f'{x:.3g}' for x in camera.position)}].")
        fitting = _fitting(camera, share)
        if fitting != camera:
            asked, shown = (" × ".join(map(str, c.resolution)) for c in (camera, fitting))
            notes.append(f"{scene.title}: the camera's {asked} pixels are shown as {shown}, so that the file "
                         "stays small.")
        if key not in found:
            found[key] = look(transport, fitting, str(scene.path))
    return [found[key] for key in keys], notes


def _fitting(camera: CameraTable, pixels: float) -> CameraTable:
    """The camera with at most `pixels` pixels, in proportion."""
    width, height = camera.resolution
    shrink = np.sqrt(pixels / (width * height))
    if shrink >= 1:
        return camera
    return camera.model_copy(update={"resolution": tuple(max(8, int(side * shrink))
                                                         for side in camera.resolution)})


def _own_camera(scene: Scene, transport: Transport) -> CameraTable | None:
    """A camera from the first free corner of the room to its centre; None where no place is free.

    It is at 0.55 of the room's height, at 4 % of each side from the walls.
    """
    low, high = transport.mesh.bounds
    size = high - low
    middle = low + size * (0.5, 0.5, 0.42)
    corners = [(x, y) for y in (0.04, 0.96) for x in (0.04, 0.96)]
    for x, y in [*corners, (0.5, 0.04), (0.5, 0.25), (0.25, 0.5), (0.5, 0.5)]:
        camera = CameraTable(position=tuple(map(float, low + size * (x, y, 0.55))),
                             look_at=tuple(map(float, middle + size * (0.01, 0.01, 0.0))), fov=84)
        try:
            seen = look(transport, camera.model_copy(update={"resolution": (16, 12)}), str(scene.path))
        except InputError:
            continue
        if (seen.patch >= 0).all():
            return camera
    return None
