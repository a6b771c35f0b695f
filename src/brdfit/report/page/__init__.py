"""The report of a fit: one HTML file that opens from disk, without a network, for years.

    write_report   the file, whole or not at all
    contents       what is said, section by section
    slices, trust, pictures, lists, svg, words    the parts of it
    render         the template with everything in it

The page's style sheet and script are bundled from `viewer-client/src/report`.
"""

from __future__ import annotations

from brdfit.report.page.write import write_report as write_report

__all__ = ["write_report"]
