"""Does it matter that lighting software models colour as RGB? Spectral radiosity of rooms.

    import renderer
    scene = renderer.load("red_room")                   # a packaged room, or a scene file
    solution = renderer.solve(scene, "31")              # a notebook shows it: picture and readings
    solution.photometers()                              # the scene's own, with error bars
    solution.photometer([2.7, 2.7, 0], [0, 0, 1]).total_lx
    solution.to_xarray().illuminance.groupby("surface").max()
"""

import os

from renderer.errors import InputError, SolveError

# OpenBLAS's threads wait for the next product for some 2^26 cycles, on the cores that rays and factors are
# worked out on meanwhile; it reads this where numpy is imported after renderer.
os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "18")

__all__ = ["InputError", "SolveError", "load", "solve"]


def __getattr__(name: str):
    """`load` and `solve`, imported when first used: numpy and scipy take a while."""
    if name == "load":
        from renderer.scene.reading import load

        return load
    if name == "solve":
        from renderer.solving.solution import Solution, solve

        # A solution knows neither pictures nor xarray, which come after it: here it is given both.
        Solution._repr_html_, Solution.to_xarray = _repr_html_, to_xarray
        return solve
    raise AttributeError(f"module 'renderer' has no attribute {name!r}")


def _repr_html_(solution) -> str:
    """A solution as a notebook shows it: a small picture, and the readings with error bars."""
    from renderer.pictures.notebook import html

    return html(solution)


def to_xarray(solution):
    """Light on every patch of a solution as an xarray.Dataset, with names and units.

    Raises ImportError where there is no xarray.
    """
    from renderer.records.xarray_dataset import dataset

    return dataset(solution)
