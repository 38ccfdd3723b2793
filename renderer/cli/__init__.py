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

COMMANDS = {
    "Begin": (starting.new, starting.keys, planning.plan),
    "Show a room": (show.compare, show.report, viewing.view, show.render, show.pseudocolour),
    "Read a room": (measure.photometer, measure.luminance, measure.ugr),
    "Study colour and accuracy": (studies.gamut, sweeping.sweep, sweeping.study, studies.tradeoff,
                                  studies.validate),
    "Look at one luminaire, paint or lamp": (luminaires.luminaire, studies.spectrum)}
"""Commands by their group in the help."""


def _epilogue() -> str:
    """End of the help: the packaged rooms and the place of the documentation."""
    rooms = ", ".join(sorted(path.stem for path in beside_package("scenes").glob("*.toml")))
    pages = beside_package("docs") / "README.md"
    where = pages if pages.is_file() else "docs/ of the source distribution"
    return (f"Packaged rooms, in place of a scene file: {rooms}.\n\n"
            f"Pages: {where}. First steps: renderer new; renderer photometer office.toml.")


def beside_package(name: str) -> Path:
    """A folder in the installed package, or beside it in a checkout."""
    package = Path(__file__).parent.parent
    return package / name if (package / name).is_dir() else package.parent / name


app = App(name="renderer", help="Does it matter that lighting software models colour as RGB? "
          "Solves the interreflection of light in a room with 3 bands and with 31, and shows and "
          "measures the difference.", version_flags=["--version"], version=__version__,
          help_format="plaintext", help_epilogue=_epilogue(), suppress_keyboard_interrupt=False)
for number, (title, commands) in enumerate(COMMANDS.items()):
    group = Group(title, sort_key=number)
    for command in commands:
        app.command(command, group=group)
planning.cache.group = (group,)
app.command(planning.cache)
app.register_install_completion_command(add_to_startup=False, group=group,
                                        help="Install completion of commands and options for this shell.")


def main() -> None:
    """Run the command line; each refusal is one line on stderr."""
    gc.set_threshold(100_000)  # imports make about as many objects, none in cycles
    atexit.register(gc.freeze)  # no collection at the end of the process
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
    except BaseException as error:  # noqa: BLE001  packages turn an interruption into errors of any class
        if interrupted():
            leave_interrupted("no partial file is left")
        _leave_for(error)
    if interrupted():
        leave_interrupted("no partial file is left")


def _wrong_call(error: CycloptsError) -> str:
    """The fault of the arguments, as one sentence."""
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
    """Print the reason for a failure and end the run. Errors of the program itself are raised again."""
    match error:
        case CycloptsError():
            leave(f"{_wrong_call(error)} See renderer --help.", 2)
        case InputError():
            leave(str(error), 2)
        case SolveError() | DisplayError() | OutputError():
            leave(str(error), 1)
        case MemoryError():
            leave("there is not enough memory. Give a looser --accuracy or a larger patch_size.", 1)
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
