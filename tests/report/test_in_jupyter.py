"""What Jupyter itself shows: a notebook that is run, by a kernel of its own."""

from __future__ import annotations

import re

import pytest

nbclient = pytest.importorskip("nbclient", reason="extra dev")
nbformat = pytest.importorskip("nbformat", reason="extra dev")
pytest.importorskip("ipykernel", reason="extra dev")

_MADE = """
import numpy as np, brdfit
from brdfit.grid import Grid
from brdfit.geometry import directions_from_spherical
theta = np.linspace(0.1, 1.4, 60)
wi = directions_from_spherical(theta, np.zeros(60))
wo = directions_from_spherical(theta[::-1], np.full(60, 2.0))
samples = brdfit.Samples(wi=wi, wo=wo, value=np.full((60, 3), 0.2))
result = brdfit.fit(samples, method=brdfit.Tabulated())
"""


def test_samples_a_result_and_a_table_show_themselves_at_the_end_of_a_cell() -> None:
    notebook = nbformat.v4.new_notebook()
    sources = (_MADE, "samples", "result", "result.table(Grid(8, 8, 8))")
    notebook.cells = [nbformat.v4.new_code_cell(source) for source in sources]
    nbclient.NotebookClient(notebook, timeout=60, kernel_name="python3").execute()
    assert notebook.cells[0].outputs == []
    shown = []
    for cell in notebook.cells[1:]:
        (output,) = cell.outputs
        assert output.output_type == "execute_result"
        # a plain console sees one line, a page the picture
        assert "text/plain" in output.data
        shown.append(output.data["text/html"])
    assert [text.count("<img") for text in shown] == [0, 1, 1]
    assert "60, 60 usable" in shown[0]
    assert re.search(r"<dt>method</dt><dd>tabulated", shown[1])
    assert "8 × 8 × 8 nodes" in shown[2]
