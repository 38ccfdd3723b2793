"""Draw the picture of the report for the pages, in chromium with the pointer on `renderer report`'s page.

    .venv/bin/renderer report && .venv/bin/python docs/report_picture.py
"""

import base64
import io
import shutil
import time
from pathlib import Path

from PIL import Image
from selenium import webdriver
from selenium.webdriver import ActionChains

DOCS = Path(__file__).parent
WIDTH, HEIGHT = 1400, 900

options = webdriver.ChromeOptions()
options.binary_location = shutil.which("chromium")
for argument in ("--headless=new", "--no-sandbox", "--hide-scrollbars", "--use-angle=swiftshader",
                 "--enable-unsafe-swiftshader"):
    options.add_argument(argument)
browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))
browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                        {"width": WIDTH, "height": HEIGHT, "deviceScaleFactor": 1, "mobile": False})
browser.get((DOCS.parent / "outputs" / "report.html").resolve().as_uri())
while not browser.execute_script("return document.documentElement.dataset.ready"):
    time.sleep(0.1)
browser.find_elements("css selector", "#tiles button")[1].click()
frame = browser.find_element("css selector", "#a .frame")
ActionChains(browser, duration=0).move_to_element_with_offset(frame, -150, 190).perform()
shot = browser.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})["data"]
browser.quit()
picture = Image.open(io.BytesIO(base64.b64decode(shot))).convert("RGB")
picture.save(DOCS / "pictures" / "report.png", optimize=True)
