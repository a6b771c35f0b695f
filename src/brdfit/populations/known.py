"""The populations that have a name: what they are, on which terms, and where from."""

from __future__ import annotations

from dataclasses import dataclass

from brdfit.populations.nbrdf import NBRDF_SHA256

__all__ = ["KNOWN", "KnownPopulation"]


@dataclass(frozen=True)
class KnownPopulation:
    """Facts about a population that brdfit knows by name."""

    name: str
    title: str
    terms: str
    """On which terms its owners give it, in a sentence."""
    page: str = ""
    """Where a person reads about it; empty where it comes with brdfit."""
    url: str = ""
    """What `fetch` downloads; empty where there is nothing to download automatically."""
    sha256: str = ""
    """Hash of what `url` gives."""


KNOWN = {
    known.name: known
    for known in (
        KnownPopulation(
            name="published",
            title="published shifted-gamma and ABC fits to the 100 MERL materials",
            terms="Figures from two publications; comes with brdfit.",
        ),
        KnownPopulation(
            name="synthetic",
            title="analytic materials of kinds that MERL lacks: films, flakes, cloth, mirrors, ...",
            terms="Made by brdfit itself; comes with brdfit.",
        ),
        KnownPopulation(
            name="embedded",
            title="the published fits and the synthetic materials, weighted on real measurements",
            terms="Figures from two publications, and made by brdfit itself; comes with brdfit.",
        ),
        KnownPopulation(
            name="nbrdf",
            title="the 100 MERL materials decoded into neural networks (Sztrajman et al. 2021)",
            terms="MIT licence.",
            page="https://github.com/asztr/Neural-BRDF",
            url="https://raw.githubusercontent.com/asztr/Neural-BRDF/HEAD/data/merl_nbrdf.zip",
            sha256=NBRDF_SHA256,
        ),
        KnownPopulation(
            name="merl",
            title="the MERL BRDF database itself, 100 measured tables (Matusik et al. 2003)",
            terms=(
                "MERL's own terms: an older header says research and academic use only, a newer "
                "README CC-BY-SA-4.0. Read them on the page before you use the data."
            ),
            page="https://www.merl.com/research/downloads/BRDF",
        ),
    )
}
"""Name -> facts."""
