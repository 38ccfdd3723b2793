"""The cases of validation: an expected value, the result, and the verdict."""

from dataclasses import dataclass
from pathlib import Path

from renderer.scene.reading import load
from renderer.scene.scene import Scene


@dataclass(frozen=True)
class Case:
    """A quantity and its expected value, or a refusal and its expected reason.

    expected, got : a number in `unit`, or a sentence; an expected sentence is part of the other
    tolerance : largest |got − expected| that passes
    source : of the expected value
    """

    group: str
    case: str
    quantity: str
    expected: float | str
    got: float | str
    tolerance: float = 0.0
    unit: str = "1"
    source: str = ""

    @property
    def error(self) -> float | None:
        """got − expected [unit]; None for a sentence."""
        if isinstance(self.expected, str) or isinstance(self.got, str):
            return None
        return self.got - self.expected

    @property
    def passes(self) -> bool:
        """The verdict."""
        if self.error is not None:
            return bool(abs(self.error) <= self.tolerance)
        return isinstance(self.expected, str) and isinstance(self.got, str) and self.expected in self.got

    def record(self) -> dict:
        """The case as an object for JSON."""
        return {**vars(self), "error": self.error, "passes": self.passes}

    def cells(self) -> list[str]:
        """The case as a row with CASE_COLUMNS."""
        verdict = "pass" if self.passes else "FAIL"
        if self.error is None:
            return [self.case, self.quantity, "a sentence", f"“{self.got}”", "–", "–", verdict]
        unit = "" if self.unit == "1" else f" {self.unit}"
        return [self.case, self.quantity, f"{self.expected:.7g}{unit}", f"{self.got:.7g}{unit}",
                f"{self.error:+.1e}", f"{self.tolerance:.1e}", verdict]


CASE_COLUMNS = ("case", "quantity", "expected", "got", "error", "tolerance", "verdict")


def cases_markdown(cases: list[Case]) -> str:
    """The cases in Markdown, one table a group."""
    lines = []
    for group in dict.fromkeys(case.group for case in cases):
        rows = [case for case in cases if case.group == group]
        source = "; ".join(dict.fromkeys(case.source for case in rows if case.source))
        lines += ["", f"**{group}.**" + (f" {source}." if source else ""), "",
                  "| " + " | ".join(CASE_COLUMNS) + " |", "|---" * len(CASE_COLUMNS) + "|"]
        lines += ["| " + " | ".join(case.cells()).replace("\n", " ") + " |" for case in rows]
    return "\n".join(lines[1:]) + "\n"


PANEL = """
[[luminaires]]
name = "panel"
shape = "rectangle"
center = [2, 2, 3]
normal = [0, 0, -1]
size = [1, 1]
luminance = 1000
"""


def box_scene(folder: Path, rest: str = PANEL, size=(4, 4, 3), rho: float = 0.5, faces: str = "",
              shape: str = "", paint: str = "") -> Scene:
    """A room that is written as a scene file and read as users' files are.

    folder : of the file
    rest : more tables, as TOML
    faces : lines of [room] with another material ("black", "white") of some faces
    shape : lines of [room] with its shape; "" for a box of `size`
    paint : keys of its material; "" for a grey of `rho`
    """
    shape = shape or f"size = [{', '.join(repr(float(x)) for x in size)}]"
    named = {line.split("=")[0].strip() for line in faces.splitlines()}
    plain = [f'{key} = "paint"' for key in ("floor", "walls", "ceiling") if key not in named]
    finish = paint or f"reflectance = {rho!r}"
    path = folder / f"room{len(list(folder.glob('room*.toml')))}.toml"
    path.write_text("\n".join(["[room]", shape, faces, *plain, "[materials]",
                               f"paint = {{{finish}}}", "black = {reflectance = 0.0}",
                               "white = {reflectance = 1.0}", rest]))
    return load(path)


def meter(*position: float, normal=(0, 0, 1)) -> str:
    """A [[photometers]] table."""
    place, facing = ([float(x) for x in vector] for vector in (position, normal))
    return f"\n[[photometers]]\nposition = {place}\nnormal = {facing}\n"


def solid(shape: str, position, size, material: str = "paint", rotation: float = 0.0) -> str:
    """An [[objects]] table."""
    place, extents = ([float(x) for x in vector] for vector in (position, size))
    return (f'\n[[objects]]\nshape = "{shape}"\nposition = {place}\nsize = {extents}\n'
            f'material = "{material}"\nrotation = {float(rotation)}\n')
