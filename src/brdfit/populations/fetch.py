"""Downloads of known populations, checked by hash, whole or not at all."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

from brdfit.errors import PopulationError, UsageError
from brdfit.populations.cache import cache_folder, locked
from brdfit.populations.known import KNOWN, KnownPopulation
from brdfit.progress import Progress, silent

__all__ = ["download", "fetch", "fetched_path"]

_TIMEOUT = 30.0


def fetched_path(name: str) -> Path:
    """Return where the download of a known population is kept, whether it exists or not."""
    return cache_folder("fetched") / Path(urlsplit(KNOWN[name].url).path).name


def fetch(name: str, url: str | None = None, progress: Progress = silent) -> Path:
    """Download a known population into the cache and return the path of the file.

    What is there already and has the right hash is not downloaded again. `url` names
    another place of the same file: a mirror, or a file server of one's own.

    Raises `UsageError` for an unknown name, `PopulationError` where there is nothing to
    download automatically (the message says what to do instead) or the download fails.
    """
    if name not in KNOWN:
        raise UsageError(f"fetch: found {name!r} but known are {', '.join(KNOWN)}.")
    known = KNOWN[name]
    if not known.page:
        raise PopulationError(f"population {name!r} comes with brdfit: nothing to fetch.")
    if not known.url:
        raise PopulationError(
            f"population {name!r} is not fetched automatically. Terms: {known.terms} Page: "
            f"{known.page} When you have the files, give the path of their folder as population."
        )
    return download(known, url or known.url, fetched_path(name), progress)


def download(known: KnownPopulation, url: str, target: Path, progress: Progress = silent) -> Path:
    """Download `url` to `target`; nothing is left of a download that failed."""
    import pooch

    host = urlsplit(url).netloc
    listener = _Listener(f"fetching {target.name} from {host}", progress)
    try:
        with locked(target), _quiet(pooch.get_logger()):
            pooch.retrieve(
                url=url,
                known_hash=f"sha256:{known.sha256}",
                fname=target.name,
                path=target.parent,
                downloader=pooch.HTTPDownloader(progressbar=listener, timeout=_TIMEOUT),
            )
    except OSError as error:
        # every error of the HTTP library is an OSError; one from a server carries its answer
        response = getattr(error, "response", None)
        reason = type(error).__name__
        if response is not None:
            reason = f"the server answered {response.status_code} {response.reason}"
        raise PopulationError(
            f"{url}: the download did not complete: {reason}. Check the address and the "
            f"network and try again. {_by_hand(known)}"
        ) from error
    except ValueError as error:
        raise PopulationError(
            f"{url}: what was downloaded does not have the SHA-256 {known.sha256[:16]}... of "
            f"{known.name!r}, and was removed. The file was altered or is another edition. "
            f"{_by_hand(known)}"
        ) from error
    return target


def _by_hand(known: KnownPopulation) -> str:
    return f"Or download it by hand from {known.page} and give the path of the file as population."


@contextmanager
def _quiet(logger: logging.Logger) -> Iterator[None]:
    # The library reports to the terminal; a library of ours does not.
    before = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(before)


class _Listener:
    """What the downloader takes for a progress bar, passed on to a `Progress`."""

    def __init__(self, label: str, progress: Progress) -> None:
        self._label = label
        self._progress = progress
        self._done = 0
        self.total = 0

    def update(self, count: int) -> None:
        """Hear of `count` more bytes, rounded up to a whole block."""
        if self._done == 0:
            self._progress(self._label, 0, self.total)
        self._done = min(self._done + count, self.total)
        self._progress(self._label, self._done, self.total)

    def reset(self) -> None:
        """Hear that all is there; the downloader then reports the total at once."""

    def close(self) -> None:
        """Hear that nothing more comes."""
