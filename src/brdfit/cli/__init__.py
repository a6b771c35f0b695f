"""The command line: a thin client of the package. One file a command.

    parser      what may be typed, with suggestions for what was mistyped
    program     `main`: run a command, turn errors into messages and exit codes
    console     what a command may say, and the progress bar
    settings    options of a method, made from the fields of its dataclass
    declaration options that say what the columns of a file mean

Every command module has `add_arguments(parser, rest)` and `run(arguments, console)`. It is
imported when its command is named, so that `brdfit --help` imports nothing heavy.
"""

from __future__ import annotations

from brdfit.cli.program import main as main

__all__ = ["main"]
