"""Numbers as bytes in a page: quantised, put in order for the compressor, compressed, as base64.

    whole numbers : exact
    reals : single precision, 6e-8
    logarithms : 16 bits over the span of the values, see `ERROR`
    shapes : a matrix as its rows' sizes times a few curves, within `CURVES`
"""

import base64
import zlib

import numpy as np

SPAN = 1e-9
"""Values below this share of the largest are stored as 0."""
ERROR = float(-np.log(SPAN)) / 65534 / 2
"""Largest relative error of a number stored as its logarithm: 1.6e-4."""
CURVES = 1e-4
"""Largest error of a row that is made up of a few curves, relative to the row's own largest value."""


class Pack:
    """Arrays one after another in one stream of bytes; each `add` returns what finds its array again."""

    def __init__(self):
        self._parts: list[bytes] = []
        self._length = 0

    def whole(self, values: np.ndarray) -> dict:
        """Add whole numbers from 0 to 2³² − 1, as differences: neighbours are alike."""
        values = np.asarray(values).ravel()
        kind = "<u2" if not len(values) or values.max() < 1 << 16 else "<u4"
        coded = values.astype(kind)
        return self._add(np.diff(coded, prepend=np.zeros(1, kind)), {"kind": kind[1:]})

    def reals(self, values: np.ndarray) -> dict:
        """Add real numbers in single precision."""
        return self._add(np.asarray(values).ravel().astype("<f4"), {"kind": "f4"})

    def logarithms(self, values: np.ndarray) -> dict:
        """Add numbers from 0, within `ERROR` of each; 0 stays 0."""
        values = np.asarray(values, dtype=float).ravel()
        top = float(values.max(initial=0.0))
        code = np.zeros(len(values))
        kept = values > SPAN * top
        code[kept] = 1 + np.rint(np.log(values[kept] / (SPAN * top)) * (65534 / -np.log(SPAN)))
        return {**self.whole(code), "top": top, "span": SPAN}

    def curves(self, rows: np.ndarray) -> dict:
        """Add a matrix (n, k) of numbers from 0 as sizes (n,) × parts (n, m) × curves (m, k), m as few as
        `CURVES` allows."""
        size = rows.max(axis=1, initial=0.0)
        shape = rows / np.where(size > 0, size, 1.0)[:, None]
        _, _, found = np.linalg.svd(shape.T @ shape)
        for m in range(1, len(found) + 1):
            parts = shape @ found[:m].T
            low = parts.min(axis=0, initial=0.0)
            step = np.maximum(parts.max(axis=0, initial=0.0) - low, 1e-30) / 65535
            code = np.rint((parts - low) / step)
            if np.abs((low + code * step) @ found[:m] - shape).max(initial=0.0) <= CURVES:
                break
        return {"size": self.reals(size), "parts": [self.whole(column) for column in code.T],
                "low": low.tolist(), "step": step.tolist(), "curves": found[:m].tolist()}

    def base64(self) -> str:
        """Everything added."""
        return base64.b64encode(zlib.compress(b"".join(self._parts), 9)).decode()

    def _add(self, values: np.ndarray, how: dict) -> dict:
        # Byte by byte: all the first bytes, then all the second, which look more alike.
        data = values.view(np.uint8).reshape(-1, values.itemsize).T.tobytes()
        found = {**how, "at": self._length, "n": len(values)}
        self._parts.append(data)
        self._length += len(data)
        return found
