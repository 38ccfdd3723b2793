"""A room with a crate and a camera."""

import renderer

CRATE = {"shape": "box", "position": [0.5, 1.0, 0.0], "size": [1.2, 0.7, 1.5]}
CAMERA = {"position": [0.5, 0.4, 1.6], "look_at": [3.0, 3.5, 0.8], "fov": 75.0}


def with_camera(scene, title):
    """A scene with a title and CAMERA, loaded anew."""
    lines = "\n".join(f"{key} = {value}" for key, value in CAMERA.items())
    scene.path.write_text(f'title = "{title}"\n{scene.path.read_text()}\n[camera]\n{lines}\n')
    return renderer.load(scene.path)
