"""The command line: arguments and messages only."""

import atexit
import gc
import sys
import warnings
from pathlib import Path

from cyclopts import App, CycloptsError, Group, MissingArgumentError, UnusedCliTokensError

from renderer import __version__
from renderer.cli import luminaires, measure, planning, show, starting, studies, sweeping, viewing
from renderer.cli.terminal import (
    close_stdout,
    heed_signals,
    interrupted,
    leave,
    leave_interrupted,
    open_streams,
    say,
)
from renderer.errors import CacheWarning, DisplayError, InputError, OutputError, SolveError

COLLECT = 100_000
"""Objects made before the garbage collector looks for cycles: imports make as many and no cycles."""

START, SHOW, READ, STUDY, LOOK = (Group(name, sort_key=k) for k, name in enumerate(
    ("Begin", "Show a room", "Read a room", "Study colour and accuracy", "Look at one thing")))
COMMANDS = ((START, (starting.new, starting.keys, planning.plan)),
            (SHOW, (show.compare, show.report, viewing.view, show.render, show.pseudocolour)),
            (READ, (measure.photometer, measure.luminance, measure.ugr)),
            (STUDY, (studies.gamut, sweeping.sweep, sweeping.study, studies.tradeoff, studies.validate)),
            (LOOK, (luminaires.luminaire, studies.spectrum)))


def _epilogue() -> str:
    """What help says last: the packaged rooms, and where the pages are."""
    rooms = ", ".join(sorted(path.stem for path in beside_package("scenes").glob("*.toml")))
    pages = beside_package("docs") / "README.md"
    where = pages if pages.is_file() else "docs/ of the source distribution"
    return (f"Packaged rooms, in place of a scene file: {rooms}.\n\n"
            f"Pages: {where}. First steps: renderer new; renderer photometer "
            "office.toml.")


def beside_package(name: str) -> Path:
    """A folder that ships within the package, or lies beside it in a checkout."""
    package = Path(__file__).parent.parent
    return package / name if (package / name).is_dir() else package.parent / name


app = App(name="renderer", help="Does it matter that lighting software models colour as RGB? "
          "Solves the interreflection of light in a room with 3 bands and with 31, and shows and "
          "measures the difference.", version_flags=["--version"], version=__version__,
          help_format="plaintext", help_epilogue=_epilogue(), suppress_keyboard_interrupt=False)
for group, commands in COMMANDS:
    for command in commands:
        app.command(command, group=group)
planning.cache.group = (LOOK,)
app.command(planning.cache)
app.register_install_completion_command(add_to_startup=False, group=LOOK,
                                        help="Install completion of commands and options for this shell.")


def main() -> None:
    """Run the command line; every refusal is one line on stderr."""
    gc.set_threshold(COLLECT)
    atexit.register(gc.freeze)  # the process ends: nothing is worth looking for any more
    heed_signals()
    open_streams()
    shown = warnings.showwarning
    warnings.showwarning = lambda message, category, *rest, **more: (
        say(f"warning: {message}") if category is CacheWarning else shown(message, category, *rest, **more))
    try:
        app(exit_on_error=False, print_error=False)
        sys.stdout.flush()
    except SystemExit:
        raise
    except BaseException as error:  # noqa: BLE001  whatever a package made of an interruption
        if interrupted():
            leave_interrupted("no partial file is left")
        _leave_for(error)
    if interrupted():
        leave_interrupted("no partial file is left")


def _wrong_call(error: CycloptsError) -> str:
    """What is wrong with the arguments, in words of this command line."""
    command = " ".join(("renderer", *(error.command_chain or ())))
    match error:
        case UnusedCliTokensError(unused_tokens=[word, *_]):
            return f"{command} takes no further {word!r}."
        case MissingArgumentError(keyword=str(option)):
            return f"{command}: {option} has no value; where that begins with a hyphen, write {option}=…."
        case MissingArgumentError(argument=argument):
            return f"{command}: {argument.name.removeprefix('--').upper()} is missing."
    return " ".join(str(error).split())


def _leave_for(error: BaseException) -> None:
    """Say why a run has failed, and end it; raise again what no user can have caused."""
    match error:
        case CycloptsError():
            leave(f"{_wrong_call(error)} See renderer --help.", 2)
        case InputError():
            leave(str(error), 2)
        case SolveError() | DisplayError() | OutputError():
            leave(str(error), 1)
        case MemoryError():
            leave("the memory is used up. Give a looser --accuracy or a larger patch_size.", 1)
        case BrokenPipeError():
            sys.stdout = None
            sys.exit(1)
        case OSError():
            close_stdout()
            leave(f"{error.filename or 'the output'}: {error.strerror}. Give another path.",
                  2 if error.filename else 1)
        case KeyboardInterrupt():
            leave_interrupted("no partial file is left")
    raise error
