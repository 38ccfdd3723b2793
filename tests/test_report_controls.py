"""The controls of a report in a real browser: names, keyboard, finger, pointer and the room in 3-D."""

import pytest
from report_page import (
    BROWSER,
    DOWN,
    DRIVER,
    ENTER,
    LEFT,
    RIGHT,
    TAB,
    beside,
    choose,
    kept,
    one,
    pointer,
    readout,
    waited,
)

pytest.importorskip("selenium", reason="the report's browser test needs selenium (pip install '.[test]')")
pytestmark = pytest.mark.skipif(
    not (BROWSER and DRIVER), reason="the report's browser test needs chromium and chromedriver (Debian: "
    "apt-get install chromium chromium-driver)")


def test_projecting_hides_the_controls_until_escape(page):
    one(page, "#project").click()
    assert not one(page, "#controls").is_displayed()
    assert one(page, "#wipe input").is_displayed()
    one(page, "body").send_keys("\ue00c")
    assert one(page, "#controls").is_displayed()


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
