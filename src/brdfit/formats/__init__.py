"""Files in and out: the functions of the front door, and the sheets of all formats.

    samples = read_samples("krylon_blue.astm")      # content is sniffed
    table = read_table("alum-bronze.binary")
    write_table(table, "out.binary")                # the suffix names the format
    write_samples(samples, "out.csv")
    list_formats()                                  # the data sheets
    format_to_write("out.bsdf", format="zemax")     # the one that would write a file

Each format is a folder that offers one `FormatSheet`; nothing outside this package knows
which formats there are.
"""

from __future__ import annotations

from brdfit.formats._registry import (
    format_to_write,
    list_formats,
    read_samples,
    read_table,
    rivals,
    write_samples,
    write_table,
)
from brdfit.formats.sheet import FormatSheet

__all__ = [
    "FormatSheet",
    "format_to_write",
    "list_formats",
    "read_samples",
    "read_table",
    "rivals",
    "write_samples",
    "write_table",
]
