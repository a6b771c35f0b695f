"""What may be typed, and what is said of what may not."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from brdfit.cli.program import COMMANDS
from brdfit.formats import list_formats

Run = Callable[..., tuple[int, str, str]]


def test_help_lists_every_command_with_a_sentence(run: Run) -> None:
    code, out, _ = run("--help")
    assert code == 0
    for name, sentence in COMMANDS.items():
        assert name in out
        assert sentence in out


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_every_command_has_help_of_its_own(run: Run, command: str) -> None:
    code, out, err = run(command, "--help")
    assert code == 0, err
    assert out.startswith(f"usage: brdfit {command}")


def test_help_imports_nothing_heavy() -> None:
    script = (
        "import sys; from brdfit.cli import main; main(['--help']); "
        "print([m for m in ('numpy', 'scipy', 'matplotlib', 'rich', 'pyarrow', 'colour') "
        "if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "[]", done.stderr


def test_version_is_one_line(run: Run) -> None:
    code, out, _ = run("--version")
    assert code == 0
    assert out.startswith("brdfit")


def test_without_a_command_the_exit_code_is_2(run: Run) -> None:
    code, _, err = run()
    assert code == 2
    assert "COMMAND" in err


@pytest.mark.parametrize(("typed", "meant"), [("fti", "fit"), ("inof", "info"), ("Fit", "fit")])
def test_a_mistyped_command_names_the_nearest(run: Run, typed: str, meant: str) -> None:
    code, _, err = run(typed, "x")
    assert code == 2
    assert f"Did you mean {meant}?" in err


def test_a_mistyped_action_names_the_nearest(run: Run) -> None:
    code, _, err = run("basis", "biuld")
    assert code == 2
    assert "Did you mean build?" in err


def test_a_mistyped_option_names_the_nearest(run: Run, tmp_path: Path) -> None:
    code, _, err = run("info", tmp_path / "x", "--jsno")
    assert code == 2
    assert "no option --jsno. Did you mean --json?" in err
    assert "brdfit info --help" in err


def test_a_mistyped_required_option_is_named_before_the_missing_one(
    run: Run, constant: type
) -> None:
    code, _, err = run("fit", "x.csv", "--otuput", "y.binary")
    assert code == 2
    assert "Did you mean --output?" in err


def test_too_many_words_are_refused(run: Run) -> None:
    code, _, err = run("info", "a", "b")
    assert code == 2
    assert "b" in err


def test_an_unknown_method_names_the_nearest(run: Run, constant: type) -> None:
    code, _, err = run("fit", "x.csv", "-o", "y.binary", "--method", "constnat")
    assert code == 2
    assert "Did you mean constant?" in err


@pytest.mark.parametrize("spelling", ["constant", "Constant", "CONSTANT", "con_stant"])
def test_a_method_is_named_in_any_spelling(run: Run, constant: type, spelling: str) -> None:
    code, out, _ = run("fit", "--method", spelling, "--help")
    assert code == 0
    assert "--error-metric" in out


def test_settings_of_the_method_are_options_with_help_and_default(run: Run, constant: type) -> None:
    code, out, _ = run("fit", "--help")
    assert code == 0
    assert "How to average: linear or log. (default: log)" in out
    assert "--careful, --no-careful" in out
    assert "--passes INT" in out


def test_a_setting_of_the_wrong_type_is_refused(run: Run, constant: type) -> None:
    code, _, err = run("fit", "x.csv", "-o", "y.binary", "--passes", "many")
    assert code == 2
    assert "found 'many' but expected a whole number" in err


def test_degrees_and_radians_exclude_each_other(run: Run, paint_csv: Path) -> None:
    code, _, err = run("info", paint_csv, "--degrees", "--radians")
    assert code == 2
    assert "not allowed" in err


def test_an_option_that_the_format_does_not_know_is_named(run: Run, paint_csv: Path) -> None:
    code, _, err = run("info", paint_csv, "--option", "delimeter=;")
    assert code == 2
    assert "delimiter" in err


def test_the_help_of_to_names_the_formats_that_share_a_suffix(run: Run) -> None:
    text = " ".join(run("convert", "--help")[1].split())
    writers = [s for s in list_formats() if s.write_table or s.write_samples]
    suffixes = {suffix for sheet in writers for suffix in sheet.extensions}
    shared = 0
    for suffix in suffixes:
        first, *others = [s.name for s in writers if suffix in s.extensions]
        if others:
            shared += 1
            assert f"{first} (default)" in text
            assert f"{' or '.join(others)} for {suffix}" in text
    assert shared >= 2
