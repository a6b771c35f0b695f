"""What a conversion between files lost: the written file is read again and held against the input.

Nothing is taken from a list of what a format should do. Each aspect is a `Loss`, whether or
not anything was lost, with a sentence for a person and figures for a script.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.errors import BrdfitWarning
from brdfit.formats import FormatSheet, read_samples, read_table
from brdfit.report.channels import channels_in_words
from brdfit.samples import Flag, Samples, Source
from brdfit.table import Table
from brdfit.tone import LUMINANCE

__all__ = ["Loss", "losses_of"]

_STATED = int(Flag.UNREADABLE | Flag.REJECTED)
# Rounding of angles that were written and read: not what anybody would call a loss.
_SAME_DIRECTION = 1e-6
# The last bits of a float64: no digit that anybody measured.
_ROUNDING = 1e-14
_BLOCK = 1 << 18


@dataclass(frozen=True)
class Loss:
    """One aspect of a conversion."""

    aspect: str
    """"channels", "resolution", "range", "precision", "missing", "flags", "metadata", ..."""
    lost: bool
    sentence: str
    figures: dict[str, Any] = field(default_factory=dict)

    def record(self) -> dict[str, Any]:
        """Return it as JSON-able values."""
        return {
            "aspect": self.aspect,
            "lost": self.lost,
            "sentence": self.sentence,
            "figures": self.figures,
        }


def losses_of(
    content: Samples | Table, written: Samples | Table, path: Path, sheet: FormatSheet
) -> tuple[Loss, ...]:
    """Return every aspect of a conversion.

    `content` is what was read, `written` what was handed to the writer (with other channels or
    on another grid, where the format wants that), `path` the file, `sheet` its format.
    """
    with warnings.catch_warnings():
        # they speak of the new file; whoever converts wants to hear of the old one
        warnings.simplefilter("ignore", BrdfitWarning)
        if isinstance(written, Samples):
            assert isinstance(content, Samples)
            back = read_samples(path, format=sheet.name)
            return tuple(_of_samples(content, back))
        assert isinstance(content, Table)
        return tuple(_of_table(content, written, path, sheet))


def _of_samples(before: Samples, after: Samples) -> Iterator[Loss]:
    yield _channels(before, after)
    marked = (before.bits & _STATED) != 0
    kept = before
    if len(after) == len(before) - int(marked.sum()):
        kept = before.subset(~marked)
    if len(after) != len(kept):
        yield Loss(
            "samples",
            True,
            f"{len(before):,} samples became {len(after):,}",
            {"before": len(before), "after": len(after)},
        )
        return
    yield from _directions(kept, after)
    yield from _values(kept.value, _spread(after.value, kept.n_channels))
    yield from _flags(before, after, marked)
    if before.sigma is not None:
        lost = after.sigma is None
        yield Loss("deviations", lost, "the standard deviations are lost" if lost else "kept")
    if before.rows is not None and not np.array_equal(kept.rows, after.rows):  # type: ignore[arg-type]
        yield Loss("rows", True, "the row numbers of the first file became those of the new one")
    yield _metadata(before.source, after.source)


def _directions(before: Samples, after: Samples) -> Iterator[Loss]:
    usable = before.usable.any(axis=1)
    if not usable.any():
        return
    moved = max(
        float(np.abs(a[usable] - b[usable]).max())
        for a, b in ((before.wi, after.wi), (before.wo, after.wo))
    )
    figures = {"largest_change_rad": moved}
    if moved <= _SAME_DIRECTION:
        yield Loss("directions", False, "kept, with their azimuths about the normal", figures)
        return
    turned = max(
        float(np.abs(np.cos(a[usable]) - np.cos(b[usable])).max())
        for a, b in zip(before.half_diff, after.half_diff, strict=True)
    )
    if turned <= _SAME_DIRECTION:
        yield Loss("anisotropy", True, "the turn of the sample about its normal is lost", figures)
    else:
        degrees = np.degrees(moved)
        yield Loss("directions", True, f"changed by up to {degrees:.2g} degrees", figures)


def _flags(before: Samples, after: Samples, marked: BoolArray) -> Iterator[Loss]:
    count = int(marked.sum())
    if not count:
        return
    left = int(np.count_nonzero(after.bits & _STATED))
    lost = left != count
    said = "kept" if not lost else "left out, because the format has no mark for them"
    yield Loss(
        "flags",
        lost,
        f"{count:,} samples marked as unreadable or rejected: {said}",
        {"before": count, "after": left},
    )


def _of_table(before: Table, written: Table, path: Path, sheet: FormatSheet) -> Iterator[Loss]:
    samples = None
    if sheet.read_table is None or sheet.averages:
        samples = read_samples(path, format=sheet.name) if sheet.read_samples else None
    table = read_table(path, format=sheet.name) if sheet.read_table else None
    after = table if table is not None else samples
    assert after is not None
    yield _channels(before, after)
    if table is not None:
        yield from _as_table(before, written, table, samples)
        yield _missing(before, table)
    elif samples is not None:
        yield from _as_samples(before, written, samples, sheet.averages)
        if before.missing:
            yield Loss(
                "missing",
                True,
                f"{before.missing:,} cells hold nothing; where the format wants a value there, it "
                f"is that of the nearest cell",
                {"before": before.missing},
            )
    yield _metadata(before.source, after.source)


def _as_table(
    before: Table, written: Table, after: Table, samples: Samples | None
) -> Iterator[Loss]:
    cells = int(before.mask.sum())
    if samples is None and after.grid == before.grid:
        yield Loss("resolution", False, f"all {_grid(before)} cells kept", {"cells": cells})
        shared = before.mask & after.mask
        yield from _values(
            written.values[shared], _spread(after.values[shared], written.n_channels)
        )
        return
    held = int(after.mask.sum()) if samples is None else len(samples)
    off = _log_differences(written, after)
    figures = {"cells": cells, "values": held, **off}
    yield Loss(
        "resolution",
        True,
        f"{cells:,} cells ({_grid(before)}) became {held:,} values on a grid of the format's own; "
        f"read back, a value is off by {off['median']:.1%} (median), {off['p95']:.1%} (95th "
        f"percentile)",
        figures,
    )
    yield from _range(written.values[written.mask], after.values[after.mask])


def _as_samples(before: Table, written: Table, after: Samples, averages: bool) -> Iterator[Loss]:
    cells = int(before.mask.sum())
    usable = after.usable.all(axis=1)
    held = int(usable.sum())
    yield Loss(
        "resolution",
        held < cells,
        f"{cells:,} cells ({_grid(before)}) became {held:,} values at directions of the format's "
        f"own; what lies between is for whoever reads them to find",
        {"cells": cells, "values": held},
    )
    expected = written.evaluate(after.wi[usable], after.wo[usable])
    got = after.value[usable]
    expected = expected @ np.array([LUMINANCE]).T if _to_luminance(expected, got) else expected
    yield from _values(expected, _spread(got, expected.shape[1]), averages)
    yield from _range(written.values[written.mask], after.value[usable])


def _channels(before: Samples | Table, after: Samples | Table) -> Loss:
    figures = {
        "before": list(before.channels),
        "after": list(after.channels),
        "wavelengths_before": _numbers(before.wavelengths),
        "wavelengths_after": _numbers(after.wavelengths),
    }
    was, now = (channels_in_words(c.channels) for c in (before, after))
    if before.wavelengths is not None and after.wavelengths is None:
        return Loss("channels", True, f"the wavelengths are lost: {was} became {now}", figures)
    if before.n_channels == 1 and after.n_channels == 3:
        return Loss("channels", False, "one channel is written three times", figures)
    if before.n_channels != after.n_channels:
        return Loss("channels", True, f"{was} became {now}", figures)
    if before.wavelengths is None and after.wavelengths is not None:
        return Loss("channels", False, f"the new file says {now} where no wavelength was", figures)
    if before.wavelengths is not None and after.wavelengths is not None:
        if np.allclose(before.wavelengths, after.wavelengths, rtol=1e-6):
            return Loss("channels", False, f"kept: {now}", figures)
        order = np.allclose(np.sort(before.wavelengths), after.wavelengths, rtol=1e-6)
        said = "put in order" if order else f"changed: {was} became {now}"
        return Loss("channels", not order, f"the wavelengths were {said}", figures)
    renamed = before.channels != after.channels
    said = f"renamed: {was} became {now}" if renamed else f"kept: {now}"
    return Loss("channels", renamed, said, figures)


def _values(before: FloatArray, after: FloatArray, averages: bool = False) -> Iterator[Loss]:
    """Yield what became of numbers that stand at the same places."""
    clipped = int(np.count_nonzero((before < 0.0) & ~(after < 0.0)))
    if clipped:
        yield Loss("range", True, f"{clipped:,} values below zero became 0", {"clipped": clipped})
    both = np.isfinite(before) & np.isfinite(after) & (before > 0.0)
    vanished = int(np.count_nonzero(np.isfinite(before) & ~np.isfinite(after)))
    if vanished:
        yield Loss("range", True, f"{vanished:,} values are gone", {"vanished": vanished})
    if not both.any():
        return
    change = np.abs(after[both] / before[both] - 1.0)
    largest, median = float(change.max()), float(np.median(change))
    p95 = float(np.percentile(change, 95.0))
    figures = {"largest": largest, "median": median, "p95": p95}
    if averages:
        said = (
            f"the format holds means, or values of its own: they differ from the table's at the "
            f"same directions by {median:.1%} (median), {p95:.1%} (95th percentile)"
        )
    elif largest > 0.0:
        said = f"a value changed by at most {largest:.1e} of itself (median {median:.1e})"
    else:
        said = "every bit kept"
    yield Loss("precision", largest > _ROUNDING, said, figures)


def _range(before: FloatArray, after: FloatArray) -> Iterator[Loss]:
    before, after = before[np.isfinite(before)], after[np.isfinite(after)]
    if not before.size or not after.size:
        return
    peaks = float(before.max()), float(after.max())
    figures = {"largest_before": peaks[0], "largest_after": peaks[1]}
    clipped = int(np.count_nonzero(before < 0.0)) if not (after < 0.0).any() else 0
    low = f"; {clipped:,} cells below zero became 0" if clipped else ""
    yield Loss(
        "range",
        peaks[1] < 0.99 * peaks[0] or bool(clipped),
        f"the largest value was {peaks[0]:.4g} 1/sr and is {peaks[1]:.4g}{low}",
        {**figures, "clipped": clipped},
    )


def _missing(before: Table, after: Table) -> Loss:
    was, now = before.missing, after.missing
    figures = {"before": was, "after": now}
    same = before.grid == after.grid and np.array_equal(before.mask, after.mask)
    if same:
        said = f"{was:,} cells hold nothing, as before" if was else "no cell is missing"
        return Loss("missing", False, said, figures)
    if now < was:
        return Loss(
            "missing",
            True,
            f"{was:,} cells held nothing, {now:,} do: a reader cannot tell which were filled",
            figures,
        )
    return Loss("missing", True, f"{was:,} cells held nothing, {now:,} do now", figures)


def _metadata(before: Source, after: Source) -> Loss:
    known = {before.name, before.sha256} - {""}
    told = " ".join([*after.metadata.values(), *after.notes, after.name, after.sha256])
    origin = all(word in told for word in known)
    fields = [key for key in before.metadata if after.metadata.get(key) != before.metadata[key]]
    notes = [note for note in before.notes if note not in after.notes]
    figures = {"origin_kept": origin, "fields_lost": fields, "notes_lost": len(notes)}
    gone = [] if origin else ["the name and hash of the first file"]
    gone += [f"{len(fields)} header field{'s' * (len(fields) > 1)}"] if fields else []
    gone += [f"{len(notes)} note{'s' * (len(notes) > 1)} of its reader"] if notes else []
    if not gone:
        return Loss("metadata", False, "kept, with the name of the first file", figures)
    return Loss("metadata", True, ", ".join(gone), figures)


def _log_differences(before: Table, after: Table) -> dict[str, float]:
    """Return the median and 95th percentile of |after / before - 1| at the cells of `before`."""
    cells = np.flatnonzero(before.mask)
    if cells.size > _BLOCK:
        cells = cells[:: -(-cells.size // _BLOCK)]
    wi, wo = before.grid.directions(cells)
    expected = before.values.reshape(-1, before.n_channels)[cells]
    got = _spread(after.evaluate(wi, wo), before.n_channels)[:, _order(before, after)]
    good = (expected > 0.0) & np.isfinite(got)
    if not good.any():
        return {"median": float("nan"), "p95": float("nan")}
    off = np.abs(got[good] / expected[good] - 1.0)
    return {"median": float(np.median(off)), "p95": float(np.percentile(off, 95.0))}


def _order(before: Table, after: Table) -> IntArray:
    """Return which channel of a file is each of the table's: some formats sort wavelengths."""
    order = np.arange(before.n_channels)
    if before.wavelengths is not None and after.wavelengths is not None:
        order[np.argsort(before.wavelengths)] = np.argsort(after.wavelengths)
    return order


def _to_luminance(expected: FloatArray, got: FloatArray) -> bool:
    return bool(expected.shape[1] == 3 and got.shape[1] == 1)


def _spread(values: FloatArray, channels: int) -> FloatArray:
    """Return values (..., channels) of a file that holds one channel three times, or as is."""
    return values[..., :1] if channels == 1 and values.shape[-1] == 3 else values


def _grid(table: Table) -> str:
    return " x ".join(str(size) for size in table.grid.shape)


def _numbers(array: FloatArray | None) -> list[float] | None:
    return None if array is None else [float(number) for number in array]
