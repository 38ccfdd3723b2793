"""The log of a run's steps and their seconds, through Python's `logging`: silent by default."""

import logging
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

LOGGER = logging.getLogger("renderer")
LOG_LEVELS = ("debug", "info", "warning")
"""Levels that `--log-level` may be given."""


@contextmanager
def logged(step: str) -> Iterator[None]:
    """Log a step with its seconds at level INFO when it ends."""
    started = time.perf_counter()
    yield
    LOGGER.info("%s: %.3f s", step, time.perf_counter() - started)


def show_log(level: str) -> None:
    """Show log messages of at least that level (one of LOG_LEVELS) on stderr."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("renderer: %(levelname)s: %(message)s"))
    LOGGER.handlers = [handler]
    LOGGER.setLevel(level.upper())
