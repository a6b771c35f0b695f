"""Mitsuba in one of its variants; skips without it, or without LLVM."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from brdfit.errors import BrdfitError
from brdfit.mitsuba.library import require_llvm


@pytest.fixture
def scalar() -> Iterator[Any]:
    """Mitsuba with the variant scalar_rgb."""
    yield from in_variant("scalar_rgb")


@pytest.fixture
def llvm() -> Iterator[Any]:
    """Mitsuba with the variant llvm_ad_rgb."""
    yield from in_variant("llvm_ad_rgb")


def in_variant(name: str) -> Iterator[Any]:
    mi = pytest.importorskip("mitsuba", reason="the extra mitsuba is not installed")
    if name.startswith("llvm"):
        try:
            require_llvm()
        except BrdfitError as error:
            pytest.skip(str(error))
    before = mi.variant()
    mi.set_variant(name)
    yield mi
    if before is not None:
        mi.set_variant(before)
