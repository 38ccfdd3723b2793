"""A window on a solved room: turned with the mouse, read with a click, switched with keys."""

import time
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import numpy as np

from renderer.errors import InputError
from renderer.pictures.camera import Pinhole
from renderer.pictures.image import exposure, save_png, tone_map, white_balance
from renderer.pictures.pseudocolour import COLOUR_MAP, colour_map, scale_top
from renderer.pictures.report.viewpoint import looks
from renderer.pictures.sheet import plain
from renderer.pictures.window.clicks import Click, band_title, place_at, said
from renderer.pictures.window.display import refuse_unseen
from renderer.pictures.window.overlay import Overlay
from renderer.pictures.window.skin import Skin, first_front, light_on, skin
from renderer.solving.solution import Solution
from renderer.solving.transport_store import Progress

SIZE = (1200, 800)
PIXELS = 160 * 120
"""Of the camera's picture that tells the exposure and the scale."""
STILL = 4
"""Pixels that the mouse may move between press and release of a click."""
TURN = 1 / 100
"""Seconds between looks at what the user has done."""
FRONT = 1e-3
"""How far a mark stands before its surface, relative to the room."""
POINT = 12
"""Pixels across a mark."""
UNITS = {"luminance": "cd/m²", "illuminance": "lx"}
KEYS = ("click       read the photometer      c         picture or pseudocolour",
        "drag        turn the room            i         luminance or illuminance",
        "wheel       nearer, farther          b         RGB or bands",
        "shift drag  move the room            r         the camera's view",
        "s           save the picture         o         from outside",
        "h           hide these lines         q or Esc  close")


@dataclass(frozen=True)
class Shown:
    """What the window draws, worked out before it opens.

    colours : by mode and number of the solution, (n, 3) bytes or (n,) values
    tops : upper ends of the scales, by mode; camera : the scene's own or one from a corner, or None
    """

    solutions: tuple[Solution, ...]
    skin: Skin
    colours: dict[tuple[str, int], np.ndarray]
    tops: dict[str, float]
    camera: Pinhole | None


def shown(solutions: tuple[Solution, ...], progress: Progress) -> Shown:
    """Work out what a window draws of one room in several band sets, on one transport, on one exposure and
    scale: those of its camera's pictures. Raises InputError where the camera stands inside a solid."""
    first = solutions[0]
    progress(f"{first.scene.title}: the light on every vertex")
    hull = skin(first.transport)
    light = [light_on(solution, hull) for solution in solutions]
    progress(f"{first.scene.title}: exposure and scale")
    view = looks([(first.scene, first.transport)], PIXELS)[0][0]
    surfaces = first.transport.reflecting[hull.patch]
    if view is None:  # nowhere to look from: the vertices have to do
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
    return Shown(solutions, hull, colours, tops, view and view.camera)


class Window:
    """The window and what the user has done in it: readings taken (band set, Click), files saved.

    shown : what it draws; out : the folder for pictures
    """

    def __init__(self, shown: Shown, out: Path, palette: str = COLOUR_MAP):
        import pyvista

        self.shown, self.out, self.palette = shown, out, palette
        self.readings: list[tuple[Solution, Click]] = []
        self.files: list[Path] = []
        self.which, self.place = 0, None
        self.mode = "picture" if ("picture", 0) in shown.colours else "luminance"
        self.helped = True
        self.lines: list[str] = []
        self.note = ""
        scene = shown.solutions[0].scene
        self.plotter = pyvista.Plotter(window_size=SIZE, title=scene.title, off_screen=False, notebook=False)
        refuse_unseen(self.plotter.render_window)
        self.plotter.background_color = "#5a5f66"
        self._draw_room()
        self._draw_marks()
        self.overlay = Overlay(self.plotter)
        self.reset()
        self.refresh()

    def _draw_room(self) -> None:
        import pyvista

        data = pyvista.PolyData.from_regular_faces(self.shown.skin.points, self.shown.skin.triangles)
        for (mode, k), values in self.shown.colours.items():
            data.point_data[f"{mode} {k}"] = values
        # lighting off: shading would falsify the colours. Back faces off: the near walls vanish.
        self.room = self.plotter.add_mesh(
            data, scalars="luminance 0", cmap=colour_map(self.palette), n_colors=4096, clim=(0, 1),
            nan_color="#808080",
            above_color="white", lighting=False, show_scalar_bar=False, culling="back",
            reset_camera=False, copy_mesh=False)
        self.room.mapper.scalar_map_mode = "point_field"

    def _draw_marks(self) -> None:
        """Points for photometers, for luminaires that have no face, and for the place clicked on."""
        scene = self.shown.solutions[0].scene
        normals = np.array([p.normal for p in scene.photometers]).reshape(-1, 3)
        normals = normals / np.linalg.norm(normals, axis=1)[:, None]
        meters = self._inside([p.position for p in scene.photometers]) + FRONT * normals
        self.meters = meters
        bare = self._inside([lum.center for lum in scene.luminaires if lum.is_point])
        for points, colour in ((meters, "white"), (bare, "yellow")):
            if len(points):
                self._points(points, colour)
        self.mark = self._points(np.zeros((1, 3)), "magenta")
        self.mark.SetVisibility(False)

    def _name_meters(self) -> None:
        """Names beside the photometers that the eye sees."""
        transport, eye = self.solution.transport, np.array(self.plotter.camera.position)
        names, places = [], []
        for table, place in zip(self.solution.scene.photometers, self.meters, strict=True):
            away = np.linalg.norm(place - eye)
            met = first_front(transport, self._outside(eye), (place - eye) / away)
            if met is None or np.linalg.norm(self._inside(met[1])[0] - eye) > away - 2 * FRONT:
                names.append(f"  {plain(table.name)}")
                places.append(place)
        self.plotter.remove_actor("names", render=False)
        if names:
            self.plotter.add_point_labels(
                np.array(places), names, name="names", font_size=13, bold=False, text_color="white",
                shape_color="black", shape_opacity=0.5, show_points=False, always_visible=True,
                reset_camera=False, render=False)

    def _points(self, points: np.ndarray, colour: str):
        return self.plotter.add_points(points, color=colour, point_size=POINT, lighting=False,
                                       render_points_as_spheres=True, reset_camera=False)

    def _inside(self, places) -> np.ndarray:
        """Places (k, 3) [m] as the window has them, the room about 0 and its longest side 1."""
        mesh = self.shown.solutions[0].transport.mesh
        return (np.array(places).reshape(-1, 3) - mesh.middle) / mesh.scale

    def _outside(self, place: np.ndarray) -> np.ndarray:
        """A place (3,) of the window in the room [m]."""
        mesh = self.shown.solutions[0].transport.mesh
        return place * mesh.scale + mesh.middle

    @property
    def solution(self) -> Solution:
        """The room in the bands that are shown."""
        return self.shown.solutions[self.which]

    def refresh(self) -> None:
        """Show the colours, legend and lines as they are now."""
        mapper, top = self.room.mapper, self.shown.tops.get(self.mode)
        mapper.array_name = f"{self.mode} {self.which}"
        mapper.color_mode = "direct" if top is None else "map"
        if top is not None:
            mapper.scalar_range = (0, top)
        self.overlay.show_legend(top, UNITS.get(self.mode, ""), self.palette)
        state = f"{self.solution.scene.title}: {band_title(self.solution)}, {self.mode}"
        self.overlay.write_upper([state, *KEYS] if self.helped else [f"{state}    (h: keys)"])
        self.overlay.write_lower([*self.lines, *([self.note] if self.note else [])])
        self._name_meters()
        self.overlay.come_forward()
        self.plotter.render()

    def reset(self) -> None:
        """Look from the scene's camera, or where there is none from outside."""
        camera = self.shown.camera
        if camera is None:
            self.go_outside()
            return
        (eye,) = self._inside(camera.position)
        # What is turned about is amid the room, so that turning leads round it.
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
        """The eye (3,) [m], and the direction (3,) that it looks in through a pixel of the window, counted
        from its lower left corner."""
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
        """Read the photometer at what a pixel shows, and mark the place."""
        self.place = place_at(self.solution, *self.sight(x, y))
        self.mark.SetVisibility(self.place is not None)
        if self.place is not None:
            self.mark.SetPosition(*(self._inside(self.place.position)[0] + FRONT * self.place.normal))
        self.note = ""
        self.read()

    def read(self) -> None:
        """Show a reading at the place last clicked on, in the bands that are shown."""
        self.overlay.write_lower(["reading …"])
        self.plotter.render()
        click, self.lines = said(self.solution, self.place)
        if click is not None:
            self.readings.append((self.solution, click))
        self.refresh()

    def save(self) -> None:
        """Write what the window shows beside earlier pictures, and say where."""
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
        """Do what a key says."""
        self.note = ""
        if key == "c":
            pictured = ("picture", self.which) in self.shown.colours
            self.mode = "picture" if self.mode != "picture" and pictured else "luminance"
        elif key == "i":
            self.mode = "luminance" if self.mode == "illuminance" else "illuminance"
        elif key == "b":
            self.which = (self.which + 1) % len(self.shown.solutions)
            if (self.mode, self.which) not in self.shown.colours:
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
        """Open the window and do what the user asks until it is closed.

        VTK swallows what its callbacks raise, so these only note what happened, and it is done here.
        """
        asked: list[tuple] = []
        plotter, iren = self.plotter, self.plotter.iren
        pressed = [0, 0]

        def press(*_) -> None:
            pressed[:] = iren.interactor.GetEventPosition()

        def release(*_) -> None:
            x, y = iren.interactor.GetEventPosition()
            if abs(x - pressed[0]) <= STILL and abs(y - pressed[1]) <= STILL:
                asked.append((self.click, x, y))

        def key(*_) -> None:
            name = iren.interactor.GetKeySym()
            asked.append(("close",) if name in ("q", "Q", "Escape") else (self.press, name.lower()))

        plotter.enable_terrain_style(mouse_wheel_zooms=True, shift_pans=True)
        iren.clear_key_event_callbacks()
        iren.style.add_observer("LeftButtonPressEvent", press)
        iren.style.add_observer("LeftButtonReleaseEvent", release)
        iren.style.add_observer("EndInteractionEvent", lambda *_: asked.append((self.refresh,)))
        iren.style.add_observer("CharEvent", lambda *_: None)  # or VTK's own keys do things as well
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
                time.sleep(TURN)
        finally:
            plotter.close()
