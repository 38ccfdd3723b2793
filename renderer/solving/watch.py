"""Progress of long readings, and the handling of an interruption."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass
class Watch:
    """Reports the progress of one run's readings, and decides what an interruption ends.

    say : called with a sentence on the remaining work
    keep : whether Ctrl-C ends only the readings, with the error bars reached so far, once each has one; else
      it ends the run
    stopped : whether Ctrl-C has ended the readings
    """

    say: Callable[[str], None] = lambda step: None
    keep: bool = False
    stopped: bool = False

    def tell(self, widest: float, asked: float, seconds: float) -> None:
        """Report the remaining work, where it takes a second or more.

        widest : largest ratio of an error bar to its limit; asked : requested accuracy [1]
        seconds : approximate time left
        """
        if seconds >= 1:
            self.say(f"error bars {_percent(widest * asked)}, {_percent(asked)} requested; {seconds:.0f} s "
                     "left")

    def stop(self, known: bool) -> None:
        """Handle a KeyboardInterrupt: raise it again where there are no readings yet, or they are not to be
        kept."""
        if not (self.keep and known):
            raise KeyboardInterrupt
        self.stopped = True


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"
