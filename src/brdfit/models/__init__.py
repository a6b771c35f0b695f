"""Analytic BRDFs, vectorised over directions: synthetic truth, and the published fits.

Every model is a frozen dataclass of parameters with `evaluate(wi, wo) -> (n, channels)`
in 1/sr, cosine not included, 0 below the horizon. One published model, one module. A
parameter is one value or one per column; a column is a channel, or a channel of one of many
materials, so the same code evaluates one material and a hundred.
"""

from __future__ import annotations

from brdfit.models.abc import Abc, AbcLobe
from brdfit.models.angles import COS_FLOOR, PairAngles
from brdfit.models.coated import CoatedDiffuse, Flakes, PearlFlakes
from brdfit.models.ggx import Ggx
from brdfit.models.lambert import Lambert
from brdfit.models.layered import Layered
from brdfit.models.particulate import Particulate
from brdfit.models.retro import Retro
from brdfit.models.rough_diffuse import RoughDiffuse
from brdfit.models.sheen import Sheen
from brdfit.models.shifted_gamma import ShiftedGamma
from brdfit.models.student import Student
from brdfit.models.thin_film import ThinFilm

__all__ = [
    "COS_FLOOR",
    "Abc",
    "AbcLobe",
    "CoatedDiffuse",
    "Flakes",
    "Ggx",
    "Lambert",
    "Layered",
    "PairAngles",
    "Particulate",
    "PearlFlakes",
    "Retro",
    "RoughDiffuse",
    "Sheen",
    "ShiftedGamma",
    "Student",
    "ThinFilm",
]
