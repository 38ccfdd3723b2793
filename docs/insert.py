"""Put the tables of `renderer validate` into the pages (`make docs`).

A page holds the table between <!-- begin NAME --> and <!-- end NAME -->, NAME a file in outputs/.
"""

import re
from pathlib import Path

DOCS = Path(__file__).parent

for page in sorted(DOCS.glob("*.md")):
    text = page.read_text(encoding="utf-8")
    for name in re.findall(r"<!-- begin (\S+) -->", text):
        source = DOCS.parent / "outputs" / name
        if source.is_file():
            begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
            before, rest = text.split(begin)
            text = before + begin + "\n" + source.read_text(encoding="utf-8") + end + rest.split(end)[1]
    page.write_text(text, encoding="utf-8")
