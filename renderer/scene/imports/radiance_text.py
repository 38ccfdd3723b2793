"""Radiance scene files as primitives in the scene's coordinates.

No command in a file is run. `!xform`, `!genbox`, `!cat` and the like are interpreted here; others are listed.
"""

import re
import shlex
from dataclasses import dataclass, field

import numpy as np

from renderer.scene.imports.record import NotImported
from renderer.scene.model_files.record import Beside, Unreadable

MAX_COPIES = 2000


@dataclass(frozen=True)
class Primitive:
    """A primitive of a scene: its modifier, type, name and arguments.

    turn : (4, 4) transform into the scene's coordinates
    file : name of its file
    """

    modifier: str
    kind: str
    name: str
    words: list[str]
    numbers: list[float]
    turn: np.ndarray
    file: str = ""

    @property
    def scale(self) -> float:
        """Factor of the transform on lengths."""
        return float(np.cbrt(abs(np.linalg.det(self.turn[:3, :3]))))

    def points(self, numbers) -> np.ndarray:
        """Points (k, 3) in the scene's coordinates, from a flat list of coordinates."""
        points = np.array(numbers, dtype=float).reshape(-1, 3)
        return points @ self.turn[:3, :3].T + self.turn[:3, 3]


@dataclass
class RadianceScene:
    """All primitives of a file and of the files it includes; skipped : commands that are not interpreted."""

    beside: Beside
    primitives: list[Primitive] = field(default_factory=list)
    skipped: list[str] = field(default_factory=list)

    def read(self, text: str, turn: np.ndarray, file: str = "", depth: int = 0) -> None:
        """Add the primitives in a file's text, moved by a transform (4, 4). Raises NotImported."""
        if depth > 16:
            raise NotImported("includes files more than 16 deep; does one include itself?")
        words: list[str] = []
        lines = iter(text.replace("\\\n", " ").splitlines())
        for line in lines:
            if line.startswith("!"):
                self._primitives(words, turn, file)
                words = []
                self._command(line[1:], turn, depth)
                continue
            words += re.findall(r'"[^"]*"|\'[^\']*\'|\S+', line.partition("#")[0])
        self._primitives(words, turn, file)

    def _primitives(self, words: list[str], turn: np.ndarray, file: str) -> None:
        words = [w[1:-1] if len(w) > 1 and w[0] in "\"'" and w[0] == w[-1] else w for w in words]
        at = 0
        try:
            while at < len(words):
                modifier, kind, name = words[at:at + 3]
                at += 3
                if kind == "alias":
                    strings, numbers = [words[at]], []
                    at += 1
                else:
                    strings, at = self._counted(words, at)
                    _, at = self._counted(words, at)
                    real, at = self._counted(words, at)
                    numbers = [float(x) for x in real]
                    if not np.isfinite(numbers).all():
                        raise ValueError
                self._add(Primitive(modifier, kind, name, strings, numbers, turn, file))
        except (ValueError, IndexError):
            near = " ".join(words[max(at - 3, 0):at + 3])[:60]
            raise NotImported(f"has a faulty primitive near {near!r}: a modifier, a type, a name, and three "
                              "counted lists of arguments belong there") from None

    def _add(self, primitive: Primitive) -> None:
        if len(self.primitives) >= 500_000:
            raise NotImported("holds more than 500000 primitives")
        self.primitives.append(primitive)

    @staticmethod
    def _counted(words: list[str], at: int) -> tuple[list[str], int]:
        count = int(words[at])
        if count < 0 or at + 1 + count > len(words):
            raise ValueError
        return words[at + 1:at + 1 + count], at + 1 + count

    def _command(self, line: str, turn: np.ndarray, depth: int) -> None:
        """Follow one command line; the commands of a pipe from the last to the first. Raises NotImported."""
        try:
            stages = [shlex.split(stage) for stage in line.split("|")]
        except ValueError:
            stages = [[]]
        turns = [turn]
        for stage in reversed(stages[1:]):
            copies = _transforms(stage[1:])[0] if stage[:1] == ["xform"] else None
            if copies is None:
                self.skipped.append(line.strip())
                return
            turns = [one @ copy for one in turns for copy in copies]
            if len(turns) > MAX_COPIES:
                raise NotImported(f"has more than {MAX_COPIES} copies with xform")
        first = stages[0]
        name, given = (first[0], first[1:]) if first else ("", [])
        if name == "xform":
            copies, files = _transforms(given)
            for one in turns:
                for copy in copies:
                    self._include(files, one @ copy, line, depth)
        elif name == "cat":
            for one in turns:
                self._include(given, one, line, depth)
        elif name == "genbox" and (made := _box(given)) is not None:
            for one in turns:
                self.read(made, one, depth=depth + 1)
        elif name == "ies2rad" and given and given[-1].lower().endswith((".ies", ".ldt")):
            for one in turns:
                self._add(Primitive("void", "ies2rad", given[-1].rpartition("/")[2], [given[-1]], [], one))
        else:
            self.skipped.append(line.strip())

    def _include(self, files: list[str], turn: np.ndarray, line: str, depth: int) -> None:
        if not files:
            self.skipped.append(line.strip())
        for file in files:
            try:
                text = self.beside(file).decode("utf-8", errors="replace")
            except Unreadable as fault:
                self.skipped.append(f"{line.strip()} ({fault})")
                continue
            self.read(text, turn, file, depth + 1)


def _transforms(words: list[str]) -> tuple[list[np.ndarray], list[str]]:
    """Transforms (4, 4) of xform's arguments, one a copy, and the files after them. Raises NotImported.

    Each argument acts after those before it. `-a n` applies the arguments up to `-i` or the next `-a` 0 to n
    − 1 times (manual page of xform).
    """
    total, array, here, at = [np.eye(4)], None, np.eye(4), 0

    def done() -> None:
        nonlocal total, here, array
        copies = [np.linalg.matrix_power(here, k) for k in range(array)] if array is not None else [here]
        total = [copy @ one for copy in copies for one in total]
        here, array = np.eye(4), None
        if len(total) > MAX_COPIES:
            raise NotImported(f"has more than {MAX_COPIES} copies with xform")

    try:
        while at < len(words):
            word = words[at]
            if word in ("-a", "-i"):
                done()
                count = int(words[at + 1])
                if word == "-a":
                    array = count
                    if not 0 <= count <= MAX_COPIES:
                        raise NotImported(f"has {count} copies with xform; at most {MAX_COPIES} are read")
                elif count != 1:
                    array = None
                    raise ValueError
                at += 2
            elif word in ("-n", "-m"):
                at += 2
            elif word in ("-c", "-e", "-I"):
                at += 1
            elif word == "-t":
                step = np.eye(4)
                step[:3, 3] = [float(x) for x in words[at + 1:at + 4]]
                here, at = step @ here, at + 4
            elif word in ("-rx", "-ry", "-rz"):
                here, at = _rotation(word[2], float(words[at + 1])) @ here, at + 2
            elif word == "-s":
                here, at = np.diag([*[float(words[at + 1])] * 3, 1.0]) @ here, at + 2
            elif word in ("-mx", "-my", "-mz"):
                flip = np.eye(4)
                axis = "xyz".index(word[2])
                flip[axis, axis] = -1
                here, at = flip @ here, at + 1
            elif word.startswith("-") and len(word) > 1:
                raise ValueError
            else:
                break
    except (ValueError, IndexError):
        raise NotImported(f"has an xform that is not understood: {' '.join(words)[:60]!r}") from None
    done()
    return total, words[at:]


def _rotation(axis: str, degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    if degrees % 90 == 0:
        c, s = round(c), round(s)
    turn, (i, j) = np.eye(4), {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    turn[i, i] = turn[j, j] = c
    turn[i, j], turn[j, i] = -s, s
    return turn


def _box(words: list[str]) -> str | None:
    """The polygons of genbox as text, normals outward, or inward with -i; None for rounded and bevelled
    boxes."""
    try:
        material, name, *size = words[:5]
        x, y, z = (float(item) for item in size)
    except ValueError:
        return None
    options = words[5:]
    if any(option not in ("-i",) for option in options):
        return None
    corners = np.array([[a, b, c] for c in (0, z) for a, b in ((0, 0), (x, 0), (x, y), (0, y))])
    sides = [[3, 2, 1, 0], [4, 5, 6, 7]] + [[k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4] for k in range(4)]
    step = -1 if "-i" in options else 1
    rings = [" ".join(map(str, corners[side[::step]].ravel())) for side in sides]
    return "\n".join(f"{material} polygon {name}.{k}\n0\n0\n12 {ring}" for k, ring in enumerate(rings))
