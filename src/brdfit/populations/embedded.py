"""What brdfit brings along: the published fits, and the synthetic families beside them.

`comes_along(name)` gives a source that needs nothing but brdfit itself.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from brdfit.populations.contract import MemberSource
from brdfit.populations.joined import Joined
from brdfit.populations.published import published_fits
from brdfit.populations.synthetic import synthetic_materials

__all__ = ["COMES_ALONG", "SHARES", "embedded_materials"]

SHARES = {
    "published": 1.0,
    "plastic": 0.033,
    "metal": 0.1,
    "mirror": 0.033,
    "flake": 0.1,
    "pearl": 0.1,
    "iridescent": 0.3,
    "cloth": 0.9,
    "powder": 0.1,
    "retro": 0.1,
    "matte": 0.1,
}
"""What the published fits and each family count, all their members together.

Chosen on half of the real files, those that nothing is reported on:
`benchmarks/population_shares.py`, whose record is `benchmarks/results/population_shares.json`.
"""


@lru_cache(maxsize=1)
def embedded_materials() -> MemberSource:
    """Return the published fits and the synthetic families, with their shares of the prior."""
    published, synthetic = published_fits(), synthetic_materials()
    kinds = ["published"] * len(published.members) + list(synthetic.materials)
    counts = Counter(kinds)
    weights = np.array([SHARES[kind] / counts[kind] for kind in kinds])
    return Joined("embedded", (published, synthetic), weights / weights.sum())


COMES_ALONG: dict[str, Callable[[], MemberSource]] = {
    "published": published_fits,
    "synthetic": synthetic_materials,
    "embedded": embedded_materials,
}
"""Name -> source, of every population that needs no download."""
