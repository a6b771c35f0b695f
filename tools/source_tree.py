"""What the source says of itself, read without importing it: modules, imports, functions."""

from __future__ import annotations

import ast
import functools
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

__all__ = [
    "ROOT",
    "Function",
    "Import",
    "Module",
    "functions_of",
    "imports_of",
    "package_modules",
    "tracked_files",
]

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "brdfit"


@dataclass(frozen=True)
class Module:
    """One file of the package. `name` is dotted and without `brdfit.`; "" is the package."""

    name: str
    is_package: bool
    path: Path
    tree: ast.Module

    @property
    def unit(self) -> str:
        """First part of the name: the folder or file that has a floor."""
        return self.name.partition(".")[0]

    def at(self, line: int) -> str:
        """Return where that is, for a message."""
        return f"{self.path.relative_to(ROOT) if self.path.is_absolute() else self.path}:{line}"


@dataclass(frozen=True)
class Import:
    """One imported name: `target` is dotted and complete, wherever the statement stands."""

    target: str
    line: int


@dataclass(frozen=True)
class Function:
    """A function or method and how many lines it has without its docstring."""

    name: str
    line: int
    length: int


def parse(name: str, source: str, path: Path | None = None, is_package: bool = False) -> Module:
    """Return a module made of `source`, for the real ones and for planted ones alike."""
    return Module(name, is_package, path or Path(f"{name}.py"), ast.parse(source))


@functools.cache
def package_modules() -> tuple[Module, ...]:
    """Return every module of the package, in the order of their paths."""
    found = []
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        is_package = parts[-1] == "__init__"
        name = ".".join(parts[:-1] if is_package else parts)
        found.append(parse(name, path.read_text(encoding="utf-8"), path, is_package))
    return tuple(found)


def imports_of(module: Module) -> Iterator[Import]:
    """Yield what a module imports: at its top, within functions and for types alone.

    `from brdfit import grid` and `from brdfit.grid import Grid` both name `brdfit.grid...`.
    """
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Import):
            yield from (Import(alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = _absolute(module, node)
            yield from (Import(f"{base}.{alias.name}", node.lineno) for alias in node.names)


def _absolute(module: Module, node: ast.ImportFrom) -> str:
    if not node.level:
        return node.module or ""
    parts = ["brdfit", *filter(None, module.name.split("."))]
    up = node.level - module.is_package
    parts = parts[: len(parts) - up]
    return ".".join([*parts, *filter(None, [node.module])])


def functions_of(tree: ast.Module) -> Iterator[Function]:
    """Yield every function and method, nested ones too."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            assert node.end_lineno is not None
            length = node.end_lineno - node.lineno + 1
            if ast.get_docstring(node, clean=False) is not None:
                docstring = node.body[0]
                assert docstring.end_lineno is not None
                length -= docstring.end_lineno - docstring.lineno + 1
            yield Function(node.name, node.lineno, length)


@functools.cache
def tracked_files() -> tuple[Path, ...]:
    """Return the files of the project: those git knows, or all where there is no git."""
    try:
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT,
            capture_output=True,
            check=True,
            text=True,
        ).stdout
    except (OSError, subprocess.CalledProcessError):
        folders = ("src", "tests", "tools", "docs", "benchmarks")
        nested = (path for folder in folders for path in (ROOT / folder).rglob("*"))
        return tuple(sorted(path for path in (*ROOT.glob("*"), *nested) if path.is_file()))
    return tuple(path for name in listed.split("\0") if name and (path := ROOT / name).is_file())
