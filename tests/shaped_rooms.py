"""Parts of rooms that are not boxes."""

import trimesh

POINT = 'shape = "point"\ncenter = [1.0, 1.0, 1.3]\nflux = 1000'
BOX = trimesh.creation.box(bounds=[[0, 0, 0], [4, 4, 3]])
TOP = BOX.triangles_center[:, 2] > 2.9


def panel(center, up=(1, 0, 0)) -> str:
    """A 1 m² panel of 4000 lm that shines down."""
    numbers = [", ".join(repr(float(x)) for x in v) for v in (center, up)]
    return ('shape = "rectangle"\ncenter = [{}]\nup = [{}]\nnormal = [0, 0, -1]\nsize = [1.0, 1.0]\n'
            "flux = 4000".format(*numbers))


def mean_lx(solution) -> float:
    """Area mean of illuminance over all surfaces [lx]."""
    areas = solution.transport.exchange.areas
    return float(areas @ (solution.irradiance @ solution.bands.luminous) / areas.sum())
