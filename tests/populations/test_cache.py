"""Small arrays that are computed once."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from brdfit.errors import PopulationError
from brdfit.populations import cache_folder, remember


class Build:
    """Counts its calls."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self) -> dict[str, np.ndarray]:
        self.calls += 1
        return {"basis": np.arange(6.0).reshape(2, 3), "names": np.array(["a", "bc"])}


def test_the_folder_is_where_the_variable_says(cache: Path) -> None:
    assert cache_folder("arrays") == cache / "arrays"
    assert (cache / "arrays").is_dir()


def test_a_folder_that_cannot_be_made_names_the_variable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("BRDFIT_CACHE", str(tmp_path / "file"))
    with pytest.raises(PopulationError, match="BRDFIT_CACHE"):
        cache_folder("arrays")


def test_what_was_built_is_remembered(cache: Path) -> None:
    build = Build()
    first = remember("toy", "key", build)
    second = remember("toy", "key", build)
    assert build.calls == 1
    assert first.keys() == second.keys()
    for name in first:
        np.testing.assert_array_equal(first[name], second[name])


def test_another_key_or_kind_is_built_anew(cache: Path) -> None:
    build = Build()
    for kind, key in (("toy", "key"), ("toy", "key 2"), ("other", "key")):
        remember(kind, key, build)
    assert build.calls == 3


@pytest.mark.parametrize("keep", [0, 10, -30])
def test_a_damaged_entry_is_built_again(cache: Path, keep: int) -> None:
    build = Build()
    remember("toy", "key", build)
    (entry,) = (cache / "arrays" / "toy").glob("*.npz")
    entry.write_bytes(entry.read_bytes()[:keep])
    assert remember("toy", "key", build)["basis"].shape == (2, 3)
    assert build.calls == 2


def test_a_changed_byte_is_noticed(cache: Path) -> None:
    build = Build()
    remember("toy", "key", build)
    (entry,) = (cache / "arrays" / "toy").glob("*.npz")
    content = entry.read_bytes()
    entry.write_bytes(content.replace(np.float64(4.0).tobytes(), np.float64(9.0).tobytes()))
    np.testing.assert_array_equal(remember("toy", "key", build)["basis"][1], [3.0, 4.0, 5.0])
    assert build.calls == 2


def test_an_entry_under_the_wrong_key_is_not_believed(cache: Path) -> None:
    build = Build()
    remember("toy", "key", build)
    (entry,) = (cache / "arrays" / "toy").glob("*.npz")
    remember("toy", "key 2", build)
    (other,) = set((cache / "arrays" / "toy").glob("*.npz")) - {entry}
    other.write_bytes(entry.read_bytes())
    remember("toy", "key 2", build)
    assert build.calls == 3


def test_a_build_that_fails_leaves_nothing(cache: Path) -> None:
    def fail() -> dict[str, np.ndarray]:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        remember("toy", "key", fail)
    assert not list((cache / "arrays" / "toy").glob("*.npz"))


REMEMBER = """
import sys, time
import numpy as np
from brdfit.populations import remember

def build():
    with open(sys.argv[1], "a") as log:
        log.write("built\\n")
    time.sleep(0.5)
    return {"x": np.arange(3.0)}
print(remember("toy", "key", build)["x"].sum())
"""


def test_two_processes_build_once(cache: Path, tmp_path: Path) -> None:
    log = tmp_path / "log.txt"
    both = [
        subprocess.Popen(
            [sys.executable, "-c", REMEMBER, str(log)], stdout=subprocess.PIPE, text=True
        )
        for _ in range(2)
    ]
    assert [process.communicate(timeout=60)[0].strip() for process in both] == ["3.0", "3.0"]
    assert log.read_text() == "built\n"
