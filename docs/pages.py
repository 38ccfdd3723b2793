"""The examples of the pages: files to save, commands with their output, Python.

    .venv/bin/python docs/pages.py [PAGE …]     shows what each command prints now (part of `make docs`)

A fenced block after <!-- save: NAME --> is a file. A `toml` block without that is a part of the scene saved
last. Lines of a `sh` block that begin with `renderer` are run in a folder with the files saved so far, as are
`python` blocks. A `text` block right after one of these is the output of its last command. A block after <!--
not run: WHY --> is not run. tests/test_docs.py follows the same rules.
"""

import os
import re
import shlex
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from markdown_it import MarkdownIt

DOCS = Path(__file__).parent
PAGES = [DOCS.parent / "README.md", *sorted(DOCS.glob("*.md"))]
WITHOUT_PROGRESS = {"new", "keys"}
"""Commands that show none and take no --quiet."""
MARK = re.compile(r"<!-- (save|not run): (.+?) -->")


@dataclass(frozen=True)
class Block:
    """Code in a page. kind : of the fence, "" where it is only indented; mark : "save", "not run" or "";
    said : the file's name or the reason; lines : of the page, from the fence to the line past its end"""

    kind: str
    text: str
    mark: str
    said: str
    lines: tuple[int, int]

    @property
    def commands(self) -> list[list[str]]:
        """The arguments of each renderer command."""
        lines = (line.strip().removeprefix(".venv/bin/") for line in self.text.splitlines())
        return [shlex.split(line, comments=True)[1:] for line in lines if line.startswith("renderer ")]


def quiet(command: list[str]) -> list[str]:
    """The option that switches progress off."""
    return [] if command[0] in WITHOUT_PROGRESS else ["--quiet"]


def blocks(page: Path) -> list[Block]:
    """The code of a page, in order."""
    found, mark, said = [], "", ""
    for token in MarkdownIt().parse(page.read_text(encoding="utf-8")):
        if token.type == "html_block" and (match := MARK.search(token.content)):
            mark, said = match.groups()
        if token.type in ("fence", "code_block"):
            found.append(Block(token.info.strip(), token.content, mark, said, tuple(token.map)))
            mark = said = ""
    return found


def shown(parts: list[Block]) -> dict[Block, Block]:
    """The output of commands on the page: from each block of commands to the text after it."""
    return {one: other for one, other in pairwise(parts)
            if one.kind in ("sh", "python") and other.kind == "text" and other.lines[0] - one.lines[1] <= 1}


def refresh(page: Path) -> None:
    """Run a page's commands, and replace their output on the page."""
    parts = blocks(page)
    outputs = shown(parts)
    lines = page.read_text(encoding="utf-8").split("\n")
    fresh = {}
    with tempfile.TemporaryDirectory() as folder:
        for block in parts:
            if block.mark == "save":
                (Path(folder) / block.said).write_text(block.text, encoding="utf-8")
            if block.mark or block.kind not in ("sh", "python"):
                continue
            calls = [["-c", block.text]] if block.kind == "python" else [
                ["-m", "renderer", *command, *quiet(command)] for command in block.commands]
            for call in calls:
                done = subprocess.run([sys.executable, *call], cwd=folder, capture_output=True, text=True,
                                      check=False, env={**os.environ, "XDG_CACHE_HOME": folder})
            if block not in outputs:
                continue
            printed = [line.rstrip() for line in (done.stdout + done.stderr).splitlines() if line.strip()]
            fresh[outputs[block].lines] = ["```text", *printed, "```"]
    for (start, end), text in sorted(fresh.items(), reverse=True):
        lines[start:end] = text
    page.write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    for page in map(Path, sys.argv[1:]) if sys.argv[1:] else PAGES:
        refresh(page)
