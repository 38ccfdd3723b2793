"""`renderer compare`, run as a user runs it, and its results."""

import csv
import json

import numpy as np
import pytest
from PIL import Image

import renderer
from renderer.pictures.answer_sheet import difference_limit
from renderer.pictures.pseudocolour import difference_colours
from renderer.studies.comparison_pictures import differences


@pytest.fixture(scope="module")
def rows(compared):
    folder, done = compared
    assert done.returncode == 0, done.stderr
    with (folder / "outputs" / "comparison.csv").open() as file:
        table = list(csv.DictReader(file))
    return {(r["room"], r["bands"]): r for r in table}


def test_the_table_has_the_stated_columns_and_rows(rows, compared):
    assert set(rows) == {(room, bands) for room in ("Grey room", "Red-paint room", "Pure-red room")
                         for bands in ("rgb", "31")}
    assert list(next(iter(rows.values()))) == [
        "room", "bands", "photometer", "direct_lx", "indirect_lx", "total_lx", "uncertainty_lx",
        "ratio_to_first_room", "rgb_error_percent"]
    folder, done = compared
    record = json.loads((folder / "outputs" / "comparison.json").read_text())
    assert len(record["table"]) == len(record["rooms"]) == 6
    for (room, _), row in rows.items():
        assert room in done.stdout
        assert f"{float(row['ratio_to_first_room']):.3f}" in done.stdout


def test_the_errors_of_rgb_are_stated(rows, compared):
    folder, done = compared
    assert done.stdout.rstrip().splitlines()[-1] == (
        "RGB makes the red-paint room 5.2 % too bright, the pure-red room 32 % too bright; "
        "the grey room is right.")
    record = json.loads((folder / "outputs" / "comparison.json").read_text())
    assert [sentence.split(",")[0] for sentence in record["finding"]] == [
        "RGB is right in the grey room.", "RGB makes the red-paint room 5.2 % too bright at floor centre",
        "RGB makes the pure-red room 32 % too bright at floor centre"]
    for room in {room for room, _ in rows}:
        rgb, spectral = (float(rows[room, bands]["total_lx"]) for bands in ("rgb", "31"))
        error = float(rows[room, "rgb"]["rgb_error_percent"])
        assert error == pytest.approx(100 * (rgb / spectral - 1), abs=1e-9)
        assert float(rows[room, "31"]["rgb_error_percent"]) == 0.0
        assert 0 < float(rows[room, "rgb"]["uncertainty_lx"]) < 0.01 * rgb


def test_direct_light_is_the_same_in_all_rooms_and_band_sets(rows):
    direct = [float(r["direct_lx"]) for r in rows.values()]
    np.testing.assert_allclose(direct, direct[0], rtol=1e-6)


@pytest.mark.parametrize(("room", "bands", "ratio", "tolerance"), [
    ("Grey room", "31", 1.0, 1e-12),
    ("Pure-red room", "rgb", 1.67, 0.02),  # the deck's "2/3 brighter"
    ("Red-paint room", "31", 1.046, 0.01),
    ("Red-paint room", "rgb", 1.10, 0.01),
])
def test_the_ratios_to_the_grey_room(rows, room, bands, ratio, tolerance):
    assert float(rows[room, bands]["ratio_to_first_room"]) == pytest.approx(ratio, abs=tolerance)


def test_the_grey_room_is_the_same_in_every_band_set(rows):
    grey = [float(rows["Grey room", bands]["total_lx"]) for bands in ("rgb", "31")]
    assert grey == pytest.approx([grey[0]] * 2, rel=1e-6)


def test_total_is_direct_and_indirect(rows):
    for r in rows.values():
        assert float(r["total_lx"]) == pytest.approx(float(r["direct_lx"]) + float(r["indirect_lx"]))


def test_every_picture_is_there_and_whole(compared):
    out = compared[0] / "outputs"
    for stem in ("grey_room", "red_room", "saturated_red_room"):
        for bands in ("rgb", "31"):
            for name in ("a_reflectance", "b_direct", "c_direct_pseudocolour", "d_total",
                         "e_total_pseudocolour"):
                with Image.open(out / "comparison" / f"{stem}_{bands}_{name}.png") as picture:
                    picture.load()
                    assert picture.height == 480
        for suffix in ("31.vtp", "31_luminance.exr", "31_spectral.exr"):
            assert (out / "comparison" / f"{stem}_{suffix}").stat().st_size > 1000
    for name in ("comparison.png", "deck.png", "comparison_3d.png"):
        with Image.open(out / name) as picture:
            assert picture.width > 1200
    assert not list(out.rglob("*.part*"))


def test_the_sheet_and_the_deck_are_as_wide_as_a_projector(compared):
    for name in ("comparison.png", "deck.png"):
        with Image.open(compared[0] / "outputs" / name) as picture:
            assert picture.width == 1920
    assert not (compared[0] / "outputs" / "comparison_full.png").exists()  # with --full


def test_differences_are_signed_and_dark_places_have_none():
    percent = differences(np.array([[110.0, 80.0, 100.0, 0.0]]), np.array([[100.0, 100.0, 100.0, 0.0]]))
    np.testing.assert_allclose(percent, [[10.0, -20.0, 0.0, np.nan]])
    assert difference_limit([percent]) == 20.0
    assert difference_limit([np.full((2, 2), np.nan)]) == 1.0  # the scale of rooms that are alike
    bright, dark, alike, none = difference_colours(percent, 20.0)[0].astype(int)
    assert bright[0] > bright[2] + 30  # orange
    assert dark[2] > dark[1] + 30  # purple
    assert alike.min() > 240
    assert none.max() == 0


def test_the_monochrome_pictures_of_the_rooms_are_equal(compared):
    folder = compared[0] / "outputs" / "comparison"
    grey, red = (np.asarray(Image.open(folder / f"{stem}_31_a_reflectance.png"), dtype=int)
                 for stem in ("grey_room", "red_room"))
    assert np.abs(grey - red).max() <= 1  # 0.200 and 0.2007 in 31 bands; one step of 255


def test_the_spectral_exr_is_the_published_layout_and_integrates_to_the_luminance(compared):
    import OpenEXR

    folder = compared[0] / "outputs" / "comparison"
    with OpenEXR.File(str(folder / "red_room_31_spectral.exr"), separate_channels=True) as file:
        header, channels = file.header(), file.channels()
        names = [f"S0.{nm:d},000000nm" for nm in range(400, 701, 10)]
        assert header["spectralLayoutVersion"] == "1.0"
        assert header["emissiveUnits"] == "W.m^-2.sr^-1"
        spectral = np.stack([channels[name].pixels for name in names], axis=-1)
    with OpenEXR.File(str(folder / "red_room_31_luminance.exr"), separate_channels=True) as file:
        luminance = file.channels()["Y"].pixels
    assert spectral.dtype == np.float32
    bands = renderer.load("red_room").band_set("31")
    # Two float32 roundings of 31 terms; a lamp's lumens per watt within a band are its own.
    np.testing.assert_allclose(spectral @ (bands.luminous * bands.widths / bands.watts), luminance, rtol=1e-5,
                               atol=1e-6)


def test_the_patches_can_be_read_back(compared):
    import pyvista

    data = pyvista.read(compared[0] / "outputs" / "comparison" / "grey_room_31.vtp")
    lux, direct = data.cell_data["illuminance_lx"], data.cell_data["direct_illuminance_lx"]
    assert (lux >= direct - 1e-9).all()
    areas = data.compute_cell_sizes(length=False, volume=False).cell_data["Area"]
    assert areas.sum() == pytest.approx(2 * 5.4 * 5.4 + 4 * 5.4 * 3, rel=1e-6)
    assert areas @ direct == pytest.approx(4000, rel=1e-6)
