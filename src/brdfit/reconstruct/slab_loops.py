"""The compiled loops over the cells of one theta_h; needs numba. `slab_cells` says what they do.

A block of cells at a time, so that what one channel leaves in the cache the next finds there.
The exponential is a polynomial around the nearest multiple of ln 2,

    exp(x) = 2^n exp(r),     n = round(x / ln 2),     r = x - n ln 2,     |r| <= ln 2 / 2

which compilers turn into operations on whole registers, off by less than 1e-7 of the value.

Reference: S. L. Moshier, Cephes mathematical library, `expf` (coefficients; ln 2 in two parts).
"""

from __future__ import annotations

import numpy as np

from brdfit.linalg.compiled import compiled

__all__ = ["add_rows", "put_lines", "put_values"]

_BLOCK = 256
_PER_LN2 = np.float32(1.44269504088896341)
_LN2_HIGH, _LN2_LOW = np.float32(0.693359375), np.float32(-2.12194440e-4)
_P0, _P1, _P2 = (
    np.float32(1.9875691500e-4),
    np.float32(1.3981999507e-3),
    np.float32(8.3334519073e-3),
)
_P3, _P4, _P5 = (
    np.float32(4.1665795894e-2),
    np.float32(1.6666665459e-1),
    np.float32(5.0000001201e-1),
)
_ONE, _ZERO = np.float32(1.0), np.float32(0.0)
# 1.5 2^23: what is added to it is rounded to a whole number, which its lowest bits hold.
_ROUND = np.float32(12582912.0)
# Bits of the mantissa of a float32, and 1.0 as bits.
_MANTISSA, _ONE_BITS = np.int32(23), np.int32(0x3F800000)


@compiled
def add_rows(logs: np.ndarray, rows: np.ndarray, row_of: np.ndarray, constant: np.ndarray) -> None:
    """Add the rows."""
    channels, n = logs.shape
    for start in range(0, n, _BLOCK):
        which = row_of[start : start + _BLOCK]
        for channel in range(channels):
            sums, values = logs[channel, start : start + _BLOCK], rows[:, channel]
            more = constant[channel]
            for cell in range(len(which)):
                # of numbers that may be negative numba asks whether they are
                sums[cell] += values[np.uintp(which[cell])] + more


@compiled
def put_values(
    logs: np.ndarray, highest: np.ndarray, lowest: np.float32, cells: np.ndarray
) -> None:
    """Put the values; `logs` stays as it is."""
    channels, n = logs.shape
    found = np.empty(_BLOCK, dtype=np.float32)
    for start in range(0, n, _BLOCK):
        limit = highest[start : start + _BLOCK]
        for channel in range(channels):
            _exponentials(logs[channel, start : start + _BLOCK], limit, lowest, found)
            values = cells[start : start + _BLOCK, channel]
            for cell in range(len(values)):
                values[cell] = found[cell]


@compiled
def put_lines(
    nodes: np.ndarray,
    low_d: np.ndarray,
    high_d: np.ndarray,
    weight_d: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    weight: np.ndarray,
    kind: np.ndarray,
    scale: np.ndarray,
    highest: np.ndarray,
    constant: np.ndarray,
    lowest: np.float32,
    cells: np.ndarray,
) -> None:
    """Put the lines: the nodes of a theta_h to all phi first, then each theta_d between them."""
    size = len(constant)
    around = np.empty((nodes.shape[1], size), dtype=np.float32)
    # What is read from where it is written to cannot go through whole registers.
    logs = np.empty(size, dtype=np.float32)
    for ring in range(len(nodes)):
        _to_phi(nodes[ring], low, high, weight, around)
        for place in range(len(low_d)):
            before, after = around[low_d[place]], around[high_d[place]]
            share, rest = weight_d[0, place], weight_d[1, place]
            factor = scale[kind[ring, place]]
            for cell in range(size):
                mean = share * before[cell] + rest * after[cell]
                logs[cell] = mean * factor[cell] + constant[cell]
            _exponentials(logs, highest[kind[ring, place]], lowest, cells[ring, place])


@compiled
def _to_phi(
    nodes: np.ndarray, low: np.ndarray, high: np.ndarray, weight: np.ndarray, around: np.ndarray
) -> None:
    """Put into each row of `around` what lies between the nodes of that row.

    Three rows at a time, so that it is read once for three where the nodes are; the last row
    is done again where there are not so many.
    """
    last = len(nodes) - 1
    some, rest = weight[0], weight[1]
    for row in range(0, len(nodes), 3):
        second, third = min(row + 1, last), min(row + 2, last)
        a, b, c = nodes[row], nodes[second], nodes[third]
        to_a, to_b, to_c = around[row], around[second], around[third]
        for cell in range(len(low)):
            at, to = np.uintp(low[cell]), np.uintp(high[cell])
            to_a[cell] = some[cell] * a[at] + rest[cell] * a[to]
            to_b[cell] = some[cell] * b[at] + rest[cell] * b[to]
            to_c[cell] = some[cell] * c[at] + rest[cell] * c[to]


@compiled
def _exponentials(
    logs: np.ndarray, highest: np.ndarray, lowest: np.float32, found: np.ndarray
) -> None:
    for cell in range(len(logs)):
        x, limit = logs[cell], highest[cell]
        x = lowest if x < lowest else x
        x = limit if x > limit else x
        rounded = np.float32(x * _PER_LN2 + _ROUND)
        n = rounded - _ROUND
        r = x - n * _LN2_HIGH - n * _LN2_LOW
        y = ((((_P0 * r + _P1) * r + _P2) * r + _P3) * r + _P4) * r + _P5
        y = y * (r * r) + r + _ONE
        power = np.int32((rounded.view(np.int32) << _MANTISSA) + _ONE_BITS)
        found[cell] = y * power.view(np.float32) if limit >= lowest else _ZERO
