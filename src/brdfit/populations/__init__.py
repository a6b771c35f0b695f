"""Materials that a reconstruction may lean on.

    population("published")                  # comes with brdfit: fits to the 100 MERL materials
    population("nbrdf")                      # the same materials as networks, once fetched
    population("merl_nbrdf.zip")             # an archive of networks
    population("merl/")                      # a folder of MERL .binary files
    population(...).without(["chrome"])      # leave one out

A population answers at any direction; `columns` keeps what it answers on a whole grid.
"""

from __future__ import annotations

from brdfit.populations.cache import cache_folder, remember
from brdfit.populations.columns import Columns, columns
from brdfit.populations.contract import VALUE_FLOOR, MemberSource, Population
from brdfit.populations.fetch import fetch
from brdfit.populations.front import population
from brdfit.populations.upkeep import (
    CheckReport,
    Cleared,
    Finding,
    PopulationInfo,
    build,
    check,
    clear,
    list_populations,
)

__all__ = [
    "VALUE_FLOOR",
    "CheckReport",
    "Cleared",
    "Columns",
    "Finding",
    "MemberSource",
    "Population",
    "PopulationInfo",
    "build",
    "cache_folder",
    "check",
    "clear",
    "columns",
    "fetch",
    "list_populations",
    "population",
    "remember",
]
