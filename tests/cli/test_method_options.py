"""From what was typed to the settings of a method."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import ClassVar, Literal

import pytest

import brdfit.reconstruct
from brdfit.cli.commands.fit import add_method_options, method_from
from brdfit.cli.parser import Parser
from brdfit.cli.settings import add_settings, field_help, given_settings
from brdfit.errors import PopulationError, UsageError
from brdfit.populations import Population
from brdfit.reconstruct import METHODS


@dataclass(frozen=True)
class Settings:
    """Fields of every kind."""

    name: ClassVar[str] = "settings"

    count: int = 3
    """How many, of what
    is counted.

    A second paragraph that help leaves out.
    """
    ratio: float | None = None
    """A share of 100 %."""
    kind: Literal["soft", "hard"] = "soft"
    """Which kind."""
    level: float | Literal["auto"] = "auto"
    """A number or a word."""
    scales: tuple[float, ...] = (1.0, 2.0)
    """Some numbers."""
    careful: bool = True
    """Take care."""
    told: str = field(default="x", metadata={"help": "From the metadata."})
    population: Callable[[], None] | None = None


def _parse(*words: str) -> dict[str, object]:
    parser = argparse.ArgumentParser()
    add_settings(parser, Settings)
    return given_settings(parser.parse_args(words))


def test_nothing_typed_means_nothing_given() -> None:
    assert _parse() == {}


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--count", "5"], {"count": 5}),
        (["--ratio", "0.25"], {"ratio": 0.25}),
        (["--kind", "hard"], {"kind": "hard"}),
        (["--level", "auto"], {"level": "auto"}),
        (["--level", "2.5"], {"level": 2.5}),
        (["--scales", "0.1, 0.2,0.3"], {"scales": (0.1, 0.2, 0.3)}),
        (["--no-careful"], {"careful": False}),
        (["--told", "y"], {"told": "y"}),
    ],
)
def test_a_typed_setting_has_the_type_of_its_field(
    words: list[str], expected: dict[str, object]
) -> None:
    assert _parse(*words) == expected
    Settings(**_parse(*words))  # type: ignore[arg-type]


def test_help_is_the_first_paragraph_of_the_string_under_the_field() -> None:
    assert field_help(Settings)["count"].startswith("How many, of what\nis counted.")
    parser = argparse.ArgumentParser()
    add_settings(parser, Settings)
    text = " ".join(parser.format_help().split())
    assert "How many, of what is counted. (default: 3)" in text
    assert "second paragraph" not in text
    assert "A share of 100 %." in text
    assert "Take care. (default: on)" in text
    assert "From the metadata." in text


def test_a_field_that_cannot_be_typed_is_no_option() -> None:
    parser = argparse.ArgumentParser()
    add_settings(parser, Settings)
    assert "--population" not in parser.format_help()


@pytest.mark.parametrize("name", sorted(METHODS))
def test_every_setting_of_every_method_is_an_option_with_help(name: str) -> None:
    parser = Parser()
    add_method_options(parser, ["--method", name])
    arguments = parser.parse_args(["--method", name])
    assert isinstance(method_from(arguments), METHODS[name])
    helped = field_help(METHODS[name])
    missing = [item.name for item in fields(METHODS[name]) if item.name not in helped]
    assert missing == []


@dataclass(frozen=True)
class Leaning:
    """A method that leans on a population."""

    name: ClassVar[str] = "leaning"

    population: str | Population = "published"
    """What it leans on."""


@dataclass(frozen=True)
class Free:
    """A method that does not."""

    name: ClassVar[str] = "free"

    passes: int = 1
    """How often."""


@pytest.fixture
def typed(monkeypatch: pytest.MonkeyPatch) -> Callable[..., argparse.Namespace]:
    monkeypatch.setattr(brdfit.reconstruct, "METHODS", {"leaning": Leaning, "free": Free})

    def parse(*words: str) -> argparse.Namespace:
        parser = Parser()
        add_method_options(parser, words)
        return parser.parse_args(words)

    return parse


def test_the_basis_is_the_population_of_the_method(
    typed: Callable[..., argparse.Namespace],
) -> None:
    assert method_from(typed("--basis", "some/folder")) == Leaning(population="some/folder")


def test_materials_are_left_out_of_the_population(
    typed: Callable[..., argparse.Namespace],
) -> None:
    method = method_from(typed("--without", "chrome, brass"), leave_out=["nickel"])
    assert isinstance(method, Leaning)
    assert isinstance(method.population, Population)
    assert not {"chrome", "brass", "nickel"} & set(method.population.materials)
    assert len(method.population.unique_materials) == 97


def test_leaving_out_a_material_that_is_not_there_is_an_error(
    typed: Callable[..., argparse.Namespace],
) -> None:
    with pytest.raises(PopulationError, match="krome"):
        method_from(typed("--without", "krome"))


def test_a_basis_for_a_method_that_leans_on_none_is_refused(
    typed: Callable[..., argparse.Namespace],
) -> None:
    with pytest.raises(UsageError, match="leans on no population"):
        method_from(typed("--method", "free", "--basis", "nbrdf"))
    assert method_from(typed("--method", "free"), leave_out=["chrome"]) == Free()
