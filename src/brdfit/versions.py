"""Which versions made a result: what every record, page and file says of itself."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

__all__ = ["version_of", "versions_of"]


def version_of(package: str = "brdfit") -> str:
    """Return the version of an installed package, or that it is not installed.

    brdfit itself is not where it runs from a source tree.
    """
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def versions_of(*packages: str) -> dict[str, str]:
    """Return the versions of Python and of packages, by name."""
    return {"python": platform.python_version()} | {p: version_of(p) for p in packages}
