"""Does it matter that lighting software models colour as RGB? Spectral radiosity of rooms.

    import renderer
    scene = renderer.load("red_room")                   # a packaged room, a scene file, or a dict of its keys
    solution = renderer.solve(scene, "31")              # a notebook shows it: picture and readings
    solution.photometers()                              # readings of the scene's photometers, with error bars
    solution.photometer([2.7, 2.7, 0], [0, 0, 1]).total_lx
    renderer.solve(scene.with_values({"materials.red.munsell": "5R 4/14"}), "31")
    solution.to_xarray().illuminance.groupby("surface").max()
"""

import os as _os
from typing import TYPE_CHECKING as _TYPE_CHECKING

from renderer.errors import InputError, SolveError

if _TYPE_CHECKING:
    from renderer.python_interface import Scene, Solution, load, solve
    from renderer.readings.glare import Glare
    from renderer.readings.grid import GridReading
    from renderer.readings.reading import Reading
    from renderer.readings.uncertainty import Figure

__version__ = "0.2.0"

# By default OpenBLAS's threads wait 2^26 cycles for the next product and so occupy the cores that trace rays.
# The variable counts where numpy is imported after renderer.
_os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "18")

__all__ = ["Figure", "Glare", "GridReading", "InputError", "Reading", "Scene", "Solution", "SolveError",
           "load", "solve"]


def __getattr__(name: str) -> object:
    """A public name, imported when first used, because importing numpy and scipy takes long."""
    if name not in __all__:
        raise AttributeError(f"module 'renderer' has no attribute {name!r}")
    from importlib import import_module

    # Public names that are not in renderer.python_interface.
    elsewhere = {"Glare": "renderer.readings.glare", "GridReading": "renderer.readings.grid",
                 "Reading": "renderer.readings.reading", "Figure": "renderer.readings.uncertainty"}
    return getattr(import_module(elsewhere.get(name, "renderer.python_interface")), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
