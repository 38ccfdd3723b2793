"""What a long reading says while it lasts, and what an interruption leaves of it."""

from collections.abc import Callable
from dataclasses import dataclass

SAID_FROM = 1.0
"""Seconds left from which a reading says how far it is."""


@dataclass
class Watch:
    """Of one run's readings.

    say : told in a sentence how far they are; keep : whether Ctrl-C ends them with the bars reached so far,
    where each has one, instead of the run; stopped : whether it did
    """

    say: Callable[[str], None] = lambda step: None
    keep: bool = False
    stopped: bool = False

    def tell(self, widest: float, asked: float, seconds: float) -> None:
        """Say what is left to the bar, if that is a second or more.

        widest : bar over what it may be; asked : accuracy [1]; seconds : what the next paths take, about
        """
        if seconds >= SAID_FROM:
            self.say(f"bars at {_percent(widest * asked)} of {_percent(asked)}, some {seconds:.0f} s more")

    def stop(self, known: bool) -> None:
        """Take a KeyboardInterrupt: raise it on where nothing is known yet or nothing is to be kept."""
        if not (self.keep and known):
            raise KeyboardInterrupt
        self.stopped = True


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"
