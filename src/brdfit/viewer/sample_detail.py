"""Everything about one sample: the row of its file, and its value against the prediction."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.geometry import spherical_from_directions
from brdfit.report.samples_csv import Judged
from brdfit.samples import Flag, Samples
from brdfit.viewer.describe import number
from brdfit.viewer.item import Item
from brdfit.viewer.messages import ChannelDetail, SampleDetail

__all__ = ["sample_message", "text_row"]

# A line longer than this is no line of a text file.
_LONGEST_LINE = 20_000


def sample_message(item: Item, index: int) -> SampleDetail:
    """Return the sample `index`; `UsageError` if there is none."""
    judged = item.fitted.judged
    if judged is None:
        raise UsageError(f"{item.name}: is a table alone; no samples of it are known.")
    samples = judged.samples
    if not 0 <= index < len(samples):
        raise UsageError(f"sample: found {index} but there are 0 to {len(samples) - 1}.")
    row = judged.rows[index]
    header, line = text_row(item.source, row)
    theta_i, phi_i = spherical_from_directions(samples.wi[index])
    theta_o, phi_o = spherical_from_directions(samples.wo[index])
    theta_h, theta_d, phi_d = (angle[index] for angle in samples.half_diff)
    bits = int(samples.bits[index])
    return SampleDetail(
        sample=index,
        row=row,
        source=samples.source.name,
        line=line,
        header=header,
        theta_i=_degrees(theta_i),
        phi_i=_degrees(phi_i),
        theta_o=_degrees(theta_o),
        phi_o=_degrees(phi_o),
        theta_h=_degrees(theta_h),
        theta_d=_degrees(theta_d),
        phi_d=_degrees(phi_d),
        flags=[str(flag.name).lower() for flag in Flag if bits & flag],
        outlier=bool(judged.outliers[index]),
        rejected=bool(bits & int(Flag.REJECTED)),
        weight=number(judged.weights[index]),
        channels=_channels(item, judged, index),
        band=item.no_band,
        prediction=_no_prediction(item, judged),
    )


def _channels(item: Item, judged: Judged, index: int) -> list[ChannelDetail]:
    samples = judged.samples
    prediction, deviation = _prediction(item, samples, index)
    details = []
    for c, name in enumerate(samples.channels):
        low = high = None
        if prediction is not None and deviation is not None:
            factor = float(np.exp(item.deviations * deviation[c]))
            low, high = number(prediction[c] / factor), number(prediction[c] * factor)
        state = "unused"
        if samples.usable[index, c]:
            state = "censored" if samples.censored[index, c] else "used"
        details.append(
            ChannelDetail(
                channel=name,
                value=number(samples.value[index, c]),
                sigma=None if samples.sigma is None else number(samples.sigma[index, c]),
                prediction=None if prediction is None else number(prediction[c]),
                low=low,
                high=high,
                residual=number(judged.residuals[index, c]),
                weight=number(_channel_weight(item, judged, index, c)),
                state=state,  # type: ignore[arg-type]
            )
        )
    return details


def _prediction(
    item: Item, samples: Samples, index: int
) -> tuple[FloatArray | None, FloatArray | None]:
    """Return (f_r (channels,), its deviation (channels,)); None for what is not known."""
    wi, wo = samples.wi[index : index + 1], samples.wo[index : index + 1]
    if int(samples.bits[index]) & int(Flag.NOT_UNIT | Flag.BELOW_HORIZON | Flag.UNREADABLE):
        return None, None
    if not np.isfinite(np.hstack([wi, wo])).all():
        return None, None
    if _same_channels(item, samples):
        prediction = item.evaluate(wi, wo)[0]
    else:
        prediction = _judged_by(item, index)
    if item.stddev is None:
        return prediction, None
    deviation = item.stddev(wi, wo)[0]
    if deviation.size not in (1, prediction.size):
        return prediction, None
    return prediction, np.broadcast_to(deviation, prediction.shape)


def _same_channels(item: Item, samples: Samples) -> bool:
    return item.result is not None or item.table.n_channels == samples.n_channels


def _judged_by(item: Item, index: int) -> FloatArray:
    """Return the f_r (channels,) that the sample was judged by: value over exp(residual).

    For a table in R, G, B of samples in many bands. NaN where the value was censored: its
    residual is against a bound.
    """
    judged = item.fitted.judged
    assert judged is not None
    positive = judged.samples.positive[index]
    with np.errstate(invalid="ignore", over="ignore"):
        prediction = judged.samples.value[index] * np.exp(-judged.residuals[index])
    return np.where(positive, prediction, np.nan)


def _no_prediction(item: Item, judged: Judged) -> str:
    """Return why some samples have no prediction; empty where all have one."""
    if _same_channels(item, judged.samples):
        return ""
    return (
        f"the table has {item.table.n_channels} channels, the samples {judged.samples.n_channels}; "
        f"so they come from the recorded residuals, which tell nothing where a value is censored"
    )


def _channel_weight(item: Item, judged: Judged, index: int, channel: int) -> float:
    if item.result is not None:
        return float(item.result.channel_weights[index, channel])
    return float(judged.weights[index])


def text_row(path: Path | None, row: int) -> tuple[str | None, str | None]:
    """Return (the line that names the columns, line `row` from 1) of a text file.

    None for each that is not there: the file is not at hand, not text, or has no such line.
    """
    if path is None:
        return None, None
    try:
        with path.open(encoding="utf-8") as stream:
            lines = list(islice((line.rstrip("\r\n")[:_LONGEST_LINE] for line in stream), row))
    except (OSError, UnicodeDecodeError):
        return None, None
    if len(lines) < row or "\0" in lines[-1]:
        return None, None
    return _names_of_columns(lines[:-1]), lines[-1]


def _names_of_columns(before: list[str]) -> str | None:
    """Return the last line before the data that has words and as many separators."""
    for line in reversed(before):
        first = line.lstrip("# \t")[:1]
        if first and not (first.isdigit() or first in "+-.,"):
            return line
    return None


def _degrees(angle: FloatArray) -> float | None:
    return number(np.degrees(angle))
