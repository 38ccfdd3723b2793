"""Draw the picture of the window for the pages: `renderer view` from outside with one click, under Xvfb.

    .venv/bin/python docs/window_picture.py
"""

import os
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

from renderer.scene.reading import load
from renderer.solving.transport_store import TransportStore
from renderer.studies.view import make_window

DOCS = Path(__file__).parent

reading, writing = os.pipe()
server = subprocess.Popen(["Xvfb", "-displayfd", str(writing), "-screen", "0", "1400x1000x24", "-noreset"],
                          pass_fds=[writing], stderr=subprocess.DEVNULL)
os.close(writing)
with os.fdopen(reading) as number, tempfile.TemporaryDirectory() as folder:
    os.environ["DISPLAY"] = f":{number.readline().strip()}"
    window = make_window(
        load("furnished_room"), None, None, None, TransportStore(), Path(folder), lambda step: None
    )
    window.plotter.show(interactive_update=True, auto_close=False)
    for key in ("c", "o"):
        window.press(key)
    window.click(660, 240)
    window.press("s")
    Image.open(window.files[0]).convert("RGB").save(DOCS / "pictures" / "window.png", optimize=True)
    window.plotter.close()
server.terminate()
