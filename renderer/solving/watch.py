"""Progress of a long reading, and what an interruption keeps of it."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass
class Watch:
    """The watch over one run's readings.

    say : called with a sentence on what is left
    keep : whether Ctrl-C ends the readings with the bars reached so far, once each has one, instead of the
        run
    stopped : whether it has done so
    """

    say: Callable[[str], None] = lambda step: None
    keep: bool = False
    stopped: bool = False

    def tell(self, widest: float, asked: float, seconds: float) -> None:
        """Say what is left until the bars are narrow enough, where that takes a second or more.

        widest : largest bar over what it may be; asked : accuracy [1]; seconds : approximate time left
        """
        if seconds >= 1:
            self.say(f"error bars {_percent(widest * asked)}, {_percent(asked)} asked; {seconds:.0f} s left")

    def stop(self, known: bool) -> None:
        """Handle a KeyboardInterrupt: raise it again where nothing is known yet or nothing is to be kept."""
        if not (self.keep and known):
            raise KeyboardInterrupt
        self.stopped = True


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"
