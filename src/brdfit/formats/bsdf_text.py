"""Text files made of keywords, each followed by its words, and of blocks of numbers.

Zemax's and LightTools' tabular BSDF are such files: `ScatterRadial 3` and then three numbers,
wherever the lines end. A line that begins with # is a comment.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile
from brdfit.formats.text import TextFile

__all__ = ["Words"]

_MOST_ANGLES = 100_000


class Words:
    """The words of a file one after the other, with the lines they stand in for messages."""

    def __init__(self, text: TextFile) -> None:
        self.name = text.name
        self._words: list[str] = []
        self._lines: list[int] = []
        for number, line in text.lines:
            if not line.lstrip().startswith("#"):
                found = line.split()
                self._words += found
                self._lines += [number] * len(found)
        self._at = 0

    @property
    def left(self) -> bool:
        """Whether there is another word."""
        return self._at < len(self._words)

    @property
    def where(self) -> str:
        """The file and the line of the next word."""
        if not self._lines:
            return f"{self.name}, line 1"
        return f"{self.name}, line {self._lines[min(self._at, len(self._lines) - 1)]}"

    def peek(self) -> str:
        """Return the next word without taking it; empty at the end."""
        return self._words[self._at] if self.left else ""

    def take(self, what: str) -> str:
        """Return the next word; `what` says what was expected if there is none."""
        if not self.left:
            raise CorruptFile(
                f"{self.where}: the file ends where {what} was expected. It looks truncated; "
                f"copy or export it again."
            )
        self._at += 1
        return self._words[self._at - 1]

    def expect(self, keyword: str) -> None:
        """Take the next word, which must be `keyword` in any case."""
        where = self.where
        found = self.take(keyword)
        if found.lower() != keyword.lower():
            raise CorruptFile(f"{where}: found {found[:40]!r} but {keyword} was expected.")

    def one_of(self, keyword: str, allowed: Sequence[str]) -> str:
        """Return the next word as written in `allowed`, whatever its case."""
        where = self.where
        found = self.take(f"the value of {keyword}")
        for word in allowed:
            if word.lower() == found.lower():
                return word
        raise CorruptFile(
            f"{where}: {keyword} is {found[:40]!r} but one of {', '.join(allowed)} was expected."
        )

    def numbers(self, count: int, what: str) -> FloatArray:
        """Return the next `count` numbers (count,)."""
        where, found = self.where, self._words[self._at : self._at + count]
        if len(found) < count:
            raise CorruptFile(
                f"{where}: {count} numbers were expected ({what}) but the file ends after "
                f"{len(found)} words. It looks truncated; copy or export it again."
            )
        try:
            values = np.array(found, dtype=np.float64)
        except ValueError as error:
            raise CorruptFile(
                f"{where}: {count} numbers were expected ({what}) but a word among them is none "
                f"({error}). A row is too short or too long, or the file is damaged."
            ) from error
        self._at += count
        return values

    def number(self, what: str) -> float:
        """Return the next word as a number."""
        return float(self.numbers(1, what)[0])

    def angles(self, keyword: str, highest: float) -> FloatArray:
        """Return the list of `keyword`: a count and then that many degrees in [0, highest]."""
        where = self.where
        count = self.number(f"the number of {keyword}")
        if not (1 <= count <= _MOST_ANGLES and count == int(count)):
            raise CorruptFile(
                f"{where}: {keyword} announces {count:g} angles but a whole number from 1 was "
                f"expected."
            )
        angles = self.numbers(int(count), f"the angles of {keyword}")
        if not ((angles >= 0.0) & (angles <= highest)).all():
            raise CorruptFile(
                f"{where}: the angles of {keyword} must be degrees from 0 to {highest:g} but they "
                f"are {angles.min():g} to {angles.max():g}."
            )
        return angles
