"""`brdfit bench paper`: the poster's tables on a population of choice, by one command."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from brdfit.bench.ledger import read_result, record_seconds, versions
from brdfit.bench.options import Say, add_run_arguments, ledger_of, result_of, share
from brdfit.bench.outliers import DEFAULT_OUTLIERS, OUTLIER_MODELS
from brdfit.bench.paper.few import row_of
from brdfit.bench.paper.parts import Run, charts, work
from brdfit.bench.paper.poster import DATA_RATIOS, OUTLIER_RATIOS
from brdfit.bench.paper.reproduction import page
from brdfit.bench.paper.settings import FEW_ROWS, PARTS, FewRow, PaperSettings
from brdfit.errors import UsageError
from brdfit.files import atomic_path
from brdfit.progress import Progress

if TYPE_CHECKING:
    from brdfit.populations import Population

__all__ = ["HELP", "add_arguments", "run"]

HELP = "regenerate every table of the published poster on a population of choice"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark."""
    parser.add_argument(
        "--population",
        default="nbrdf",
        metavar="NAME|PATH",
        help="materials to reconstruct and to lean on: a name, an archive of networks, or a "
        "folder of MERL tables (default: nbrdf)",
    )
    parser.add_argument(
        "--data", type=Path, metavar="DIR", help="folder of real measurements for the real table"
    )
    parser.add_argument(
        "--parts", nargs="+", choices=list(PARTS), help="make only these (default: all)"
    )
    parser.add_argument(
        "--methods",
        nargs="+",
        metavar="NAME",
        help="these columns (default: our glo loc tab, the poster's, and post); there is also pca",
    )
    parser.add_argument(
        "--outliers",
        choices=list(OUTLIER_MODELS),
        default=DEFAULT_OUTLIERS,
        help=f"how measurements go wrong (default: {DEFAULT_OUTLIERS})",
    )
    parser.add_argument(
        "--full",
        action="store_true",
        help="measure every cell of the grid, not a twentieth of them",
    )
    parser.add_argument(
        "--universe", type=share, default=0.05, help="share of the cells measured (default: 0.05)"
    )
    parser.add_argument(
        "--materials", type=int, default=0, metavar="N", help="reconstruct only N (default: all)"
    )
    _add_cell_arguments(parser)
    parser.add_argument(
        "--docs", type=Path, metavar="PAGE", help="write the page of tables here as well"
    )
    add_run_arguments(parser, "benchmarks/results/paper.json")


def _add_cell_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--rows",
        nargs="+",
        type=_row,
        default=list(FEW_ROWS),
        metavar="N:MODEL",
        help="tables of few samples: so many samples, wrong by this outlier model (default: "
        + " ".join(f"{count}:{model}" for count, model in FEW_ROWS)
        + ")",
    )
    for name, what, ratios in (
        ("--outlier-ratios", "shares of the samples that are wrong", OUTLIER_RATIOS),
        ("--data-ratios", "shares of the universe that are samples", DATA_RATIOS),
    ):
        parser.add_argument(
            name,
            nargs="+",
            type=float,
            default=list(ratios),
            metavar="SHARE",
            help=f"{what} (default: {' '.join(f'{ratio:g}' for ratio in ratios)})",
        )


def _row(text: str) -> FewRow:
    try:
        return row_of(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"found {text!r} but expected samples and outlier model, as in 1000:factor"
        ) from None


def run(arguments: argparse.Namespace, progress: Progress, say: Say) -> None:
    """Run the benchmark; leave the result, the page of tables, and the figures."""
    if arguments.from_result:
        _write_pages(arguments, result_of(arguments.output, "paper"), say)
        return
    settings = _settings(arguments)
    population = _population(arguments.population)
    plan = Run.plan(settings, population, arguments.data, arguments.methods)
    ledger = ledger_of(arguments, _header(arguments, settings, population, plan))
    records = ledger.run(
        plan.tasks, work, lambda left: plan.prepared(left, progress), progress, say, "paper"
    )
    plan.pictures(records, _figure_folder(arguments.output), progress)
    _write_pages(arguments, read_result(ledger.result), say)


def _settings(arguments: argparse.Namespace) -> PaperSettings:
    parts = arguments.parts or list(PARTS)
    if arguments.data is None:
        if arguments.parts and "real" in arguments.parts:
            raise UsageError("--parts real: needs --data DIR, a folder of real measurements.")
        parts = [part for part in parts if part != "real"]
    return PaperSettings(
        seed=arguments.seed,
        outliers=arguments.outliers,
        few=tuple(dict.fromkeys(arguments.rows)),
        data_ratios=tuple(dict.fromkeys(arguments.data_ratios)),
        outlier_ratios=tuple(dict.fromkeys(arguments.outlier_ratios)),
        universe=1.0 if arguments.full else arguments.universe,
        materials=arguments.materials,
        parts=tuple(parts),
    )


def _population(name: str) -> Population:
    from brdfit.populations import population

    return population(name)


def _header(
    arguments: argparse.Namespace, settings: PaperSettings, population: Population, plan: Run
) -> dict[str, Any]:
    return {
        "benchmark": "paper",
        "command": _command(arguments, settings),
        "settings": settings.record(),
        "population": {
            # A population given by its path is named as its file: a folder says nothing.
            "name": Path(population.name).name,
            "fingerprint": population.fingerprint,
            "members": len(population),
        },
        "methods": plan.method_records(),
        "inputs": plan.input_hashes(),
        "versions": versions(),
    }


def _command(arguments: argparse.Namespace, settings: PaperSettings) -> str:
    """Return the command that repeats the run; folders are named by their last part."""
    words = ["brdfit bench paper", f"--population {Path(arguments.population).name}"]
    words += [f"--outliers {settings.outliers}", f"--seed {settings.seed}"]
    if arguments.data is not None:
        words.append(f"--data {arguments.data.resolve().name}")
    if arguments.full:
        words.append("--full")
    elif settings.universe != PaperSettings.universe:
        words.append(f"--universe {settings.universe:g}")
    if settings.materials:
        words.append(f"--materials {settings.materials}")
    if settings.data_ratios != DATA_RATIOS:
        words.append("--data-ratios " + " ".join(f"{ratio:g}" for ratio in settings.data_ratios))
    if settings.outlier_ratios != OUTLIER_RATIOS:
        shares = " ".join(f"{ratio:g}" for ratio in settings.outlier_ratios)
        words.append(f"--outlier-ratios {shares}")
    if "few" in settings.parts and settings.few != FEW_ROWS:
        words.append("--rows " + " ".join(f"{count}:{model}" for count, model in settings.few))
    if arguments.methods:
        words.append("--methods " + " ".join(arguments.methods))
    if arguments.parts:
        words.append("--parts " + " ".join(arguments.parts))
    return " ".join(words)


def _figure_folder(result: Path) -> Path:
    return result.with_suffix("")


def _write_pages(arguments: argparse.Namespace, content: dict[str, Any], say: Say) -> None:
    folder = _figure_folder(arguments.output)
    figures, seconds = charts(content, folder), record_seconds(arguments.output)
    targets = [arguments.output.with_suffix(".md")]
    targets += [arguments.docs] if arguments.docs is not None else []
    for target in targets:
        links = {name: _link(path, target) for name, path in figures.items()}
        with atomic_path(target) as aside:
            aside.write_text(page(content, links, seconds), encoding="utf-8")
    say(f"wrote {arguments.output}, {', '.join(map(str, targets))} and figures in {folder}")


def _link(path: Path, page_path: Path) -> str:
    return Path(os.path.relpath(path, page_path.parent)).as_posix()
