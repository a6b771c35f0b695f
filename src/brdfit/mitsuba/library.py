"""Mitsuba itself: imported late, and what to install where it or LLVM is missing."""

from __future__ import annotations

from typing import Any

from brdfit.errors import BrdfitError, MissingExtra

__all__ = ["mitsuba_library", "require_llvm"]


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
