"""Whether a window can be opened here, asked before VTK is: without a display it may end the program."""

import os
import subprocess
import sys

from renderer.errors import DisplayError

PROBE = """
from vtkmodules.vtkRenderingCore import vtkRenderWindow
import vtkmodules.vtkRenderingOpenGL2
window = vtkRenderWindow()
window.SetShowWindow(False)
print(window.GetClassName() if window.SupportsOpenGL() else "no OpenGL")
"""
ON_SCREEN = "vtkXOpenGLRenderWindow"
"""What VTK makes under X; where it cannot, one that draws unseen."""
PATIENCE = 30.0
"""Seconds for a display, which may be on another machine, to answer."""
INSTEAD = "renderer report SCENE makes a page with the same room and photometer for any browser."


def refuse_no_display() -> None:
    """Raise DisplayError where no window can be opened. Elsewhere than under X one always can."""
    if sys.platform in ("darwin", "win32"):
        return
    display = os.environ.get("DISPLAY")
    if not display:
        under = "Wayland without Xwayland" if os.environ.get("WAYLAND_DISPLAY") else "DISPLAY is not set"
        raise DisplayError(f"there is no X display to open a window on ({under}). {INSTEAD}")
    # In a process of its own: with a dead display, or one without OpenGL, some versions of VTK abort.
    try:
        said = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True, check=False,
                              timeout=PATIENCE, stdin=subprocess.DEVNULL).stdout
    except subprocess.TimeoutExpired:
        said = ""
    if ON_SCREEN not in said:
        raise DisplayError(f"no window can be opened on DISPLAY {display!r} (no X server answers there, or "
                           f"it has no OpenGL, or libX11 or libGL is not installed). {INSTEAD}")


def refuse_unseen(render_window) -> None:
    """Raise DisplayError where VTK has made no window after all: the display has gone since it was asked."""
    if sys.platform not in ("darwin", "win32") and render_window.GetClassName() != ON_SCREEN:
        raise DisplayError(f"the display {os.environ.get('DISPLAY')!r} answers no more. {INSTEAD}")
