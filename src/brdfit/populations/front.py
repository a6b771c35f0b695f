"""From a name or a path to a population."""

from __future__ import annotations

import os
import warnings
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path

from brdfit.errors import DataQualityWarning, PopulationError
from brdfit.populations.contract import MemberSource, Population
from brdfit.populations.embedded import COMES_ALONG
from brdfit.populations.fetch import fetch, fetched_path
from brdfit.populations.known import KNOWN
from brdfit.progress import Progress, silent

__all__ = ["population"]


def population(
    name_or_path: str | os.PathLike[str] | Population, progress: Progress = silent
) -> Population:
    """Return all members of a population.

    Parameters
    ----------
    name_or_path
        "published", "synthetic", or "embedded", which is both with their weights (they come
        with brdfit); "nbrdf" (needs `brdfit basis fetch nbrdf` once); the path of an archive
        of networks (.zip), or of a folder of MERL `.binary` files.
        A `Population` is returned as it is.
    progress
        Hears of the reading of a folder of tables, which takes a minute the first time.

    Warns with `DataQualityWarning` of files that are not what was published; they are used.
    Raises `PopulationError` where there is no such population, naming those there are.
    """
    if isinstance(name_or_path, Population):
        return name_or_path
    name = os.fspath(name_or_path)
    if name in COMES_ALONG:
        return Population.of(COMES_ALONG[name]())
    if name == "nbrdf":
        return Population.of(_fetched_networks())
    if name in KNOWN:
        # says the terms, where the data are, and what to do with them
        fetch(name)
    path = Path(name).expanduser()
    if path.is_dir():
        return Population.of(_folder(path, name, progress))
    if path.is_file():
        return Population.of(_networks(path, name))
    raise PopulationError(_unknown(name))


def _fetched_networks() -> MemberSource:
    path = fetched_path("nbrdf")
    if not path.is_file():
        raise PopulationError(
            "population 'nbrdf' is not on this machine. Fetch it (0.5 MB, MIT licence) with: "
            "brdfit basis fetch nbrdf. Or give the path of the archive merl_nbrdf.zip."
        )
    return _networks(path, "nbrdf")


def _networks(path: Path, name: str) -> MemberSource:
    status = path.stat()
    source, notes = _read_networks(path, name, status.st_mtime_ns, status.st_size)
    _warn(name, notes)
    return source


@lru_cache(maxsize=4)
def _read_networks(
    path: Path, name: str, changed: int, size: int
) -> tuple[MemberSource, tuple[str, ...]]:
    # h5py is only wanted by those who use networks
    from brdfit.populations.nbrdf import read_nbrdf

    networks = read_nbrdf(path, name)
    return networks, networks.notes


def _folder(path: Path, name: str, progress: Progress) -> MemberSource:
    from brdfit.populations.merl_folder import read_merl_folder

    folder = read_merl_folder(path, name, progress)
    _warn(name, folder.notes)
    folder.prepare(progress)
    return folder


def _warn(name: str, notes: tuple[str, ...]) -> None:
    if notes:
        more = f" (and {len(notes) - 1} more)" if len(notes) > 1 else ""
        warnings.warn(
            f"population {name!r}: {notes[0]}{more}. It is used as it is; all are listed by: "
            f"brdfit basis check {name}",
            DataQualityWarning,
            stacklevel=4,
        )


def _unknown(name: str) -> str:
    near = get_close_matches(name, KNOWN, n=1)
    hint = f" Did you mean {near[0]!r}?" if near else ""
    return (
        f"population {name!r}: found neither a population of that name nor a file or folder. "
        f"There are {', '.join(KNOWN)}, the path of an archive of networks, and the path of a "
        f"folder of MERL .binary files.{hint}"
    )
