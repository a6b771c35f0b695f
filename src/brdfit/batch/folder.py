"""A folder or pattern of measurement files: every file is an item."""

from __future__ import annotations

import glob
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from brdfit.batch.source import Part
from brdfit.errors import BrdfitError, UsageError
from brdfit.files import sha256_of_file
from brdfit.formats import read_samples
from brdfit.reconstruct.compact import Block
from brdfit.samples import Samples

__all__ = ["FolderInput"]

# Files that lie among measurements and are none.
_ASIDE = (".toml", ".md", ".json")


@dataclass(frozen=True)
class FolderInput:
    """Files in the order of their names; they have the channels of the first that can be read."""

    name: str
    paths: tuple[str, ...]
    names: tuple[str, ...]
    options: tuple[tuple[str, Any], ...]
    channels: tuple[str, ...]
    wavelengths: tuple[float, ...]
    samples_per_item: float
    positioned: bool = False

    @classmethod
    def of(cls, pattern: str, options: Mapping[str, Any]) -> FolderInput:
        """Return the files of a folder (all of them, below it too) or of a glob pattern.

        Raises `UsageError` where there is no file, `BrdfitError` where none can be read.
        """
        folder = Path(pattern)
        found = folder.rglob("*") if folder.is_dir() else map(Path, glob.glob(pattern))
        paths = sorted(p for p in found if p.is_file() and _is_item(p))
        if not paths:
            raise UsageError(
                f"{pattern}: found no file. Name a folder of measurements, a pattern in quotes "
                f"('scans/*.csv'), or one long table (.parquet, .zarr)."
            )
        root = folder if folder.is_dir() else _common_folder(paths)
        first = _first_readable(paths, options)
        return cls(
            name=folder.name if folder.is_dir() else pattern,
            paths=tuple(map(str, paths)),
            names=tuple(p.relative_to(root).as_posix() for p in paths),
            options=tuple(sorted(options.items())),
            channels=first.channels,
            wavelengths=() if first.wavelengths is None else tuple(first.wavelengths.tolist()),
            samples_per_item=float(len(first)),
        )

    @property
    def count(self) -> int:
        """Number of files."""
        return len(self.paths)

    @property
    def longest_name(self) -> int:
        """Bytes of the longest name."""
        return max(len(name.encode()) for name in self.names)

    def fingerprint(self) -> str:
        """SHA-256 over names, contents and reading options."""
        digest = hashlib.sha256(json.dumps(self.options, default=str).encode())
        for name, path in zip(self.names, self.paths, strict=True):
            digest.update(f"{name}\0{sha256_of_file(path)}\0".encode())
        return digest.hexdigest()

    def part(self, start: int, stop: int) -> Part:
        """Read files `start` to `stop`; one that cannot be read is named with its error."""
        items: list[Samples] = []
        where: list[int] = []
        problems: dict[int, str] = {}
        for place, path in enumerate(self.paths[start:stop]):
            try:
                samples = read_samples(path, **dict(self.options))
            except (BrdfitError, OSError) as error:
                problems[place] = str(error)
                continue
            if samples.channels != self.channels:
                problems[place] = (
                    f"found channels {', '.join(samples.channels)} but the batch has "
                    f"{', '.join(self.channels)}; fit it in a batch of its own"
                )
                continue
            items.append(samples)
            where.append(place)
        names = list(self.names[start:stop])
        return Part(names, Block.of(items) if items else None, where, problems)


def _is_item(path: Path) -> bool:
    return not path.name.startswith(".") and path.suffix.lower() not in _ASIDE


def _common_folder(paths: list[Path]) -> Path:
    common = paths[0].parent
    while not all(path.is_relative_to(common) for path in paths):
        common = common.parent
    return common


def _first_readable(paths: list[Path], options: Mapping[str, Any]) -> Samples:
    problem: Exception | None = None
    for path in paths[:20]:
        try:
            return read_samples(path, **options)
        except (BrdfitError, OSError) as error:
            problem = problem or error
    assert problem is not None
    raise problem
