"""All checks of whatever a file holds."""

from __future__ import annotations

from brdfit.physics.finding import Health
from brdfit.physics.of_samples import sample_findings
from brdfit.physics.of_tables import table_findings
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["examine"]


def examine(content: Samples | Table) -> Health:
    """Return what physics says of measurements or a table: six findings, each with a figure.

    | finding       | figure                                                             |
    |---------------|--------------------------------------------------------------------|
    | `cells`       | share that is missing, negative or (samples) at the noise floor    |
    | `reciprocity` | median |delta ln f| with light and detector exchanged              |
    | `energy`      | largest directional albedo over incidence; 1 is a white furnace    |
    | `grazing`     | scatter of ln f between neighbours beyond 75 degrees               |
    | `symmetry`    | median |delta ln f| between phi_d and -phi_d                       |
    | `peak`        | distance of the specular peak from theta_h = 0, degrees            |
    """
    if isinstance(content, Samples):
        return Health("samples", sample_findings(content))
    return Health("table", table_findings(content))
