"""The pages: examples print the output shown, links have targets, pictures are made by a command."""

import contextlib
import io
import json
import re
import subprocess
import tomllib
from itertools import pairwise
from pathlib import Path
from urllib.parse import unquote, urlparse

import api
import gallery
import pages
import pictures
import pytest
from markdown_it import MarkdownIt
from PIL import Image
from shown import differences

from renderer.scene.schema import SceneTable

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
PAGES = {str(page.relative_to(ROOT)): page for page in pages.PAGES}
SOLVING = {"photometer", "luminance", "ugr", "render", "pseudocolour", "sweep"}
"""Commands that a test asks for 20 %, where the page shows no output and no accuracy."""
MAX_PICTURE_BYTES = 300_000
RUN = set()


def runs(block: pages.Block) -> bool:
    """Whether a block is to be run."""
    return not block.mark and block.kind in ("sh", "python")


EXAMPLES = [name for name, page in PAGES.items() if any(map(runs, pages.blocks(page)))]


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_run_and_print_the_text_shown(name, tmp_path, here, monkeypatch):
    """Files are saved and commands run in an empty folder, in the order of the page."""
    monkeypatch.chdir(tmp_path)
    parts = pages.blocks(PAGES[name])
    shown, scene = pages.shown(parts), {}
    for block in parts:
        if block.mark == "save":
            (tmp_path / block.said).write_text(block.text)
        if block.kind == "toml" and block.mark != "not run":
            table = tomllib.loads(block.text)
            if "vary" not in table:
                scene = table if block.mark else {**scene, **table}  # a part is added to the last whole scene
        if not runs(block):
            continue
        said = ran(block, here, tmp_path, block in shown)
        if block in shown:
            assert not differences(shown[block].text, said)


def ran(block: pages.Block, here, folder: Path, whole: bool) -> str:
    """Run a block; what its last command says. whole : as it stands, else as cheaply as it can be."""
    if block.kind == "python":
        with contextlib.redirect_stdout(io.StringIO()) as said:
            exec(block.text, {})
        return said.getvalue()
    said = ""
    for command in block.commands:
        own = any(path.name in command for path in folder.iterdir())
        if not whole and not own and tuple(command) in RUN:
            continue  # the same on another page, of nothing that is this page's
        RUN.add(tuple(command))
        cheap = [] if whole or "--accuracy" in command or command[0] not in SOLVING else ["--accuracy", "20%"]
        done = here(*command, *cheap, *pages.quiet(command), cwd=folder)
        assert done.returncode in ((0, 2) if whole else (0,)), f"{command}: {done.stderr}"
        said = done.stdout + done.stderr
    return said


@pytest.mark.parametrize("name", PAGES)
def test_parts_of_scenes_in_pages_have_allowed_keys(name):
    """TOML that is not saved is a part of the page's last whole scene, and valid with it."""
    scene = tomllib.loads((ROOT / "scenes" / "furnished_room.toml").read_text())
    for block in pages.blocks(PAGES[name]):
        if block.kind != "toml" or block.said == "wrong.toml":
            continue
        table = tomllib.loads(block.text)
        if "vary" in table:
            continue
        scene = table if block.mark == "save" else {**scene, **table}
        SceneTable.model_validate(scene)


@pytest.mark.parametrize("name", PAGES)
def test_examples_that_are_not_run_could_be(name):
    """Every command on a page exists with its options; those that are not run state the reason."""
    from renderer.cli import app

    for block in pages.blocks(PAGES[name]):
        if block.kind not in ("", "sh"):
            continue
        assert runs(block) or not block.commands or block.mark == "not run", block.text
        for command in block.commands:
            assert command[0] in app  # of a synopsis, no more can be asked
            if block.kind == "sh":
                app.parse_args(command, exit_on_error=False, print_error=False)


def texts() -> dict[Path, str]:
    """Every page, and the text of the notebook."""
    found = {page: page.read_text(encoding="utf-8") for page in PAGES.values()}
    notebook = json.loads((DOCS / "tutorial.ipynb").read_text(encoding="utf-8"))
    cells = ("".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "markdown")
    return {**found, DOCS / "tutorial.ipynb": "\n\n".join(cells)}


def links(text: str) -> list[str]:
    """The targets of links and pictures."""
    inline = (token for part in MarkdownIt("commonmark").enable("table").parse(text) if part.type == "inline"
              for token in part.children)
    return [token.attrs.get("href") or token.attrs.get("src") for token in inline
            if token.type in ("link_open", "image")]


def anchors(text: str) -> set[str]:
    """The places in a page that a link may name: GitHub's, of its headings."""
    tokens = MarkdownIt("commonmark").parse(text)
    heads = [after.content for token, after in pairwise(tokens)
             if token.type == "heading_open"]
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", texts(), ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    for link in links(texts()[page]):
        parsed = urlparse(link)
        if parsed.scheme:
            assert parsed.scheme == "https", link
            assert "." in parsed.netloc, link
            continue
        target = (page.parent / parsed.path).resolve() if parsed.path else page
        assert target.exists(), f"{page.name}: {link}"
        if parsed.fragment:
            places = anchors(target.read_text(encoding="utf-8"))
            assert unquote(parsed.fragment) in places, f"{page.name}: {link}"


def test_every_page_can_be_found():
    """From the README, by links between pages."""
    seen, new = set(), {ROOT / "README.md"}
    while new:
        page = new.pop()
        seen.add(page)
        named = {(page.parent / urlparse(link).path).resolve() for link in links(texts()[page])}
        new |= (named & set(texts())) - seen
    assert seen == set(texts())


def test_the_site_lists_every_page():
    listed = re.findall(r"[\w]+\.md", (DOCS / "mkdocs.yml").read_text(encoding="utf-8").partition("nav:")[2])
    start = {"README.md", "index.md", "pages.md", "notebook.md", "changelog.md", "contributing.md"}
    assert set(listed) | start == {page.name for page in PAGES.values()} | start


def test_the_wheel_carries_every_page():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    carried = project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    names = [f"docs/{page.name}" for page in PAGES.values() if page.parent == DOCS]
    assert {name: carried.get(name) for name in names} == {name: f"renderer/{name}" for name in names}


def test_pictures_are_shown_small_and_made_by_one_command():
    kept = {path.name for path in (DOCS / "pictures").iterdir()}
    used = {Path(link).name for text in texts().values() for link in links(text) if link.endswith(".png")}
    assert kept == used
    assert all((DOCS / "pictures" / name).stat().st_size < MAX_PICTURE_BYTES for name in kept)
    for name in kept:
        Image.open(DOCS / "pictures" / name).load()  # fails where a picture is cut short
    done = subprocess.run(["make", "--dry-run", "docs"], cwd=ROOT, capture_output=True, text=True, check=True)
    for script in ("pictures", "gallery", "living_room", "report_picture", "window_picture", "notebook",
                   "pages", "insert"):
        assert f"docs/{script}.py" in done.stdout
    rooms = re.search("for room in (.*); do", done.stdout).group(1).split()
    gallery_rooms = {f"{room}{kind}.png" for room, isolux in gallery.ROOMS.items()
                     for kind in ("", "_pseudocolour", *(["_isolux"] if isolux else []))}
    assert kept == {*pictures.MADE, *gallery_rooms, *(f"tradeoff_{room}.png" for room in rooms),
                    *(f"study_{name}.png" for name in ("within", "rule", "models", "colour", "reds")),
                    "report.png", "window.png", "living_room.png"}


def test_decisions_have_a_number_each_and_those_cited_exist():
    page = (DOCS / "decisions.md").read_text(encoding="utf-8")
    entries = re.findall(r"^\*\*D(\d+) \(20\d\d-\d\d\)\. ", page, re.M)
    assert len(entries) == len(set(entries)) > 0
    for source in sorted((ROOT / "renderer").rglob("*.py")) + sorted((ROOT / "tests").glob("*.py")):
        cited = re.findall(r"decisions\.md, D(\d+)", source.read_text(encoding="utf-8"))
        assert set(cited) <= set(entries), f"{source} cites what docs/decisions.md does not have"


def test_decisions_are_short():
    entries = (DOCS / "decisions.md").read_text(encoding="utf-8").split("\n**D")[1:]
    long = [entry.split("(")[0] for entry in entries if len(entry.split("\n\n")[0].splitlines()) > 3]
    assert not long, f"entries of more than three lines: D{', D'.join(long)}"


def test_every_install_line_is_of_the_published_name():
    """No line installs `renderer`, which on the index is another's; extras are those of pyproject.toml."""
    extras = set(tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"])
    files = [*PAGES.values(), DOCS / "tutorial.ipynb", *(ROOT / "renderer").rglob("*.py")]
    lines = [line for file in files for line in file.read_text(encoding="utf-8").splitlines()
             if re.search(r"\binstall\b.*(renderer|radiosity|\[)", line)]
    assert len(lines) > 8
    for line in lines:
        assert not re.search(r"install (-\S+ )*'?renderer\b", line), line
        for named in re.findall(r"radiosity\[(\w+)\]", line):
            assert named in extras, line


def test_the_page_of_python_names_is_fresh():
    assert (DOCS / "api.md").read_text(encoding="utf-8") == api.page(), "give python docs/api.py"
