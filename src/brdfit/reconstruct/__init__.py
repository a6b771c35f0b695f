"""reconstruct."""

from __future__ import annotations
