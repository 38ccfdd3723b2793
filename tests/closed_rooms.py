"""A lamp, a box, and the mean illuminance of closed rooms."""


LAMP = {"shape": "point", "center": [1.3, 2.2, 1.7], "flux": 1000.0}
BOX = {"shape": "box", "position": [0.5, 1.0, 0.0], "size": [1.2, 0.7, 1.5]}
RHOS = [0.0, 1e-12, 0.2, 0.5, 0.9, 0.9999, 1 - 1e-9]


def mean_illuminance(solution) -> float:
    """Area mean of total illuminance over all exposed surfaces [lx]."""
    areas = solution.transport.exchange.areas
    return float(areas @ (solution.irradiance @ solution.bands.luminous) / areas.sum())
