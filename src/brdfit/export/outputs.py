"""Files of analytic materials: which suffix holds what, and what travels with it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from brdfit.errors import UsageError
from brdfit.export.fitting import DEFAULT_SETTINGS, Analytic, AnalyticSettings, fit_analytic
from brdfit.export.write_gltf import write_gltf
from brdfit.export.write_json import write_json
from brdfit.export.write_materialx import require_materialx, write_materialx
from brdfit.progress import Progress, silent
from brdfit.report.rgb import Conversion, rgb_table
from brdfit.table import Table
from brdfit.versions import version_of

__all__ = ["SUFFIXES", "TARGETS", "Exported", "Target", "target_of", "write_export"]

Writer = Callable[[list[Analytic], dict[str, Any], Path], None]


@dataclass(frozen=True)
class Target:
    """A kind of file that holds an analytic material."""

    suffix: str
    title: str
    """One line for a person."""
    models: tuple[str, ...]
    """Which models are fitted for it."""
    write: Writer
    """(fits, provenance, path): write the file whole or not at all."""
    require: Callable[[], object] = bool
    """Raises `MissingExtra` before anything is computed."""


_ALL = (
    Target(
        ".mtlx", "MaterialX, OpenPBR surface", ("openpbr",), write_materialx, require_materialx
    ),
    Target(".gltf", "glTF 2.0, a sphere with the material", ("gltf",), write_gltf),
    Target(
        ".json", "parameters and errors for scripts", ("ggx", "gltf", "openpbr"), write_json
    ),
)  # fmt: skip

TARGETS: Mapping[str, Target] = MappingProxyType({target.suffix: target for target in _ALL})
"""Suffix -> what a file of that name holds."""
SUFFIXES = tuple(TARGETS)


@dataclass(frozen=True)
class Exported:
    """What was written, and what it cost."""

    path: Path
    target: Target
    fits: tuple[Analytic, ...]
    conversion: Conversion
    """How the table came to R, G, B."""


def target_of(path: Path) -> Target:
    """Return the target that the suffix names; `UsageError` for another."""
    target = TARGETS.get(path.suffix.lower())
    if target is None:
        known = ", ".join(f"{one.suffix} ({one.title})" for one in TARGETS.values())
        raise UsageError(
            f"{path.name}: the suffix {path.suffix!r} names no analytic material. There are: "
            f"{known}. Tables of other formats are written by brdfit convert."
        )
    return target


def write_export(
    table: Table,
    path: Path,
    settings: AnalyticSettings = DEFAULT_SETTINGS,
    progress: Progress = silent,
) -> Exported:
    """Fit the materials that the suffix of `path` names, and write them.

    Raises `UsageError` for another suffix, `MissingExtra` where a library is not installed:
    both before anything is computed.
    """
    target = target_of(path)
    target.require()
    rgb, conversion = rgb_table(table)
    fits = [fit_analytic(rgb, model, settings, progress) for model in target.models]
    target.write(fits, _provenance(table, settings), path)
    return Exported(path, target, tuple(fits), conversion)


def _provenance(table: Table, settings: AnalyticSettings) -> dict[str, Any]:
    source = table.source
    return {
        "generator": f"brdfit {version_of()}",
        "source": {"name": source.name, "format": source.format, "sha256": source.sha256},
        "settings": asdict(settings),
    }
