"""The refusal of a meter, camera or luminaire inside an object, when a scene is read."""

import numpy as np

from renderer.errors import InputError
from renderer.scene.room import spelt, winding
from renderer.scene.scene import STAND_OFF, Body


def refuse_buried(bodies: list[Body], point: np.ndarray, scale: float, what: str) -> None:
    """Raise InputError for a point (3,) inside a solid: "`what` [x, y, z], inside …".

    scale : longest side of the room [m]; a point within the rays' resolution of a surface counts as on it
    """
    around = point + 2 * STAND_OFF * scale * np.vstack([np.eye(3), -np.eye(3)])
    near = [body for body in bodies if body.closed and (body.mesh.bounds[0] <= point).all()
            and (point <= body.mesh.bounds[1]).all()]
    if near and (winding(around, np.concatenate([body.mesh.triangles for body in near])) < -0.5).all():
        raise InputError(f"{what} {spelt(point)}, inside {near[0].name!r}. Move one of them.")
