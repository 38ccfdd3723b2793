"""Build the pages as one site with search, for use without a network: build/site/index.html.

    .venv/bin/python docs/build_site.py       `make site`; a link that leads nowhere ends it with an error

README is its first page; the notebook and formulas are converted for browsers without scripts.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import nbformat
from latex2mathml.converter import convert
from nbconvert import MarkdownExporter

ROOT = Path(__file__).parent.parent
PAGES, SITE = ROOT / "build" / "pages", ROOT / "build" / "site"
LINK = re.compile(r"(\]\()([^)\s#]+)(#[^)]*)?(\))")


def main() -> None:
    """Write the pages for mkdocs, and build the site."""
    shutil.rmtree(PAGES, ignore_errors=True)
    shutil.copytree(ROOT / "docs" / "pictures", PAGES / "pictures")
    sources = {ROOT / "README.md": "index.md", ROOT / "docs" / "README.md": "pages.md",
               ROOT / "CHANGELOG.md": "changelog.md", ROOT / "CONTRIBUTING.md": "contributing.md"}
    sources |= {page: page.name for page in (ROOT / "docs").glob("*.md") if page not in sources}
    sources[ROOT / "docs" / "tutorial.ipynb"] = "notebook.md"
    for source, name in sources.items():
        text = _notebook(source, PAGES) if source.suffix == ".ipynb" else source.read_text(encoding="utf-8")
        (PAGES / name).write_text(_formulas(_links(text, source, sources)), encoding="utf-8")
    done = subprocess.run([sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--config-file",
                           ROOT / "docs" / "mkdocs.yml"], check=False,
                          env={**os.environ, "NO_MKDOCS_2_WARNING": "1"})
    if done.returncode:
        sys.exit(done.returncode)
    print(f"{SITE / 'index.html'}: {len(sources)} pages")  # noqa: T201  a command


def _notebook(path: Path, folder: Path) -> str:
    """A notebook as Markdown, with its pictures in files beside it."""
    body, resources = MarkdownExporter().from_notebook_node(nbformat.read(path, as_version=4))
    for name, data in resources["outputs"].items():
        (folder / name).write_bytes(data)
    return body


def _links(text: str, source: Path, sources: dict[Path, str]) -> str:
    """Links between pages and to files of the repository, which are copied; other links are unchanged."""
    def moved(match: re.Match) -> str:
        before, target, place, after = match.groups()
        path = (source.parent / target).resolve()
        if "://" in target or not path.exists():
            return match[0]
        if path in sources:
            return f"{before}{sources[path]}{place or ''}{after}"
        if path.is_relative_to(ROOT / "docs" / "pictures"):
            return f"{before}pictures/{path.name}{after}"
        copy = PAGES / "files" / path.relative_to(ROOT)
        if path.is_dir():
            return match[0]
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, copy)
        return f"{before}files/{path.relative_to(ROOT)}{place or ''}{after}"

    return LINK.sub(moved, text)


def _formulas(text: str) -> str:
    """TeX as MathML, for browsers without a script."""
    text = re.sub(r"```math\n(.+?)```", lambda m: convert(m[1].strip(), display="block"), text, flags=re.S)
    return re.sub(r"\$`(.+?)`\$", lambda m: convert(m[1]), text)


if __name__ == "__main__":
    main()
