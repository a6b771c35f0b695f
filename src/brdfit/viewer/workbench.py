"""`Workbench`: all that the page can do, as functions of Python without a server.

with Workbench() as bench:
    bench.open("krylon_blue.binary")
    bench.slice("e1", theta_i=45.0, phi=180.0)
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any

from brdfit.errors import BrdfitError, UsageError
from brdfit.formats import list_formats, write_samples, write_table
from brdfit.progress import Progress
from brdfit.reconstruct.result import Method, Reconstruction
from brdfit.render import ILLUMINATIONS, Illumination
from brdfit.report.compare import compare
from brdfit.report.fitted import Fitted
from brdfit.report.reading_options import typed_options
from brdfit.report.rgb import needs_rgb, rgb_table
from brdfit.samples import Samples
from brdfit.table import Table
from brdfit.versions import version_of
from brdfit.viewer.describe import reading_settings, writable
from brdfit.viewer.environment import environment_from
from brdfit.viewer.item import Item
from brdfit.viewer.jobs import Jobs
from brdfit.viewer.messages import (
    ComparisonTable,
    FitRequest,
    Home,
    Job,
    LightSet,
    MetricRow,
    Upload,
)
from brdfit.viewer.opening import open_path
from brdfit.viewer.refit import method_infos, requested_method, with_rejected
from brdfit.viewer.store import Held, Store
from brdfit.viewer.warned import heard

__all__ = ["UPLOAD_LIMIT", "Workbench"]

UPLOAD_LIMIT = 256 << 20
"""Bytes of an uploaded file."""

_TITLES = {
    "studio": "studio of 40 lights",
    "area_studio": "studio of three area lights",
    "point": "point light",
}


class Workbench:
    """The items of one session, and everything that is asked of them."""

    def __init__(self, method: Method | None = None) -> None:
        self.store = Store()
        self.jobs = Jobs()
        self._method = method
        self._first_jobs: list[str] = []
        # Once, and here: it parses source, which Python 3.11 cannot do on two threads at once.
        self._methods = method_infos()

    def __enter__(self) -> Workbench:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Stop what runs; remove every file that was uploaded."""
        self.jobs.close()
        self.store.close()

    # What there is at the start

    def open(self, what: str | os.PathLike[str] | Table | Reconstruction, **options: Any) -> None:
        """Show a file, a table or a reconstruction; measurements are fitted, see `first_jobs`.

        `options` are those of the file's reader. Raises `BrdfitError` for what cannot be read.
        """
        id = self.store.next_id("e")
        found: Item | Held
        if isinstance(what, Table):
            found = Item(id, what.source.name, Fitted.of_table(what))
        elif isinstance(what, Reconstruction):
            found = Item(id, what.samples.source.name, Fitted.of(what), result=what)
        else:
            found = open_path(Path(what), id, options)
        if isinstance(found, Item):
            self.store.open(found)
            self._pack_ahead(found)
            return
        found = replace(found, id=self.store.next_id("u"))
        self.store.add(found)
        job = self._fit(FitRequest(source=found.id), found, keep=True)
        self._first_jobs.append(job.id)

    def _pack_ahead(self, item: Item) -> None:
        """Pack the table while the browser starts; where that fails, the page is told."""

        def pack() -> None:
            with contextlib.suppress(BrdfitError):
                _ = item.packed

        threading.Thread(target=pack, name="brdfit-pack", daemon=True).start()

    def home(self) -> Home:
        """Return what the page asks for first."""
        return Home(
            version=version_of(),
            entries=[item.id for item in self.store.opened],
            jobs=list(self._first_jobs),
            methods=self._methods,
            lights=[lights_message(make()) for make in ILLUMINATIONS.values()],
            reading=reading_settings(),
            upload_limit=UPLOAD_LIMIT,
        )

    # What can be done

    def upload(self, path: Path, options: dict[str, Any] | None = None) -> Upload:
        """Take in a file that lies in a folder of its own within the private one.

        `options` are those of its reader, also as texts (`brdfit.report.reading_options`).
        The file belongs to the store from now on; what cannot be read is removed.
        """
        try:
            found = open_path(path, self.store.next_id("u"), typed_options(options or {}))
        except BaseException:
            shutil.rmtree(path.parent)
            raise
        self.store.add(found)
        name = path.name
        if isinstance(found, Item):
            count = int(found.table.mask.sum())
            return Upload(found.id, name, "table", count, found.id, list(found.warnings))
        return Upload(found.id, name, "samples", len(found.samples), None, list(found.warnings))

    def environment(self, path: Path) -> LightSet:
        """Return the lights of a panorama that lies in a folder of its own; the file goes."""
        try:
            with heard() as warned:
                lights = environment_from(path)
        finally:
            shutil.rmtree(path.parent)
        return lights_message(lights, warned.messages)

    def fit(self, request: FitRequest) -> Job:
        """Queue a fit; `UsageError` for what the request cannot mean."""
        return self._fit(request, self.store.get(request.source))

    def _fit(self, request: FitRequest, source: Item | Held, keep: bool = False) -> Job:
        samples, item = _samples_of(source)
        samples = with_rejected(samples, request)
        samples.require_usable()
        if item is None and self._method is not None and not request.method:
            method, notes = self._method, list[str]()
        else:
            method, notes = requested_method(request, item)
        id = self.store.next_id("e")
        warned = tuple(dict.fromkeys((*source.warnings, *notes)))
        path = source.source

        def work(progress: Progress) -> Item:
            result = method.fit(samples, progress)
            fitted = Fitted.of(result, progress)
            parent = None if item is None else item.id
            made = Item(id, source.name, fitted, result, path, warned, parent)
            _prepare(made, progress)
            self.store.add(made)
            return made

        title = f"{source.name} by {method.name}"
        replaces = None if item is None or request.beside else item.id
        job_id = self.store.next_id("j")
        return self.jobs.start(job_id, title, work, replaces=replaces, keep=keep)

    def compare(self, reference: str, test: str) -> ComparisonTable:
        """Return every metric of one item against another."""
        first, second = self.store.item(reference), self.store.item(test)
        found = compare(first.rgb, second.rgb, illuminations=("studio", "point"))
        rows = [
            _row(name, light, value)
            for light, values in found.images.items()
            for name, value in values.items()
        ]
        rows += [_row(name, "values", score.value) for name, score in found.values.items()]
        notes = [*found.notes, *(f"{name}: {why}" for name, why in found.absent.items())]
        return ComparisonTable(reference, test, rows, notes)

    def download(self, id: str, kind: str, format: str) -> tuple[Path, str]:
        """Write an item in a format; return (a file in the private folder, its name for people).

        Whoever asked removes the file. Raises `UsageError` for a format that there is not.
        """
        item = self.store.item(id)
        offered = {(str(one.kind), one.format): one for one in writable(item)}
        one = offered.get((kind, format))
        if one is None:
            known = ", ".join(f"{kind} as {format}" for kind, format in offered)
            raise UsageError(f"download: found {kind} as {format} but there are {known}.")
        path = self.store.folder / f"{self.store.next_id('d')}{one.suffix}"
        # what a format loses stands beside its link
        with heard():
            _writer(item, kind, format)(path)
        stem = Path(item.name.split(" (")[0]).stem or "brdf"
        return path, stem + one.suffix


def _samples_of(source: Item | Held) -> tuple[Samples, Item | None]:
    if isinstance(source, Held):
        return source.samples, None
    if source.fitted.judged is None:
        raise UsageError(
            f"{source.name}: is a table alone. Open the measurements, or the table together with "
            f"the .json and .csv that brdfit fit left beside it."
        )
    return source.fitted.judged.samples, source


def _prepare(item: Item, progress: Progress) -> None:
    """Work out what the page asks for next, while it still waits for the fit."""
    progress("packing", 0, 1)
    _ = item.packed
    progress("packing", 1, 1)


def _writer(item: Item, kind: str, format: str) -> Callable[[Path], Any]:
    judged = item.fitted.judged
    if kind == "record":
        text = json.dumps(item.record, indent=1, default=str)
        return lambda path: path.write_text(text + "\n", encoding="utf-8")
    if kind == "samples":
        assert judged is not None
        return lambda path: write_samples(judged.samples, path, format=format)
    sheet = next(sheet for sheet in list_formats() if sheet.name == format)
    table = rgb_table(item.table)[0] if needs_rgb(item.table, sheet) else item.table
    return lambda path: write_table(table, path, format=sheet.name)


def lights_message(lights: Illumination, warnings: tuple[str, ...] = ()) -> LightSet:
    """Return lights as the page takes them."""
    return LightSet(
        name=lights.name,
        title=_TITLES.get(lights.name, lights.name),
        direction=lights.direction.tolist(),
        irradiance=lights.irradiance.tolist(),
        surround=list(lights.surround),
        warnings=list(warnings),
    )


def _row(name: str, where: str, value: float) -> MetricRow:
    from brdfit.metrics import METRICS

    metric = METRICS[name]
    finite = value if abs(value) < float("inf") else None
    return MetricRow(
        name=name,
        title=metric.title,
        where=where,
        value=finite,
        text=f"{value:.4g}",
        unit=metric.unit,
        higher_is_better=metric.higher_is_better,
    )
