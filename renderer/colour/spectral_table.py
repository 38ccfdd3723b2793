"""Spectra of one file, side by side, and the choice of one of them."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class SpectralTable:
    """Spectra of a file, side by side.

    nm : (n,) [nm], ascending; values : (n, k); names : of each (k,); numbers : how each is counted in the
    file (k,)
    """

    nm: np.ndarray
    values: np.ndarray
    names: list[str]
    numbers: list[int]

    def column(self, wanted: str | None) -> np.ndarray:
        """The one spectrum (n,), or that of a name or number. Raises ValueError with a sentence."""
        listed = ", ".join(f"#{k} {name}".rstrip()
                           for k, name in zip(self.numbers[:12], self.names, strict=False))
        listed += " …" if len(self.names) > 12 else ""
        if wanted is None:
            if len(self.names) > 1:
                raise ValueError(f"has {len(self.names)} spectra: {listed}. Choose one by its number or "
                                 f"name, as "
                                 f"FILE#{self.numbers[0]}")
            return self.values[:, 0]
        if wanted.isascii() and wanted.isdigit() and int(wanted) in self.numbers:
            return self.values[:, self.numbers.index(int(wanted))]
        named = [k for k, name in enumerate(self.names) if name.casefold() == wanted.strip().casefold()]
        if len(named) != 1:
            raise ValueError(f"has {len(named) or 'no'} spectra named {wanted[:40]!r}; it has {listed}. "
                             f"Give the "
                             "number or name of one")
        return self.values[:, named[0]]


def sorted_table(nm: np.ndarray, values: np.ndarray, names: list[str], numbers: list[int]) -> SpectralTable:
    """A table with ascending wavelengths. Raises ValueError where one is there twice."""
    order = np.argsort(nm, kind="stable")
    nm, values = nm[order], values[order]
    twice = np.flatnonzero(np.diff(nm) <= 0)
    if len(twice):
        raise ValueError(f"has the wavelength {nm[twice[0]]:g} nm twice. Remove one of them")
    return SpectralTable(nm, values, names, numbers)
