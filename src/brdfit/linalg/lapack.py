"""Factor and inverse of a positive definite matrix, in a way that two threads can at once.

SciPy's wrappers of LAPACK hold the interpreter's lock while they work: of two threads that
factorise one waits for the other. The same routines, of the same library, are there for Cython
(`scipy.linalg.cython_lapack`), and are called from there without the lock.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["factor_and_inverse"]

_Routine = Callable[..., None]
# What a pointer to dpotrf and dpotri is told by: other widths of an integer are other routines.
_ARGUMENTS = (b"(char *, int *, ", b" *, int *, int *)")


def factor_and_inverse(matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (L, A^-1) of A = L L^T (n, n), float64; only their lower triangles mean anything.

    `matrix` may be overwritten. Raises `LinAlgError` if it is not positive definite.
    """
    # LAPACK wants columns; nothing is copied of rows, because A is its own transpose
    factor = _called("dpotrf", np.asfortranarray(matrix.T, dtype=np.float64))
    return factor, _called("dpotri", factor.copy(order="F"))


def _called(name: str, matrix: FloatArray) -> FloatArray:
    """Return what a routine makes of the lower triangle of `matrix`, column-major, in its place."""
    routine = _routine(name)
    if routine is None:
        matrix, failed = _wrapped(name, matrix)
    else:
        n, info = ctypes.c_int(len(matrix)), ctypes.c_int(0)
        order = ctypes.byref(n)
        routine(b"L", order, matrix.ctypes.data, order, ctypes.byref(info))
        failed = info.value
    if failed:
        raise np.linalg.LinAlgError(f"leading minor {failed} is not positive definite")
    return matrix


def _wrapped(name: str, matrix: FloatArray) -> tuple[FloatArray, int]:
    from scipy.linalg import lapack

    found, failed = getattr(lapack, name)(matrix, lower=1)
    return found, int(failed)


@cache
def _routine(name: str) -> _Routine | None:
    """Return the routine without the lock, or None where this SciPy offers none."""
    from scipy.linalg import cython_lapack

    capsule = getattr(cython_lapack, "__pyx_capi__", {}).get(name)
    if capsule is None:
        return None
    named = _of_python("PyCapsule_GetName", ctypes.c_char_p, ctypes.py_object)
    pointer = _of_python("PyCapsule_GetPointer", ctypes.c_void_p, ctypes.py_object, ctypes.c_char_p)
    kind = named(capsule)
    if not all(part in kind for part in _ARGUMENTS):
        return None
    text, address = ctypes.c_char_p, ctypes.c_void_p
    return ctypes.CFUNCTYPE(None, text, address, address, address, address)(pointer(capsule, kind))


def _of_python(name: str, result: type, *arguments: type) -> Callable[..., Any]:
    """Return a function of the interpreter, with a signature that nobody else's use changes."""
    return ctypes.PYFUNCTYPE(result, *arguments)((name, ctypes.pythonapi))
