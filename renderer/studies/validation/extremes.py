"""Cases at the limits: reflectances of 0 and 1, rooms of a millimetre and ten kilometres, faulty geometry.

In each case the result is right within a stated tolerance, or the input is refused with one sentence.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import trimesh

from renderer.colour.bands import band_set
from renderer.errors import InputError, SolveError
from renderer.readings.photometer import make_meter
from renderer.readings.reading import Reading
from renderer.scene.scene import Scene
from renderer.solving.plan import Plan
from renderer.solving.solution import Solution, solve, solve_on
from renderer.solving.transport_store import TransportStore
from renderer.studies.validation.cases import PANEL, Case, box_scene, meter, solid
from renderer.studies.validation.photometry import BALANCE_TOLERANCE, POINT_LAMP, UP
from renderer.transport.transport import compute_transport

FLOOR_METER = meter(1.5, 2.2, 0)
CRATE = solid("box", (0.5, 1, 0), (1.2, 0.7, 1.5))


def refusal(work: Callable[[], object]) -> str:
    """The sentence of a refusal, without its path; "not refused" for none."""
    try:
        work()
    except (InputError, SolveError) as error:
        return str(error).split(".toml: ")[-1]
    return "not refused"


def _mean(solution: Solution) -> float:
    areas = solution.transport.exchange.areas
    return float(areas @ solution.irradiance @ solution.bands.luminous / areas.sum())


def _total(scene, accuracy: float | None = None) -> float:
    return solve(scene, "rgb", accuracy).photometers()[0].total_lx


def reflectances(folder: Path) -> list[Case]:
    """Reflectances from 0 to 1: the mean illuminance by conservation of energy; no light; linearity in the
    flux."""
    case, rows = partial(Case, "Reflectance and flux"), []
    for rho in (0.0, 1e-12, 0.5, 0.99, 0.9999, 1 - 1e-9):
        for name, objects in (("", ""), (", with a crate", CRATE)):
            solution = solve(box_scene(folder, POINT_LAMP + objects, rho=rho), "rgb", 0.05)
            areas = solution.transport.exchange.areas
            expected = 10000 / areas.sum() / (1 - rho)
            # The solver stops at a residual of 1e-11, which 1/(1 − ρ) enlarges.
            rows.append(case(f"ρ = {rho:.10g}{name}", "mean total", expected, _mean(solution),
                             (1e-9 + 1e-11 / (1 - rho)) * expected, "lx", "Φ/(S(1 − ρ))"))
    one = box_scene(folder, POINT_LAMP, rho=0.5, faces='ceiling = "white"')
    rows.append(case("ρ = 1 on the ceiling", "energy balance", 0.0,
                     solve(one, "rgb").energy_balance_error, BALANCE_TOLERANCE))
    rows.append(case("ρ = 1 everywhere", "refused", "no steady state",
                     refusal(lambda: solve(box_scene(folder, POINT_LAMP, rho=1.0), "rgb"))))
    lamp = solve(box_scene(folder, PANEL, rho=1.0), "rgb", 0.05)
    rows.append(case("ρ = 1 everywhere but the lamp's face", "energy balance", 0.0,
                     lamp.energy_balance_error, BALANCE_TOLERANCE))
    rows.append(case("no luminaire", "total", 0.0, _total(box_scene(folder, FLOOR_METER)), 0.0, "lx"))
    black = solve(box_scene(folder, PANEL + FLOOR_METER, rho=0.0), "rgb").photometers()[0]
    rows.append(case("black room", "indirect", 0.0, black.indirect_lx, 0.0, "lx"))
    small, large = (
        _total(box_scene(folder, POINT_LAMP.replace("10000", str(flux)) + CRATE + FLOOR_METER), 0.05)
        for flux in ("1e-12", "1e12")
    )
    rows.append(case("1e12 lm over 1e-12 lm", "ratio of readings", 1e24, large / small, 1e12,
                     source="light is linear; the tolerance is rounding, 1e-12"))
    return rows


def sizes(folder: Path) -> list[Case]:
    """Illuminance falls as the square of the scale, and does not depend on the room's place and direction."""
    case, rows = partial(Case, "Size, place and turn"), []
    base = _total(box_scene(folder, _scaled(1.0) + CRATE + FLOOR_METER))
    tolerance = 1e-4
    for metres in (1e-3, 1.0, 1e4):
        k = metres / 4
        crate = solid("box", np.multiply((0.5, 1, 0), k), np.multiply((1.2, 0.7, 1.5), k))
        scene = box_scene(folder, _scaled(k) + crate + meter(*np.multiply((1.5, 2.2, 0), k)),
                         np.multiply((4, 4, 3), k))
        rows.append(
            case(
                f"{metres:g} m",
                "total × scale²",
                base,
                _total(scene) * k**2,
                tolerance * base,
                "lx",
                "the same room of 4 m, same random numbers",
            )
        )
    for turn in (33.0, 180.0 / np.pi):
        for far in (0.0, 1e6):
            reading, reference = _outlined(folder, turn, far), _outlined(folder, 0.0, 0.0)
            rows.append(case(f"turned by {turn:.4g}°, moved by {far:g} m", "total", reference, reading,
                             tolerance * reference, "lx", "the same room of 4 m, same random numbers"))
    still, moved = (_bent(folder, turn, far) for turn, far in ((0.0, 0.0), (33.0, 1e6)))
    rows.append(case("L-shaped, turned by 33°, moved by 1e+06 m", "total", still.total_lx,
                     moved.total_lx, still.uncertainty + moved.uncertainty, "lx",
                     "both error bars; its rays differ"))
    for size, name in (((1, 1, 1000), "corridor"), ((1000, 1000, 1), "slab")):
        for what, objects in (("", ""), (" with a crate", solid("box", np.multiply((0.3, 0.3, 0), size),
                                                              np.minimum(0.3, size)))):
            point = POINT_LAMP.replace("2, 2, 2", ", ".join(str(x / 2) for x in size))
            solution = solve(box_scene(folder, point + objects, size), "rgb", 0.05)
            areas = solution.transport.exchange.areas
            expected = 10000 / areas.sum() / 0.5
            rows.append(case(f"{name} {size[0]} × {size[1]} × {size[2]} m{what}", "mean total", expected,
                             _mean(solution), BALANCE_TOLERANCE * expected, "lx", "Φ/(S(1 − ρ))"))
    return rows


def _scaled(k: float) -> str:
    panel = PANEL.replace("[2, 2, 3]", str([2 * k, 2 * k, 3 * k])).replace("[1, 1]", str([k, k]))
    return panel.replace("luminance = 1000", "flux = 3000")


def _outlined(folder: Path, turn: float, far: float) -> float:
    """Reading in a square room given by its outline, turned and moved."""
    square = ((0, 0), (4, 0), (4, 4), (0, 4))
    return solve(_moved(folder, square, turn, far), "rgb").photometers()[0].total_lx


def _bent(folder: Path, turn: float, far: float) -> Reading:
    """Reading in an L-shaped room, with rays, turned and moved."""
    bend = ((0, 0), (6, 0), (6, 3), (4, 3), (4, 6), (0, 6))
    return solve(_moved(folder, bend, turn, far), "rgb").photometers()[0]


def _moved(folder: Path, outline, turn: float, far: float) -> Scene:
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))

    def at(x, y, z=0.0):
        return [float(c * x - s * y + far), float(s * x + c * y + far), float(z)]

    panel = PANEL.replace("[2, 2, 3]", str(at(2, 2, 3))) + f"up = {[float(c), float(s), 0.0]}\n"
    shape = f"outline = {[at(*corner)[:2] for corner in outline]}\nheight = 3"
    return box_scene(folder, panel + meter(*at(1.5, 2.2)), shape=shape)


def lamps_and_meters(folder: Path) -> list[Case]:
    """Luminaires in contact or of 1 µm; meters on edges, in corners, on luminaires, and 1 µm off a wall."""
    case, rows = partial(Case, "Lamps and meters"), []
    near = POINT_LAMP.replace("2, 2, 2", "2, 2, 2.999999")
    solution = solve(box_scene(folder, near, rho=0.0), "rgb", 0.05)
    ceiling = solution.transport.mesh.surface == solution.scene.surface_names.index("ceiling")
    areas = solution.transport.exchange.areas * ceiling
    share = float(areas @ solution.irradiance @ solution.bands.luminous / 10000)
    rows.append(case("point lamp 1 µm under the ceiling", "share of its flux on the ceiling", 0.5, share,
                     1e-3, source="half of all directions go up"))
    tiny = PANEL.replace("[2, 2, 3]", "[25, 15, 10]").replace("[1, 1]", "[0.001, 0.001]").replace(
        "luminance = 1000", "flux = 1000")
    hall = solve(box_scene(folder, tiny + meter(25, 15, 0), (50, 30, 10), 0.0), "rgb").photometers()[0]
    rows.append(case("lamp of 1 mm in a hall of 50 m", "direct below it", 1000 / np.pi / 100,
                     hall.direct_lx, 1e-6 * 1000 / np.pi / 100, "lx", "Φ/(π h²)"))
    scene = box_scene(folder)
    solution = solve(scene, "rgb")
    spots = {"on an edge": (0, 2, 0), "in a corner": (0, 0, 0), "on a patch boundary": (2.5, 2, 0),
             "1 nm from a wall": (1e-9, 2, 0)}
    for name, spot in spots.items():
        inside = np.clip(spot, 1e-3, 4 - 1e-3) * [1, 1, 0]
        reading, beside = (solution.photometer(p, UP) for p in (spot, inside))
        rows.append(case(f"meter {name}", "total", beside.total_lx, reading.total_lx,
                         0.004 * beside.total_lx + reading.uncertainty + beside.uncertainty, "lx",
                         "1 mm beside it; the tolerance is the light's slope and both error bars"))
    on_lamp = solution.photometer([2, 2, 3], [0, 0, -1])
    rows.append(case("meter on the lamp", "direct", 0.0, on_lamp.direct_lx, 0.0, "lx",
                     "a lamp does not light its own face"))
    rows.append(case("meter on a point lamp", "refused", "on the point luminaire", refusal(
        lambda: solve(box_scene(folder, POINT_LAMP), "rgb", 0.05).photometer([2, 2, 2], UP))))
    return rows


def objects(folder: Path) -> list[Case]:
    """Contacts, duplicates, sheets, thin partitions, interpenetration; faulty meshes."""
    case, rows = partial(Case, "Objects and meshes"), []
    cube = solid("box", (1, 1, 0), (1, 1, 1))
    pieces = {
        "flush with floor and two walls": (solid("box", (0, 0, 0), (1, 1, 2)), 80),
        "the same box twice": (2 * cube, 80 + 4),
        "boxes through each other": (cube + solid("box", (1.5, 1, 0), (1, 1, 1)),
                                     80 + 1.5 + 2 * 1 + 2 * 1.5 - 1.5),
        "a crate on a crate": (cube + solid("box", (1, 1, 1), (1, 1, 1)), 80 + 8),
    }
    for name, (tables, area) in pieces.items():
        solution = solve(box_scene(folder, POINT_LAMP.replace("2, 2, 2", "3, 3, 2.5") + tables), "rgb", 0.05)
        exposed, expected = float(solution.transport.exchange.areas.sum()), 10000 / area / 0.5
        rows.append(case(name, "exposed area", float(area), exposed, 1e-6 * area, "m²", "counted by hand"))
        rows.append(case(name, "mean total", expected, _mean(solution), 1e-6 * expected, "lx",
                         "Φ/(S(1 − ρ))"))
    wall = solid("box", (2, 0, 0), (0.0001, 4, 3))
    dark = solve(box_scene(folder, POINT_LAMP.replace("2, 2, 2", "1, 2, 2") + wall + meter(3, 2, 0)), "rgb",
                 0.1)
    rows.append(case("behind a partition of 0.1 mm", "total", 0.0, dark.photometers()[0].total_lx, 1e-9,
                     "lx", "no light passes"))
    rows.append(case("a sheet of 1 µm", "refused", "Make it thicker", refusal(
        lambda: box_scene(folder, POINT_LAMP + solid("box", (2, 0, 0), (1e-6, 4, 3))))))
    return rows + _meshes(folder, case)


def _meshes(folder: Path, case: Callable[..., Case]) -> list[Case]:
    box = trimesh.creation.box(bounds=[[0, 0, 0], [4, 4, 3]])
    flipped = trimesh.Trimesh(box.vertices, np.where(np.arange(12)[:, None] % 3 == 0, box.faces[:, ::-1],
                                                     box.faces), process=False)
    sliver = trimesh.Trimesh(np.vstack([box.vertices, [[2, 0, 0]]]),
                             np.vstack([box.faces, [[0, 4, 8]]]), process=False)
    # A wall divided at its middle, its neighbours not: the vertex stands on their edges.
    apart = trimesh.creation.box(bounds=[[0, 0, 0], [4, 4, 3]]).subdivide(face_index=[0, 1])
    lidless = trimesh.Trimesh(box.vertices, box.faces[box.face_normals[:, 2] < 0.5], process=False)
    rows = []
    for name, mesh in (("flipped triangles", flipped), ("a triangle without area", sliver),
                       ("T-junctions", apart)):
        mesh.export(folder / "mesh.obj")
        solution = solve(box_scene(folder, POINT_LAMP, shape='mesh = "mesh.obj"'), "rgb", 0.05)
        rows.append(case(f"room mesh with {name}", "mean total", 10000 / 80 / 0.5, _mean(solution),
                         1e-6 * 250, "lx", "Φ/(S(1 − ρ))"))
    lidless.export(folder / "open.obj")
    scene = box_scene(folder, POINT_LAMP.replace("2, 2, 2", "2, 2, 1.5"), shape='mesh = "open.obj"', rho=0.0)
    solution = solve(scene, "rgb")
    opening = [name.startswith("opening") for name in scene.surface_names]
    areas = solution.transport.exchange.areas * np.array(opening)[solution.transport.mesh.surface]
    lost = float(areas @ solution.irradiance @ solution.bands.luminous)
    # From the middle of a box each face takes its solid angle: 4 arcsin of its half sides' slopes.
    a, b = np.arctan2(2, 1.5), np.arctan2(2, 1.5)
    share = 4 * np.arcsin(np.sin(a) * np.sin(b)) / (4 * np.pi)
    rows.append(case("black room without its lid", "lumens that escape", 10000 * share, lost, 1e-3, "lm",
                     "solid angle of the opening"))
    open_box = trimesh.Trimesh(lidless.vertices * 0.2, lidless.faces, process=False)
    open_box.export(folder / "crate.obj")
    crate = '\n[[objects]]\nname = "crate"\nmesh = "crate.obj"\nposition = [1, 1, 0]\nmaterial = "paint"\n'
    scene = box_scene(folder, POINT_LAMP + crate)
    solution = solve(scene, "rgb", 0.1)
    own = solution.transport.mesh.surface == scene.surface_names.index("crate")
    rows.append(case("object mesh without its lid", "exposed area", 2 * 4 * 0.8 * 0.6 + 0.8**2,
                     float(solution.transport.exchange.areas[own].sum()), 1e-6, "m²",
                     "both sides of its walls, one of its bottom"))
    return rows


def meshes_and_spectra(folder: Path) -> list[Case]:
    """One patch for each wall, very many patches, and spectra of one line."""
    case, rows = partial(Case, "Resolution and spectra"), []
    fine = _total(box_scene(folder, PANEL + FLOOR_METER), 0.002)
    one = box_scene(folder, PANEL + FLOOR_METER + "\n[solver]\npatch_size = 100.0\n")
    coarse = solve(one, "rgb").photometers()[0]
    rows.append(case("one patch a wall", "total", fine, coarse.total_lx, coarse.uncertainty, "lx",
                     "a fine mesh; the tolerance is the error bar"))
    many = solve(box_scene(folder, POINT_LAMP + CRATE + "\n[solver]\npatch_size = 0.0295\n"), "rgb", 0.05)
    area = many.transport.exchange.areas.sum()
    rows.append(
        case(
            f"{round(len(many.transport.mesh.patches), -3):,} patches",
            "mean total",
            10000 / area / 0.5,
            _mean(many),
            BALANCE_TOLERANCE * 10000 / area / 0.5,
            "lx",
            "Φ/(S(1 − ρ))",
        )
    )
    for nm in (555, 700):
        lines = "\n".join(f"{x},{1 if x == nm else 0}" for x in range(380, 781))
        (folder / "laser.csv").write_text("wavelength_nm,power\n" + lines + "\n")
        for bands in ("rgb", "31"):
            lamp = POINT_LAMP + 'spectrum = "laser.csv"\n'
            solution = solve(box_scene(folder, lamp), bands, 0.05)
            rows.append(case(f"a line of 1 nm at {nm} nm, {bands}", "mean total", 250.0, _mean(solution),
                             250 * BALANCE_TOLERANCE, "lx", "Φ/(S(1 − ρ)); a grey room, without colour"))
    noisy = "\n".join(f"{x},{0.5 - 0.503 * (x % 20 == 0)}" for x in range(380, 781, 5))
    (folder / "noisy.csv").write_text("wavelength_nm,reflectance\n" + noisy + "\n")
    scene = box_scene(
        folder, POINT_LAMP + '[materials.noisy]\nspectrum = "noisy.csv"\n', faces='floor = "noisy"'
    )
    noise = next(material.spectrum for material in scene.materials if material.name == "noisy")
    rows.append(case("a reflectance of −0.003 by noise", "least reflectance used", 0.0,
                     float(noise.values.min()), 0.0))
    (folder / "percent.csv").write_text("wavelength_nm,reflectance\n380,20\n780,30\n")
    rows.append(
        case(
            "a reflectance in per cent",
            "refused",
            "Divide percentages by 100",
            refusal(
                lambda: box_scene(
                    folder, POINT_LAMP + '[materials.p]\nspectrum = "percent.csv"\n', faces='floor = "p"'
                )
            ),
        )
    )
    return rows


def single_precision(folder: Path) -> list[Case]:
    """Changes of a reading by the single precision of rays, which round differently in scaled rooms."""
    rows, readings = [], []
    for k in (1.0, 1.1, 1.2, 1.3, 1.4, 1.5):
        crate = solid("box", np.multiply((0.5, 1, 0), k), np.multiply((1.2, 0.7, 1.5), k), rotation=20)
        scene = box_scene(folder, _scaled(k) + crate, np.multiply((4, 4, 3), k))
        transport = compute_transport(scene, 0.4 * k, 1024, 0)
        at = make_meter(transport, np.multiply((1.5, 2.2, 0), k), np.array(UP), "")
        light = solve_on(scene, band_set("rgb"), Plan(0.4 * k, 1024, ()), TransportStore(), transport)
        readings.append(light.read_lx(at).sum() * k**2)
    for k, reading in zip((1.1, 1.2, 1.3, 1.4, 1.5), readings[1:], strict=True):
        rows.append(Case("Single precision", f"the same rays, {k:g} times as large", "total × scale²",
                         readings[0], reading, 1e-4 * readings[0], "lx",
                         "equal random numbers; only the rounding of rays differs"))
    return rows
