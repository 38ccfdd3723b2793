"""The report: accuracy of its numbers, coverage of its bars, and escaped text without network access."""

import base64
import hashlib
import json
import re
import zlib
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from conftest import PANEL, ROOT

import renderer
from renderer.pictures.camera import look
from renderer.pictures.report.bars import patch_bars, shadow_bars
from renderer.pictures.report.data import lamps_of
from renderer.pictures.report.files import scene_files
from renderer.pictures.report.pack import CURVE_ERROR, LOGARITHM_ERROR, LOGARITHM_SPAN, Pack
from renderer.pictures.report.viewpoint import looks
from renderer.readings.photometer import make_meter
from renderer.scene.meter_tables import CameraTable
from renderer.scene.reading import load
from renderer.solving.transport_store import TransportStore
from renderer.studies.report import MAX_PAGE_BYTES, save_page, solve_rooms
from renderer.transport.direct.direct import SHADOW_RAYS
from renderer.transport.sensors import direct_on, seen_from

CAMERA = CameraTable(position=(2.0, 0.0, 1.5), look_at=(2.0, 4.0, 1.4), fov=100, resolution=(64, 48))
NASTY = """title = '<script>alert(1)</script> "O''Neil" & </script><!--'
[room]
size = [3.0, 4.0, 2.5]
floor = "<b>oak</b>"
walls = "plain"
ceiling = "plain"
[materials."<b>oak</b>"]
reflectance = 0.3
[materials.plain]
reflectance = 0.6
[[luminaires]]
shape = "point"
center = [1.5, 2.0, 2.0]
flux = 1000
[[photometers]]
name = '''"quoted" <i>meter</i>'''
position = [1.5, 2.0, 0.0]
""".replace("O''Neil", "O’Neil")


def quiet(step):
    """Progress without output."""


def written(scenes, out):
    """The page made of scenes, as text, and what was said about it."""
    rooms = solve_rooms(scenes, 0.05, None, TransportStore(), quiet)
    path, notes = save_page(rooms, "renderer report", out, quiet)
    return path.read_text(encoding="utf-8"), notes


def decoded(pack: Pack, how: dict) -> np.ndarray:
    """Whole numbers back from a pack."""
    data = zlib.decompress(base64.b64decode(pack.base64()))
    kind = np.dtype("<" + how["kind"])
    size = kind.itemsize * how["n"]
    planes = np.frombuffer(data, np.uint8, size, how["at"]).reshape(kind.itemsize, -1)
    return np.cumsum(np.ascontiguousarray(planes.T).view(kind).ravel(), dtype=kind)


def test_whole_numbers_are_exact_and_logarithms_within_their_step():
    pack, rng = Pack(), np.random.default_rng(1)
    small, large = rng.integers(0, 60_000, 1000), rng.integers(0, 2**32, 1000)
    values = np.concatenate([[0.0], np.exp(rng.uniform(np.log(7e-9), np.log(5.0), 5000)), [5.0]])
    ways = pack.whole(small), pack.whole(large), pack.logarithms(values)
    np.testing.assert_array_equal(decoded(pack, ways[0]), small)
    np.testing.assert_array_equal(decoded(pack, ways[1]), large)
    code = decoded(pack, ways[2]).astype(float)
    back = np.where(
        code > 0, LOGARITHM_SPAN * 5.0 * np.exp((code - 1) * -np.log(LOGARITHM_SPAN) / 65534), 0.0
    )
    assert back[0] == 0.0
    assert np.abs(back[1:] / values[1:] - 1).max() <= LOGARITHM_ERROR * 1.001
    assert LOGARITHM_ERROR + CURVE_ERROR < 1e-3  # what the issue allows


def test_a_few_curves_stand_for_every_spectrum():
    nm, amount = np.linspace(0, 1, 31), np.random.default_rng(2).uniform(1e-6, 10, (400, 1))
    rows = amount * np.exp(-np.random.default_rng(3).uniform(0, 3, (400, 1)) * nm)
    pack = Pack()
    how = pack.curves(rows)
    parts = np.array([low + step * decoded(pack, part) for part, low, step
                      in zip(how["parts"], how["low"], how["step"], strict=True)])
    back = rows.max(axis=1, keepdims=True) * (parts.T @ np.array(how["curves"]))
    assert len(parts) < 8
    assert (np.abs(back - rows).max(axis=1) <= CURVE_ERROR * rows.max(axis=1)).all()


def test_lamps_of_one_spectrum_are_one_column(room):
    warm = {**PANEL, "cct": 3000.0, "center": [1.0, 1.0, 3.0]}
    scene = room(0.5, luminaires=[PANEL, {**PANEL, "center": [3, 3, 3], "luminance": 300.0}, warm])
    solutions = [renderer.solve(scene, bands=bands, accuracy=0.1) for bands in ("rgb", "31")]
    lamps = lamps_of(solutions)
    assert len(lamps.first) == 2
    light = solutions[0].transport.direct
    for solution in solutions:
        np.testing.assert_allclose(lamps.joined(light) @ lamps.flux(solution), light @ solution.flux,
                                   rtol=1e-9)


def test_bars_of_spots_hold_and_are_not_idle(room):
    scene = room(0.6, luminaires=[{**PANEL, "center": [1.2, 2.6, 3.0]}])
    solution, finer = (renderer.solve(scene, bands="rgb", accuracy=a) for a in (0.05, 0.01))
    mesh_bar, sampling = patch_bars(solution)
    view, mesh = look(solution.transport, CAMERA, "test"), solution.transport.mesh
    pixel = np.random.default_rng(4).choice(view.patch.size, 60, replace=False)
    patch, s, t = seen_from(solution.transport, view.eye, view.directions(pixel))
    shown = solution.transport.reflecting[patch]
    patch, s, t = patch[shown], s[shown], t[shown]
    on_vertices = solution.vertex_irradiance @ solution.bands.luminous
    here = (mesh.weights(patch, s, t) * on_vertices[mesh.patches[patch]]).sum(axis=1)
    truth = [finer.read_lx(make_meter(finer.transport, p, n, "test"))[1:].sum()
             for p, n in zip(mesh.at(patch, s, t), mesh.normal[patch], strict=True)]
    error = np.abs(here - truth)
    # A 95 % bar is larger than the error at nearly all of about 58 places, and at most about ten times it.
    assert (error <= mesh_bar[patch]).mean() >= 0.9
    assert np.median(mesh_bar[patch] / error) < 12
    assert not sampling.any()  # an empty convex room casts no ray


def test_bars_of_penumbras_hold(room):
    crate = {"shape": "box", "position": [1.6, 2.2, 0.6], "size": [0.8, 0.8, 0.1]}
    solution = renderer.solve(room(0.5, objects=[crate]), bands="rgb", accuracy=0.1)
    view = look(solution.transport, CAMERA, "test")
    half = shadow_bars(view).toarray()[:, 0]
    pixel = np.flatnonzero(half)
    assert len(pixel) > 50
    patch, s, t = seen_from(solution.transport, view.eye, view.directions(pixel))
    truth = direct_on(solution.transport, patch, s, t, 9, 16 * SHADOW_RAYS)[0, :, 0]
    error = np.abs(view.light[pixel, 0] - truth)
    assert (error <= half[pixel]).mean() > 0.9
    assert np.median(half[pixel] / error) < 12


def test_bars_stand_where_only_the_other_mesh_has_replicas(room):
    crate = {"shape": "box", "position": [1.6, 2.2, 0.0], "size": [0.8, 0.8, 0.8]}
    solution = renderer.solve(room(0.5, objects=[crate]), bands="rgb", accuracy=0.1)
    own = patch_bars(solution)[1]
    mesh_sequence = solution.mesh_sequence
    solution.__dict__["mesh_sequence"] = replace(mesh_sequence, replicas=mesh_sequence.meshes[1].by_replica())
    theirs = patch_bars(solution)[1]
    assert np.isfinite(theirs).all()
    # As many rays a patch on patches twice as long: spread of the same order, not the same numbers.
    assert 0.3 < np.median(theirs) / np.median(own) < 3


class Tags(HTMLParser):
    """The elements of a page, and its scripts' texts."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.tags, self.scripts, self._in = [], [], None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        self._in = tag if tag == "script" else None
        if self._in:
            self.scripts.append("")

    def handle_data(self, text):
        if self._in:
            self.scripts[-1] += text

    def handle_endtag(self, tag):
        self._in = None


@pytest.fixture(scope="module")
def nasty(tmp_path_factory):
    """A page of a scene whose names are code."""
    folder = tmp_path_factory.mktemp("nasty")
    (folder / "nasty.toml").write_text(NASTY)
    return written([load(folder / "nasty.toml")], folder)


def test_names_are_text_and_nothing_is_loaded(nasty):
    text, notes = nasty
    page = Tags(text)
    assert not {tag for tag, _ in page.tags} & {"i", "img", "iframe", "link", "object"}
    assert [tag for tag, _ in page.tags].count("b") == 4  # two legends', a tile's and the plan's own
    assert len(page.scripts) == 4
    assert not [a for tag, a in page.tags if tag != "a" and {"src", "href", "srcset", "action"} & set(a)]
    policy = next(a["content"] for tag, a in page.tags if a.get("http-equiv"))
    allowed = re.findall(r"'sha256-([^']+)'", policy)
    for script, code in zip(page.scripts[2:], allowed, strict=True):
        assert base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() == code
    data = json.loads(page.scripts[0])
    assert data["rooms"][0]["title"].startswith("<script>alert(1)</script>")
    assert len(notes) == 1
    assert "has no camera; seen from" in notes[0]


def test_a_page_is_made_of_a_room_without_light_camera_or_meter(room, tmp_path):
    text, notes = written([room(0.5, luminaires=())], tmp_path)
    assert "have no photometers" in text
    assert "NaN" not in Tags(text).scripts[0]
    assert len(notes) == 1


def test_a_page_of_a_millimetre_and_of_rooms_of_two_shapes(room, tmp_path):
    lamp = {**PANEL, "center": [5e-4, 5e-4, 1e-3], "size": [3e-4, 3e-4]}
    scenes = [room(0.5, size=(1e-3, 1e-3, 1e-3), luminaires=[lamp]), room(0.2), room(0.7), room(0.7)]
    data = json.loads(Tags(written(scenes, tmp_path)[0]).scripts[0])
    assert [r["geometry"] for r in data["rooms"]] == [0, 1, 1, 1]
    assert len(data["views"]) == 2


def test_a_camera_of_many_pixels_is_shown_smaller(room):
    scene = replace(room(0.5), camera=CAMERA.model_copy(update={"resolution": (8192, 4096)}))
    transport = renderer.solve(scene, bands="rgb", accuracy=0.1).transport
    (view,), notes = looks([(scene, transport)], 5000)
    assert view.patch.shape == (50, 100)
    assert "8192 × 4096 pixels are shown as 100 × 50" in notes[0]


def test_a_page_that_stays_large_is_reported(room, tmp_path, monkeypatch):
    monkeypatch.setattr("renderer.studies.report.MAX_PAGE_BYTES", 1000)
    scene = replace(room(0.5), camera=CAMERA)
    _, notes = written([scene], tmp_path)
    assert len(notes) == 1
    assert "a looser --accuracy makes it smaller" in notes[0]


def test_scene_files_are_embedded_with_the_files_that_they_name():
    files = scene_files(load(ROOT / "scenes" / "red_room.toml"))
    assert [f["name"] for f in files] == ["red_room.toml", "spectra/red_20_percent.csv"]
    for file in files:
        data = (ROOT / "scenes" / file["name"]).read_bytes()
        assert file["text"].encode() == data
        assert file["sha256"] == hashlib.sha256(data).hexdigest()


def test_bands_are_refused(here, tmp_path):
    said = here("report", "grey_room", "--bands", "rgb", cwd=tmp_path)
    assert said.returncode == 2
    assert "--bands has no place in report" in said.stderr


@pytest.mark.slow
def test_the_deck_makes_a_file_that_a_mail_can_carry(run, tmp_path):
    said = run("report", cwd=tmp_path)
    assert said.returncode == 0, said.stderr
    assert "opens in any browser" in said.stdout
    assert (tmp_path / "outputs" / "report.html").stat().st_size <= MAX_PAGE_BYTES
