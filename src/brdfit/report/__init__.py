"""What is told of a fit and of two BRDFs: figures, records, pictures, and the files they go to.

    fit_outputs   the four files of a fit, together or not at all
    fit_figure    the picture of a fit
    samples_csv   the samples with their weight and residual
    channels      which channels a plot shows, and in which colours
    slice_panel   one slice with its band and the samples nearby, for an interactive plot
    coverage      where the samples lie
    compare       one BRDF against another under every metric
    fitted        a finished fit as it can be told of; fit_files finds its files again
    uncertainty   how sure the method is, small enough for the record
    page          the report: one HTML file
    notebook      what a notebook shows of samples, a table, a result
    rgb           a table of any channels as R, G, B, and what that cost
    reading       a file that may hold samples or a table
    field_help    the string under each field of a dataclass
    packed_table  a table small enough to travel into a browser
    demo_input    measurements for the demonstration

Nothing here prints; the command line says what these return.
"""

from __future__ import annotations
