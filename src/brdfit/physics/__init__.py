"""What physics asks of a BRDF, and the nearest one that obeys.

directional_albedo(brdf, theta_i)        (angles, channels): above 1 no surface can be
AlbedoPlan.build(grid, valid, theta_i)   the same for many tables on one grid
limit_energy(table, stddev).table        the nearest table with an albedo of at most 1
"""

from __future__ import annotations

from brdfit.albedo import directional_albedo
from brdfit.physics.albedo_plan import AlbedoPlan
from brdfit.physics.energy import EnergyLimit, limit_energy

__all__ = ["AlbedoPlan", "EnergyLimit", "directional_albedo", "limit_energy"]
