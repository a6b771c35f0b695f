"""What a check found: a figure, a verdict and a plain sentence."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

__all__ = ["Finding", "Health", "Verdict"]


class Verdict(StrEnum):
    """How a figure is to be taken."""

    GOOD = "good"
    """As it should be, within what measurements can be."""
    LOOK = "look"
    """Legal, but worth a look before it is believed."""
    WRONG = "wrong"
    """No surface, or no instrument in order, gives this."""
    UNKNOWN = "unknown"
    """The content cannot answer."""


@dataclass(frozen=True)
class Finding:
    """The answer of one check."""

    name: str
    verdict: Verdict
    sentence: str
    """For a person; says what was measured, in which unit, and what it means."""
    figure: float | None = None
    """None where the content cannot answer."""
    unit: str = ""
    details: dict[str, Any] = field(default_factory=dict)
    """JSON-able figures behind the one above."""

    def record(self) -> dict[str, Any]:
        """Return everything as JSON-able values."""
        return {
            "name": self.name,
            "verdict": str(self.verdict),
            "figure": self.figure,
            "unit": self.unit,
            "sentence": self.sentence,
            **({"details": self.details} if self.details else {}),
        }


@dataclass(frozen=True)
class Health:
    """All findings about one file, in the order in which they are told."""

    kind: str
    """"samples" or "table"."""
    findings: tuple[Finding, ...]

    def __getitem__(self, name: str) -> Finding:
        """Return the finding of that name."""
        return next(finding for finding in self.findings if finding.name == name)

    @property
    def worst(self) -> Verdict:
        """WRONG if anything is, else LOOK if anything wants one, else GOOD."""
        found = {finding.verdict for finding in self.findings}
        order = (Verdict.WRONG, Verdict.LOOK, Verdict.GOOD)
        return next((verdict for verdict in order if verdict in found), Verdict.UNKNOWN)

    def record(self) -> dict[str, Any]:
        """Return everything as JSON-able values."""
        return {
            "kind": self.kind,
            "worst": str(self.worst),
            "findings": [finding.record() for finding in self.findings],
        }
