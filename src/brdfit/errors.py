"""The error tree: every exception that brdfit raises on purpose.

    BrdfitError
    ├── UsageError            an argument or option that cannot mean anything
    ├── SampleError           measurements that cannot be used as they are
    ├── FormatError           a file
    │   ├── NotThisFormat     a reader declines: the file is of another format
    │   ├── UnknownFormat     no reader recognises the file
    │   └── CorruptFile       the format is right, the content is damaged
    ├── PopulationError       a population is missing, altered or unreadable
    ├── FitError              a fit cannot start or has no result
    └── MissingExtra          an optional dependency is not installed

and the warnings, for what is legal but probably not what was wanted:

    BrdfitWarning
    ├── ConventionWarning     the data contradict the declared convention
    ├── DataQualityWarning    samples were flagged, few, or without coverage
    └── FitWarning            a fit ended in a way that wants attention

A message says what was found, what was expected, where, and what to do next.
Catching `BrdfitError` catches everything that is not a defect of brdfit.
"""

from __future__ import annotations

__all__ = [
    "BrdfitError",
    "BrdfitWarning",
    "ConventionWarning",
    "CorruptFile",
    "DataQualityWarning",
    "FitError",
    "FitWarning",
    "FormatError",
    "MissingExtra",
    "NotThisFormat",
    "PopulationError",
    "SampleError",
    "UnknownFormat",
    "UsageError",
]


class BrdfitError(Exception):
    """Base of every error that brdfit raises on purpose."""


class UsageError(BrdfitError, ValueError):
    """An argument or option that cannot mean anything; names the allowed values."""


class SampleError(BrdfitError, ValueError):
    """Measurements that cannot be used as they are (shapes, none usable, ...)."""


class FormatError(BrdfitError):
    """Something is wrong with a file."""


class NotThisFormat(FormatError):
    """Raised by a reader that declines a file, so that the next reader may try."""


class UnknownFormat(FormatError):
    """No reader recognises the file; the message lists what was tried and why not."""


class CorruptFile(FormatError):
    """The format was recognised but the content is damaged or incomplete."""


class PopulationError(BrdfitError):
    """A population of materials is missing, altered or unreadable."""


class FitError(BrdfitError):
    """A fit cannot start or cannot give a result."""


class MissingExtra(BrdfitError, ImportError):
    """An optional dependency is not installed.

    Parameters: `package`, what was to be imported; `extra`, the optional extra of
    brdfit that brings it; `purpose`, what it is needed for.
    """

    def __init__(self, package: str, extra: str, purpose: str) -> None:
        self._arguments = (package, extra, purpose)
        super().__init__(
            f"{purpose} needs the package {package!r}, which is not installed. "
            f'Install it with: python -m pip install "brdfit[{extra}]"'
        )

    def __reduce__(self) -> tuple[type[MissingExtra], tuple[str, str, str]]:
        # The message alone would not rebuild it on its way between processes.
        return type(self), self._arguments


class BrdfitWarning(UserWarning):
    """Base of every warning that brdfit gives."""


class ConventionWarning(BrdfitWarning):
    """The data contradict the convention that was declared or guessed."""


class DataQualityWarning(BrdfitWarning):
    """Samples were flagged, are few, or leave much of the domain uncovered."""


class FitWarning(BrdfitWarning):
    """A fit ended in a way that wants attention; the outcome's advice says what."""
