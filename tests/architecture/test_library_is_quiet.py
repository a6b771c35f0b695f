"""The library neither prints nor exits, and its numerical core touches no file."""

from __future__ import annotations

import ast
from collections.abc import Iterator

import pytest

from source_tree import Module, imports_of, package_modules, parse

SPEAKERS = {"cli", "viewer", "__main__"}
CORE = {
    "geometry",
    "grid",
    "samples",
    "table",
    "models",
    "albedo",
    "linalg",
    "robust",
    "transform",
    "metrics",
    "render",
    "physics",
    "reconstruct",
}

SPEAKING = {
    "print",
    "input",
    "exit",
    "quit",
    "breakpoint",
    "sys.exit",
    "os._exit",
    "sys.stdout",
    "sys.stderr",
    "sys.stdin",
    "logging.basicConfig",
}
FILE_CALLS = {"open", "io.open", "os.open"}
FILE_METHODS = {
    "fromfile",
    "genfromtxt",
    "loadtxt",
    "memmap",
    "mkdir",
    "read_bytes",
    "read_text",
    "savetxt",
    "savez",
    "savez_compressed",
    "tofile",
    "unlink",
    "write_bytes",
    "write_text",
}
FILE_MODULES = {"brdfit.files", "brdfit.formats", "os", "pathlib", "shutil", "tempfile", "io"}

# What may stay, with its reason.
ALLOWED = {
    ("batch.engine", "os._exit"): "a worker whose parent was killed must end without a word",
    ("bench.workers", "os._exit"): "a worker whose parent was killed must end without a word",
}


def _dotted(node: ast.AST) -> str:
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        return f"{_dotted(node.value)}.{node.attr}"
    return ""


def speaks(module: Module) -> Iterator[str]:
    """Yield each place where a module prints, asks, or exits."""
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Name | ast.Attribute):
            name = _dotted(node)
            if name in SPEAKING and (module.name, name) not in ALLOWED:
                yield f"{module.at(node.lineno)}: {name}"
        if isinstance(node, ast.Raise) and "SystemExit" in ast.dump(node):
            yield f"{module.at(node.lineno)}: raise SystemExit"


def touches_files(module: Module) -> Iterator[str]:
    """Yield each place where a module of the core meets a file or keeps global state."""
    for found in imports_of(module):
        if any(f"{found.target}.".startswith(f"{name}.") for name in FILE_MODULES):
            yield f"{module.at(found.line)}: import {found.target}"
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Call):
            name = _dotted(node.func)
            if name in FILE_CALLS or name.rpartition(".")[2] in FILE_METHODS:
                yield f"{module.at(node.lineno)}: {name}()"
        if isinstance(node, ast.Global):
            yield f"{module.at(node.lineno)}: global {', '.join(node.names)}"


def test_only_the_command_line_and_the_viewer_print_or_exit() -> None:
    quiet = [module for module in package_modules() if module.unit not in SPEAKERS]
    assert len(quiet) > 20
    assert [line for module in quiet for line in speaks(module)] == []


def test_the_numerical_core_touches_no_file_and_keeps_no_state() -> None:
    core = [module for module in package_modules() if module.unit in CORE]
    assert {module.unit for module in core} == CORE
    assert [line for module in core for line in touches_files(module)] == []


def test_every_exception_is_still_needed() -> None:
    for name, what in ALLOWED:
        module = next(module for module in package_modules() if module.name == name)
        assert any(
            _dotted(node) == what
            for node in ast.walk(module.tree)
            if isinstance(node, ast.Name | ast.Attribute)
        )


@pytest.mark.parametrize(
    "source",
    [
        "print('x')",
        "def f():\n    input()",
        "import sys\nsys.exit(1)",
        "import sys\nsys.stderr.write('x')",
        "raise SystemExit(2)",
        "def f(out=print): ...",
    ],
)
def test_planted_speech_is_caught(source: str) -> None:
    assert list(speaks(parse("grid", source)))


@pytest.mark.parametrize(
    "source",
    [
        "open('x')",
        "from pathlib import Path",
        "import os",
        "from brdfit.files import atomic_path",
        "from brdfit import formats",
        "import numpy as np\nnp.fromfile('x')",
        "x.write_text('y')",
        "def f():\n    global seen\n    seen = 1",
    ],
)
def test_a_planted_file_is_caught(source: str) -> None:
    assert list(touches_files(parse("grid", source)))


def test_speech_in_a_text_is_none() -> None:
    assert list(speaks(parse("grid", "'''call print() yourself'''"))) == []
