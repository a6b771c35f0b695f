"""One tree of errors, one of warnings; each survives the way between processes."""

from __future__ import annotations

import pickle

import pytest

from brdfit import errors

EXCEPTIONS = [getattr(errors, name) for name in errors.__all__]


@pytest.mark.parametrize("kind", EXCEPTIONS, ids=lambda kind: kind.__name__)
def test_every_name_hangs_in_one_of_the_two_trees(kind: type[Exception]) -> None:
    assert issubclass(kind, errors.BrdfitError) != issubclass(kind, errors.BrdfitWarning)


@pytest.mark.parametrize("kind", EXCEPTIONS, ids=lambda kind: kind.__name__)
def test_the_tree_in_the_docstring_names_every_exception(kind: type[Exception]) -> None:
    assert errors.__doc__ is not None
    assert kind.__name__ in errors.__doc__


@pytest.mark.parametrize("kind", EXCEPTIONS, ids=lambda kind: kind.__name__)
def test_every_exception_survives_pickling(kind: type[Exception]) -> None:
    arguments = ("h5py", "networks", "reading") if kind is errors.MissingExtra else ("what",)
    raised = kind(*arguments)
    returned = pickle.loads(pickle.dumps(raised))
    assert type(returned) is kind
    assert str(returned) == str(raised)


def test_a_usage_error_is_caught_as_a_value_error() -> None:
    with pytest.raises(ValueError, match="what"):
        raise errors.UsageError("what")


def test_a_missing_extra_says_what_to_install() -> None:
    message = str(errors.MissingExtra("h5py", "networks", "Reading networks"))
    assert message.startswith("Reading networks needs")
    assert 'pip install "brdfit[networks]"' in message
