"""Very many items: from files or one long table to a store of compact results.

    run_batch(open_input("scans/"), "scans.zarr", Compact())
    batch = open_batch("scans.zarr")
    batch["krylon_blue"].evaluate(wi, wo)

`source` says what items there are and reads some of them, `store` keeps what became of them,
`engine` lets processes of this machine do the work and `cluster` those of Dask.
"""

from __future__ import annotations

from brdfit.batch.inputs import open_input
from brdfit.batch.opened import Batch, BatchItem, open_batch
from brdfit.batch.run import run_batch
from brdfit.batch.source import BatchInput, Part

__all__ = ["Batch", "BatchInput", "BatchItem", "Part", "open_batch", "open_input", "run_batch"]
