"""Execute docs/tutorial.ipynb in a folder of its own, and keep its outputs (`make docs`)."""

import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

NOTEBOOK = Path(__file__).parent / "tutorial.ipynb"
LARGEST = 300_000
"""Bytes of the notebook with its pictures."""


def executed(notebook: Path, folder: Path) -> nbformat.NotebookNode:
    """The notebook with the outputs of its cells, run in that folder. Raises CellExecutionError."""
    book = nbformat.read(notebook, as_version=4)
    return NotebookClient(book, timeout=120, kernel_name="python3", record_timing=False,
                          resources={"metadata": {"path": str(folder)}}).execute()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        book = executed(NOTEBOOK, Path(folder))
    book.metadata["language_info"] = {"name": "python"}  # not which patch of Python it was
    text = nbformat.writes(book) + "\n"
    assert len(text) < LARGEST, f"{len(text)} bytes; smaller pictures are needed"
    NOTEBOOK.write_text(text, encoding="utf-8")
