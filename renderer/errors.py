"""The ways a run can refuse, each one sentence long."""


class InputError(Exception):
    """The input is wrong: the message names what, where, the value, what is allowed, the remedy."""


class SolveError(Exception):
    """The scene is well formed but has no answer (no steady state, too large for the memory)."""


class OutputError(Exception):
    """A result cannot be written though its folder can: the disk is full, or fails."""


class DisplayError(Exception):
    """There is no display to open a window on."""


class CacheWarning(UserWarning):
    """Something kept between runs is of no use; the run goes on without it."""
