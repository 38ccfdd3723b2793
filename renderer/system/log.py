"""The steps of a run and their seconds, through Python's logging: nothing is shown unless it is asked for."""

import logging
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

LOGGER = logging.getLogger("renderer")
LOG_LEVELS = ("debug", "info", "warning")


@contextmanager
def logged(step: str) -> Iterator[None]:
    """Log a step with its seconds at level INFO as it ends."""
    started = time.perf_counter()
    yield
    LOGGER.info("%s: %.3f s", step, time.perf_counter() - started)


def show_log(level: str) -> None:
    """Show steps of at least that level (one of LOG_LEVELS) on stderr."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("renderer: %(levelname)s: %(message)s"))
    LOGGER.handlers = [handler]
    LOGGER.setLevel(level.upper())
