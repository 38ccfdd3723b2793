"""The window of `renderer view`, opened under Xvfb and clicked in by xdotool."""

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
from PIL import Image
from viewed_rooms import CAMERA, CRATE, with_camera

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is no DISPLAY")


XVFB = pytest.mark.skipif(
    not (shutil.which("Xvfb") and shutil.which("xdotool")), reason="the window's test needs Xvfb and xdotool "
    "(Debian: apt-get install xvfb xdotool libgl1)")
ROW = r"(\S+) +(RGB|31 bands) +(\S+,\S+,\S+) +(\S+,\S+,\S+) +(\S+) +(\S+) +(\S+) +± (\S+)"


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
    """A user at the window of `renderer view`: real clicks and keys, saved files and output."""

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
        """Output of an xdotool command; "" where it fails."""
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
        """The window's picture after all commands (height, width, 3), saved by its own key."""
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
