"""Does it matter that lighting software models colour as RGB? Spectral radiosity of rooms.

    import renderer
    scene = renderer.load("scenes/red_room.toml")
    solution = renderer.solve(scene, bands="31")
    solution.photometer([2.7, 2.7, 0], [0, 0, 1]).total_lx
"""

from renderer.errors import InputError, SolveError

__all__ = ["InputError", "SolveError", "load", "solve"]


def __getattr__(name: str):
    """`load` and `solve`, imported when first used: numpy and scipy take a while."""
    if name == "load":
        from renderer.scene.reading import load

        return load
    if name == "solve":
        from renderer.solution import solve

        return solve
    raise AttributeError(f"module 'renderer' has no attribute {name!r}")
