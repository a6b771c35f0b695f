"""From a name or a path to a population."""

from __future__ import annotations

import os
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path

from brdfit.errors import PopulationError
from brdfit.populations.cache import cache_folder
from brdfit.populations.contract import MemberSource, Population
from brdfit.populations.published import published_fits

__all__ = ["NAMES", "fetched_archive", "population"]

NAMES = ("published", "nbrdf")
"""The populations that have a name; others are a path."""


def population(name_or_path: str | os.PathLike[str] | Population) -> Population:
    """Return all members of a population.

    Parameters
    ----------
    name_or_path
        "published" (comes with brdfit), "nbrdf" (needs `brdfit basis fetch nbrdf` once),
        the path of an archive of networks (.zip), or of a folder of MERL `.binary` files.
        A `Population` is returned as it is.

    Raises `PopulationError` where there is no such population, naming those there are.
    """
    if isinstance(name_or_path, Population):
        return name_or_path
    name = os.fspath(name_or_path)
    if name == "published":
        return Population.of(published_fits())
    if name == "nbrdf":
        return Population.of(_networks(fetched_archive(), "nbrdf"))
    path = Path(name).expanduser()
    if path.is_dir():
        raise PopulationError(f"{path}: folders come next.")
    if path.is_file():
        return Population.of(_networks(path, path.name))
    raise PopulationError(_unknown(name))


def fetched_archive() -> Path:
    """Return where the archive of networks is kept once it is fetched."""
    return cache_folder("fetched") / "merl_nbrdf.zip"


def _networks(path: Path, name: str) -> MemberSource:
    try:
        status = path.stat()
    except FileNotFoundError as error:
        raise PopulationError(
            f"population {name!r} is not on this machine. Fetch it (0.5 MB, MIT licence) with: "
            f"brdfit basis fetch nbrdf. Or give the path of the archive merl_nbrdf.zip."
        ) from error
    return _read_networks(path, name, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=4)
def _read_networks(path: Path, name: str, changed: int, size: int) -> MemberSource:
    # h5py is only wanted by those who use networks
    from brdfit.populations.nbrdf import read_nbrdf

    return read_nbrdf(path, name)


def _unknown(name: str) -> str:
    near = get_close_matches(name, NAMES, n=1)
    hint = f" Did you mean {near[0]!r}?" if near else ""
    return (
        f"population {name!r}: found neither a population of that name nor a file or folder. "
        f"There are {', '.join(NAMES)}, the path of an archive of networks, and the path of a "
        f"folder of MERL .binary files.{hint}"
    )
