"""A report's page in a browser."""

import base64
import csv
import io
import shutil
import time

import numpy as np
from PIL import Image

BROWSER = shutil.which("chromium") or shutil.which("google-chrome") or shutil.which("chromium-browser")
DRIVER = shutil.which("chromedriver")
SWITCHES = (("light", "direct"), ("light", "total"), ("rightBands", "rgb"), ("mode", "pseudocolour"),
            ("rightBands", "31"), ("quantity", "illuminance"), ("rightBands", "difference"))
LEFT, RIGHT, DOWN, ENTER, TAB = "\ue012", "\ue014", "\ue015", "\ue007", "\ue004"


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
    # The browser reserves the name with an empty file before it writes.
    file = waited(lambda: next((each for each in page.saved.glob("*.csv") if each.stat().st_size), None))
    with file.open(newline="", encoding="utf-8") as lines:
        return list(csv.DictReader(lines))
