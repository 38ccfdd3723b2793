"""A scene file before it is complete, and the files that go beside it."""

from dataclasses import dataclass, field
from pathlib import Path

from renderer.scene.imports.record import ImportedFinish
from renderer.scene.imports.shape import RoomShape
from renderer.scene.imports.toml_text import clean
from renderer.system.files import whole_file


@dataclass
class Written:
    """The scene file that an import wrote, and sentences about it.

    files : all written files, the scene's first
    room : name of the room in the scene
    rooms : names of all rooms in the source file
    not_carried, notes : sentences
    """

    files: list[Path]
    room: str = ""
    rooms: list[str] = field(default_factory=list)
    not_carried: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


@dataclass
class Draft:
    """A scene file before it is complete; folder : for its meshes, made when the first is written."""

    target: Path
    shape: RoomShape
    finishes: dict[str, ImportedFinish]
    written: Written

    @property
    def folder(self) -> Path:
        return self.target.with_name(f"{self.target.stem}_parts")

    def remove(self, mesh: str | None) -> None:
        """Remove a mesh that the scene does not use."""
        if mesh is not None:
            path = self.target.parent / mesh
            path.unlink(missing_ok=True)
            self.written.files.remove(path)

    def remove_parts(self) -> None:
        """Remove the meshes and photometric files that were written."""
        for path in self.written.files:
            path.unlink(missing_ok=True)
        self.written.files.clear()
        if self.folder.is_dir() and not any(self.folder.iterdir()):
            self.folder.rmdir()

    def beside(self, name: str, text: str) -> str:
        """Write a mesh, and return its path as the scene file names it."""
        path = self.folder / name
        with whole_file(path) as part:
            part.write_text(text, encoding="utf-8")
        self.written.files.append(path)
        return f"{self.folder.name}/{name}"


def listed_names(names: list[str]) -> str:
    """Names as text for a message, at most twelve."""
    shown = [repr(clean(name)) for name in names[:12]]
    return ", ".join(shown) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
