"""A file appears whole or not at all."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import pytest

from brdfit.errors import UsageError
from brdfit.files import atomic_path, sha256_of_bytes, sha256_of_file


def write(target: Path, content: str) -> None:
    with atomic_path(target) as aside:
        aside.write_text(content)


def fail_half_way(target: Path, error: type[BaseException]) -> None:
    with atomic_path(target) as aside:
        aside.write_text("half of")
        raise error


def test_a_finished_file_is_whole_and_alone(tmp_path: Path) -> None:
    write(tmp_path / "out.csv", "all of it")
    assert (tmp_path / "out.csv").read_text() == "all of it"
    assert os.listdir(tmp_path) == ["out.csv"]


def test_nothing_is_at_the_target_before_it_is_whole(tmp_path: Path) -> None:
    with atomic_path(tmp_path / "out.csv") as aside:
        aside.write_text("half of")
        assert not (tmp_path / "out.csv").exists()
        assert aside.parent == tmp_path


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit])
def test_a_failure_leaves_nothing_behind(tmp_path: Path, error: type[BaseException]) -> None:
    with pytest.raises(error):
        fail_half_way(tmp_path / "out.csv", error)
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_a_failure_keeps_what_was_there(tmp_path: Path, error: type[BaseException]) -> None:
    target = tmp_path / "out.csv"
    target.write_text("the old content")
    with pytest.raises(error):
        fail_half_way(target, error)
    assert target.read_text() == "the old content"
    assert os.listdir(tmp_path) == ["out.csv"]


def test_success_replaces_what_was_there(tmp_path: Path) -> None:
    target = tmp_path / "out.csv"
    target.write_text("old")
    write(target, "new")
    assert target.read_text() == "new"


def test_the_path_to_write_to_has_the_suffix_of_the_target(tmp_path: Path) -> None:
    with atomic_path(tmp_path / "out.png") as aside:
        assert aside.suffix == ".png"
        aside.touch()


def test_the_mode_is_that_of_an_ordinary_new_file(tmp_path: Path) -> None:
    ordinary = tmp_path / "ordinary"
    ordinary.touch()
    write(tmp_path / "out.csv", "x")
    assert (tmp_path / "out.csv").stat().st_mode == ordinary.stat().st_mode


def test_a_link_is_followed(tmp_path: Path) -> None:
    real, link = tmp_path / "real.csv", tmp_path / "link.csv"
    real.touch()
    link.symlink_to(real)
    write(link, "x")
    assert link.is_symlink()
    assert real.read_text() == "x"


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"no_such.*does not exist; create it first"):
        write(tmp_path / "no_such" / "out.csv", "x")


def test_a_folder_or_device_is_no_target(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="found a folder or a device"):
        write(tmp_path, "x")
    with pytest.raises(UsageError, match="found a folder or a device"):
        write(Path(os.devnull), "x")


def test_the_hash_is_sha_256(tmp_path: Path) -> None:
    # FIPS 180-2, appendix B.1
    expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert sha256_of_bytes(b"abc") == expected
    (tmp_path / "abc").write_bytes(b"abc")
    assert sha256_of_file(tmp_path / "abc") == expected


def test_a_file_longer_than_a_block_is_hashed_whole(tmp_path: Path) -> None:
    content = bytes(range(256)) * 5000
    (tmp_path / "long").write_bytes(content)
    assert sha256_of_file(tmp_path / "long") == hashlib.sha256(content).hexdigest()
