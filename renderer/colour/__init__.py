"""Spectra, bands and colour.

colour-science imports its plots and matplotlib.pyplot, which take as long as all its other modules and are
not used here. This module delays both until first use.
"""

import sys
from importlib import import_module
from types import ModuleType


def _import_on_first_use(module: str) -> None:
    """Put a stand-in for a module in place, which imports the module when an attribute is first looked up."""
    later = ModuleType(module)

    def load(name: str):
        if sys.modules.get(module) is later:
            del sys.modules[module]
        return getattr(import_module(module), name)

    later.__getattr__ = load
    sys.modules[module] = later


if "colour" not in sys.modules:
    _import_on_first_use("colour.plotting")
