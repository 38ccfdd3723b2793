"""A solution in a notebook, and as an xarray Dataset."""

import base64
import copy
import io
import re
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient
from PIL import Image
from shown import differences

import renderer

ROOT = Path(__file__).parent.parent
LAMP = {"shape": "point", "center": [1.5, 2.0, 1.2], "flux": 1000.0, "spectrum": "A"}
METER = {"name": "a < b & c", "position": [2.0, 1.0, 0.0]}
GREEN = {"munsell": "5G 5/8"}


class Shown(HTMLParser):
    """Pictures and cells of a page; every element must be closed in order."""

    def __init__(self, page: str):
        super().__init__()
        self.open, self.pictures, self.cells = [], [], []
        self.feed(page)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        if tag == "img":
            data = dict(attrs)["src"].removeprefix("data:image/png;base64,")
            self.pictures.append(Image.open(io.BytesIO(base64.b64decode(data))))
            return
        self.open.append(tag)
        self.cells += [""] * (tag == "td")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] == ["td"]:
            self.cells[-1] += data


def seen(scene, resolution=(64, 48)):
    """The scene, with a camera in a corner of the room."""
    from renderer.scene.meter_tables import CameraTable

    return replace(scene, camera=CameraTable(position=(0.3, 0.3, 1.5), look_at=(3.0, 3.0, 1.0),
                                             resolution=resolution))


@pytest.mark.parametrize("bands", ["31", "rgb", "rgb-prefiltered", "6"])
def test_a_notebook_shows_the_picture_and_the_readings(room, bands):
    scene = seen(room(GREEN, luminaires=[LAMP], photometers=[METER]), (800, 600))
    solution = renderer.solve(scene, bands, accuracy=0.05)
    shown = Shown(solution._repr_html_())
    assert [p.size for p in shown.pictures] == [(360, 270)]
    assert np.ptp(np.array(shown.pictures[0])) > 50  # there is something to see
    reading = solution.photometers()[0]
    assert shown.cells == [METER["name"], f"{reading.direct_lx:.2f}", f"{reading.indirect_lx:.2f}",
                           f"{reading.total_lx:.2f}", f"± {reading.uncertainty:.2g}"]
    assert f"{reading.total_lx:.2f} ±" in repr(reading)
    assert scene.title in repr(solution)
    assert len(repr(solution)) < 100  # and not its arrays


def test_missing_pictures_and_readings_state_the_reason(room):
    """A dark room; no camera, no photometer; a camera inside a solid; a meter that faces its surface."""
    dark = renderer.solve(seen(room(luminaires=[], photometers=[METER])), accuracy=0.1)._repr_html_()
    assert Shown(dark).cells[3] == "0.00"
    assert not np.array(Shown(dark).pictures[0]).any()
    bare = renderer.solve(room(), accuracy=0.1)._repr_html_()
    assert "[camera]" in bare
    assert "[[photometers]]" in bare
    crate = {"name": "<crate>", "shape": "box", "position": [0.1, 0.1, 1.0], "size": [1, 1, 1]}
    wrong = {**METER, "normal": [0, 0, -1]}
    blocked = Shown(renderer.solve(seen(room(objects=[crate], photometers=[wrong])), accuracy=0.1)
                    ._repr_html_())
    assert blocked.pictures == []
    assert "faces" in blocked.cells[1]


def test_as_a_dataset_absorbed_light_is_the_lamps_flux_in_every_band(room):
    """Energy: Σ A (1 − ρ) E over the patches is what the lamps emit, band by band; in lumens, 2000."""
    scene = room(GREEN, luminaires=[LAMP, {**LAMP, "center": [3.0, 3.0, 2.0], "spectrum": "FL2"}],
                 objects=[{"shape": "box", "position": [1, 1, 0], "size": [1, 1, 0.8]}])
    solution = renderer.solve(scene, "31", accuracy=0.05)
    data = solution.to_xarray()
    absorbed = ((1 - data.reflectance) * data.irradiance * data.area * data.band_width).sum("patch")
    per_watt = solution.bands.luminous / solution.bands.watts
    lamps = scene.flux(solution.bands).sum(axis=0)
    np.testing.assert_allclose(absorbed, lamps * solution.bands.watts, rtol=1e-8)
    lumens = (absorbed * per_watt).sum()
    assert float(lumens) == pytest.approx(2000.0, rel=1e-8)
    # What is reflected is ρE, and luminance is M/π of the luminous part of it.
    np.testing.assert_allclose(data.radiosity, data.reflectance * data.irradiance, rtol=1e-9, atol=1e-12)
    in_bands = (data.radiosity * data.band_width).values
    np.testing.assert_allclose(np.pi * data.luminance, in_bands @ per_watt, rtol=1e-12)


@pytest.mark.parametrize("bands", ["rgb", "6", "31"])
def test_a_closed_grey_room_has_the_mean_illuminance_of_a_sphere(room, bands):
    """Φ / A(1 − ρ), exactly, in any closed room of one grey: energy alone decides it (Sumpner 1892)."""
    data = renderer.solve(room(0.6, luminaires=[LAMP]), bands, accuracy=0.05).to_xarray()
    area = 2 * (4 * 4 + 4 * 3 + 4 * 3)
    assert float(data.area.sum()) == pytest.approx(area, rel=1e-9)
    mean = data.illuminance.weighted(data.area).mean()
    assert float(mean) == pytest.approx(1000 / (area * 0.4), rel=1e-8)


def test_a_datasets_patches_have_places_names_and_units(room):
    solution = renderer.solve(room(GREEN, luminaires=[LAMP]), "31", accuracy=0.02)
    data = solution.to_xarray()
    assert set(data.sizes) == {"patch", "wavelength"}
    assert data.wavelength.values.tolist() == list(range(400, 701, 10))
    assert all(variable.attrs["long_name"] for variable in data.variables.values())
    assert data.irradiance.attrs["units"] == "W m-2 nm-1"
    assert {name: data[name].attrs["units"] for name in ("illuminance", "luminance", "area", "x")} == {
        "illuminance": "lx", "luminance": "cd m-2", "area": "m2", "x": "m"}
    by_surface = data.illuminance.groupby("surface").mean()
    assert set(by_surface.surface.values) == set(solution.scene.surface_names)
    assert (data.z.where(data.surface == "floor", 0) == 0).all()
    assert (data.z.where(data.surface == "ceiling", 3) == 3).all()
    # A meter in the middle of a patch reads what the patch receives: the patch is small, so to 2 %.
    far = abs(data.x - 2) + abs(data.y - 2) + 9 * (data.surface != "floor")
    one = data.isel(patch=int(np.argmin(far.values)))
    reading = solution.photometer([float(one.x), float(one.y), 0.0], [0, 0, 1])
    assert float(one.illuminance) == pytest.approx(reading.total_lx, rel=0.02)


def test_bands_that_are_no_wavelengths_are_named(room):
    scene = room(GREEN, luminaires=[LAMP])
    rgb = renderer.solve(scene, "rgb", accuracy=0.1).to_xarray()
    assert rgb.band.values.tolist() == ["R", "G", "B"]
    assert rgb.irradiance.attrs["units"] == "lm m-2"
    nodes = renderer.solve(scene, "6", accuracy=0.1).to_xarray()
    assert nodes.node.shape == (6,)
    assert ((nodes.node > 400) & (nodes.node < 700)).all()


def test_without_xarray_one_sentence_names_the_package(room, monkeypatch):
    solution = renderer.solve(room(), accuracy=0.1)
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(ImportError, match=re.escape("pip install 'spectral-radiosity[notebook]'")):
        solution.to_xarray()


def test_the_tutorials_notebook_runs_from_chip_to_finding(tmp_path):
    """Ten cells, each of which runs; the last asserts the finding, far outside the error bars."""
    kept = nbformat.read(ROOT / "docs" / "tutorial.ipynb", as_version=4)
    assert sum(cell.cell_type == "code" for cell in kept.cells) == 10
    assert "assert apart > 20 * bar" in kept.cells[-1].source
    new = NotebookClient(copy.deepcopy(kept), timeout=120, kernel_name="python3",
                         resources={"metadata": {"path": str(tmp_path)}}).execute()
    for before, after in zip(kept.cells, new.cells, strict=True):
        assert not differences(printed(before), printed(after))


def printed(cell) -> str:
    """What a cell has printed."""
    return "".join(output.text for output in cell.get("outputs", [])
                   if output.output_type == "stream" and output.name == "stdout")
