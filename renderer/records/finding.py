"""The error of RGB in a room, from its readings."""

from renderer.readings.finding import Comparison, Finding, of_grid, of_reading
from renderer.readings.grid import GridReading
from renderer.readings.reading import Reading
from renderer.solving.solution import Solution


def room_finding(title: str, readings: list[Reading], grids: list[GridReading] = ()) -> Finding:
    """The error of RGB in a room, from readings in 31 bands that also hold the illuminance in RGB."""
    found = [each for each in map(of_grid, grids) if each]
    return Finding(title, [one for reading in readings for one in of_reading(reading)]
                   + [mean for mean, _ in found], [worst for _, worst in found])


def solution_finding(rgb: Solution, spectral: Solution, readings: list[Reading],
                     grids: list[GridReading] = ()) -> Finding:
    """The error of RGB in a room solved in RGB and in 31 bands on one transport.

    Without readings it is the error of the mean over the room's surfaces, with the requested accuracy as
    error bar.
    """
    found = room_finding(spectral.scene.title, readings, grids)
    if found.readings:
        return found
    total, other = mean_lx(spectral), mean_lx(rgb)
    direct = _area_mean(spectral, spectral.direct_irradiance)
    mean = Comparison("its surfaces, on average", other, total, direct,
                      spectral.scene.solver.accuracy * total)
    return Finding(spectral.scene.title, [mean])


def mean_lx(solution: Solution) -> float:
    """Mean illuminance of all surfaces [lx]: Σ A E / Σ A."""
    return _area_mean(solution, solution.irradiance)


def _area_mean(solution: Solution, irradiance) -> float:
    areas = solution.transport.exchange.areas
    return float(areas @ (irradiance @ solution.bands.luminous) / areas.sum())
