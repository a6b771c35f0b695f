"""A material in the weights of a small neural network (Sztrajman et al. 2021).

A network 6-21-21-3 takes the half and difference vector (hx, hy, hz, dx, dy, dz), with the
half vector at azimuth 0, through two layers of rectified units, and f_r = max(exp(y) - 1, 0)
for R, G and B in 1/sr.

A network was taught phi_d in [0, pi) only and knows nothing of reciprocity, so it is asked
at phi_d wrapped into that half: exchanging wi and wo then gives the same value exactly. It
is not symmetric about pi/2, and need not agree with itself across the seam at phi_d = pi.

Reference: A. Sztrajman, G. Rainer, T. Ritschel, T. Weyrich, "Neural BRDF Representation and
Importance Sampling", Computer Graphics Forum 40(6), 2021.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray, IntArray, as_directions
from brdfit.geometry import half_diff_from_directions, wrap_phi_d

__all__ = ["NETWORK_SHAPES", "Layer", "Networks"]

NETWORK_SHAPES = ((6, 21), (21, 21), (21, 3))
"""(inputs, outputs) of the three layers."""

Layer = tuple[FloatArray, FloatArray]
"""Kernel (inputs, outputs) and bias (outputs,), float32."""

# Directions of a block: its activations (2100 x block, float32) stay near the processor.
_BLOCK = 1024


@dataclass(frozen=True, eq=False)
class Networks:
    """m networks of one shape, evaluated together."""

    weights: tuple[FloatArray, FloatArray, FloatArray]
    """Transposed kernels (m, outputs, inputs) of the three layers, float32."""
    biases: tuple[FloatArray, FloatArray, FloatArray]
    """(m, outputs, 1), float32."""

    @classmethod
    def of(cls, layers: Sequence[Sequence[Layer]]) -> Networks:
        """Return the networks of which each has three layers, shaped as `NETWORK_SHAPES`."""
        kernels = [np.stack([layer[index][0].T for layer in layers]) for index in range(3)]
        biases = [np.stack([layer[index][1][:, None] for layer in layers]) for index in range(3)]
        return cls(
            weights=(kernels[0], kernels[1], kernels[2]), biases=(biases[0], biases[1], biases[2])
        )

    def evaluate(self, wi: FloatArray, wo: FloatArray, pick: IntArray | None = None) -> FloatArray:
        """Return f_r (channels, n, networks), float32, at direction pairs (n, 3).

        0 below the horizon. `pick`: indices of the networks that are asked, all if left out.
        """
        wi, wo = as_directions("wi", wi), as_directions("wo", wo)
        which = slice(None) if pick is None else np.asarray(pick)
        weights = [weight[which] for weight in self.weights]
        biases = [bias[which] for bias in self.biases]
        below = (wi[:, 2] <= 0.0) | (wo[:, 2] <= 0.0)
        inputs = _inputs(wi, wo)
        by_channel = np.empty((NETWORK_SHAPES[-1][1], len(wi), len(weights[0])), dtype=np.float32)
        for start in range(0, len(wi), _BLOCK):
            rows = slice(start, start + _BLOCK)
            signal = inputs[:, rows]
            for weight, bias in zip(weights[:2], biases[:2], strict=True):
                signal = np.matmul(weight, signal)
                signal += bias
                np.maximum(signal, 0.0, out=signal)
            signal = np.matmul(weights[2], signal)
            signal += biases[2]
            np.expm1(signal, out=signal)
            # (networks, channels, n) -> (channels, n, networks)
            np.maximum(signal.transpose(1, 2, 0), 0.0, out=by_channel[:, rows])
        by_channel[:, below] = 0.0
        return by_channel


def _inputs(wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Return (hx, hy, hz, dx, dy, dz) as (6, n), float32, half vector at azimuth 0."""
    theta_h, theta_d, phi_d = half_diff_from_directions(wi, wo)
    phi_d = wrap_phi_d(phi_d)
    sin_d = np.sin(theta_d)
    rows = (
        np.sin(theta_h),
        np.zeros_like(theta_h),
        np.cos(theta_h),
        sin_d * np.cos(phi_d),
        sin_d * np.sin(phi_d),
        np.cos(theta_d),
    )
    return np.stack(rows).astype(np.float32)
