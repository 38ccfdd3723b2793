"""Cases of light in rooms: CIE 171:2006, closed rooms, Sumpner's planes, the integrating sphere, the
furnace."""

import json
from pathlib import Path

import numpy as np
import trimesh

from renderer.radiometry.polygons import exchange_areas, polygon_factors
from renderer.readings.photometer import make_meter
from renderer.solving.solution import Solution, solve
from renderer.solving.transport_store import TransportStore
from renderer.studies.validation.cases import PANEL, Case, box_scene, solid
from renderer.transport.radiosity.solve import radiosity
from renderer.transport.transport import compute_transport

PUBLISHED_VALUES = json.loads((Path(__file__).parent / "oracles.json").read_text())
PHOTOMETRIC_TOLERANCE = 0.002
"""Largest error of a photometric value, relative to it."""
BALANCE_TOLERANCE = 1e-6
UP = (0.0, 0.0, 1.0)
POINT_LAMP = """
[[luminaires]]
shape = "point"
center = [2, 2, 2]
flux = 10000
"""


def form_factors(_folder: Path) -> list[Case]:
    """Rectangles and points against Howell's closed forms."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    wall = np.array([[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]], dtype=float)
    small = square * 0.1 + [0.1, 0.1, 0]

    def over(a, height):
        return a, a[::-1] + [0, 0, height]

    pairs = [over(square, 1), over(square * [1, 1.5, 1], 0.5), (square, wall), over(square * 4, 3),
             (square * 4, wall * [1, 4, 3]), None, None, over(small, 0.05)]
    got = []
    for pair in pairs:
        if pair is not None:
            area = np.linalg.norm(np.cross(pair[0][1] - pair[0][0], pair[0][3] - pair[0][0]))
            got.append(exchange_areas(pair[0][None], pair[1][None])[0] / area)
    origin, up = np.zeros((1, 3)), np.array([UP])
    parallel = polygon_factors(origin, up, (square[::-1] + [0, 0, 1])[None])[0]
    # B-4: the normal lies along the height a; width b; the plane c away.
    upright = np.array([[0, 0, 1.5], [0, 3, 1.5], [2, 3, 1.5], [2, 0, 1.5]])
    across = polygon_factors(origin, np.array([[1.0, 0, 0]]), upright[None])[0]
    got[5:5] = [parallel, across]
    return [Case("Form factors", entry["case"], "F", entry["value"], float(value), 1e-6,
                 source="Howell, Mengüç, Daun and Siegel, catalogue of configuration factors")
            for entry, value in zip(PUBLISHED_VALUES["form_factors"], got, strict=True)]


def cie_171(folder: Path) -> list[Case]:
    """CIE 171:2006, cases 5.2 to 5.4 and 5.6 to 5.8."""
    return [*_point_source(folder), *_area_source(folder), *_flux(folder), *_lit_floor(folder),
            *_lit_wall(folder), *_mean_indirect(folder)]


def _case(number: str, where: str, quantity: str, expected: float, got: float, unit: str) -> Case:
    # At y = 1.75 m of case 5.7 the wall's top lies on the shadow line, and rays resolve 16 µm.
    return Case("CIE 171:2006", f"{number} {where}", quantity, expected, float(got),
                max(PHOTOMETRIC_TOLERANCE * abs(expected), 1e-3 if number == "5.7" else 1e-6), unit,
                "closed forms of CIE 171:2006, recomputed where the printed table is wrong (5.7)")


def _point_source(folder: Path) -> list[Case]:
    lamp = ('\n[[luminaires]]\nshape = "point"\ndistribution = "lambertian"\ncenter = [4, 4, 3]\n'
            "normal = [0, 0, -1]\nintensity = 1000\n")
    solution = solve(box_scene(folder, lamp, (8, 8, 4), 0.0), "rgb")
    case = PUBLISHED_VALUES["cie171"]["5.2"]
    return [_case("5.2", f"({x:g}, {y:g})", "illuminance", 3 ** 2 * 1000 / (x * x + y * y + 9) ** 2,
                  solution.photometer([4 + x, 4 + y, 0], UP).total_lx, "lx") for x, y in case["points_xy"]]


def _area_source(folder: Path) -> list[Case]:
    solution = solve(box_scene(folder, rho=0.0), "rgb")
    case = PUBLISHED_VALUES["cie171"]["5.3"]
    walls = [_case("5.3", f"wall, z = {z:g} m", "illuminance", e,
                   solution.photometer([2, 0, z], [0, 1, 0]).total_lx, "lx")
             for z, e in zip(case["wall_z"], case["wall_exact"], strict=True)]
    return walls + [_case("5.3", f"floor, y = {y:g} m", "illuminance", e,
                          solution.photometer([2, y, 0], UP).total_lx, "lx")
                    for y, e in zip(case["floor_y"], case["floor_exact"], strict=True)]


def _flux(folder: Path) -> list[Case]:
    solution = solve(box_scene(folder, POINT_LAMP, rho=0.0), "rgb")
    received = solution.transport.exchange.areas @ solution.direct_irradiance
    return [_case("5.4", "10,000 lm", "flux received over emitted",
                  PUBLISHED_VALUES["cie171"]["5.4"]["exact"], received.sum() / solution.flux.sum(), "1")]


def _lit_floor(folder: Path) -> list[Case]:
    """5.6: a floor of even exitance, which is set; the meter is the program's own."""
    solution = solve(box_scene(folder, POINT_LAMP, rho=0.3), "rgb")
    case = PUBLISHED_VALUES["cie171"]["5.6"]
    rows = [("wall, z", z, e, (2, 0, z), (0, 1, 0))
            for z, e in zip(case["wall_z"], case["wall"], strict=True)]
    rows += [("ceiling, y", y, e, (2, y, 3), (0, 0, -1))
             for y, e in zip(case["ceiling_y"], case["ceiling"], strict=True)]
    return [_case("5.6", f"{where} = {at:g} m", "of the floor's exitance", expected,
                  100 * _from_surface(solution, "floor", position, normal), "%")
            for where, at, expected, position, normal in rows]


def _lit_wall(folder: Path) -> list[Case]:
    """5.7: a wall of even exitance with a black box in front of it."""
    box = solid("box", (0, 2.5, 0), (4, 0.2, 1), "black")
    solution = solve(box_scene(folder, POINT_LAMP + box, rho=0.6), "rgb")
    case = PUBLISHED_VALUES["cie171"]["5.7"]
    rows = [("wall, z", z, e, (2, 0, z), (0, 1, 0))
            for z, e in zip(case["wall_z"], case["wall"], strict=True)]
    rows += [("floor, y", y, e, (2, y, 0), UP) for y, e in zip(case["floor_y"], case["floor"], strict=True)]
    return [_case("5.7", f"{where} = {at:g} m", "of the wall's exitance", expected,
                  100 * _from_surface(solution, "wall_y1", position, normal), "%")
            for where, at, expected, position, normal in rows]


def _from_surface(solution: Solution, name: str, position, normal) -> float:
    """Illuminance at a meter from one surface of radiosity 1."""
    mesh, index = solution.transport.mesh, solution.scene.surface_names.index(name)
    meter = make_meter(solution.transport, np.array(position, dtype=float), np.array(normal, dtype=float), "")
    vertices, patches = ((of == index)[:, None].astype(float) for of in (mesh.vertex_surface, mesh.surface))
    return float(np.mean([sensor.indirect_radiosity(vertices, patches).sum() for sensor in meter.sensors]))


def _mean_indirect(folder: Path) -> list[Case]:
    case, rows = PUBLISHED_VALUES["cie171"]["5.8"], []
    for rho in case["rho"]:
        solution = solve(box_scene(folder, POINT_LAMP, (4, 4, 4), float(rho)), "rgb", 0.05)
        areas = solution.transport.exchange.areas
        indirect = (solution.irradiance - solution.direct_irradiance) @ solution.bands.luminous
        rows.append(_case("5.8", f"ρ = {rho:g}", "mean indirect", 10000 / 96 * rho / (1 - rho),
                          areas @ indirect / areas.sum(), "lx"))
    return rows


def closed_rooms(folder: Path) -> list[Case]:
    """Mean illuminance Φ/(S(1 − ρ)) and energy balance of rooms of several shapes, with and without
    objects."""
    crate, ball = solid("box", (0.5, 1, 0), (1.2, 0.7, 1.5)), solid("sphere", (1, 1, 0.5), (0.8, 0.8, 0.8))
    bend = "outline = [[0,0],[5,0],[5,3],[3,3],[3,6],[0,6]]\nheight = 3"
    rooms = {"box": ("", ""), "box with a crate": (crate, ""), "box with a ball": (ball, ""),
             "L-shaped": ("", bend)}
    rows = []
    for name, (objects, shape) in rooms.items():
        for rho in (0.2, 0.5, 0.9):
            solution = solve(box_scene(folder, POINT_LAMP + objects, rho=rho, shape=shape), "rgb", 0.05)
            areas = solution.transport.exchange.areas
            mean = areas @ solution.irradiance @ solution.bands.luminous / areas.sum()
            expected = 10000 / areas.sum() / (1 - rho)
            rows.append(Case("Closed rooms", f"{name}, ρ = {rho:g}", "mean total", expected, float(mean),
                             BALANCE_TOLERANCE * expected, "lx", "Φ/(S(1 − ρ)); absorbed is emitted flux"))
            rows.append(Case("Closed rooms", f"{name}, ρ = {rho:g}", "energy balance", 0.0,
                             solution.energy_balance_error, BALANCE_TOLERANCE))
    return rows


def sphere(folder: Path) -> list[Case]:
    """An integrating sphere as a meshed room: even indirect illuminance."""
    ball = trimesh.creation.icosphere(subdivisions=3, radius=1.0)
    ball.export(folder / "sphere.ply")
    lamp = '\n[[luminaires]]\nshape = "point"\ncenter = [0.3, 0.2, 0.1]\nflux = 1000\n'
    rows, store = [], TransportStore()
    for rho in (0.5, 0.9, 0.98):
        scene = box_scene(folder, lamp, rho=rho, shape='mesh = "sphere.ply"')
        solution = solve(scene, "rgb", store=store)
        expected = 1000 / scene.room.area * rho / (1 - rho)
        middles = ball.triangles_center[:: len(ball.faces) // 4]
        for k, point in enumerate(middles):
            reading = solution.photometer(point, -point)
            rows.append(Case("Integrating sphere", f"ρ = {rho:g}, facet {k}", "indirect", expected,
                             reading.indirect_lx, PHOTOMETRIC_TOLERANCE * expected, "lx",
                             "Φ/S · ρ/(1 − ρ), so with the direct mean the gain is 1/(1 − ρ); 1,280 facets"))
    return rows


def planes(folder: Path) -> list[Case]:
    """Floor and ceiling of a wide room with black walls and an evenly lit floor: Sumpner's sums."""
    rows = []
    walls = 'walls = "black"'
    for rho in (0.2, 0.5, 0.8):
        for width in (10, 30, 100):
            scene = box_scene(folder, "", (width, width, 1), rho, walls)
            transport = compute_transport(scene, width / 16, 0, 0)
            names = np.array(scene.surface_names)[transport.mesh.surface]
            lit = (names == "floor").astype(float)[:, None]
            on = np.where(np.isin(names, ["floor", "ceiling"]), rho, 0.0)[:, None]
            received = lit + radiosity(transport.exchange, on, lit)[1]
            middle = np.linalg.norm(transport.mesh.centroid[:, :2] - width / 2, axis=1)
            for name, expected in (("floor", 1 / (1 - rho**2)), ("ceiling", rho / (1 - rho**2))):
                at = np.flatnonzero(names == name)
                got = received[at[middle[at].argmin()], 0]
                # At each crossing, light from the middle loses the share of its view past the plate's edge,
                # and light from elsewhere up to twice that. The mean number of crossings to the floor is Σ 2k
                # ρ^2k / Σ ρ^2k.
                crossings = 2 * rho**2 / (1 - rho**2) + (name == "ceiling")
                lost = 2 * (1 - _above_middle(width)) * crossings
                rows.append(Case("Wide plates", f"ρ = {rho:g}, {width} × {width} × 1 m", name, expected,
                                 float(got), (lost + PHOTOMETRIC_TOLERANCE) * expected, "E_D",
                                 "two infinite planes, W. E. Sumpner 1892; the tolerance is the light lost "
                                 "through the sides"))
    return rows


def _above_middle(width: float) -> float:
    """Share of the view from the floor's middle that a ceiling 1 m above fills."""
    half = width / 2
    corners = np.array([[-half, -half, 1], [-half, half, 1], [half, half, 1], [half, -half, 1]])
    return float(polygon_factors(np.zeros((1, 3)), np.array([UP]), corners[None])[0])


def furnace(folder: Path) -> list[Case]:
    """White furnace: where every surface emits 1 − ρ, each receives 1."""
    crate = solid("box", (0.5, 1, 0), (1.2, 0.7, 1.5))
    rows = []
    for name, objects in (("empty", ""), ("with a crate", crate)):
        transport = compute_transport(box_scene(folder, PANEL + objects), 0.5, 256 if objects else 0, 0)
        rho = np.random.default_rng(0).uniform(0, 1, (len(transport.mesh.patches), 1))
        # B = ρE + (1 − ρ) with E = 1 is what direct light (1 − ρ)/ρ would give.
        received = radiosity(transport.exchange, rho, (1 - rho) / rho)[1][transport.exchange.areas > 0]
        worst = received.ravel()[np.abs(received - 1).argmax()]
        rows.append(Case("White furnace", name, "irradiance farthest from 1", 1.0, float(worst), 1e-6,
                         source="every surface emits 1 − ρ, so all receive 1 for any ρ"))
    return rows
