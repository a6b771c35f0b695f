"""From column names and options to a `Declaration`, for text and Parquet alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.formats.columns import Guess, guess_angles, guess_columns, sidecar_text
from brdfit.formats.declaration import Column, Declaration, position_of

__all__ = ["declare"]


def declare(
    file: str,
    names: Sequence[str],
    options: Mapping[str, Any],
    take: Callable[[Column], FloatArray],
) -> tuple[Declaration, list[str]]:
    """Return (declaration, notes on what was guessed).

    What `options` say holds; what they leave out is guessed from the names where that is
    unambiguous. Otherwise raises `UsageError` with the sidecar to write.
    """
    if "directions" in options and "values" in options:
        return Declaration.from_options(options, file), []
    guess = guess_columns(
        names,
        _places(options.get("directions"), names, file),
        _places(options.get("values"), names, file),
    )
    if isinstance(guess, str):
        raise UsageError(_ambiguous(file, f"the columns are not clear: {guess}", names, guess))
    merged: dict[str, Any] = {**_guessed(guess, options), **options}
    notes = [f"columns guessed from their names: {_said(guess, names, options)}"]
    if guess.ignored:
        notes.append(f"columns not read: {', '.join(guess.ignored)}")
    if not merged.get("angles") and "directions" not in options and guess.coordinates != "vectors":
        merged["angles"] = guess.angles or guess_angles(take, guess.directions)
        if not merged["angles"]:
            reason = "whether the angles are in degrees or radians is not clear"
            raise UsageError(_ambiguous(file, reason, names, guess))
        why = "their column names" if guess.angles else "angles beyond 2 pi"
        notes.append(f"angles taken as {merged['angles']} because of {why}")
    return Declaration.from_options(merged, file), notes


def _places(columns: Any, names: Sequence[str], file: str) -> list[int] | None:
    """0-based places of declared columns; constants have none. None if nothing is declared."""
    if columns is None:
        return None
    held = [c for c in columns if not (isinstance(c, str) and c.startswith("="))]
    return [position_of(column, names, file) for column in held]


def _guessed(guess: Guess, options: Mapping[str, Any]) -> dict[str, Any]:
    guessed: dict[str, Any] = {}
    if "directions" not in options:
        guessed = {"coordinates": guess.coordinates, "directions": guess.directions}
    if "values" not in options:
        guessed |= {"values": guess.values, "sigma": guess.sigma}
    if guess.flags is not None:
        guessed["flags"] = guess.flags
    return guessed


def _said(guess: Guess, names: Sequence[str], options: Mapping[str, Any]) -> str:
    said = []
    if "directions" not in options:
        directions = ", ".join(names[int(column) - 1] for column in guess.directions)
        said.append(f"{guess.coordinates} from {directions}")
    if "values" not in options:
        said.append("values from " + ", ".join(names[int(c) - 1] for c in guess.values))
    return "; ".join(said)


def _ambiguous(file: str, reason: str, names: Sequence[str], guess: Guess | str) -> str:
    return (
        f"{file}: {reason}. Declare them by options (directions=..., values=..., angles=...) or "
        f"in a file {file}.toml beside it, for example:\n\n{sidecar_text(names, guess)}"
    )
