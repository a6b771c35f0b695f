"""One file a command: `add_arguments(parser, rest)` and `run(arguments, console)`."""

from __future__ import annotations
