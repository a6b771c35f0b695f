"""RT-300S `.xls`: what J&C's goniometer exports, read together with its blank measurement."""

from __future__ import annotations

from pathlib import Path

from brdfit.formats.sheet import FormatSheet
from brdfit.samples import Samples

__all__ = ["CONVENTION", "SHEET"]

CONVENTION = (
    "degrees; the detector turns in one plane by Receive, the light stands at Incidence in a plane "
    "turned by Azimuth, specular at Azimuth -90 and Receive = Incidence; values are "
    "(RT - RT of the blank) / (pi cos Receive), f_r in 1/sr"
)

_COMPOUND_DOCUMENT = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"


def _sniff(path: Path, head: bytes) -> bool:
    return head.startswith(_COMPOUND_DOCUMENT)


def _read_samples(
    path: Path,
    *,
    blank: str | Path | bool | None = None,
    obscured: float = 6.0,
    wavelength: float | None = None,
) -> Samples:
    from brdfit.formats.rt300s.read import read_samples

    return read_samples(path, blank=blank, obscured=obscured, wavelength=wavelength)


SHEET = FormatSheet(
    name="rt300s",
    title="J&C RT-300S goniometer (.xls)",
    extensions=(".xls",),
    specification=(
        "the columns Azimuth, Incidence, Receive, RT of its export; their use after the bsdf-tools "
        "of the Large Optics Fabrication and Testing group, University of Arizona, "
        "https://github.com/ua-loft/bsdf-tools"
    ),
    convention=CONVENTION,
    sniff=_sniff,
    read_samples=_read_samples,
    options=("blank", "obscured", "wavelength"),
)
"""The data sheet."""
