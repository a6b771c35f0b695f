"""The population that comes with brdfit: published fits to the 100 MERL materials.

200 members, two for each material: "alum-bronze/shifted_gamma" (Bagher et al. 2012) and
"alum-bronze/abc" (Low et al. 2012). Nothing to download; the figures are a table of the
package (`data/published_fits.csv`, citations in its head).

What is altered: cosines in a denominator are held at 89.5 degrees and above, negative
Fresnel terms at zero (see `brdfit.models`). With that every member is finite and above
zero at every pair of directions above the horizon.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib.resources import files

import numpy as np

from brdfit.arrays import FloatArray, IntArray, as_directions
from brdfit.files import sha256_of_bytes
from brdfit.models import AbcLobe, PairAngles, ShiftedGamma
from brdfit.populations.contract import MemberSource, member_values

__all__ = ["CITATION", "PublishedFits", "published_fits"]

CITATION = (
    "Fits to the MERL database: Bagher, Soler, Holzschuch 2012 (shifted gamma); "
    "Low, Kronander, Ynnerman, Unger 2012 (ABC)."
)

CHANNELS = ("R", "G", "B")

# Raise it when a change of the models changes values: caches of the old ones then expire.
_VERSION = 1
# Rows of a block whose temporaries (block x materials, float64) stay in the processor's cache.
_BLOCK = 512

# Columns of the table in the order of the models' fields.
_SHIFTED_GAMMA = (
    *("rho_d", "rho_s", "alpha", "p", "f0", "f1", "kap"),
    *("lambda", "c", "k", "theta0"),
)
_ABC = ("rho_d", "a", "b", "c", "ior")


@dataclass(frozen=True, eq=False)
class PublishedFits:
    """A `MemberSource` over the rows of the table of published fits."""

    table: bytes
    """The CSV file as it is."""

    @property
    def name(self) -> str:
        """Always "published"."""
        return "published"

    @property
    def channels(self) -> tuple[str, ...]:
        """R, G, B."""
        return CHANNELS

    @property
    def bilateral(self) -> bool:
        """Both models are symmetric in theta_i and theta_o at given theta_h and theta_d."""
        return True

    @cached_property
    def members(self) -> tuple[str, ...]:
        """Material/model, the shifted-gamma fits first."""
        return tuple(f"{material}/{model}" for material, model in self._rows)

    @cached_property
    def materials(self) -> tuple[str, ...]:
        """Material of each member."""
        return tuple(material for material, _ in self._rows)

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 of the table and the version of its evaluation."""
        return sha256_of_bytes(self.table + f"published {_VERSION}".encode())

    @cached_property
    def _rows(self) -> dict[tuple[str, str], dict[str, dict[str, str]]]:
        # (material, model) -> channel -> row of the file
        lines = (line for line in self.table.decode().splitlines() if not line.startswith("#"))
        rows: dict[tuple[str, str], dict[str, dict[str, str]]] = {}
        for row in csv.DictReader(lines):
            rows.setdefault((row["material"], row["model"]), {})[row["channel"]] = row
        # A stable order with each model in one piece, whatever the order of the file.
        return dict(sorted(rows.items(), key=lambda item: (item[0][1] == "abc", item[0][0])))

    @cached_property
    def _figures(self) -> dict[str, FloatArray]:
        """Each parameter as (channels, members); NaN where a model does not have it."""
        names = (*_SHIFTED_GAMMA, *_ABC)
        return {
            name: np.array(
                [
                    [float(rows[channel][name] or "nan") for rows in self._rows.values()]
                    for channel in CHANNELS
                ]
            )
            for name in dict.fromkeys(names)
        }

    def evaluate(self, wi: FloatArray, wo: FloatArray, pick: IntArray) -> FloatArray:
        """Return f_r (n, len(pick), 3), float32, at direction pairs (n, 3); 0 below the horizon."""
        wi, wo = as_directions("wi", wi), as_directions("wo", wo)
        by_channel = np.empty((len(CHANNELS), len(wi), len(pick)), dtype=np.float32)
        groups = self._groups(np.asarray(pick))
        for start in range(0, len(wi), _BLOCK):
            rows = slice(start, start + _BLOCK)
            angles = PairAngles.of(wi[rows], wo[rows])
            for group in groups:
                group.put(angles, by_channel[:, rows])
            if not angles.above.all():
                by_channel[:, rows][:, ~angles.above[:, 0]] = 0.0
        return member_values(by_channel)

    def _groups(self, pick: IntArray) -> list[_GammaGroup | _AbcGroup]:
        """Gather the picked members by model, so that each model is evaluated at once."""
        is_gamma = np.array([member.endswith("/shifted_gamma") for member in self.members])[pick]
        groups: list[_GammaGroup | _AbcGroup] = []
        if is_gamma.any():
            figures = [self._figures[name][:, pick[is_gamma]] for name in _SHIFTED_GAMMA]
            models = tuple(ShiftedGamma(*columns) for columns in zip(*figures, strict=True))
            groups.append(_GammaGroup(np.flatnonzero(is_gamma), models))
        if not is_gamma.all():
            k_d, a, b, c, ior = (self._figures[name][:, pick[~is_gamma]] for name in _ABC)
            # b, c and the index of refraction are the same in the three channels of a fit
            lobe = AbcLobe(b[0], c[0], ior[0])
            groups.append(_AbcGroup(np.flatnonzero(~is_gamma), lobe, k_d / np.pi, a))
        return groups


@dataclass(frozen=True, eq=False)
class _GammaGroup:
    """Shifted-gamma members: one model per channel, a column per member."""

    to: IntArray
    """Where the members go among those picked, ascending."""
    models: tuple[ShiftedGamma, ...]

    def put(self, angles: PairAngles, out: FloatArray) -> None:
        """Write the values to the columns `to` of `out` (channels, n, members)."""
        for values, model in zip(out, self.models, strict=True):
            values[:, self.to] = model.at(angles)


@dataclass(frozen=True, eq=False)
class _AbcGroup:
    """ABC members; the channels of a material share one lobe, computed once."""

    to: IntArray
    """Where the members go among those picked, ascending."""
    lobe: AbcLobe
    diffuse: FloatArray
    """k_d / pi, (channels, members)."""
    a: FloatArray
    """(channels, members)."""

    def put(self, angles: PairAngles, out: FloatArray) -> None:
        """Write the values to the columns `to` of `out` (channels, n, members)."""
        lobe = self.lobe.at(angles)
        for values, diffuse, a in zip(out, self.diffuse, self.a, strict=True):
            values[:, self.to] = lobe * a + diffuse


@lru_cache(maxsize=1)
def published_fits() -> MemberSource:
    """Return the source of the embedded table."""
    return PublishedFits(
        files("brdfit.populations").joinpath("data/published_fits.csv").read_bytes()
    )
