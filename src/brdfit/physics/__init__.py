"""What physics asks of a BRDF, and the nearest one that obeys.

directional_albedo(brdf, theta_i)        (angles, channels): above 1 no surface can be
AlbedoPlan.build(grid, valid, theta_i)   the same for many tables on one grid
limit_energy(table, stddev).table        the nearest table with an albedo of at most 1
examine(samples or table)                six findings: a figure, a verdict, a sentence
repair_table, repair_samples             what can be put right, each change counted
"""

from __future__ import annotations

from brdfit.albedo import directional_albedo
from brdfit.physics.albedo_plan import AlbedoPlan
from brdfit.physics.energy import EnergyLimit, limit_energy
from brdfit.physics.examination import examine
from brdfit.physics.finding import Finding, Health, Verdict
from brdfit.physics.repair import Change, Repair, repair_samples, repair_table

__all__ = [
    "AlbedoPlan",
    "Change",
    "EnergyLimit",
    "Finding",
    "Health",
    "Repair",
    "Verdict",
    "directional_albedo",
    "examine",
    "limit_energy",
    "repair_samples",
    "repair_table",
]
