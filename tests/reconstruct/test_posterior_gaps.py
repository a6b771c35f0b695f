"""What the default fit says where nobody measured."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit import read_samples
from brdfit.geometry import directions_from_spherical
from brdfit.reconstruct import Posterior


@pytest.mark.filterwarnings("ignore::brdfit.errors.DataQualityWarning")
def test_a_matt_material_has_no_ring_beside_its_mirror_direction(shared_data):
    # measured in the mirror direction and from theta_h = 6 degrees on: both are 0.28
    samples = read_samples(shared_data / "rgl" / "paper_white_rgb.bsdf")
    theta_o = np.radians([20.0, 24.0, 26.0, 27.0, 28.0, 29.0, 30.0, 32.0, 36.0])
    wi = directions_from_spherical(np.full(9, np.radians(28.0)), np.zeros(9))
    f = Posterior().fit(samples).evaluate(wi, directions_from_spherical(theta_o, np.full(9, np.pi)))
    assert np.ptp(np.log(f[:, 1])) < 0.1
