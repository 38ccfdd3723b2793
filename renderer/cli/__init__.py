"""The command line: arguments and messages only."""

import atexit
import gc
import signal
import sys
import warnings

from cyclopts import App, CycloptsError

from renderer.cli import luminaires, measure, planning, show, studies, sweeping, viewing
from renderer.cli.terminal import interrupt, leave, leave_interrupted, say
from renderer.errors import CacheWarning, DisplayError, InputError, SolveError

COLLECT = 100_000
"""Objects made before the garbage collector looks for cycles: imports make as many and no cycles."""

app = App(name="renderer", help="Does it matter that lighting software models colour as RGB? "
          "Solves the interreflection of light in a room with 3 bands and with 31, and shows and "
          "measures the difference.", version_flags=["--version"], help_format="plaintext",
          suppress_keyboard_interrupt=False)
for command in (
    show.compare,
    show.report,
    viewing.view,
    show.render,
    show.pseudocolour,
    measure.photometer,
    measure.luminance,
    measure.ugr,
    studies.validate,
    studies.spectrum,
    studies.gamut,
    studies.tradeoff,
    sweeping.sweep,
    sweeping.study,
    luminaires.luminaire,
    planning.plan,
):
    app.command(command)
app.command(planning.cache)


def main() -> None:
    """Run the command line; every refusal is one line on stderr."""
    gc.set_threshold(COLLECT)
    atexit.register(gc.freeze)  # the process ends: nothing is worth looking for any more
    for asked in (signal.SIGINT, signal.SIGTERM):
        signal.signal(asked, interrupt)
    shown = warnings.showwarning
    warnings.showwarning = lambda message, category, *rest, **more: (
        say(f"warning: {message}") if category is CacheWarning else shown(message, category, *rest, **more))
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="replace")
    try:
        app(exit_on_error=False, print_error=False)
    except CycloptsError as error:
        leave(f"{' '.join(str(error).split())} See renderer --help.", 2)
    except InputError as error:
        leave(str(error), 2)
    except (SolveError, DisplayError) as error:
        leave(str(error), 1)
    except MemoryError:
        leave("the memory is used up. Give a looser --accuracy or a larger patch_size.", 1)
    except BrokenPipeError:
        sys.stdout = None
        sys.exit(1)
    except OSError as error:
        leave(f"{error.filename or 'the output'}: {error.strerror}. Give another path.",
               2 if error.filename else 1)
    except KeyboardInterrupt:
        leave_interrupted("no partial file is left")
