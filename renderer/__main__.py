"""`python -m renderer` is the command `renderer`."""

import atexit
import os
import sys
from contextlib import suppress


def main() -> None:
    """Run the command line. Ctrl-C ends it with a sentence even while its modules are imported."""
    try:
        from renderer.cli import main as command
    except KeyboardInterrupt:
        print("renderer: interrupted; nothing has been done.", file=sys.stderr)  # noqa: T201
        sys.exit(1)
    from renderer.cli.terminal import interrupted

    try:
        command()
    except SystemExit as end:
        if interrupted():
            _end_with(end.code)
        raise


def _end_with(code: int) -> None:
    """End the process with that exit code, also where the interpreter would end it by SIGINT.

    It would where Ctrl-C or SIGTERM came while an extension ran Python text of its own (CPython,
    `run_eval_code_obj`). Functions registered with `atexit` run first, so that no semaphore of worker
    processes is left.
    """
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):
            stream.flush()
    os._exit(code)


if __name__ == "__main__":
    main()
