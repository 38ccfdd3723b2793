"""A window with a solved room that the user turns by mouse, reads by clicks and changes by keys."""

import time
from itertools import count
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.pictures.camera import Pinhole
from renderer.pictures.image import save_png
from renderer.pictures.pseudocolour import COLOUR_MAP, colour_map
from renderer.pictures.sheet import plain
from renderer.pictures.window.clicks import Click, band_title, place_at, reading_lines
from renderer.pictures.window.content import WindowContent
from renderer.pictures.window.display import refuse_unseen
from renderer.pictures.window.overlay import Overlay
from renderer.pictures.window.skin import first_front
from renderer.solving.solution import Solution

MARK_HEIGHT = 1e-3
"""Distance of a mark in front of its surface, relative to the room's longest side."""


class Window:
    """A window with a room, the user's readings and saved files.

    content : solutions and colours
    out : folder for pictures
    palette : colour map of pseudocolour
    """

    def __init__(self, content: WindowContent, out: Path, palette: str = COLOUR_MAP):
        import pyvista

        self.content, self.out, self.palette = content, out, palette
        self.readings: list[tuple[Solution, Click]] = []
        self.files: list[Path] = []
        self.which, self.place = 0, None
        self.mode = "picture" if ("picture", 0) in content.colours else "luminance"
        self.helped = True
        self.lines: list[str] = []
        self.note = ""
        scene = content.solutions[0].scene
        self.plotter = pyvista.Plotter(
            window_size=(1200, 800), title=scene.title, off_screen=False, notebook=False
        )
        refuse_unseen(self.plotter.render_window)
        self.plotter.background_color = "#5a5f66"
        self._draw_room()
        self._draw_marks()
        self.overlay = Overlay(self.plotter)
        self.reset()
        self.refresh()

    def _draw_room(self) -> None:
        import pyvista

        data = pyvista.PolyData.from_regular_faces(self.content.skin.points, self.content.skin.triangles)
        for (mode, k), values in self.content.colours.items():
            data.point_data[f"{mode} {k}"] = values
        # No lighting: shading would change the colours. No back faces: the near walls are left out.
        self.room = self.plotter.add_mesh(
            data, scalars="luminance 0", cmap=colour_map(self.palette), n_colors=4096, clim=(0, 1),
            nan_color="#808080",
            above_color="white", lighting=False, show_scalar_bar=False, culling="back",
            reset_camera=False, copy_mesh=False)
        self.room.mapper.scalar_map_mode = "point_field"

    def _draw_marks(self) -> None:
        """Draw points for photometers, for point luminaires, and for the place of a click."""
        scene = self.content.solutions[0].scene
        normals = np.array([p.normal for p in scene.photometers]).reshape(-1, 3)
        normals = normals / np.linalg.norm(normals, axis=1)[:, None]
        meters = self._inside([p.position for p in scene.photometers]) + MARK_HEIGHT * normals
        self.meters = meters
        bare = self._inside([lum.center for lum in scene.luminaires if lum.is_point])
        for points, colour in ((meters, "white"), (bare, "yellow")):
            if len(points):
                self._points(points, colour)
        self.mark = self._points(np.zeros((1, 3)), "magenta")
        self.mark.SetVisibility(False)

    def _name_meters(self) -> None:
        """Write names beside the photometers in sight."""
        transport, eye = self.solution.transport, np.array(self.plotter.camera.position)
        names, places = [], []
        for table, place in zip(self.solution.scene.photometers, self.meters, strict=True):
            away = np.linalg.norm(place - eye)
            met = first_front(transport, self._outside(eye), (place - eye) / away)
            if met is None or np.linalg.norm(self._inside(met[1])[0] - eye) > away - 2 * MARK_HEIGHT:
                names.append(f"  {plain(table.name)}")
                places.append(place)
        self.plotter.remove_actor("names", render=False)
        if names:
            self.plotter.add_point_labels(
                np.array(places), names, name="names", font_size=13, bold=False, text_color="white",
                shape_color="black", shape_opacity=0.5, show_points=False, always_visible=True,
                reset_camera=False, render=False)

    def _points(self, points: np.ndarray, colour: str):
        return self.plotter.add_points(points, color=colour, point_size=12, lighting=False,
                                       render_points_as_spheres=True, reset_camera=False)

    def _inside(self, places) -> np.ndarray:
        """Places (k, 3) [m] in the window's units: the room's centre at 0 and its longest side 1."""
        mesh = self.content.solutions[0].transport.mesh
        return (np.array(places).reshape(-1, 3) - mesh.middle) / mesh.scale

    def _outside(self, place: np.ndarray) -> np.ndarray:
        """A place (3,) in the window's units as a place in the room [m]."""
        mesh = self.content.solutions[0].transport.mesh
        return place * mesh.scale + mesh.middle

    @property
    def solution(self) -> Solution:
        """The solution in the bands on the screen."""
        return self.content.solutions[self.which]

    def refresh(self) -> None:
        """Draw colours, legend and lines anew."""
        mapper, top = self.room.mapper, self.content.tops.get(self.mode)
        mapper.SelectColorArray(f"{self.mode} {self.which}")  # by name in pyvista of every version
        mapper.color_mode = "direct" if top is None else "map"
        if top is not None:
            mapper.scalar_range = (0, top)
        unit = {"luminance": "cd/m²", "illuminance": "lx"}.get(self.mode, "")
        self.overlay.show_legend(top, unit, self.palette)
        state = f"{self.solution.scene.title}: {band_title(self.solution)}, {self.mode}"
        keys = (
            "click       read the photometer      c         picture or pseudocolour",
            "drag        turn the room            i         luminance or illuminance",
            "wheel       nearer, farther          b         RGB or bands",
            "shift drag  move the room            r         the camera's view",
            "s           save the picture         o         from outside",
            "h           hide these lines         q or Esc  close",
        )
        self.overlay.write_upper([state, *keys] if self.helped else [f"{state}    (h: keys)"])
        self.overlay.write_lower([*self.lines, *([self.note] if self.note else [])])
        self._name_meters()
        self.overlay.come_forward()
        self.plotter.render()

    def reset(self) -> None:
        """Look from the scene's camera, or from outside where there is none."""
        camera = self.content.camera
        if camera is None:
            self.go_outside()
            return
        (eye,) = self._inside(camera.position)
        # The mouse turns the view about the focus, in the middle of the room.
        ahead = max(-float(eye @ camera.axes[2]), 0.1)
        self.plotter.camera_position = [eye, eye + ahead * camera.axes[2], camera.axes[1]]
        width, height = self.plotter.window_size
        spread = camera.spread * max(camera.height / camera.width, height / width)
        self.plotter.camera.view_angle = float(np.degrees(2 * np.arctan(spread)))
        self.plotter.reset_camera_clipping_range()

    def go_outside(self) -> None:
        """Look at the whole room from outside, through the near walls."""
        self.plotter.camera.view_angle = 30.0
        self.plotter.view_vector((0.35, -0.8, 0.5), viewup=(0, 0, 1))

    def sight(self, x: float, y: float) -> tuple[np.ndarray, np.ndarray]:
        """The eye (3,) [m], and the direction (3,) through a pixel, counted from the window's lower left
        corner."""
        camera = self.plotter.camera
        eye, focus = np.array(camera.position), np.array(camera.focal_point)
        forward = (focus - eye) / np.linalg.norm(focus - eye)
        right = np.cross(forward, camera.up)
        right /= np.linalg.norm(right)
        width, height = self.plotter.window_size
        spread = np.tan(np.radians(camera.view_angle / 2)) * width / height
        seen = Pinhole(eye, np.stack([right, np.cross(right, forward), forward]), width, height, spread)
        direction = seen.directions(np.array([x + 0.5]), np.array([height - y - 0.5]))[0]
        return self._outside(eye), direction

    def click(self, x: float, y: float) -> None:
        """Read the photometer at the place in a pixel, and mark the place."""
        self.place = place_at(self.solution, *self.sight(x, y))
        self.mark.SetVisibility(self.place is not None)
        if self.place is not None:
            self.mark.SetPosition(*(self._inside(self.place.position)[0] + MARK_HEIGHT * self.place.normal))
        self.note = ""
        self.read()

    def read(self) -> None:
        """Show the reading at the place of the last click, in the bands on the screen."""
        self.overlay.write_lower(["reading …"])
        self.plotter.render()
        click, self.lines = reading_lines(self.solution, self.place)
        if click is not None:
            self.readings.append((self.solution, click))
        self.refresh()

    def save(self) -> None:
        """Save the window as a picture under a new name, and show the name."""
        stem = f"{self.solution.scene.path.stem}_view"
        path = next(p for k in count(1) if not (p := self.out / f"{stem}_{k}.png").exists())
        self.refresh()
        try:
            pixels = self.plotter.screenshot(return_img=True)
            self.files.append(save_png(np.ascontiguousarray(pixels), path, []))
            self.note = f"saved {path}"
        except InputError as error:
            self.note = str(error)

    def press(self, key: str) -> None:
        """Carry out the command of a key."""
        self.note = ""
        if key == "c":
            pictured = ("picture", self.which) in self.content.colours
            self.mode = "picture" if self.mode != "picture" and pictured else "luminance"
        elif key == "i":
            self.mode = "luminance" if self.mode == "illuminance" else "illuminance"
        elif key == "b":
            self.which = (self.which + 1) % len(self.content.solutions)
            if (self.mode, self.which) not in self.content.colours:
                self.mode = "luminance"
            if self.place is not None:
                self.read()
        elif key == "h":
            self.helped = not self.helped
        elif key in ("r", "o"):
            (self.reset if key == "r" else self.go_outside)()
        elif key == "s":
            self.save()
        self.refresh()

    def run(self) -> None:
        """Open the window, and carry out the user's commands until it is closed.

        VTK suppresses exceptions in its callbacks. These therefore only record commands, which this loop
        carries out.
        """
        asked: list[tuple] = []
        plotter, iren = self.plotter, self.plotter.iren
        pressed, tolerance = [0, 0], 4  # largest movement of a click [pixels]

        def press(*_) -> None:
            pressed[:] = iren.interactor.GetEventPosition()

        def release(*_) -> None:
            x, y = iren.interactor.GetEventPosition()
            if abs(x - pressed[0]) <= tolerance and abs(y - pressed[1]) <= tolerance:
                asked.append((self.click, x, y))

        def key(*_) -> None:
            name = iren.interactor.GetKeySym()
            asked.append(("close",) if name in ("q", "Q", "Escape") else (self.press, name.lower()))

        plotter.enable_terrain_style(mouse_wheel_zooms=True, shift_pans=True)
        iren.clear_key_event_callbacks()
        iren.style.add_observer("LeftButtonPressEvent", press)
        iren.style.add_observer("LeftButtonReleaseEvent", release)
        iren.style.add_observer("EndInteractionEvent", lambda *_: asked.append((self.refresh,)))
        iren.style.add_observer("CharEvent", lambda *_: None)  # in place of VTK's own keys
        iren.add_observer("KeyPressEvent", key)
        iren.add_observer("ExitEvent", lambda *_: asked.append(("close",)))
        plotter.show(interactive_update=True, auto_close=False)
        try:
            while True:
                iren.process_events()
                while asked:
                    what, *at = asked.pop(0)
                    if what == "close":
                        return
                    what(*at)
                time.sleep(1 / 100)
        finally:
            plotter.close()
