"""The TOML file beside a data file that declares its columns."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from brdfit.errors import UsageError

__all__ = ["find_sidecar", "read_sidecar"]


def find_sidecar(path: Path) -> Path | None:
    """Return `name.csv.toml`, else `name.toml`, where there is one beside `name.csv`."""
    for beside in (path.with_name(f"{path.name}.toml"), path.with_suffix(".toml")):
        if beside != path and beside.is_file():
            return beside
    return None


def read_sidecar(path: Path) -> tuple[dict[str, Any], str]:
    """Return (the keys of the sidecar of `path`, its name); ({}, "") without one."""
    beside = find_sidecar(path)
    if beside is None:
        return {}, ""
    try:
        return tomllib.loads(beside.read_text(encoding="utf-8-sig")), beside.name
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise UsageError(
            f"{beside.name}: is not valid TOML ({error}), but it should declare the columns of "
            f"{path.name}. Write strings in quotes and lists in brackets."
        ) from error
    except OSError as error:
        raise UsageError(f"{beside.name}: cannot be read: {error.strerror or error}.") from error
