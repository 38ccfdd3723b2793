"""A new kind of luminaire needs only its class."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from photometric import ies

import renderer
from renderer.scene.luminaires.luminaire import PointLuminaire
from renderer.scene.luminaires.opening import OpeningLuminaire

DEGREE = np.arange(0, 181, 5.0)
CANDELA = 100 * np.clip(np.cos(np.radians(DEGREE)), 0, None) ** 2 + 20.0
"""A beam downward over light all round; linear between its entries, as a photometric file is read."""


def table_flux() -> float:
    """Flux [lm] of the table: ∫ 2π I sin γ dγ with I linear between entries, by parts."""
    gamma = np.radians(DEGREE)
    a, b, rise = gamma[:-1], gamma[1:], np.diff(CANDELA)
    each = (CANDELA[:-1] * np.cos(a) - CANDELA[1:] * np.cos(b) + rise / (b - a) * (np.sin(b) - np.sin(a)))
    return float(2 * np.pi * each.sum())


class ByTable:
    """Intensities of a table, about the normal."""

    def intensity(self, away):
        gamma = np.degrees(np.arccos(np.clip(away @ self.normal, -1, 1)))
        return np.interp(gamma, DEGREE, CANDELA) / table_flux()


class TablePoint(ByTable, PointLuminaire):
    """A point that shines by a table of directions."""


@dataclass(frozen=True)
class TableOpening(ByTable, OpeningLuminaire):
    """A panel that does."""

    axes: np.ndarray = field(kw_only=True)


def pair(room_file, tmp_path, size, make, **more):
    """A scene lit by a file of the table, and one lit by what `make` makes of that luminaire."""
    (tmp_path / "lamp.ies").write_text(ies(CANDELA, DEGREE, size=size))
    table = {"shape": "ies", "file": "lamp.ies", "center": [1.5, 2.0, 2.0], "flux": 1000.0}
    scene = room_file(luminaires=[table], **more)
    return scene, replace(scene, luminaires=[make(scene.luminaires[0])])


def test_a_point_that_shines_by_a_table_lights_a_black_room_by_the_inverse_square_law(room_file, tmp_path):
    _, scene = pair(room_file, tmp_path, (0, 0, 0),
                    lambda lum: TablePoint("new", lum.center, lum.normal, 1000.0), rho=0.0)
    down = np.array([0.5, -1.0, -2.0])
    distance = np.linalg.norm(down)
    candela = np.interp(np.degrees(np.arccos(2 / distance)), DEGREE, CANDELA) * 1000 / table_flux()
    reading = renderer.solve(scene, "rgb", 0.3).photometer([2.0, 1.0, 0.0], [0, 0, 1])
    # The meter stands 2e-9 of the room's size off the floor.
    assert reading.total_lx == pytest.approx(candela * 2 / distance**3, rel=2e-8)


BOX = {"shape": "box", "position": [2.2, 1.6, 0.6], "size": [0.8, 0.8, 0.3]}


@pytest.mark.parametrize("objects", [[], [BOX]])
@pytest.mark.parametrize(
    ("size", "make"),
    [
        ((0, 0, 0), lambda lum: TablePoint("new", lum.center, lum.normal, lum.lumens)),
        ((0.3, 0.6, 0), lambda lum: TableOpening("new", lum.center, lum.normal, lum.lumens, lum.body,
                                                 lum.opening, axes=lum.axes)),
    ],
)
def test_a_new_emitter_reads_as_the_file_of_its_table_does(room_file, tmp_path, size, make, objects):
    """Direct and indirect, beside a box and without one; steps of 5° ask for pieces no shorter than
    the file's, whose seams are below 1e-3."""
    readings = [renderer.solve(scene, "rgb", 0.3).photometer([2.05, 2.0, 0.0], [0, 0, 1])
                for scene in pair(room_file, tmp_path, size, make, rho=0.5, objects=objects)]
    for part in ("direct_lx", "indirect_lx"):
        measured, new = (getattr(reading, part) for reading in readings)
        assert measured > 0
        assert new == pytest.approx(measured, rel=1e-3)
