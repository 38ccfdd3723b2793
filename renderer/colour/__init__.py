"""Spectra, bands and colour; colour-science's plots, which it imports with itself, wait until first used."""

import sys
from importlib import import_module
from types import ModuleType

PLOTS = "colour.plotting"
"""Brings matplotlib.pyplot: as long to import as the rest of the package, and no command of ours plots so."""


def _put_off() -> None:
    """Let a stand-in be imported for the plots, which gives way to them when it is asked for anything."""
    later = ModuleType(PLOTS)

    def load(name: str):
        if sys.modules.get(PLOTS) is later:
            del sys.modules[PLOTS]
        return getattr(import_module(PLOTS), name)

    later.__getattr__ = load
    sys.modules[PLOTS] = later


if "colour" not in sys.modules:
    _put_off()
