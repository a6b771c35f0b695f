"""What the server and the page say to each other, typed once.

`viewer-client/src/messages.ts` is made of these classes by `tools/client_types.py`; a test
holds the two together. Angles are in degrees, values f_r in 1/sr, wherever a field does not
say otherwise; numbers that are not finite travel as null.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from brdfit.report.slice_panel import Curve, NearPoint, SlicePanel

__all__ = ["MESSAGES"]


@dataclass(frozen=True)
class LightSet:
    """Distant lights and an even surround, view coordinates: x right, y up, z to the viewer."""

    name: str
    title: str
    direction: list[list[float]]
    irradiance: list[list[float]]
    surround: list[float]
    warnings: list[str]
    """What the reader of a panorama had to leave out."""


@dataclass(frozen=True)
class Setting:
    """One setting of a method or of a reader, as a form shows it."""

    name: str
    help: str
    kind: Literal["number", "integer", "flag", "word", "choice"]
    default: float | bool | str | None
    choices: list[str]


@dataclass(frozen=True)
class MethodInfo:
    """A method that can fit."""

    name: str
    title: str
    settings: list[Setting]
    leans_on_population: bool


@dataclass(frozen=True)
class Writable:
    """A format that something can be downloaded in."""

    format: str
    kind: Literal["table", "samples", "record"]
    title: str
    suffix: str
    loses: str


@dataclass(frozen=True)
class Home:
    """The first thing that the page asks for."""

    version: str
    entries: list[str]
    """What was opened at the start: ids, in order."""
    jobs: list[str]
    """Fits that began at the start."""
    methods: list[MethodInfo]
    """The default first."""
    lights: list[LightSet]
    reading: list[Setting]
    """What can be said of a file whose columns do not speak for themselves."""
    upload_limit: int
    """Bytes."""


@dataclass(frozen=True)
class SamplesSummary:
    """What is known of an entry's samples as a whole."""

    count: int
    used: int
    outliers: int
    rejected: int
    """Switched off, by the file or by a person."""
    flags: dict[str, int]
    source: str
    convention: str
    incidences: list[float]
    """Angles of the light, degrees, at which the most samples lie in one plane."""


@dataclass(frozen=True)
class FitSummary:
    """How an entry was fitted."""

    method: str
    settings: dict[str, str]
    population: str
    outcome: str
    ok: bool
    advice: str
    iterations: int
    residual_before: float | None
    residual_after: float | None
    """Median |ln(value / result)|."""
    outlier_rule: str
    live: bool
    """Fitted in this session: predictions come from the model, not from the table alone."""


@dataclass(frozen=True)
class Entry:
    """A table or a reconstruction that can be looked at."""

    id: str
    name: str
    kind: Literal["table", "reconstruction"]
    grid: list[int]
    """n_theta_h, n_theta_d, n_phi_d"""
    scale: float
    """f_r is the half float times this."""
    channels: list[str]
    conversion: str
    """How the table became R, G, B; empty if it was."""
    missing: int
    """Cells that hold nothing and are shown as their nearest neighbour."""
    samples: SamplesSummary | None
    fit: FitSummary | None
    warnings: list[str]
    writable: list[Writable]
    parent: str | None
    """The entry that this is a refit of."""


@dataclass(frozen=True)
class Albedo:
    """What an even surround adds: directional albedo in R, G, B against cos theta_o."""

    cosine: list[float]
    value: list[list[float]]


@dataclass(frozen=True)
class SampleColumns:
    """The samples as columns of equal length, for the two maps."""

    sample: list[int]
    """Index, from 0."""
    row: list[int]
    """Line or record of the source, from 1."""
    theta_h: list[float | None]
    theta_d: list[float | None]
    phi_d: list[float | None]
    theta_i: list[float | None]
    theta_o: list[float | None]
    turn: list[float | None]
    """Azimuth of the detector from the light."""
    value: list[float | None]
    """Mean over the channels."""
    residual: list[float | None]
    """Mean of ln(value / result) over the channels."""
    weight: list[float | None]
    outlier: list[bool]
    used: list[bool]
    left_out: int
    """How many more there are than are listed."""


@dataclass(frozen=True)
class ChannelDetail:
    """One channel of one sample."""

    channel: str
    value: float | None
    sigma: float | None
    prediction: float | None
    low: float | None
    high: float | None
    """Ends of the 95 % band, where the method knows it."""
    residual: float | None
    weight: float | None
    state: Literal["used", "censored", "unused"]


@dataclass(frozen=True)
class SampleDetail:
    """Everything about one sample."""

    sample: int
    row: int
    """Line or record of the source, from 1."""
    source: str
    line: str | None
    """The row of the file as it stands there; null where the file is not text or not at hand."""
    header: str | None
    """The line of a text file that names the columns, if it has one."""
    theta_i: float | None
    phi_i: float | None
    theta_o: float | None
    phi_o: float | None
    theta_h: float | None
    theta_d: float | None
    phi_d: float | None
    flags: list[str]
    outlier: bool
    rejected: bool
    weight: float | None
    channels: list[ChannelDetail]
    band: str
    """Why there is no band; empty where there is one."""
    prediction: str
    """Where predictions come from, and why some are not known; empty where all are."""


@dataclass(frozen=True)
class TrustPlane:
    """Where a result comes from, over theta_h x theta_d at one phi_d."""

    phi_d: float
    theta_h: list[float]
    theta_d: list[float]
    code: list[list[int]]
    """[theta_d][theta_h]: 0 below the horizon, else 1 + index into `names`."""
    names: list[str]
    shares: list[float]
    """Share of the whole domain, all phi_d, for each name."""
    definition: str


@dataclass(frozen=True)
class MetricRow:
    """One figure of a comparison."""

    name: str
    title: str
    where: str
    """Illumination, or "values"."""
    value: float | None
    text: str
    unit: str
    higher_is_better: bool


@dataclass(frozen=True)
class ComparisonTable:
    """One entry against another under every metric."""

    reference: str
    test: str
    rows: list[MetricRow]
    notes: list[str]


@dataclass(frozen=True)
class Upload:
    """A file that the page handed over."""

    id: str
    name: str
    kind: Literal["samples", "table"]
    count: int
    """Samples, or cells with a value."""
    entry: str | None
    """A table can be looked at at once."""
    warnings: list[str]


@dataclass(frozen=True)
class FitRequest:
    """Fit an upload, or an entry's samples once more."""

    source: str
    """Id of an upload or an entry."""
    method: str = ""
    """Name; empty = that of the entry, or the default."""
    settings: dict[str, float | bool | str | None] = field(default_factory=dict)
    population: str = ""
    """"published", or empty for what the entry leaned on."""
    rejected: list[int] = field(default_factory=list)
    """Samples, by index, to switch off."""
    accepted: list[int] = field(default_factory=list)
    """Samples, by index, to switch on again."""
    beside: bool = False
    """Show the result beside the entry, not in its place."""


@dataclass(frozen=True)
class Job:
    """A fit that waits, runs, or has ended."""

    id: str
    title: str
    state: Literal["waiting", "running", "done", "failed", "cancelled"]
    label: str
    done: int
    total: int
    seconds: float
    entry: str | None
    """The result, once there is one."""
    replaces: str | None
    """The entry that was refitted."""
    message: str
    """What went wrong, or what the result wants to be known."""


@dataclass(frozen=True)
class Problem:
    """Why a request was refused."""

    kind: str
    message: str


MESSAGES: tuple[type, ...] = (
    LightSet,
    Setting,
    MethodInfo,
    Writable,
    Home,
    SamplesSummary,
    FitSummary,
    Entry,
    Albedo,
    SampleColumns,
    ChannelDetail,
    SampleDetail,
    Curve,
    NearPoint,
    SlicePanel,
    TrustPlane,
    MetricRow,
    ComparisonTable,
    Upload,
    FitRequest,
    Job,
    Problem,
)
"""Every message, those that others are made of first."""
