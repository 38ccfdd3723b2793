"""The window: what it draws and reads, and a real one, opened under Xvfb and clicked in by xdotool."""

import ctypes
import json
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import PANEL
from PIL import Image

import renderer
from renderer.errors import DisplayError
from renderer.pictures.report.bars import patch_bars
from renderer.pictures.window.clicks import place_at, read, reading_lines
from renderer.pictures.window.content import window_content
from renderer.pictures.window.display import refuse_no_display
from renderer.pictures.window.skin import CORNER_INSET, first_front, light_on, skin
from renderer.transport.sensors import seen_from

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is no DISPLAY")
XVFB = pytest.mark.skipif(
    not (shutil.which("Xvfb") and shutil.which("xdotool")), reason="the window's test needs Xvfb and xdotool "
    "(Debian: apt-get install xvfb xdotool libgl1)")
ROW = r"(\S+) +(RGB|31 bands) +(\S+,\S+,\S+) +(\S+,\S+,\S+) +(\S+) +(\S+) +(\S+) +± (\S+)"
CRATE = {"shape": "box", "position": [0.5, 1.0, 0.0], "size": [1.2, 0.7, 1.5]}
CAMERA = {"position": [0.5, 0.4, 1.6], "look_at": [3.0, 3.5, 0.8], "fov": 75.0}


def _quiet(step):
    """Progress that nobody watches."""


def with_camera(scene, title):
    """A scene with a title and CAMERA, loaded anew."""
    lines = "\n".join(f"{key} = {value}" for key, value in CAMERA.items())
    scene.path.write_text(f'title = "{title}"\n{scene.path.read_text()}\n[camera]\n{lines}\n')
    return renderer.load(scene.path)


def test_a_line_of_sight_meets_what_embree_meets(room):
    transport = renderer.solve(room(0.5, objects=[CRATE]), bands="rgb", accuracy=0.1).transport
    eye, random = np.array([3.0, 3.1, 1.3]), np.random.default_rng(3)
    directions = random.normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    patch, s, t = seen_from(transport, eye, directions)
    met = [first_front(transport, eye, direction) for direction in directions]
    # Embree has single precision: 6e-8 of the room, some digits of it lost at grazing incidence.
    expected = transport.mesh.at(patch, s, t)
    np.testing.assert_allclose([place for _, place in met], expected, atol=1e-5)
    surface = transport.mesh.surface
    assert (surface[[k for k, _ in met]] == surface[patch]).all()


def test_from_outside_the_near_walls_are_seen_through(room):
    transport = renderer.solve(room(0.5, objects=[CRATE]), bands="rgb", accuracy=0.1).transport
    for eye, direction, seen in (([-5, 3, 1.0], [1, 0, 0], [4, 3, 1.0]),        # the far wall, over the crate
                                 ([-5, 1.3, 0.5], [1, 0, 0], [0.5, 1.3, 0.5]),  # the crate's near side
                                 ([2, 2, -3], [0, 0, 1], [2, 2, 3]),            # the panel, through the floor
                                 ([1, 1.2, 9], [0, 0, -1], [1, 1.2, 1.5])):     # the crate's top
        patch, place = first_front(transport, np.array(eye, float), np.array(direction, float))
        np.testing.assert_allclose(place, seen, atol=1e-12)
        assert transport.mesh.normal[patch] @ direction < 0
    assert first_front(transport, np.array([-5.0, 3.0, 1.0]), np.array([-1.0, 0.0, 0.0])) is None


def test_the_window_s_light_is_the_photometer_s(room):
    solution = renderer.solve(room(0.5), bands="31", accuracy=0.05)
    mesh, hull = solution.transport.mesh, skin(solution.transport)
    xyz, illuminance = light_on(solution, hull)
    bars = np.hypot(*patch_bars(solution))
    lamp = ~solution.transport.reflecting[hull.patch]
    assert np.isnan(illuminance[lamp]).all()
    np.testing.assert_allclose(xyz[lamp, 1], 1000.0, rtol=1e-9)
    places = hull.points * mesh.scale + mesh.middle
    for k in np.random.default_rng(4).choice(np.flatnonzero(~lamp), 8, replace=False):
        # Corners are lit CORNER_INSET of a patch inside the patch, where a meter touches one surface.
        patch = hull.patch[k]
        place = places[k] + CORNER_INSET * (mesh.centroid[patch] - places[k])
        reading = solution.photometer(place, mesh.normal[patch])
        assert illuminance[k] == pytest.approx(reading.total_lx, abs=bars[patch] + reading.uncertainty)
        assert xyz[k, 1] == pytest.approx(0.5 * illuminance[k] / np.pi, rel=1e-9)


@pytest.mark.parametrize("center", [[2.0, 2.0, 3.0], [2.5, 1.5, 2.0]])  # mounted, and in mid-air
def test_every_triangle_is_of_one_thing_and_all_are_there(room, center):
    transport = renderer.solve(room(0.5, luminaires=[{**PANEL, "center": center}]), bands="rgb",
                               accuracy=0.1).transport
    hull, scale = skin(transport), transport.mesh.scale
    of = transport.mesh.surface[hull.patch][hull.triangles]
    assert (of == of[:, :1]).all()
    a, b, c = np.moveaxis(hull.points[hull.triangles] * scale, 1, 0)
    areas = np.bincount(of[:, 0], np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)
    mounted = center[2] == 3.0
    # floor, ceiling, four walls, the panel: both of its sides where it hangs free.
    np.testing.assert_allclose(areas, [16, 16 - mounted, 12, 12, 12, 12, 1 if mounted else 2], rtol=1e-9)


@pytest.mark.parametrize("scale", [1e-3 / 4, 1.0, 2500.0])
def test_rooms_of_a_millimetre_and_of_ten_kilometres_are_drawn_alike(room, scale):
    panel = {**PANEL, "center": [2 * scale, 2 * scale, 3 * scale], "size": [scale, scale]}
    scene = room(0.5, size=(4 * scale, 4 * scale, 3 * scale), luminaires=[panel])
    drawn = window_content((renderer.solve(scene, bands="31", accuracy=0.1),), _quiet)
    np.testing.assert_allclose(np.ptp(drawn.skin.points, axis=0), [1, 1, 0.75], rtol=1e-9)
    assert 20 <= drawn.tops["luminance"] <= 30  # 142 lx · 0.5 / π on the floor is 22.7 cd/m²
    assert drawn.tops["illuminance"] in (150.0, 200.0)


@pytest.mark.parametrize("bands", ["31", "6"])
def test_a_dark_room_has_a_scale_and_no_light(room, bands):
    scene = room(0.5, luminaires=[])
    drawn = window_content(
        tuple(renderer.solve(scene, bands=b, accuracy=0.1) for b in (bands, "rgb")), _quiet
    )
    assert drawn.tops == {"luminance": 1.0, "illuminance": 1.0}
    assert (("picture", 0) in drawn.colours) == (bands == "31")
    assert all((values == 0).all() for values in drawn.colours.values())


def test_a_click_reads_what_the_photometer_command_reads(room_file, here, tmp_path):
    scene = room_file(0.5, objects=[CRATE])
    solution = renderer.solve(scene, bands="31", accuracy=0.1)
    eye = np.array([3.0, 3.1, 1.3])
    for toward in ([1.1, 1.35, 1.5], [2.2, 0.7, 0.0], [0.0, 2.9, 2.9], [4.0, 0.0, 0.0]):  # the last a corner
        place = place_at(solution, eye, (toward - eye) / np.linalg.norm(toward - eye))
        click = read(solution, place)
        at, normal = (",".join(map(repr, xyz.tolist())) for xyz in (place.position, place.normal))
        assert click.reading.total_lx == solution.photometer(place.position, place.normal).total_lx
        run = here("photometer", scene.path, "--at", at, "--normal", normal, "--json", "--accuracy", "10%",
                   "--quiet", cwd=tmp_path)
        lx = json.loads(run.stdout)["readings"][0]["illuminance_lx"]
        # The same rays bring the direct light. The window draws, so its mesh is finer than the command's: the
        # indirect light differs by less than both 95 % bars, 2.8 standard errors where these are equal.
        assert click.reading.direct_lx == pytest.approx(lx["direct"], rel=1e-9)
        both = click.reading.uncertainty + lx["uncertainty"]
        assert click.reading.total_lx == pytest.approx(lx["total"], abs=both)
        assert click.luminance == pytest.approx(0.5 * click.reading.total_lx / np.pi, rel=1e-9)


def test_nothing_is_read_off_a_luminaire_or_off_nothing(room):
    solution = renderer.solve(room(0.5), bands="rgb", accuracy=0.1)
    click, lines = reading_lines(
        solution, place_at(solution, np.array([2.0, 2.0, 1.0]), np.array([0.0, 0.0, 1.0]))
    )
    assert click is None
    assert "1000 cd/m²" in lines[1]
    assert reading_lines(solution, None)[0] is None


@LINUX
@pytest.mark.parametrize("display", [None, ":7654"])
def test_without_a_display_one_sentence_names_the_report(here, tmp_path, monkeypatch, display):
    monkeypatch.delenv("DISPLAY", raising=False)
    if display:  # set, and nobody answers
        monkeypatch.setenv("DISPLAY", display)
    run = here("view", "grey_room", cwd=tmp_path)
    assert run.returncode == 1
    assert run.stdout == ""
    assert run.stderr.count("\n") == 1
    assert "renderer report" in run.stderr
    assert (display or "DISPLAY is not set") in run.stderr
    assert not (tmp_path / "outputs").exists()


@pytest.mark.parametrize("platform", ["darwin", "win32"])
def test_a_display_is_asked_for_only_where_there_is_such_a_thing(monkeypatch, platform):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(sys, "platform", platform)
    refuse_no_display()
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(DisplayError):
        refuse_no_display()


@pytest.fixture(scope="module")
def screen():
    """The environment of an X server without a screen, of 1400 × 1000 pixels."""
    reading, writing = os.pipe()
    # Without -noreset it starts anew whenever its last client, xdotool perhaps, has left.
    words = ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1400x1000x24", "-noreset"]
    server = subprocess.Popen(words, pass_fds=[writing], stderr=subprocess.DEVNULL)
    os.close(writing)
    with os.fdopen(reading) as number:
        display = f":{number.readline().strip()}"
    kept = {k: v for k, v in os.environ.items() if k != "VTK_DEFAULT_OPENGL_WINDOW"}
    yield {**kept, "DISPLAY": display}
    server.terminate()
    server.wait()


class Desk:
    """A user at the window of `renderer view`: real clicks and keys, and what is saved and said."""

    def __init__(self, scene, environment, folder):
        self.environment, self.out = environment, folder
        words = ["view", scene.path, "--accuracy", "10%", "--quiet", "--out", self.out]
        self.program = subprocess.Popen([sys.executable, "-m", "renderer", *map(str, words)], env=environment,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            named = ("search", "--onlyvisible", "--name", f"^{scene.title}$")
            self.window = self.waited(lambda: self.do(*named))
        except BaseException:
            self.program.kill()
            raise

    def do(self, *words):
        """What xdotool says to a command; "" where it fails."""
        return subprocess.run(["xdotool", *map(str, words)], env=self.environment, capture_output=True,
                              text=True, timeout=20, check=False).stdout.strip()

    def waited(self, found, seconds=60):
        """What `found` returns, as soon as it is something."""
        end = time.monotonic() + seconds
        while not (value := found()):
            assert time.monotonic() < end, "waited in vain"
            assert self.program.poll() is None, self.program.communicate()
            time.sleep(0.05)
        return value

    def click(self, x, y):
        """Press and release the left button there [pixels from the window's upper left corner]."""
        self.do("mousemove", "--sync", "--window", self.window, x, y, "click", 1)

    def drag(self, x, y, dx, dy):
        """Press the left button there and release it elsewhere."""
        move = ("mousemove_relative", "--sync", "--", dx // 2, dy // 2)
        self.do("mousemove", "--sync", "--window", self.window, x, y, "mousedown", 1, *move, *move, "mouseup",
                1)

    def press(self, *keys):
        """Press keys, one after the other."""
        self.do("windowfocus", "--sync", self.window, "key", "--delay", 50, *keys)

    def picture(self):
        """What the window shows after all that was asked (height, width, 3), by its own key."""
        number = len(list(self.out.glob("*.png"))) + 1
        self.press("s")
        file = self.waited(lambda: next(self.out.glob(f"*_view_{number}.png"), None))
        return np.array(Image.open(file).convert("RGB")).astype(int)

    def close(self):
        """Ask it to close, as a window manager does when its cross is clicked on."""
        x11 = ctypes.CDLL("libX11.so.6")
        x11.XOpenDisplay.restype, x11.XInternAtom.restype = ctypes.c_void_p, ctypes.c_ulong
        display = ctypes.c_void_p(x11.XOpenDisplay(self.environment["DISPLAY"].encode()))
        protocols, delete = (x11.XInternAtom(display, name, 0)
                             for name in (b"WM_PROTOCOLS", b"WM_DELETE_WINDOW"))
        window = ctypes.c_ulong(int(self.window))
        # XClientMessageEvent: type 33, serial, sent, display, window, message, format, data; then padding.
        event = struct.pack("@iLiPLLi5l24l", 33, 0, 1, 0, window.value, protocols, 32, delete, *[0] * 28)
        x11.XSendEvent(display, window, 0, 0, event)
        x11.XCloseDisplay(display)

    def ended(self):
        """Exit code, stdout, stderr."""
        out, err = self.program.communicate(timeout=60)
        return self.program.returncode, out, err


@pytest.fixture
def desk(room_file, screen, tmp_path):
    """A function that opens a room's window; it is closed at the end whatever happens."""
    opened = []

    def sit(**keys):
        title = f"Test room {len(opened)}"
        opened.append(Desk(with_camera(room_file(0.5, **keys), title), screen, tmp_path / title))
        return opened[-1]

    yield sit
    for each in opened:
        if each.program.poll() is None:
            each.program.kill()
            each.program.communicate()


def floor_under(x, y, width=1200, height=800):
    """Where CAMERA sees the floor through a pixel of a window (3,) [m], worked out anew: its picture of
    4 : 3 fits into the window's height."""
    eye, target = np.array(CAMERA["position"]), np.array(CAMERA["look_at"])
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    pixel = 2 * np.tan(np.radians(CAMERA["fov"] / 2)) * 480 / 640 / height
    direction = forward + (x + 0.5 - width / 2) * pixel * right + (height / 2 - y - 0.5) * pixel * up
    return eye - direction * eye[2] / direction[2]


@LINUX
@XVFB
def test_real_clicks_and_keys_in_a_real_window(desk, here, tmp_path):
    user = desk()
    start = user.picture()
    assert user.picture().shape == (800, 1200, 3)
    user.click(640, 700)
    clicked = user.picture()
    assert (clicked[560:] != start[560:]).any()  # the reading and its mark
    assert (clicked[60:500, 500:] == start[60:500, 500:]).all()
    user.press("c")
    luminance = user.picture()
    assert np.abs(luminance[300:500, 300:900] - start[300:500, 300:900]).mean() > 30
    assert (luminance[780, 1110:1180] == 255).all()  # the legend
    user.press("i")
    assert (user.picture() != luminance).any()
    user.press("h")
    hidden = user.picture()
    assert (hidden[60:120, 20:400] != luminance[60:120, 20:400]).any()
    user.press("h", "i", "c")
    user.drag(600, 400, 120, 40)
    turned = user.picture()
    assert np.abs(turned - clicked)[200:600].mean() > 3
    user.press("r")
    assert np.abs(user.picture() - clicked)[:550].mean() < 1
    user.press("b", "o")
    user.click(1190, 300)  # beside the room
    user.click(600, 500)
    user.picture()
    user.press("Escape")
    code, out, err = user.ended()
    assert (code, err) == (0, "")
    rows = re.findall(ROW, out)
    # The drag and the click beside the room read nothing; b reads the same place again in RGB.
    assert [(row[0], row[1]) for row in rows] == [("floor", "31 bands"), ("floor", "RGB"), ("floor", "RGB")]
    at = np.array(rows[0][2].split(","), float)
    np.testing.assert_allclose(at, floor_under(640, 700), atol=1e-5)  # printed with 6 digits
    for row in rows:
        bands = {"RGB": "rgb", "31 bands": "31"}[row[1]]
        read_there = here("photometer", user.program.args[4], "--at", row[2], "--normal", row[3], "--bands",
                          bands, "--accuracy", "10%", "--json", "--quiet", cwd=tmp_path)
        lx = json.loads(read_there.stdout)["readings"][0]["illuminance_lx"]
        # To the last digit printed; the place is rounded to 1e-5 m, in which 100 lx change by 1e-3.
        assert float(row[4]) == pytest.approx(lx["direct"], abs=0.0065)
        assert float(row[6]) == pytest.approx(lx["total"], abs=0.0065)
        assert float(row[7]) == pytest.approx(lx["uncertainty"], rel=0.06)


@LINUX
@XVFB
def test_the_window_manager_and_ctrl_c_close_it(desk):
    first, second = desk(luminaires=[], objects=[CRATE]), desk()
    assert (first.picture()[200:500, 500:] == 0).all()  # a dark room
    first.close()
    assert first.ended()[0] == 0
    second.program.send_signal(signal.SIGINT)
    code, _, err = second.ended()
    assert (code, "interrupted" in err) == (1, True)
