"""All fits as JSON, for scripts."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from brdfit.export.fitting import Analytic
from brdfit.export.record import fit_record
from brdfit.files import atomic_path

__all__ = ["write_json"]


def write_json(fits: list[Analytic], provenance: dict[str, Any], path: Path) -> None:
    """Write the parameters, errors and provenance of `fits`."""
    record = {
        "schema": "brdfit.export/1",
        **provenance,
        "colour": "linear sRGB",
        "models": {fit.model: fit_record(fit) for fit in fits},
    }
    with atomic_path(path) as aside:
        aside.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
