"""Which real files the posterior's constants have seen, so that the others can be told apart.

Kernel shapes, the degrees of freedom of a good sample and how deviations are calibrated were
chosen on these. So were how low the bound of a negative value may be (chm_mint asked for it) and
the say of members unlike the material (paper_white). The shares of the embedded
population were chosen on a half of its own (`benchmarks/population_shares.py`).
"""

from __future__ import annotations

from brdfit.bench.holdout.aims import Cells

__all__ = ["SEEN", "unseen"]

SEEN = frozenset(
    (
        "cornell/acryl_blue.astm",
        "cornell/krylon_blue.astm",
        "nist/PTFE.data.csv",
        "rgl/cc_ibiza_sunset_rgb.bsdf",
        "rgl/chm_mint_rgb.bsdf",
        "rgl/colodur_napoli_4f_rgb.bsdf",
        "rgl/irid_flake_paint1_rgb.bsdf",
        "rgl/paper_white_rgb.bsdf",
        "rgl/satin_rosaline_rgb.bsdf",
        "rt300s/NiTE_on_invar_v1o0A_20250915.xls",
        *(f"curet/abrdf_1_30.dat#{number:02d}" for number in range(1, 31, 3)),
    )
)


def unseen(cells: Cells) -> Cells:
    """Return the records of the files that no constant of the posterior was chosen on."""
    return Cells([record for record in cells.every if record["file"] not in SEEN])
