"""Files in and out: the five functions of the front door, and the sheets of all formats.

    samples = read_samples("krylon_blue.astm")      # content is sniffed
    table = read_table("alum-bronze.binary")
    write_table(table, "out.binary")                # the suffix names the format
    write_samples(samples, "out.csv")
    list_formats()                                  # the data sheets

Each format is a folder that offers one `FormatSheet`; nothing outside this package knows
which formats there are.
"""

from __future__ import annotations

from brdfit.formats._registry import (
    list_formats,
    read_samples,
    read_table,
    write_samples,
    write_table,
)
from brdfit.formats.sheet import FormatSheet

__all__ = [
    "FormatSheet",
    "list_formats",
    "read_samples",
    "read_table",
    "write_samples",
    "write_table",
]
