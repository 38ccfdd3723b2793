"""Errors with which a run ends, and the warning with which it goes on. Each message is one sentence and its
remedy."""


class InputError(Exception):
    """The input is wrong. The message names the file, the key, its value, the values allowed and the
    remedy."""


class SolveError(Exception):
    """The scene is well formed but has no answer (no steady state, too large for the memory)."""


class OutputError(Exception):
    """A result cannot be written though its folder can: the disk is full, or fails."""


class DisplayError(Exception):
    """There is no display to open a window on."""


class CacheWarning(UserWarning):
    """The cache cannot be read or written; the run computes its contents again."""
