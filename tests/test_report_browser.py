"""The report in a real browser, from disk, with the network off: every switch, hover and click."""


import numpy as np
import pytest
from report_page import (
    BROWSER,
    DRIVER,
    ENTER,
    LEFT,
    SWITCHES,
    beside,
    cells,
    choose,
    kept,
    one,
    opened,
    pixels,
    pointer,
    readout,
)

from renderer.pictures.camera import look
from renderer.pictures.image import exposure, tone_map, white_balance
from renderer.scene.reading import load
from renderer.solving.transport_store import TransportStore
from renderer.studies.report import save_page, solve_rooms

pytest.importorskip("selenium", reason="the report's browser test needs selenium (pip install '.[test]')")
pytestmark = pytest.mark.skipif(
    not (BROWSER and DRIVER), reason="the report's browser test needs chromium and chromedriver (Debian: "
    "apt-get install chromium chromium-driver)")


def test_a_picture_is_the_program_s_own(page, report):
    solutions = [room.solutions[bands] for room in report[1] for bands in ("rgb", "31")]
    view = look(solutions[0].transport, solutions[0].scene.camera, "test")
    direct = [view.direct(s, s.bands.xyz) for s in solutions]
    total = [d + view.indirect(s, s.bands.xyz) for d, s in zip(direct, solutions, strict=True)]
    first = solutions[0]
    balance = white_balance(first.flux.sum(axis=0) @ first.bands.xyz).T
    exposed = exposure([t @ balance for t in total], [view.shows_surface] * len(total))
    for light, wanted in (("total", total), ("direct", direct)):
        choose(page, "light", light)
        for bands, grey, red in (("rgb", 0, 2), ("31", 1, 3)):
            beside(page, ("0", bands), ("1", bands))
            for pane, k in (("#a", grey), ("#b", red)):
                expected = tone_map(wanted[k] @ balance, exposed).astype(int)
                # Both round to 256 steps; the file's own error of 3e-4 moves hardly any across a half.
                assert np.abs(pixels(page, pane).astype(int) - expected).max() <= 1


def test_every_switch_changes_the_pictures(page):
    from selenium.webdriver.support.select import Select

    beside(page)
    before = pixels(page, "#b")
    for name, value in SWITCHES:
        choose(page, name, value)
        after = pixels(page, "#b")
        assert (before != after).any(), (name, value)
        before = after
    choose(page, "rightBands", "31")
    for selector, values in (("#scale", ("log", "stepped", "linear")),
                             ("#palette", ("cividis", "magma", "rainbow"))):
        for value in values:
            Select(one(page, selector)).select_by_visible_text(value)
            after = pixels(page, "#b")
            assert (before != after).any(), value
            before = after
    for act in (lambda: (one(page, "#top").clear(), one(page, "#top").send_keys("7" + ENTER)),
                lambda: one(page, "#fit").click(),
                lambda: choose(page, "right", "2")):
        act()
        after = pixels(page, "#b")
        assert (before != after).any()
        before = after
    choose(page, "layout", "over")
    assert one(page, "#a").location == one(page, "#b").location
    one(page, "#wipe input").send_keys(LEFT)
    assert "49%" in one(page, "#stage").get_attribute("style")
    theme = one(page, "body").value_of_css_property("background-color")
    one(page, "#theme").click()
    assert one(page, "body").value_of_css_property("background-color") != theme


def test_the_answer_stands_first_and_is_the_command_s(page, report):
    said = one(page, "#finding").text
    assert said.endswith("RGB makes the red-paint room 5.2 % too bright, the pure-red room 32 % too bright; "
                         "the grey room is right.")
    tiles = page.find_elements("css selector", "#tiles button")
    assert [tile.text.split("\n") for tile in tiles] == [
        ["Grey room", "right"], ["Red-paint room", "+5.2 %"], ["Pure-red room", "+32 %"]]
    assert [tile.get_attribute("aria-pressed") for tile in tiles] == ["false", "false", "true"]  # the worst
    tiles[1].click()
    (row,) = cells(page, "#meters tbody tr")
    room = report[1][1]
    spectral, rgb = (room.readings[bands][0].total_lx for bands in ("31", "rgb"))
    assert float(row[1]) == pytest.approx(rgb, rel=1e-3)
    assert float(row[2].split()[0]) == pytest.approx(spectral, rel=1e-3)
    assert row[3] == "+5.2 %"


@pytest.mark.parametrize(("width", "height"), [(1400, 900), (1920, 1080)])
def test_readings_and_slider_are_above_the_fold(page, width, height):
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
        "width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
    for selector in ("#meters", "#readout", "#wipe", "#a .frame"):
        box = one(page, selector).rect
        assert box["y"] + box["height"] <= height, selector
    assert one(page, "#a .frame").rect["width"] > 0.45 * width
    page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_a_narrow_screen_scrolls_one_way_only(page):
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
        "width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True})
    assert page.execute_script("return document.documentElement.scrollWidth") <= 390
    page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_a_room_where_all_is_equal_shows_its_outlines_and_no_idle_scale(page):
    assert not one(page, "#scaling").is_displayed()  # a picture has no scale
    assert not one(page, "#a .legend").is_displayed()
    beside(page, ("0", "difference"), ("0", "31"))
    assert one(page, "#scaling").is_displayed()
    shown = pixels(page, "#a").astype(int)
    outlines = (np.abs(shown - 110).max(axis=-1) <= 1).mean()
    assert 0.002 < outlines < 0.1


def test_the_photometer_in_the_picture_agrees_with_the_program(page, report):
    beside(page)
    spots = ((150, 400), (320, 460), (500, 200), (60, 300))
    for x, y in spots:
        pointer(page, "#a", x, y, click=True)
    assert [row[0] for row in readout(page)][::3] == ["Grey room: illuminance lx",
                                                      "Red-paint room: illuminance lx"]
    rows = kept(page)
    assert len(rows) == len(spots) * 3 * 2
    for row in rows:
        room = next(room for room in report[1] if room.title == row["room"])
        solution = room.solutions[row["bands"].lower()]
        at, facing = ([float(row[name.format(axis)]) for axis in "xyz"] for name in ("{}_m", "normal_{}"))
        reading = solution.photometer(at, facing)
        bar = float(row["half_width_95_lx"])
        # Direct light is exact in both, to the file's 0.03 %; the rest to both error bars.
        assert float(row["direct_lx"]) == pytest.approx(reading.direct_lx, rel=4e-4)
        assert float(row["total_lx"]) == pytest.approx(reading.total_lx, abs=bar + reading.uncertainty)
        assert bar < 0.03 * reading.total_lx
        if row["bands"] == "31":
            spectrum = [float(value) for name, value in row.items() if name.startswith("irradiance_")]
            illuminance = np.array(spectrum) * solution.bands.widths @ solution.bands.luminous
            assert illuminance == pytest.approx(float(row["total_lx"]), rel=1e-6)
    cards = page.find_elements("css selector", ".card")
    assert len(cards) == len(spots)
    assert len(cards[0].find_elements("css selector", "svg polyline")) == 4  # three rooms and their one lamp
    cards[1].find_element("css selector", "button").click()
    assert [card.text[0] for card in page.find_elements("css selector", ".card")] == ["1", "3", "4"]
    one(page, "#clear").click()
    assert not one(page, "#kept").is_displayed()


def test_names_that_are_code_are_shown_as_text(browser, tmp_path, room_file):
    scene = room_file(0.5)
    path = tmp_path / "nasty.toml"
    path.write_text('title = "<script>alert(1)</script>=1+1"\n' + scene.path.read_text() + """
[[photometers]]
name = "</script><img src=x onerror=alert(2)>"
position = [2, 2, 0]
""")
    file, _ = save_page(
        solve_rooms([load(path)], 0.1, None, TransportStore(), lambda step: None), "renderer report",
        tmp_path, lambda step: None)
    opened(browser, file)
    assert browser.title == "<script>alert(1)</script>=1+1"
    assert browser.find_elements("css selector", "img") == []
    assert one(browser, "#finding p").text.startswith("RGB ")
    pointer(browser, "#a", 300, 300, click=True)
    assert kept(browser)[0]["room"] == "<script>alert(1)</script>=1+1"
    assert [entry for entry in browser.get_log("browser") if entry["level"] != "INFO"] == []
