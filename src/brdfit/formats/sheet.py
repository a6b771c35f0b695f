"""The data sheet of a format, and what a reader is handed.

Each folder `formats/<name>/` offers one `SHEET`. The core never names a format: the registry
collects the sheets, sniffs content, and calls what the sheet offers. The support table in
the docs is generated from the sheets.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from brdfit.grid import Grid
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["HEAD_BYTES", "FormatSheet"]

HEAD_BYTES = 8192
"""How much of a file a `sniff` sees."""


@dataclass(frozen=True)
class FormatSheet:
    """What a format is, how to recognise it, and what can be done with it.

    `sniff(path, head)` gets the path (for its size and suffix only) and the first
    `HEAD_BYTES` bytes, and answers whether the content is of this format; it is cheap and
    never raises. Readers take the path and keyword options; those of a format are explicit
    keywords, an unknown one is the registry's error. Writers take (object, path) and write
    atomically.
    """

    name: str
    """Short name, also the value of --format: "merl", "astm", ..."""
    title: str
    """One line for a person."""
    extensions: tuple[str, ...]
    """Suffixes with the dot, lower case; the first is the usual one."""
    specification: str
    """Where the format is described: citation or URL."""
    convention: str
    """Angles, units, cosine, and which vector is the light, in one sentence."""
    sniff: Callable[[Path, bytes], bool]
    read_samples: Callable[..., Samples] | None = None
    read_table: Callable[..., Table] | None = None
    write_samples: Callable[[Samples, Path], Any] | None = None
    write_table: Callable[[Table, Path], Any] | None = None
    options: tuple[str, ...] = ()
    """Keyword options that the readers take, by name."""
    loses: str = ""
    """What writing this format loses (channels, resolution, precision); empty = nothing."""
    precision: float = 0.0
    """Largest relative error of a value that is written and read back, at directions that the
    file holds; 0 = every bit."""
    averages: bool = False
    """A written value is a mean over a patch of directions, or is found between nodes of the
    format's own: `precision` is then that of the median value of a smooth material."""
    colour: Literal["any", "grey or RGB", "RGB"] = "any"
    """Which channels a table must have to be written; the command line converts to them."""
    grid: Grid | None = None
    """The only grid on which tables are written, or None for any."""
    competes_for: tuple[str, ...] = ()
    """Other formats that use the same suffix, so that errors can name them."""
