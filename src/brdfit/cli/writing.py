"""The option that names the format of an output, for every command that writes one."""

from __future__ import annotations

import argparse

__all__ = ["add_output_format"]


def add_output_format(parser: argparse.ArgumentParser) -> None:
    """Add --to; the value is a name of a format or None, checked by `format_to_write`."""
    parser.add_argument(
        "--to",
        metavar="FORMAT",
        help="Format of the output by name, where the suffix names none or not the one that is "
        "meant: rgl (default), zemax or lighttools for .bsdf; tensortree (default) or klems for "
        ".xml.",
    )
