"""The spectra of one file, and the choice of one of them."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class SpectralTable:
    """The spectra of a file.

    nm : (n,) [nm], ascending
    values : (n, k) one column a spectrum
    names : (k,) of the spectra, "" for none
    numbers : (k,) of the spectra, as the file counts its rows or columns
    """

    nm: np.ndarray
    values: np.ndarray
    names: list[str]
    numbers: list[int]

    def column(self, wanted: str | None) -> tuple[np.ndarray, np.ndarray]:
        """Wavelengths (m,) [nm] and values (m,) of one spectrum, without blank cells at its ends.

        wanted : name or number of the spectrum; None for the only one
        Raises ValueError; the message completes a sentence that begins with the file's name.
        """
        values = self.values[:, self._place(wanted)]
        there = np.flatnonzero(np.isfinite(values))
        if not len(there):
            raise ValueError("has no numbers in that spectrum. Choose another")
        kept = slice(there[0], there[-1] + 1)
        nm, values = self.nm[kept], values[kept]
        gaps = nm[~np.isfinite(values)]
        if len(gaps):
            raise ValueError(f"has no number at {gaps[0]:g} nm in that spectrum. Write it, or remove that "
                             "row")
        return nm, values

    def _place(self, wanted: str | None) -> int:
        """Index of the spectrum of a name or number."""
        listed = ", ".join(f"#{k} {name}".rstrip()
                           for k, name in zip(self.numbers[:12], self.names, strict=False))
        listed += " …" if len(self.names) > 12 else ""
        if wanted is None:
            if len(self.names) > 1:
                raise ValueError(f"has {len(self.names)} spectra: {listed}. Choose one by its number or "
                                 f"name, as FILE#{self.numbers[0]}")
            return 0
        if wanted.isascii() and wanted.isdigit() and int(wanted) in self.numbers:
            return self.numbers.index(int(wanted))
        named = [k for k, name in enumerate(self.names) if name.casefold() == wanted.strip().casefold()]
        if len(named) != 1:
            raise ValueError(f"has {len(named) or 'no'} spectra named {wanted[:40]!r}; it has {listed}. "
                             "Give the number or name of one")
        return named[0]


def sorted_table(nm: np.ndarray, values: np.ndarray, names: list[str], numbers: list[int]) -> SpectralTable:
    """A table of ascending wavelengths. Raises ValueError for two equal ones.

    Names that are whole numbers replace the file's count of its rows or columns: #5 is the spectrum named 5.
    """
    if len(names) > 1 and len(set(names)) == len(names) and all(
            name.isascii() and name.isdigit() and len(name) < 10 for name in names):
        names, numbers = [""] * len(names), [int(name) for name in names]
    order = np.argsort(nm, kind="stable")
    nm, values = nm[order], values[order]
    twice = np.flatnonzero(np.diff(nm) <= 0)
    if len(twice):
        raise ValueError(f"has the wavelength {nm[twice[0]]:g} nm twice. Remove one of them")
    return SpectralTable(nm, values, names, numbers)
