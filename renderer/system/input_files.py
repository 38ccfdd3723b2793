"""Files that a user names: checked before they are opened, and listed with their checksums."""

import codecs
import hashlib
import os
import re
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from stat import S_ISDIR, S_ISREG

from renderer.errors import InputError
from renderer.system.text import quoted

MAX_BYTES = {"scene": 4_000_000, "study": 4_000_000, "spectral": 16_000_000, "photometric": 16_000_000,
             "model": 500_000_000}
"""Largest size allowed for a file of each kind [bytes]: at least thirty times the largest known file."""
MAX_TOML_DEPTH = 20
"""Largest depth of tables and lists within each other in a TOML file; a scene has 4."""


@dataclass(frozen=True)
class OpenedFile:
    """A file as it was when it was read.

    path : as it was opened
    sha256 : checksum of its bytes
    size : [bytes]
    """

    path: Path
    sha256: str
    size: int


_opened: ContextVar[dict[Path, OpenedFile] | None] = ContextVar("opened", default=None)


@contextmanager
def remembered() -> Iterator[dict[Path, OpenedFile]]:
    """Every file that `read_input` reads inside this context, by path, in order. An outer context lists the
    files of an inner one too."""
    outer, here = _opened.get(), {}
    token = _opened.set(here)
    try:
        yield here
    finally:
        _opened.reset(token)
        if outer is not None:
            outer.update(here)


def read_input(path: Path, kind: str, where: str, remedy: str = "Correct the path.") -> bytes:
    """The bytes of a file that a user names. Raises InputError where there is no such file, or it is too
    large.

    kind : a key of MAX_BYTES
    where : the key or option that names the file, for the message
    remedy : the last sentence of the message where there is no such file
    Never waits: a pipe, a device or a socket is refused before it is opened.
    """
    limit, name = MAX_BYTES[kind], str(path)
    try:
        _refuse_irregular(os.stat(path), name, where)
        with open(path, "rb", opener=_without_waiting) as file:
            status = os.fstat(file.fileno())  # of the open file; the name may meanwhile belong to another
            _refuse_irregular(status, name, where)
            if status.st_size <= limit:
                data = file.read(limit + 1)
            if status.st_size > limit or len(data) > limit:
                raise InputError(f"{where}: {name} has {max(status.st_size, limit + 1) / 1e6:.3g} MB; a "
                                 f"{kind} file may have at most {limit / 1e6:g} MB. Give a smaller one.")
    except FileNotFoundError:
        raise InputError(f"{where}: there is no file {name!r}. {remedy}") from None
    except (OSError, ValueError) as error:  # the latter for a name with a zero byte in it
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{where}: {name!r} cannot be read ({reason}). Give another file.") from None
    opened = _opened.get()
    if opened is not None:
        opened[path] = OpenedFile(path, hashlib.sha256(data).hexdigest(), len(data))
    return data


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _refuse_irregular(status: os.stat_result, name: str, where: str) -> None:
    if S_ISDIR(status.st_mode):
        raise InputError(f"{where}: {name} is a folder. Give a file.")
    if not S_ISREG(status.st_mode):
        raise InputError(f"{where}: {name} is a pipe, a device or a socket. Give a regular file.")


def is_regular_file(path: Path) -> bool:
    """Whether there is a regular file of that name; False for a name that no file can have."""
    try:
        return S_ISREG(os.stat(path).st_mode)
    except (OSError, ValueError):
        return False


def parse_toml(data: bytes, where: str) -> dict:
    """The table in a TOML file, which may begin with a byte-order mark. Raises InputError for text that is
    not TOML."""
    text = ""
    try:
        text = data.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
        table = tomllib.loads(text)
    except UnicodeDecodeError:
        raise InputError(f"{where}: is not UTF-8 text{_other_encoding(data)}; a TOML file is. Save it as "
                         "UTF-8.") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{where}: is not valid TOML: {_toml_fault(str(error), text)}.") from None
    except RecursionError:
        raise InputError(f"{where}: has lists or tables within each other, more than {MAX_TOML_DEPTH} deep; "
                         "a scene needs 4. Remove them.") from None
    except ValueError:
        raise InputError(f"{where}: has an integer of thousands of digits; TOML allows "
                         "19. Correct it.") from None
    refuse_excess(table, where)
    return table


def _other_encoding(data: bytes) -> str:
    """The encoding that a byte-order mark names, as " but UTF-16"; "" where there is none."""
    return " but UTF-16" if data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE) else ""


def _toml_fault(said: str, text: str) -> str:
    """The message of tomllib with the names of tables as in the file, and the probable mistake in its line.

    said : the message, in which names of tables are tuples; text : of the file
    """
    said = re.sub(r"\('[^()]*\)", lambda name: "[" + ".".join(re.findall(r"'(.*?)'", name[0])) + "]",
                  " ".join(said.split()))
    place = re.search(r"at line (\d+), column (\d+)", said)
    if not place:
        return said
    lines, row, column = text.split("\n"), int(place[1]) - 1, int(place[2]) - 1
    line = lines[row] if row < len(lines) else ""
    letter = line[column:column + 1]
    if not letter.isascii():
        return (f"{said}; {quoted(letter)} (U+{ord(letter):04X}) is there; outside quotation marks only "
                "ASCII characters are allowed")
    if re.search(r"=\s*-?\d+,\d+\s*(#.*)?$", line):  # a number with a decimal comma
        return f"{said}; write decimals with a point"
    return said


def refuse_excess(table: dict, where: str) -> None:
    """Raise InputError where a table is nested too deep, or has an integer that no TOML file may have."""
    todo: list[tuple[str, object, int]] = [("", table, 0)]
    largest = 2**63 - 1  # TOML 1.0, Integer
    while todo:
        key, value, depth = todo.pop()
        if depth > MAX_TOML_DEPTH:
            raise InputError(f"{where}: {key[:40]} has lists or tables within each other, more than "
                             f"{MAX_TOML_DEPTH} deep; a scene needs 4. Remove them.")
        if isinstance(value, dict):
            todo += [(f"{key}.{name}" if key else str(name), item, depth + 1) for name, item in value.items()]
        elif isinstance(value, (list, tuple)):
            todo += [(f"{key}[{k}]", item, depth + 1) for k, item in enumerate(value)]
        elif isinstance(value, int) and abs(value) > largest:
            raise InputError(f"{where}: {key} is an integer of {value.bit_length()} bits; must be within "
                             f"±{largest:.3g}. Correct it.")
