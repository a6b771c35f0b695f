"""What is kept of every item: names, types and meanings of the arrays of a store."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import IntArray
from brdfit.batch.source import Part
from brdfit.reconstruct import Outcome
from brdfit.reconstruct.compact import BlockResult

__all__ = ["FAILED", "FIELDS", "OUTCOMES", "Field", "PartResult", "words", "words_array"]

OUTCOMES = (
    Outcome.CONVERGED,
    Outcome.ITERATION_LIMIT,
    Outcome.TOO_FEW_SAMPLES,
    Outcome.MOSTLY_OUTLIERS,
)
"""Code - 1 -> how a fit ended."""
FAILED = 255
"""Code of an item that could not be fitted; its message says why. 0: not done yet."""
_MESSAGE = 240


@dataclass(frozen=True)
class Field:
    """One array of a store: the first axis is the items."""

    name: str
    dtype: str
    fill: float
    meaning: str


FIELDS = (
    Field("coefficients", "float32", np.nan, "(channels, 1 + k): of [tau | B], see basis"),
    Field("outcome", "uint8", 0, "how the fit ended: attribute outcomes; 255 failed, 0 not done"),
    Field("samples", "int32", 0, "usable samples"),
    Field("outliers", "int32", 0, "of them, more likely wrong than right"),
    Field("noise", "float32", np.nan, "relative noise of a good sample, ln f_r"),
    Field("outlier_share", "float32", np.nan, "share of outliers, estimated"),
    Field("deviation", "float32", np.nan, "standard deviation of ln f_r, rms over direction pairs"),
    Field("position", "float32", np.nan, "(2,): pixel column and row"),
    Field("name", "uint8", 0, "(width,): UTF-8, filled up with 0"),
    Field("message", "uint8", 0, f"({_MESSAGE},): why it failed, UTF-8, filled up with 0"),
)


@dataclass(frozen=True, eq=False)
class PartResult:
    """The arrays of some items, ready to be written."""

    start: int
    arrays: dict[str, np.ndarray]

    @classmethod
    def of(
        cls, start: int, part: Part, found: BlockResult | None, shape: tuple[int, int], width: int
    ) -> PartResult:
        """Gather what became of a part: its readable items were fitted, in order."""
        n = len(part)
        arrays = {
            "coefficients": np.full((n, *shape), np.nan, dtype=np.float32),
            "position": part.positions().astype(np.float32),
            "name": words_array(part.names, width),
        }
        for name, dtype, fill in (
            ("outcome", np.uint8, FAILED),
            ("samples", np.int32, 0),
            ("outliers", np.int32, 0),
            ("noise", np.float32, np.nan),
            ("outlier_share", np.float32, np.nan),
            ("deviation", np.float32, np.nan),
        ):
            arrays[name] = np.full(n, fill, dtype=dtype)
        problems = dict(part.problems)
        if found is not None:
            where = np.array(part.where, dtype=np.int64)
            _enter(arrays, where, found)
            problems |= {part.where[item]: text for item, text in found.failures.items()}
        if problems:  # where there is none the store has its fill value without being told
            texts = [problems.get(item, "") for item in range(n)]
            arrays["message"] = words_array(texts, _MESSAGE)
        return cls(start, arrays)

    def __len__(self) -> int:
        return len(self.arrays["outcome"])

    @property
    def failed(self) -> Iterator[tuple[str, str]]:
        """Yield (name, why) of the items that could not be fitted."""
        for item in np.flatnonzero(self.arrays["outcome"] == FAILED):
            yield words(self.arrays["name"][item]), words(self.arrays["message"][item])


def _enter(arrays: dict[str, np.ndarray], where: IntArray, found: BlockResult) -> None:
    arrays["coefficients"][where] = found.coefficients
    arrays["samples"][where] = found.used
    for name in ("outliers", "noise", "outlier_share", "deviation"):
        arrays[name][where] = getattr(found, name)
    codes = [FAILED if o is None else 1 + OUTCOMES.index(o) for o in found.outcomes]
    arrays["outcome"][where] = codes


def words_array(texts: list[str], width: int) -> np.ndarray:
    """Return texts as UTF-8 (n, width), filled up with 0, cut where they are too long."""
    result = np.zeros((len(texts), width), dtype=np.uint8)
    for row, text in zip(result, texts, strict=True):
        encoded = text.encode()[:width]
        encoded = encoded.decode(errors="ignore").encode()  # not in the middle of a letter
        row[: len(encoded)] = np.frombuffer(encoded, dtype=np.uint8)
    return result


def words(row: np.ndarray) -> str:
    """Return the text of a row of `words_array`."""
    return bytes(row).rstrip(b"\0").decode()
