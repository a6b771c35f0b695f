"""Families of materials that a population of measured ones lacks, as recipes with ranges.

A recipe turns evenly spread numbers into the parameters of one analytic model, a column for
each channel of each member. Nothing here was fitted to a measurement: the ranges are those
in which such materials are made (indices of lacquers and pigments, thickness of films) or
measured (roughness), wide rather than likely. How much each family counts is another matter,
and stands with the populations that combine them (`embedded`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.files import sha256_of_bytes
from brdfit.models import (
    CoatedDiffuse,
    Flakes,
    Ggx,
    Lambert,
    Layered,
    Particulate,
    PearlFlakes,
    Retro,
    RoughDiffuse,
    Sheen,
    Student,
    ThinFilm,
)

__all__ = ["BANDS", "RECIPES", "Draws", "Recipe"]

BANDS = (610.0, 545.0, 455.0)
"""Middle of the red, green and blue band, nm."""


class Draws:
    """Evenly spread numbers for `count` members, a new dimension at each call.

    Each dimension holds the middles of `count` equal strata of [0, 1), in an order of its own
    (a Latin hypercube). The order follows from hashes, and so is the same on every machine
    and with every version of what brdfit is built on.
    """

    def __init__(self, family: str, count: int) -> None:
        self.family = family
        self.count = count
        self._dimension = 0

    def share(self) -> FloatArray:
        """Return numbers in [0, 1), (members,)."""
        key = f"{self.family} {self._dimension}"
        self._dimension += 1
        hashes = [sha256_of_bytes(f"{key} {member}".encode()) for member in range(self.count)]
        return np.asarray((np.argsort(np.argsort(hashes)) + 0.5) / self.count)

    def linear(self, low: float, high: float) -> FloatArray:
        """Return numbers evenly between `low` and `high`, a column per channel and member."""
        return self._columns(low + (high - low) * self.share())

    def log(self, low: float, high: float) -> FloatArray:
        """Return numbers whose logarithms are evenly spread, a column per channel and member."""
        return self._columns(low * (high / low) ** self.share())

    def tint(self, low: float, high: float, spread: float) -> FloatArray:
        """Return reflectances: a level as `log`, each channel up to `spread` times off it."""
        level = low * (high / low) ** self.share()
        channels = [spread ** (2.0 * self.share() - 1.0) for _ in BANDS]
        return np.concatenate([np.minimum(level * channel, 0.98) for channel in channels])

    def bands(self) -> FloatArray:
        """Return the wavelength of each column, nm."""
        return np.repeat(BANDS, self.count)

    def _columns(self, values: FloatArray) -> FloatArray:
        # all members of the first channel, then of the second, ...
        return np.tile(values, len(BANDS))


@dataclass(frozen=True)
class Recipe:
    """A family: its name, how many members it has, and how their parameters are made."""

    name: str
    members: int
    make: Callable[[Draws], Layered]


def _plastic(draws: Draws) -> Layered:
    """Return a glossy to satin coat over a diffuse base, black to white."""
    f0 = draws.linear(0.025, 0.08)
    alpha = draws.log(0.005, 0.5)
    return Layered(
        (
            CoatedDiffuse(draws.tint(0.0005, 0.9, 3.0), draws.linear(1.3, 1.7)),
            Student(f0, alpha, draws.log(1.2, 12.0)),
            Student(f0 * draws.log(0.003, 0.3), np.minimum(alpha * draws.log(3.0, 12.0), 1.0)),
        )
    )


def _metal(draws: Draws) -> Layered:
    """Return bare metal from polished to blasted: a tinted lobe with a wider one below."""
    f0 = draws.tint(0.1, 0.9, 1.5)
    alpha = draws.log(0.01, 0.6)
    return Layered(
        (
            Lambert(draws.log(0.0003, 0.05)),
            Student(f0, alpha, draws.log(1.2, 12.0)),
            Student(f0 * draws.log(0.003, 0.5), np.minimum(alpha * draws.log(2.0, 8.0), 1.0)),
        )
    )


def _mirror(draws: Draws) -> Layered:
    """Return near-mirror foils and platings: a lobe of a tenth of a degree to two, and haze."""
    f0 = draws.tint(0.03, 0.9, 2.0)
    alpha = draws.log(0.0015, 0.04)
    return Layered(
        (
            CoatedDiffuse(draws.tint(0.0002, 0.1, 2.0)),
            Student(f0, alpha, draws.log(1.2, 12.0)),
            Student(f0 * draws.log(0.003, 0.3), alpha * draws.log(3.0, 12.0)),
            Student(f0 * draws.log(0.002, 0.1), draws.log(0.1, 0.6), draws.log(1.5, 6.0)),
        )
    )


def _flake(draws: Draws) -> Layered:
    """Return metallic paint: flakes and a diffuse ground under a glossy to satin coat."""
    ior = draws.linear(1.4, 1.65)
    return Layered(
        (
            Student(_normal(ior), draws.log(0.003, 0.2), draws.log(1.2, 12.0)),
            Flakes(draws.log(0.06, 0.5), draws.tint(0.05, 0.9, 2.0), ior),
            CoatedDiffuse(draws.tint(0.003, 0.4, 3.0), ior),
        )
    )


def _pearl(draws: Draws) -> Layered:
    """Return interference pigments (titania on mica, or on a metal) under a coat."""
    ior = draws.linear(1.4, 1.65)
    extinction = draws.linear(-4.0, 6.0)
    return Layered(
        (
            Student(_normal(ior), draws.log(0.003, 0.2), draws.log(1.2, 12.0)),
            PearlFlakes(
                draws.log(0.06, 0.5),
                draws.linear(0.2, 1.0),
                draws.linear(30.0, 300.0),
                draws.bands(),
                draws.linear(1.7, 2.6),
                extinction=np.maximum(extinction, 0.0),
                ior=ior,
            ),
            CoatedDiffuse(draws.tint(0.003, 0.6, 2.0), ior),
        )
    )


def _iridescent(draws: Draws) -> Layered:
    """Return a film on the surface itself: oxides, colour-changing foils."""
    return Layered(
        (
            ThinFilm(
                draws.log(0.005, 0.4),
                draws.linear(80.0, 700.0),
                draws.bands(),
                draws.linear(1.3, 2.4),
                draws.linear(0.5, 2.5),
                np.maximum(draws.linear(-2.0, 6.0), 0.0),
            ),
            Ggx(draws.tint(0.0005, 0.2, 2.0), draws.tint(0.003, 0.2, 1.5), draws.log(0.15, 0.7)),
        )
    )


def _cloth(draws: Draws) -> Layered:
    """Return cloth, felt, dust: rough diffuse with a sheen."""
    return Layered(
        (
            RoughDiffuse(draws.tint(0.01, 0.9, 3.0), draws.linear(0.0, 1.0)),
            Sheen(draws.tint(0.02, 0.9, 1.5), draws.log(0.1, 1.0)),
        )
    )


def _powder(draws: Draws) -> Layered:
    """Return powder, dust, earth: particles that scatter forth or back, and shadow each other."""
    return Layered(
        (
            Particulate(
                draws.tint(0.1, 0.98, 1.3),
                draws.linear(-0.5, 0.5),
                draws.linear(0.0, 1.0),
                draws.log(0.02, 0.5),
            ),
            Student(draws.log(0.0005, 0.04), draws.log(0.2, 1.0), draws.log(1.5, 6.0)),
        )
    )


def _retro(draws: Draws) -> Layered:
    """Return matter that shines back at the light, strongly (beads) or slightly (backscatter)."""
    return Layered(
        (
            RoughDiffuse(draws.tint(0.01, 0.9, 2.0), draws.linear(0.0, 1.0)),
            Retro(draws.tint(0.002, 0.5, 1.5), draws.log(0.02, 0.6)),
            Student(draws.log(0.005, 0.05), draws.log(0.05, 0.7), draws.log(1.2, 6.0)),
        )
    )


def _matte(draws: Draws) -> Layered:
    """Return paper, plaster, matte lacquer: rough diffuse with at most a wide faint lobe."""
    return Layered(
        (
            RoughDiffuse(draws.tint(0.01, 0.95, 3.0), draws.linear(0.0, 1.0)),
            Student(draws.log(0.002, 0.06), draws.log(0.2, 1.0), draws.log(1.5, 6.0)),
        )
    )


def _normal(ior: FloatArray) -> FloatArray:
    """Return the reflectance of a dielectric at normal incidence."""
    return np.asarray(((ior - 1.0) / (ior + 1.0)) ** 2)


RECIPES = (
    Recipe("plastic", 20, _plastic),
    Recipe("metal", 20, _metal),
    Recipe("mirror", 20, _mirror),
    Recipe("flake", 20, _flake),
    Recipe("pearl", 20, _pearl),
    Recipe("iridescent", 20, _iridescent),
    Recipe("cloth", 20, _cloth),
    Recipe("powder", 20, _powder),
    Recipe("retro", 20, _retro),
    Recipe("matte", 20, _matte),
)
"""Every family, in the order of the members."""
