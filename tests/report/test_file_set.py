from __future__ import annotations

from pathlib import Path

import pytest

from brdfit.errors import UsageError
from brdfit.report.file_set import write_set


def test_all_files_appear_with_their_content(tmp_path: Path) -> None:
    write_set({tmp_path / name: lambda aside, n=name: aside.write_text(n) for name in ("a", "b.c")})
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "a", "b.c": "b.c"}


@pytest.mark.parametrize("failure", [RuntimeError, KeyboardInterrupt])
def test_a_failing_writer_leaves_no_file_and_old_ones_as_they_were(
    tmp_path: Path, failure: type[BaseException]
) -> None:
    (tmp_path / "old.txt").write_text("old")

    def fail(aside: Path) -> None:
        aside.write_text("half")
        raise failure

    with pytest.raises(failure):
        write_set(
            {
                tmp_path / "old.txt": lambda aside: aside.write_text("new"),
                tmp_path / "other.txt": fail,
            }
        )
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"old.txt": "old"}


def test_a_folder_as_target_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    written: list[Path] = []
    with pytest.raises(UsageError, match="folder"):
        write_set({tmp_path / "a": written.append, tmp_path / "folder": written.append})
    assert written == []
