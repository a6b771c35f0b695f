"""What may be said of a file, typed once for the command line and the page."""

from __future__ import annotations

import pytest

from brdfit.errors import UsageError
from brdfit.formats.declaration import Declaration
from brdfit.report.reading_options import READING_OPTIONS, typed_options


def test_every_key_of_a_declaration_can_be_said() -> None:
    assert set(Declaration.option_names()) <= {option.name for option in READING_OPTIONS}


def test_every_option_is_explained_and_choices_are_given() -> None:
    for option in READING_OPTIONS:
        assert option.help.endswith(".")
        assert (option.kind == "choice") == (len(option.choices) > 1)


def test_texts_become_what_the_reader_takes() -> None:
    given = {"wavelength": "550", "cosine_weighted": "true", "values": "4", "half": "true"}
    assert typed_options(given) == {
        "wavelength": 550.0,
        "cosine_weighted": True,
        "values": "4",
        "half": True,
    }
    assert typed_options({"cosine_weighted": "false", "delimiter": ";"}) == {
        "cosine_weighted": False,
        "delimiter": ";",
    }


def test_what_is_no_text_stays() -> None:
    assert typed_options({"values": [4], "half": True}) == {"values": [4], "half": True}


def test_a_number_that_is_none_is_named() -> None:
    with pytest.raises(UsageError, match=r"wavelength: found 'green'"):
        typed_options({"wavelength": "green"})
