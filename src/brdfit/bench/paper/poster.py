"""The figures that the poster prints, to be set beside ours.

T. Noell, J. Koehler, D. Stricker, "Robust and Accurate Non-Parametric Estimation of Reflectance
using Basis Decomposition and Correction Functions", European Conference on Computer Vision,
2014: the poster. Average perceptual errors over the materials of the MERL database, a measure
that the poster does not define further; its renderer, its illumination, its outliers and the
constants gamma, damping and number of iterations are not given.
"""

from __future__ import annotations

__all__ = [
    "CITATION",
    "DATA_RATIOS",
    "ERRORS",
    "EXPRESSIVENESS",
    "OUTLIER_RATIOS",
    "REAL",
    "REAL_AVERAGE",
    "SENSITIVITY",
    "TITLES",
]

CITATION = "T. Noell, J. Koehler, D. Stricker, poster at ECCV 2014"

DATA_RATIOS = (1.0, 0.7, 0.5, 0.3, 0.1)
"""Columns of the tables of errors."""

OUTLIER_RATIOS = (0.0, 0.2, 0.4, 0.6, 0.8)
"""Rows of the tables of errors."""

TITLES = {"our": "Our", "glo": "Glo", "loc": "Loc", "tab": "Tab"}
"""The poster's short names: the columns of a run unless others are asked for."""

ERRORS = {
    "our": (
        (0.28, 0.29, 0.29, 0.29, 0.31),
        (0.36, 0.37, 0.44, 0.41, 0.49),
        (0.73, 0.72, 0.75, 0.78, 0.92),
        (2.06, 2.10, 2.05, 2.23, 2.31),
        (4.86, 4.89, 4.83, 4.81, 4.83),
    ),
    "glo": (
        (4.88, 4.89, 4.91, 4.96, 5.05),
        (6.32, 6.58, 6.76, 7.57, 7.59),
        (7.97, 8.22, 7.93, 8.32, 9.03),
        (9.64, 9.74, 9.46, 9.59, 9.53),
        (11.33, 11.16, 11.05, 11.05, 10.61),
    ),
    "loc": (
        (4.11, 4.11, 4.13, 4.15, 4.17),
        (6.85, 6.78, 6.96, 7.12, 7.74),
        (9.74, 9.98, 9.79, 10.41, 11.04),
        (12.49, 12.63, 12.49, 12.56, 13.45),
        (15.18, 15.32, 15.28, 15.16, 15.92),
    ),
    "tab": (
        (0.00, 0.09, 0.20, 0.46, 2.14),
        (17.32, 15.59, 17.28, 14.00, 12.30),
        (26.12, 26.38, 24.80, 24.35, 22.90),
        (33.32, 34.90, 32.71, 32.13, 28.22),
        (39.86, 41.70, 40.75, 38.94, 34.09),
    ),
}
"""Average perceptual errors: ERRORS[method][outlier row][data column]."""

SENSITIVITY = {
    "our": {"linear": 0.44, "root": 0.31, "log": 0.28},
    "glo": {"linear": 13.39, "root": 5.05, "log": 4.88},
    "loc": {"linear": 24.14, "root": 3.32, "log": 4.11},
}
"""Average perceptual error by error metric. The logarithmic column repeats the cell of all data
and no outliers of the tables above, so that is what the table was made at."""

EXPRESSIVENESS = 0.076
"""Average deviation of a correction function from its description by the 99 others."""

REAL = {
    "glo": (
        *(0.37, 0.49, 0.53, 0.51, 0.58, 0.54, 0.37, 0.45),
        *(0.57, 0.48, 0.47, 0.56, 0.54, 0.49, 0.61, 0.49),
    ),
    "loc": (
        *(0.31, 0.35, 0.47, 0.29, 0.29, 0.41, 0.34, 0.38),
        *(0.37, 0.36, 0.41, 0.40, 0.55, 0.38, 0.44, 0.31),
    ),
    "our": (
        *(0.19, 0.21, 0.23, 0.18, 0.19, 0.19, 0.19, 0.19),
        *(0.19, 0.18, 0.23, 0.18, 0.20, 0.18, 0.19, 0.15),
    ),
}
"""Perceptual errors of the poster's 16 own measured materials, which are not published."""

REAL_AVERAGE = {"glo": 0.50, "loc": 0.38, "our": 0.19}
"""Their averages as the poster prints them."""
