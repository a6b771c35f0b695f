"""What brdfit brings along: the published fits, and the synthetic families beside them.

`comes_along(name)` gives a source that needs nothing but brdfit itself.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from brdfit.populations.contract import MemberSource
from brdfit.populations.joined import Joined
from brdfit.populations.published import published_fits
from brdfit.populations.recipes import RECIPES
from brdfit.populations.synthetic import Synthetic, synthetic_materials

__all__ = ["COMES_ALONG", "SHARES", "embedded_materials"]

SHARES = {
    "published": 1.0,
    "plastic": 0.1,
    "metal": 0.1,
    "mirror": 0.1,
    "flake": 0.1,
    "pearl": 0.1,
    "iridescent": 0.1,
    "cloth": 0.1,
    "retro": 0.1,
    "matte": 0.1,
}
"""What the published fits and each family count, all their members together."""


@lru_cache(maxsize=1)
def embedded_materials() -> MemberSource:
    """Return the published fits and the synthetic families, with their shares of the prior."""
    families = [Synthetic((recipe,)) for recipe in RECIPES if recipe.name in SHARES]
    shares = [SHARES["published"], *(SHARES[family.recipes[0].name] for family in families)]
    return Joined("embedded", (published_fits(), *families), tuple(shares))


COMES_ALONG: dict[str, Callable[[], MemberSource]] = {
    "published": published_fits,
    "synthetic": synthetic_materials,
    "embedded": embedded_materials,
}
"""Name -> source, of every population that needs no download."""
