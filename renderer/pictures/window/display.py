"""The check for a display before VTK opens a window: without one VTK may end the program."""

import os
import subprocess
import sys

from renderer.errors import DisplayError

X_WINDOW_CLASS = "vtkXOpenGLRenderWindow"
"""Class of VTK's windows under X. Where VTK cannot open one, it makes a window of another class, off
screen."""


def refuse_no_display() -> None:
    """Raise DisplayError where no window can be opened; macOS and Windows always can."""
    if sys.platform in ("darwin", "win32"):
        return
    display = os.environ.get("DISPLAY")
    if not display:
        under = "Wayland without Xwayland" if os.environ.get("WAYLAND_DISPLAY") else "DISPLAY is not set"
        raise _no_window(f"there is no X display to open a window on ({under})")
    # In a separate process, because some versions of VTK abort without a display or OpenGL.
    probe = """
from vtkmodules.vtkRenderingCore import vtkRenderWindow
import vtkmodules.vtkRenderingOpenGL2
window = vtkRenderWindow()
window.SetShowWindow(False)
print(window.GetClassName() if window.SupportsOpenGL() else "no OpenGL")
"""
    try:
        said = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=False,
                              timeout=30.0, stdin=subprocess.DEVNULL).stdout
    except subprocess.TimeoutExpired:
        said = ""
    if X_WINDOW_CLASS not in said:
        raise _no_window(f"no window can be opened on DISPLAY {display!r} (no X server answers there, or "
                         "it has no OpenGL, or libX11 or libGL is not installed)")


def refuse_unseen(render_window) -> None:
    """Raise DisplayError where VTK has opened no window because the display was lost after the check."""
    if sys.platform not in ("darwin", "win32") and render_window.GetClassName() != X_WINDOW_CLASS:
        raise _no_window(f"the display {os.environ.get('DISPLAY')!r} no longer answers")


def _no_window(reason: str) -> DisplayError:
    return DisplayError(f"{reason}. renderer report SCENE makes a page with the same room and photometer for "
                        "any browser.")
