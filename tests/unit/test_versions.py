"""The versions that travel with results."""

from __future__ import annotations

import platform

import numpy

from brdfit.versions import version_of, versions_of


def test_versions_are_those_of_what_runs():
    assert versions_of("numpy") == {
        "python": platform.python_version(),
        "numpy": numpy.__version__,
    }


def test_a_package_that_is_not_there_is_said_to_be_missing():
    assert version_of("no-such-package-of-brdfit") == "not installed"
