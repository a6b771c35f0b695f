"""What a step asks of the features: sums over the rows of each item, and A^-1.

    A = I + Phi^T W Phi,     z = A^-1 Phi^T W y,     h_i = phi_i^T A^-1 phi_i

Where all items have the same directions, phi_i phi_i^T is the same for all: A is then one
product of all weights, and h one of all inverses. Symmetric matrices are packed (`Triangle`).
The axes are those of `solve`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from array_api_compat import device

from brdfit.linalg import Triangle, solved

__all__ = ["Products", "products_of"]

# An array of whichever library: no static type names them all.
Array = Any


class Products(Protocol):
    """The products of one form of features."""

    def solved(self, xp: Any, weights: Array, y: Array) -> tuple[Array, Array]:
        """Return (A^-1 in a form of its own, z (b, g, m, k)) of weights (b, g, n), y (b, g, m, n).

        The weights are not yet on `y`.
        """

    def fitted(self, xp: Any, z: Array) -> Array:
        """Return Phi z (b, g, m, n) of coefficients (b, g, m, k)."""

    def variance(self, xp: Any, inverse: Array) -> Array:
        """Return h (b, g, n)."""

    def spread(self, xp: Any, inverse: Array) -> Array:
        """Return the mean of phi^T A^-1 phi (b, g) over what `spread` of the items averages."""


def products_of(xp: Any, features: Array, spread: Array) -> Products:
    """Return the products of features (n, k), shared by all items, or (b, n, k)."""
    k = features.shape[-1]
    if len(features.shape) == 3:
        turned = xp.permute_dims(features, (0, 2, 1))
        unit = xp.eye(k, dtype=features.dtype, device=device(features))
        return _Own(features[:, None, :, :], turned[:, None, :, :], unit, xp.reshape(spread, (-1,)))
    triangle = Triangle.of(k)
    squares = triangle.squares(xp, features)
    unit = triangle.pack(xp, xp.eye(k, dtype=features.dtype, device=device(features)))
    return _Shared(
        features,
        xp.permute_dims(features, (1, 0)),
        squares,
        xp.permute_dims(triangle.doubled(xp, squares), (1, 0)),
        unit,
        triangle.doubled(xp, triangle.pack(xp, spread)),
    )


@dataclass(frozen=True, eq=False)
class _Shared:
    features: Array
    """(n, k)"""
    turned: Array
    """(k, n)"""
    squares: Array
    """(n, p): phi_i phi_i^T"""
    doubled: Array
    """(p, n): the same, its elements as often as they stand in the whole"""
    unit: Array
    """(p,)"""
    average: Array
    """(p,)"""

    def solved(self, xp: Any, weights: Array, y: Array) -> tuple[Array, Array]:
        b, g, n = weights.shape
        a = xp.reshape(weights, (b * g, n)) @ self.squares
        a += self.unit
        moment = _flat(xp, weights[:, :, None, :] * y, self.features)
        return solved(xp, xp.reshape(a, (b, g, -1)), moment, packed=True)

    def fitted(self, xp: Any, z: Array) -> Array:
        return _flat(xp, z, self.turned)

    def variance(self, xp: Any, inverse: Array) -> Array:
        return _flat(xp, inverse, self.doubled)

    def spread(self, xp: Any, inverse: Array) -> Array:
        return inverse @ self.average


@dataclass(frozen=True, eq=False)
class _Own:
    features: Array
    """(b, 1, n, k)"""
    turned: Array
    """(b, 1, k, n)"""
    unit: Array
    """(k, k)"""
    average: Array
    """(k k,)"""

    def solved(self, xp: Any, weights: Array, y: Array) -> tuple[Array, Array]:
        a = xp.matmul(self.turned, weights[..., None] * self.features)
        a += self.unit
        return solved(xp, a, xp.matmul(weights[:, :, None, :] * y, self.features))

    def fitted(self, xp: Any, z: Array) -> Array:
        return xp.matmul(z, self.turned)

    def variance(self, xp: Any, inverse: Array) -> Array:
        return xp.vecdot(xp.matmul(self.features, inverse), self.features, axis=-1)

    def spread(self, xp: Any, inverse: Array) -> Array:
        return xp.reshape(inverse, (*inverse.shape[:2], -1)) @ self.average


def _flat(xp: Any, array: Array, matrix: Array) -> Array:
    """Return array (..., i) @ matrix (i, j) as one product of two matrices."""
    *outer, inner = array.shape
    return xp.reshape(xp.reshape(array, (-1, inner)) @ matrix, (*outer, matrix.shape[1]))
