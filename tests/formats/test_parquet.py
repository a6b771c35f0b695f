"""Parquet: what only that format can hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import brdfit
from brdfit.errors import CorruptFile, DataQualityWarning, UsageError


def test_text_in_a_parquet_column_is_flagged_by_record(tmp_path: Path) -> None:
    fr = ["0.5"] * 20
    fr[6] = "saturated"
    angle = np.linspace(0.1, 0.6, 20)
    table = pa.table({"theta_h": angle, "theta_d": angle, "phi_d": angle, "fr": fr})
    pq.write_table(table, tmp_path / "x.parquet")
    with pytest.warns(DataQualityWarning, match="1 unreadable, rows 7"):
        samples = brdfit.read_samples(tmp_path / "x.parquet", angles="radians")
    assert samples.flag_counts()["unreadable"] == 1


def test_a_parquet_column_of_lists_is_refused_by_name(tmp_path: Path) -> None:
    angle = np.linspace(0.1, 1.0, 3)
    table = pa.table({"theta_h": angle, "theta_d": angle, "phi_d": angle, "fr": [[1.0]] * 3})
    pq.write_table(table, tmp_path / "x.parquet")
    with pytest.raises(UsageError, match="column 'fr' holds list"):
        brdfit.read_samples(tmp_path / "x.parquet", angles="radians")


def test_a_truncated_parquet_file_is_corrupt(tmp_path: Path) -> None:
    path = tmp_path / "x.parquet"
    pq.write_table(pa.table({"theta_h": np.ones(50)}), path)
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(CorruptFile, match="truncated or damaged"):
        brdfit.read_samples(path)


def test_integers_and_nulls_are_numbers_and_missing(tmp_path: Path) -> None:
    angle = np.linspace(0.1, 0.6, 20)
    values = pa.array([None, *range(1, 20)], pa.int32())
    table = pa.table({"theta_h": angle, "theta_d": angle, "phi_d": angle, "fr": values})
    pq.write_table(table, tmp_path / "x.parquet")
    with pytest.warns(DataQualityWarning, match="1 not_finite, rows 1"):
        samples = brdfit.read_samples(tmp_path / "x.parquet", angles="radians")
    assert samples.value[1:, 0].tolist() == list(range(1, 20))


def test_a_table_without_records_is_corrupt(tmp_path: Path) -> None:
    pq.write_table(pa.table({"theta_h": pa.array([], pa.float64())}), tmp_path / "x.parquet")
    with pytest.raises(CorruptFile, match="holds no record"):
        brdfit.read_samples(tmp_path / "x.parquet")
