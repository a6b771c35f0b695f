"""Mitsuba itself: imported late, and what to install where it or LLVM is missing."""

from __future__ import annotations

import subprocess
import sys
from functools import lru_cache
from typing import Any

from brdfit.errors import BrdfitError, MissingExtra

__all__ = ["mitsuba_library", "require_llvm"]

# The smallest picture: an old LLVM ends the whole process when it meets what it cannot compile.
_SMALLEST = """
import mitsuba
mitsuba.set_variant("llvm_ad_rgb")
film = {"type": "hdrfilm", "width": 16, "height": 16}
scene = {
    "type": "scene",
    "integrator": {"type": "direct"},
    "shape": {"type": "sphere"},
    "light": {"type": "constant"},
    "sensor": {"type": "perspective", "film": film},
}
mitsuba.render(mitsuba.load_dict(scene), spp=1).numpy()
"""
_SECONDS = 120


def mitsuba_library() -> Any:
    """Import Mitsuba; `MissingExtra` says what to install."""
    try:
        import mitsuba
    except ImportError as error:
        raise MissingExtra("mitsuba", "mitsuba", "rendering with Mitsuba") from error
    return mitsuba


def require_llvm() -> None:
    """Raise `BrdfitError` where Mitsuba's llvm variants cannot run."""
    mitsuba_library()
    import drjit

    if not drjit.has_backend(drjit.JitBackend.LLVM):
        raise BrdfitError(
            "Mitsuba's llvm variants need the shared library of LLVM, which was not found. Install "
            "it (Debian and Ubuntu: apt install libllvm19 or llvm; macOS: brew install llvm), or "
            "name the file in the environment variable DRJIT_LIBLLVM_PATH."
        )
    wrong = _trouble()
    if wrong:
        raise BrdfitError(
            f"Mitsuba's llvm variants do not run here: a small picture ended with {wrong!r}. "
            f"LLVM is too old for this processor: install a newer one (Debian and Ubuntu: apt "
            f"install libllvm19), and name its file in DRJIT_LIBLLVM_PATH if several are there."
        )


@lru_cache(maxsize=1)
def _trouble() -> str:
    """Return how the smallest picture ended in a process of its own; empty if well."""
    try:
        ended = subprocess.run(
            [sys.executable, "-c", _SMALLEST],
            capture_output=True,
            text=True,
            timeout=_SECONDS,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"{type(error).__name__}: {error}"
    if ended.returncode == 0:
        return ""
    said = [line for line in ended.stderr.splitlines() if "ERROR" in line] or ["no message"]
    return f"{said[0][:120]} (code {ended.returncode})"
