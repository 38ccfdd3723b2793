"""Spectra, bands and colour.

colour-science imports its plots, and with them matplotlib.pyplot, which takes as long as all the rest; no
command here uses them. They are imported on first use.
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
