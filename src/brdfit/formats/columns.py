"""Guess a declaration from column names, only where it is unambiguous.

A name is compared in lower case, with blanks, hyphens and dots as underscores, and without
a unit in brackets or at its end (`theta_i [deg]`, `theta_i_deg`), which is kept as a hint.
`ALIASES` is the whole list; the documentation is generated from it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.formats.declaration import COORDINATES, OWN_FLAGS, Column, wavelength_of

__all__ = ["ALIASES", "OWN_ROW", "Guess", "guess_angles", "guess_columns", "sidecar_text"]

OWN_ROW = "brdfit_row"
"""Column of our own files: the row of the file that the sample first came from."""

_OWN = (OWN_FLAGS, OWN_ROW)

_I = ("i", "in", "inc", "incident", "l", "light")
_O = ("o", "out", "s", "scattered", "r", "reflected", "v", "view", "det", "detector")


def _angle_names(angle: str, sides: Sequence[str]) -> tuple[str, ...]:
    joined = [f"{angle}_{side}" for side in sides] + [f"{side}_{angle}" for side in sides]
    return (*joined, *(f"{angle}{side}" for side in sides))


ALIASES: dict[str, tuple[str, ...]] = {
    "theta_i": _angle_names("theta", _I),
    "phi_i": _angle_names("phi", _I),
    "theta_o": _angle_names("theta", _O),
    "phi_o": _angle_names("phi", _O),
    "theta_h": ("theta_h", "theta_half", "thetah"),
    "theta_d": ("theta_d", "theta_diff", "thetad"),
    "phi_d": ("phi_d", "phi_diff", "phid"),
    **{f"wi_{axis}": (f"wi_{axis}", f"wi{axis}", f"l_{axis}", f"l{axis}") for axis in "xyz"},
    **{f"wo_{axis}": (f"wo_{axis}", f"wo{axis}", f"v_{axis}", f"v{axis}") for axis in "xyz"},
}
"""Canonical direction column -> names that are taken for it."""

_SINGLE_VALUE = ("value", "f_r", "fr", "brdf", "bsdf")
_RGB = (("r", "g", "b"), ("red", "green", "blue"))
_SIGMA = re.compile(r"(?:sigma|std|stddev|unc)_(.+)|(.+)_(?:sigma|std|stddev|unc)")
_LONGEST_NAME = 200  # of a line that is no header, perhaps not even text
_UNITS = {"deg": "degrees", "degrees": "degrees", "rad": "radians", "radians": "radians"}
_UNIT = re.compile(r"(.*?)_*(?:[\[(](deg|degrees|rad|radians)[\])]|_(deg|degrees|rad|radians))")


@dataclass(frozen=True)
class Guess:
    """What the names say; `angles` is "" where they do not say the unit."""

    coordinates: str
    directions: tuple[Column, ...]
    values: tuple[Column, ...]
    sigma: tuple[Column, ...]
    flags: Column | None
    angles: str
    ignored: tuple[str, ...]


def guess_columns(
    names: Sequence[str],
    directions: Sequence[int] | None = None,
    values: Sequence[int] | None = None,
) -> Guess | str:
    """Return what the column names mean, or why that is not clear.

    `directions` and `values` are 0-based places that are declared already; what is given
    is not guessed, and comes back as it is (with coordinates "" for directions).
    """
    plain, units = zip(*(_fold(name) for name in names), strict=True) if names else ((), ())
    if len(set(plain)) != len(plain):
        return "two columns have the same name"
    kind = ""
    if directions is None:
        guessed = _guess_directions(plain)
        if isinstance(guessed, str):
            return guessed
        kind, directions = guessed
    hints = {units[place] for place in directions} - {""}
    if len(hints) > 1:
        return "the angle columns name different units"
    found = _values(plain, set(directions)) if values is None else list(values)
    if isinstance(found, str):
        return found
    sigma = _sigma(plain, found) if values is None else []
    used = {*directions, *found, *sigma}
    return Guess(
        coordinates=kind,
        directions=tuple(place + 1 for place in directions),
        values=tuple(place + 1 for place in found),
        sigma=tuple(place + 1 for place in sigma),
        flags=names[plain.index(OWN_FLAGS)] if OWN_FLAGS in plain else None,
        angles=hints.pop() if hints else "",
        ignored=tuple(n for i, n in enumerate(names) if i not in used and plain[i] not in _OWN),
    )


def _guess_directions(plain: Sequence[str]) -> tuple[str, list[int]] | str:
    found = {canon: _places(plain, aliases) for canon, aliases in ALIASES.items()}
    twice = [canon for canon, places in found.items() if len(places) > 1]
    if twice:
        return f"more than one column may be {', '.join(twice)}"
    kinds = [
        kind
        for kind, columns in COORDINATES.items()
        if kind != "relative" and all(found[column] for column in columns)
    ]
    if not kinds:
        return "no complete set of direction columns is named"
    if len(kinds) > 1:
        return f"the columns hold several kinds of coordinates ({', '.join(kinds)})"
    return kinds[0], [found[column][0] for column in COORDINATES[kinds[0]]]


def guess_angles(take: Callable[[Column], FloatArray], columns: Sequence[Column]) -> str:
    """Return "degrees" where radians are impossible, else "": small angles may be either.

    Impossible means that at least one angle in twenty exceeds a full turn of 2 pi; one
    wild number is no evidence.
    """
    angles = np.abs(np.concatenate([take(column) for column in columns]))
    angles = angles[np.isfinite(angles)]
    share = np.mean(angles > 2.0 * np.pi + 1e-3) if angles.size else 0.0
    return "degrees" if share >= 0.05 else ""


def sidecar_text(names: Sequence[str], guess: Guess | str) -> str:
    """Return a TOML sidecar to fill in, with what is known already in its place."""
    listed = ", ".join(f'"{name}"' for name in names[:40])
    if isinstance(guess, str):
        directions = '["theta_i", "phi_i", "theta_o", "phi_o"]   # your names, or positions 1, 2'
        values = '["R", "G", "B"]   # your columns of f_r in 1/sr'
    else:
        directions = _toml_list([names[int(column) - 1] for column in guess.directions])
        values = _toml_list([names[int(column) - 1] for column in guess.values])
    return (
        f"# columns found: {listed}\n"
        f"directions = {directions}\n"
        f"values = {values}\n"
        f'angles = "degrees"   # or "radians"\n'
        f'light = "first"   # the first direction points toward the light; or "second"\n'
        f"cosine_weighted = false   # true: values are f_r times cos theta of the detector\n"
    )


def _toml_list(items: Sequence[str]) -> str:
    return "[" + ", ".join('"' + item.replace('"', '\\"') + '"' for item in items) + "]"


def _fold(name: str) -> tuple[str, str]:
    # the point of 400.25nm stays: without it that would be another wavelength
    folded = re.sub(r"([\s\-]|(?<!\d)\.|\.(?!\d))+", "_", name.strip().lower()[:_LONGEST_NAME])
    match = _UNIT.fullmatch(folded)
    if match:
        return match[1].rstrip("_"), _UNITS[match[2] or match[3]]
    return folded, ""


def _places(plain: Sequence[str], aliases: Sequence[str]) -> list[int]:
    return [place for place, name in enumerate(plain) if name in aliases]


def _values(plain: Sequence[str], taken: set[int]) -> list[int] | str:
    free = {name: place for place, name in enumerate(plain) if place not in taken}
    sets: list[list[int]] = []
    bands = [place for name, place in free.items() if wavelength_of(name) is not None]
    if bands:
        sets.append(bands)
    sets += [[free[name] for name in rgb] for rgb in _RGB if all(name in free for name in rgb)]
    sets += [[free[name]] for name in _SINGLE_VALUE if name in free]
    numbered = [place for name, place in free.items() if re.fullmatch(r"channel\d+", name)]
    if numbered:
        sets.append(numbered)
    if len(sets) == 1:
        return sets[0]
    return "no column is named as a value" if not sets else "several columns may be the values"


def _sigma(plain: Sequence[str], values: Sequence[int]) -> list[int]:
    """Columns of the standard deviation of `values`, all of them or none."""
    of: dict[str, int] = {}
    for place, name in enumerate(plain):
        match = _SIGMA.fullmatch(name)
        if match:
            of[match[1] or match[2]] = place
    if all(plain[place] in of for place in values):
        return [of[plain[place]] for place in values]
    if len(values) == 1 and "sigma" in plain:
        return [list(plain).index("sigma")]
    return []
