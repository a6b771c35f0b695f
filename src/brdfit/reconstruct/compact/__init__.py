"""`Compact`: a fit with few coefficients, made for very many small fits at once.

    ln f_r(x) = mean(x) + tau z_0 + sum_k B_k(x) z_k,     z ~ N(0, I)

B_k are the leading components of a population's covariance and a weak local residual together
(`basis`). Samples come in blocks of many items (`block`); the two-component mixture is solved
for all items of a block side by side (`solve`), and a single fit is a block of one item.
"""

from __future__ import annotations

from brdfit.reconstruct.compact.basis import LeadingBasis, leading_basis
from brdfit.reconstruct.compact.block import Block
from brdfit.reconstruct.compact.method import Compact
from brdfit.reconstruct.compact.model import CompactModel
from brdfit.reconstruct.compact.result import BlockResult

__all__ = ["Block", "BlockResult", "Compact", "CompactModel", "LeadingBasis", "leading_basis"]
