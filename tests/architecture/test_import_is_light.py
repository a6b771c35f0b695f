"""`import brdfit` and `brdfit --help` are quick: nothing heavy is imported before it is needed."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = {"matplotlib", "pyarrow", "colour", "skimage", "h5py", "pooch"} | {
    # `import scipy` alone is light: it imports its parts when they are first used
    f"scipy.{part}"
    for part in ("fft", "interpolate", "linalg", "ndimage", "optimize", "sparse", "special")
}

_REPORT = "import sys; sys.stderr.write('\\n' + ' '.join(sys.modules))"


def imported_by(program: str) -> set[str]:
    """Return the modules that a fresh interpreter has after `program`."""
    done = subprocess.run(
        [sys.executable, "-c", f"{program}\n{_REPORT}"], capture_output=True, text=True, check=True
    )
    return set(done.stderr.splitlines()[-1].split())


def help_of(*words: str) -> set[str]:
    """Return the modules that `brdfit WORDS --help` imports."""
    return imported_by(
        "import runpy, sys\n"
        f"sys.argv = {['brdfit', *words, '--help']!r}\n"
        "try: runpy.run_module('brdfit', run_name='__main__')\n"
        "except SystemExit as end: assert not end.code, end.code"
    )


def test_importing_the_package_imports_nothing_heavy() -> None:
    imported = imported_by("import brdfit; brdfit.__all__")
    assert "brdfit" in imported
    assert imported & (HEAVY | {"numpy", "rich", "scipy"}) == set()


@pytest.mark.parametrize("name", ["BrdfitError", "Samples"])
def test_using_a_light_name_imports_nothing_heavy(name: str) -> None:
    assert imported_by(f"import brdfit; brdfit.{name}") & HEAVY == set()


@pytest.mark.parametrize("words", [(), ("fit",)], ids=["brdfit", "fit"])
def test_help_imports_nothing_heavy(words: tuple[str, ...]) -> None:
    imported = help_of(*words)
    assert "brdfit" in imported
    assert imported & HEAVY == set()


def test_a_heavy_import_would_be_seen() -> None:
    assert "scipy.linalg" in imported_by("import scipy.linalg") & HEAVY
