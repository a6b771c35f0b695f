"""What the command line asks of populations: list, build, check, clear."""

from __future__ import annotations

import json
import os
import shutil
from dataclasses import dataclass
from pathlib import Path

from brdfit.errors import PopulationError
from brdfit.files import sha256_of_file
from brdfit.grid import MERL_GRID
from brdfit.populations.cache import cache_folder
from brdfit.populations.columns import Columns, columns
from brdfit.populations.contract import MemberSource
from brdfit.populations.embedded import COMES_ALONG
from brdfit.populations.fetch import fetched_path
from brdfit.populations.front import population
from brdfit.populations.joined_store import stores_of
from brdfit.populations.known import KNOWN
from brdfit.populations.store import MANIFEST, columns_folder, intact
from brdfit.progress import Progress, silent

__all__ = [
    "CheckReport",
    "Cleared",
    "Finding",
    "PopulationInfo",
    "build",
    "check",
    "clear",
    "list_populations",
]


@dataclass(frozen=True)
class PopulationInfo:
    """One line of the list of populations that have a name."""

    name: str
    title: str
    terms: str
    page: str
    available: bool
    """Whether it can be used now, without fetching anything."""
    built: bool
    """Whether its columns on the MERL grid are in the cache."""
    advice: str
    """What to do to use it; empty where it is ready."""


@dataclass(frozen=True)
class Finding:
    """What a check found about one thing."""

    subject: str
    verdict: str
    """One word: "published", "altered", "unknown", "damaged", "missing", ..."""
    explanation: str
    ok: bool


@dataclass(frozen=True)
class CheckReport:
    """What is known of the files behind a population."""

    name: str
    findings: tuple[Finding, ...]

    @property
    def ok(self) -> bool:
        """True where everything is as published."""
        return all(finding.ok for finding in self.findings)


@dataclass(frozen=True)
class Cleared:
    """What was removed from the cache."""

    entries: int
    bytes: int


def list_populations() -> tuple[PopulationInfo, ...]:
    """Return the populations that have a name, and whether each is ready."""
    return tuple(_info(name) for name in KNOWN)


def _info(name: str) -> PopulationInfo:
    known = KNOWN[name]
    source: MemberSource | None = None
    advice = f"Read the terms at {known.page}, then give the path of the folder of files."
    if name in COMES_ALONG:
        source, advice = COMES_ALONG[name](), ""
    elif known.url:
        advice = f"brdfit basis fetch {name}"
        if fetched_path(name).is_file():
            try:
                source, advice = population(name).source, ""
            except (PopulationError, ImportError) as error:
                advice = str(error)
    return PopulationInfo(
        name=name,
        title=known.title,
        terms=known.terms,
        page=known.page,
        available=source is not None,
        built=source is not None and all(map(intact, stores_of(source, MERL_GRID))),
        advice=advice,
    )


def build(name: str | os.PathLike[str], progress: Progress = silent) -> Columns:
    """Build the columns of a population on the MERL grid, unless they are there already.

    Columns that an older version of the same population left are removed.
    """
    built = columns(population(name, progress), progress=progress)
    clear(stale_only=True)
    return built


def check(name: str | os.PathLike[str], progress: Progress = silent) -> CheckReport:
    """Compare every file behind a population, and its cached columns, with what they must be.

    Raises `PopulationError` for a population that does not exist.
    """
    name = os.fspath(name)
    path = Path(name).expanduser()
    if name not in KNOWN and path.is_dir():
        findings, source = _check_folder(path, name, progress)
    elif name in COMES_ALONG:
        source = COMES_ALONG[name]()
        findings = [Finding("members", "ok", f"{len(source.members)}, come with brdfit", True)]
    else:
        findings, source = _check_archive(name, path)
    if source is not None:
        findings.append(_check_columns(source))
    return CheckReport(name, tuple(findings))


def _check_folder(
    path: Path, name: str, progress: Progress
) -> tuple[list[Finding], MemberSource | None]:
    from brdfit.populations.merl_folder import published_sha256, read_merl_folder

    folder = read_merl_folder(path, name, progress)
    findings = [
        Finding(table.path.name, table.verdict, table.explanation, table.verdict == "published")
        for table in folder.tables
    ]
    absent = [material for material in published_sha256() if material not in folder.members]
    if absent:
        shown = ", ".join(absent[:5]) + (", ..." if len(absent) > 5 else "")
        text = f"{len(absent)} of the 100 materials are not in the folder: {shown}"
        findings.append(Finding("completeness", "partial", text, True))
    return findings, folder


def _check_archive(name: str, path: Path) -> tuple[list[Finding], MemberSource | None]:
    known = KNOWN["nbrdf"]
    if name == "nbrdf":
        path = fetched_path(name)
        if not path.is_file():
            text = f"not fetched; brdfit basis fetch {name}"
            return [Finding(path.name, "missing", text, False)], None
    elif not path.is_file():
        # the front door says what there is instead
        population(name)
    from brdfit.populations.nbrdf import read_nbrdf

    same = sha256_of_file(path) == known.sha256
    try:
        source = read_nbrdf(path, name)
    except PopulationError as error:
        return [Finding(path.name, "damaged", str(error), False)], None
    text = "the archive as published" if same else source.notes[0]
    return [Finding(path.name, "published" if same else "altered", text, same)], source


def _check_columns(source: MemberSource) -> Finding:
    stores = stores_of(source, MERL_GRID)
    if not all((store.folder / MANIFEST).is_file() for store in stores):
        return Finding("cached columns", "absent", "not built yet; built when needed", True)
    if all(intact(store, thorough=True) for store in stores):
        return Finding("cached columns", "ok", "every checksum is right", True)
    return Finding("cached columns", "damaged", "they will be built again when needed", False)


def clear(stale_only: bool = False) -> Cleared:
    """Remove what brdfit computed and kept; downloads stay, since they cost a network.

    `stale_only` removes only what nothing will read again: columns of an older version of
    a population that has a name, and what an interrupted build left.
    """
    doomed = [folder for folder in columns_folder().iterdir() if folder.is_dir()]
    if stale_only:
        current = _current_fingerprints()
        doomed = [folder for folder in doomed if _is_stale(folder, current)]
    else:
        doomed += [folder for folder in cache_folder("arrays").iterdir() if folder.is_dir()]
    size = 0
    for folder in doomed:
        size += sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
        shutil.rmtree(folder, ignore_errors=True)
    return Cleared(len(doomed), size)


def _current_fingerprints() -> dict[str, str]:
    current = {name: source().fingerprint for name, source in COMES_ALONG.items()}
    if fetched_path("nbrdf").is_file():
        try:
            current["nbrdf"] = population("nbrdf").fingerprint
        except (PopulationError, ImportError):
            return current
    return current


def _is_stale(folder: Path, current: dict[str, str]) -> bool:
    if folder.name.startswith("."):
        # a build that is under way holds the lock of its target
        return not _locked(folder)
    try:
        manifest = json.loads((folder / MANIFEST).read_text())
        fingerprint = manifest["columns"]["fingerprint"]
        return bool(current.get(manifest["source"], fingerprint) != fingerprint)
    except (OSError, ValueError, KeyError, TypeError):
        return True


def _locked(folder: Path) -> bool:
    from filelock import FileLock, Timeout

    target = folder.name.removeprefix(".").removesuffix(".part")
    try:
        with FileLock(folder.with_name(f"{target}.lock"), timeout=0):
            return False
    except Timeout:
        return True
