"""Arrays of numbers stored in a page: quantised, reordered, compressed, in base64.

    whole numbers : exact
    reals : single precision, 6e-8
    logarithms : 16 bits over the range of the values, within LOGARITHM_ERROR
    curves : a matrix as the sizes of its rows times a few curves, within CURVE_ERROR
"""

import base64
import zlib

import numpy as np

LOGARITHM_SPAN = 1e-9
"""Smallest stored value, relative to the largest; smaller ones are stored as 0."""
LOGARITHM_ERROR = float(-np.log(LOGARITHM_SPAN)) / 65534 / 2
"""Largest relative error of a number stored as its logarithm: 1.6e-4."""
CURVE_ERROR = 1e-4
"""Largest error of a row stored as a sum of curves, relative to the row's largest value."""


class Pack:
    """Arrays in one stream of bytes. Each method that adds an array returns the record with which the page
    reads it."""

    def __init__(self):
        self._parts: list[bytes] = []
        self._length = 0

    def whole(self, values: np.ndarray) -> dict:
        """Add whole numbers from 0 to 2³² − 1, as differences from their predecessors."""
        values = np.asarray(values).ravel()
        kind = "<u2" if not len(values) or values.max() < 1 << 16 else "<u4"
        coded = values.astype(kind)
        return self._add(np.diff(coded, prepend=np.zeros(1, kind)), {"kind": kind[1:]})

    def reals(self, values: np.ndarray) -> dict:
        """Add real numbers in single precision."""
        return self._add(np.asarray(values).ravel().astype("<f4"), {"kind": "f4"})

    def logarithms(self, values: np.ndarray) -> dict:
        """Add non-negative numbers with the relative error LOGARITHM_ERROR; 0 stays 0."""
        values = np.asarray(values, dtype=float).ravel()
        top = float(values.max(initial=0.0))
        code = np.zeros(len(values))
        kept = values > LOGARITHM_SPAN * top
        code[kept] = 1 + np.rint(
            np.log(values[kept] / (LOGARITHM_SPAN * top)) * (65534 / -np.log(LOGARITHM_SPAN))
        )
        return {**self.whole(code), "top": top, "span": LOGARITHM_SPAN}

    def curves(self, rows: np.ndarray) -> dict:
        """Add a matrix (n, k) of non-negative numbers as sizes (n,) × parts (n, m) × curves (m, k), with the
        least m that CURVE_ERROR allows."""
        size = rows.max(axis=1, initial=0.0)
        shape = rows / np.where(size > 0, size, 1.0)[:, None]
        _, _, found = np.linalg.svd(shape.T @ shape)
        for m in range(1, len(found) + 1):
            parts = shape @ found[:m].T
            low = parts.min(axis=0, initial=0.0)
            step = np.maximum(parts.max(axis=0, initial=0.0) - low, 1e-30) / 65535
            code = np.rint((parts - low) / step)
            if np.abs((low + code * step) @ found[:m] - shape).max(initial=0.0) <= CURVE_ERROR:
                break
        return {"size": self.reals(size), "parts": [self.whole(column) for column in code.T],
                "low": low.tolist(), "step": step.tolist(), "curves": found[:m].tolist()}

    def base64(self) -> str:
        """All arrays as base64."""
        return base64.b64encode(zlib.compress(b"".join(self._parts), 9)).decode()

    def _add(self, values: np.ndarray, how: dict) -> dict:
        # All first bytes, then all second bytes, and so on: they compress better.
        data = values.view(np.uint8).reshape(-1, values.itemsize).T.tobytes()
        found = {**how, "at": self._length, "n": len(values)}
        self._parts.append(data)
        self._length += len(data)
        return found
