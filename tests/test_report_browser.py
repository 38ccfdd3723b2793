"""The report in a real browser, from disk, with the network off: every switch, hover and click."""

import base64
import csv
import io
import shutil
import time
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from renderer.cli.show import DEFAULT_ROOMS
from renderer.pictures.camera import look
from renderer.pictures.image import exposure, tone_map, white_balance
from renderer.scene.reading import load
from renderer.solving.transport_store import TransportStore
from renderer.studies.report import save_page, solve_rooms

BROWSER = shutil.which("chromium") or shutil.which("google-chrome") or shutil.which("chromium-browser")
DRIVER = shutil.which("chromedriver")
pytest.importorskip("selenium", reason="the report's browser test needs selenium (pip install '.[test]')")
pytestmark = pytest.mark.skipif(
    not (BROWSER and DRIVER), reason="the report's browser test needs chromium and chromedriver (Debian: "
    "apt-get install chromium chromium-driver)")
SWITCHES = (("light", "direct"), ("light", "total"), ("rightBands", "rgb"), ("mode", "pseudocolour"),
            ("rightBands", "31"), ("quantity", "illuminance"), ("rightBands", "difference"))
LEFT, RIGHT, DOWN, ENTER, TAB = "\ue012", "\ue014", "\ue015", "\ue007", "\ue004"


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The deck's three rooms, seen smaller: where their page is, and the rooms as they were solved."""
    scenes = [load(name) for name in DEFAULT_ROOMS]
    seen = scenes[0].camera.model_copy(update={"resolution": (320, 240)})
    rooms = solve_rooms(
        [replace(scene, camera=seen) for scene in scenes], None, None, TransportStore(), _quiet
    )
    folder = tmp_path_factory.mktemp("report")
    return save_page(rooms, "renderer report", folder, _quiet)[0], rooms


def _quiet(step):
    """Progress that nobody watches."""


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """Chromium without a window and without a network."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for argument in ("--headless=new", "--no-sandbox", "--window-size=1400,1000", "--use-angle=swiftshader",
                     "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    driver.saved = tmp_path_factory.mktemp("saved")
    driver.execute_cdp_cmd("Browser.setDownloadBehavior",
                           {"behavior": "allow", "downloadPath": str(driver.saved)})
    driver.execute_cdp_cmd("Network.enable", {})
    driver.execute_cdp_cmd("Network.emulateNetworkConditions",
                           {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0})
    yield driver
    driver.quit()


@pytest.fixture
def page(browser, report):
    """The report, opened anew; at the end nothing has been complained of or asked for."""
    opened(browser, report[0])
    yield browser
    assert [entry for entry in browser.get_log("browser") if entry["level"] != "INFO"] == []
    asked = browser.execute_script("return performance.getEntriesByType('resource').map(entry => entry.name)")
    assert [name for name in asked if not name.startswith(("blob:", "data:"))] == []


def opened(browser, path):
    browser.get(path.as_uri())
    waited(lambda: browser.execute_script("return document.documentElement.dataset.ready"))


def waited(found, seconds=30):
    """What `found` returns, as soon as it is something."""
    end = time.monotonic() + seconds
    while not (value := found()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)
    return value


def one(page, selector):
    return page.find_element("css selector", selector)


def choose(page, name, value):
    """Turn a switch, or choose from a list."""
    from selenium.webdriver.support.select import Select

    if name in ("left", "right", "leftBands", "rightBands"):
        Select(one(page, f"#{name}")).select_by_value(value)
    else:
        one(page, f"[name={name}][value='{value}']").click()


def beside(page, left=("0", "31"), right=("1", "31")):
    """Two rooms side by side, each (room, bands)."""
    choose(page, "layout", "beside")
    for side, (room, bands) in (("left", left), ("right", right)):
        choose(page, side, room)
        choose(page, f"{side}Bands", bands)


def pixels(page, pane):
    """The picture in a pane (height, width, 3)."""
    url = page.execute_script("return document.querySelector(arguments[0] + ' canvas').toDataURL()", pane)
    return np.array(Image.open(io.BytesIO(base64.b64decode(url.split(",")[1]))).convert("RGB"))


def pointer(page, pane, x, y, click=False):
    """Move the pointer to a pixel of a pane's picture, and click."""
    from selenium.webdriver import ActionChains

    frame = one(page, f"{pane} .frame")
    page.execute_script("arguments[0].scrollIntoView({block: 'center'})", frame)
    size = frame.size
    action = ActionChains(page, duration=0).move_to_element_with_offset(
        frame, round((x / 640 - 0.5) * size["width"]), round((y / 480 - 0.5) * size["height"]))
    (action.click() if click else action).perform()


def cells(page, rows):
    """The texts of the cells of a table's rows."""
    return [[cell.text for cell in row.find_elements("css selector", "th, td")]
            for row in page.find_elements("css selector", rows)]


def readout(page):
    """The cells of what is read under the pointer."""
    return cells(page, "#readout tbody tr")


def kept(page):
    """The rows of the CSV file that the page saves."""
    for old in page.saved.glob("*.csv"):
        old.unlink()
    one(page, "#csv").click()
    file = waited(lambda: next(page.saved.glob("*.csv"), None))
    with file.open(newline="", encoding="utf-8") as lines:
        return list(csv.DictReader(lines))


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


def test_projecting_hides_the_controls_until_escape(page):
    one(page, "#project").click()
    assert not one(page, "#controls").is_displayed()
    assert one(page, "#wipe input").is_displayed()
    one(page, "body").send_keys("\ue00c")
    assert one(page, "#controls").is_displayed()


def test_a_room_where_all_is_equal_shows_its_outlines_and_no_idle_scale(page):
    assert not one(page, "#scaling").is_displayed()  # a picture has no scale
    assert not one(page, "#a .legend").is_displayed()
    beside(page, ("0", "difference"), ("0", "31"))
    assert one(page, "#scaling").is_displayed()
    shown = pixels(page, "#a").astype(int)
    outlines = (np.abs(shown - 110).max(axis=-1) <= 1).mean()
    assert 0.002 < outlines < 0.1


def test_every_control_has_a_name(page):
    unnamed = page.execute_script("""
return [...document.querySelectorAll('button, input, select, [role=application]')].filter(each =>
  !(each.getAttribute('aria-label') || each.textContent.trim() || (each.labels && each.labels.length &&
    [...each.labels].some(label => label.textContent.trim())))).map(each => each.outerHTML)""")
    assert unnamed == []
    ids = page.execute_script("return [...document.querySelectorAll('[id]')].map(each => each.id)")
    assert len(ids) == len(set(ids))
    assert page.execute_script("return document.querySelectorAll('h1, main').length") == 2


STATES = {
    "as it opens": "",
    "unfolded": "document.querySelectorAll('details').forEach(each => { each.open = true; })",
    "in the other theme": "document.querySelector('#theme').click()",
    "in pseudocolour": "document.querySelector('[name=mode][value=pseudocolour]').click()",
    "projecting": "document.querySelector('#project').click()",
}


def test_axe_finds_nothing_serious(page):
    from axe_core_python.base import AXE_SCRIPT

    page.execute_script(AXE_SCRIPT)
    for state, act in STATES.items():
        page.execute_script(act)
        violations = page.execute_async_script(
            "axe.run(document, {resultTypes: ['violations']}).then(arguments[0])")["violations"]
        assert [(v["id"], v["nodes"][0]["html"]) for v in violations
                if v["impact"] in ("serious", "critical")] == [], state


def test_every_control_answers_to_the_keyboard(page):
    from selenium.webdriver import ActionChains

    def now(script):
        return page.execute_script(f"const at = document.activeElement; return {script}")

    wanted = set(page.execute_script("""
return [...document.querySelectorAll('button, input, select, summary, [tabindex]')]
  .filter(each => each.checkVisibility() && !each.disabled && (each.type !== 'radio' || each.checked))
  .map(each => (each.dataset.key = each.id || each.name || each.outerHTML.slice(0, 60)))"""))
    page.execute_script("document.activeElement.blur(); window.scrollTo(0, 0)")
    reached = set()
    for _ in range(3 * len(wanted)):
        ActionChains(page, duration=0).send_keys(TAB).perform()
        key = now("at.dataset.key")
        reached.add(key)
        if key == "layout":  # a row of radio buttons: arrow keys choose
            ActionChains(page, duration=0).send_keys(RIGHT).perform()
            assert now("at.checked && at.value") == "beside"
            ActionChains(page, duration=0).send_keys(LEFT).perform()
            assert now("at.checked && at.value") == "over"
        if reached >= wanted:
            break
    assert wanted - reached == set()
    tile = page.find_elements("css selector", "#tiles button")[0]
    tile.send_keys(ENTER)
    assert page.find_elements("css selector", "#tiles button")[0].get_attribute("aria-pressed") == "true"


def tap(page, element, across=0.5):
    """One finger, put down on an element and lifted; across : how far from its left end."""
    page.execute_script("arguments[0].scrollIntoView({block: 'center'})", element)
    x, y, wide, high = page.execute_script(
        "const b = arguments[0].getBoundingClientRect(); return [b.x, b.y, b.width, b.height]", element)
    finger = {"x": x + across * wide, "y": y + high / 2}
    for kind, points in (("touchStart", [finger]), ("touchEnd", [])):
        page.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


def test_every_control_answers_to_a_finger(page):
    for which in range(3):
        tap(page, page.find_elements("css selector", "#tiles button")[which])
        waited(lambda which=which: page.find_elements("css selector", "#tiles button")[which].get_attribute(
            "aria-pressed") == "true")
    slider = one(page, "#wipe input")
    tap(page, slider, across=0.25)
    waited(lambda: abs(float(slider.get_property("value")) - 25) <= 2)
    for switch in ("layout=beside", "light=direct", "light=total", "mode=pseudocolour",
                   "quantity=illuminance", "mode=picture"):
        button = one(page, "[name={}][value={}]".format(*switch.split("=")))
        tap(page, button)
        waited(lambda button=button: button.is_selected())
    theme = one(page, "body").value_of_css_property("background-color")
    tap(page, one(page, "#theme"))
    waited(lambda: one(page, "body").value_of_css_property("background-color") != theme)
    tap(page, one(page, "#a .frame"))
    waited(lambda: one(page, "#kept").is_displayed())
    tap(page, one(page, ".card button"))
    waited(lambda: not one(page, "#kept").is_displayed())
    tap(page, one(page, "#project"))
    waited(lambda: not one(page, "#controls").is_displayed())


def test_the_photometer_in_the_picture_reads_what_the_program_reads(page, report):
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


def test_hovering_shows_both_rooms_and_leaving_hides_them(page):
    beside(page)
    pointer(page, "#b", 320, 420)
    grey, grey_direct, _, red, red_direct, _ = readout(page)
    assert float(red[2].split()[0]) > float(grey[2].split()[0]) > 100
    assert grey_direct[2] == red_direct[2]  # direct light is the same
    assert grey[3] == "0 %"
    assert red[3].startswith("+")
    pointer(page, "#a", 320, 40)
    assert readout(page)[0][0].endswith("a luminaire, cd/m²")
    choose(page, "light", "direct")
    assert readout(page) == []


def test_nothing_below_moves_when_the_pointer_leaves_the_picture(page):
    beside(page)
    pointer(page, "#a", 320, 420, click=True)
    before = one(page, "#csv").rect
    pointer(page, "#a", 320, -40)
    assert readout(page) == []
    assert one(page, "#csv").rect == before


def test_keys_move_the_photometer_and_keep_a_reading(page):
    frame = one(page, "#a .frame")
    frame.send_keys(RIGHT + DOWN + DOWN + ENTER)
    (row,) = [row for row in kept(page) if row["room"] == "Red-paint room" and row["bands"] == "31"]
    assert row["surface"] == "wall_y1"  # from the picture's middle


def test_the_room_in_three_dimensions_turns_and_reads_patches(page):
    from selenium.webdriver import ActionChains

    def drawn():
        return page.execute_script("return document.querySelector('#view3d canvas').toDataURL()")

    beside(page, ("0", "31"), ("2", "rgb"))
    one(page, "#space summary").click()
    waited(lambda: page.find_elements("css selector", "#view3d canvas"))
    box = one(page, "#view3d")
    page.execute_script("arguments[0].scrollIntoView({block: 'center'})", box)
    waited(lambda: page.execute_script(
        "return document.querySelector('#view3d canvas').width > 300"))
    before = drawn()
    box.send_keys(LEFT)
    assert drawn() != before
    before = drawn()
    drag = ActionChains(page, duration=0).move_to_element_with_offset(box, -300, 0).click_and_hold()
    drag.move_by_offset(80, 20).release().perform()
    assert drawn() != before
    assert not page.find_elements("css selector", ".card")  # a drag is no click
    middle_of_a = -box.size["width"] // 4
    ActionChains(page, duration=0).move_to_element_with_offset(box, middle_of_a, 20).click().perform()
    assert "mean over a patch" in one(page, ".card").text
    before = drawn()
    choose(page, "mode", "pseudocolour")
    assert drawn() != before


def test_names_that_are_code_are_shown_as_text(browser, tmp_path, room_file):
    scene = room_file(0.5)
    path = tmp_path / "nasty.toml"
    path.write_text('title = "<script>alert(1)</script>=1+1"\n' + scene.path.read_text() + """
[[photometers]]
name = "</script><img src=x onerror=alert(2)>"
position = [2, 2, 0]
""")
    file, _ = save_page(
        solve_rooms([load(path)], 0.1, None, TransportStore(), _quiet), "renderer report", tmp_path, _quiet
    )
    opened(browser, file)
    assert browser.title == "<script>alert(1)</script>=1+1"
    assert browser.find_elements("css selector", "img") == []
    assert one(browser, "#finding p").text.startswith("RGB ")
    pointer(browser, "#a", 300, 300, click=True)
    assert kept(browser)[0]["room"] == "<script>alert(1)</script>=1+1"
    assert [entry for entry in browser.get_log("browser") if entry["level"] != "INFO"] == []
