"""Runs and their stage timings, as box plots and time graphs."""

from pydantic import Field

from protocol.timings import Box, Run, RunSummary, Series, box, downsample, outliers
from server.views.base import View

_MOST_OUTLIERS, _MOST_POINTS = 100, 240


class TimingRunView(View):
    """A run whose timings this server's machine has: one start of the system there. `newest_ns` is when it was last written
    to."""

    name: str
    start_ns: int
    newest_ns: int
    lab: str
    machine: str
    version: str
    processes: tuple[str, ...]
    size_bytes: int


class BoxView(View):
    """A box plot's numbers in ms: quartiles (linear interpolation), whiskers `low` and `high` at the last value within 1.5 IQR,
    how many `outliers` lie beyond them, and some of those for a picture."""

    count: int
    low: float
    q1: float
    median: float
    q3: float
    high: float
    mean: float
    p99: float
    outliers: int
    outlier_values: tuple[float, ...]


class SeriesView(View):
    """A time graph: seconds since the run's start, and the median and highest ms of each short while."""

    seconds: tuple[float, ...]
    median: tuple[float, ...]
    highest: tuple[float, ...]


class StageView(View):
    """A stage of a kind of process, over all processes of that kind."""

    kind: str = Field(examples=["camera"])
    stage: str = Field(examples=["total"])
    box: BoxView
    series: SeriesView


class RunTimingsView(View):
    """A run's stages in the order in which they happen, kind by kind."""

    name: str
    start_ns: int
    processes: tuple[str, ...]
    stages: tuple[StageView, ...]


def run_view(summary: RunSummary) -> TimingRunView:
    """A run in the list."""
    header = summary.header
    return TimingRunView(
        name=summary.name,
        start_ns=header.run_start_ns,
        newest_ns=summary.newest_ns,
        lab=header.lab,
        machine=header.machine,
        version=header.version,
        processes=summary.processes,
        size_bytes=summary.size_bytes,
    )


def run_timings_view(run: Run) -> RunTimingsView:
    """A run's statistics; stages without any value are left out."""
    stages: list[StageView] = []
    for kind in run.kinds:
        for stage in run.stages(kind):
            stamps, values = run.values(kind, stage)
            found = box(values)
            if found is not None:
                beyond = outliers(values, found, _MOST_OUTLIERS)
                series = downsample(stamps, values, run.header.run_start_ns, _MOST_POINTS)
                view = StageView(kind=kind, stage=stage, box=_box(found, beyond.tolist()), series=_series(series))
                stages.append(view)
    return RunTimingsView(
        name=run.name,
        start_ns=run.header.run_start_ns,
        processes=tuple(process.process for process in run.processes),
        stages=tuple(stages),
    )


def _box(found: Box, beyond: list[float]) -> BoxView:
    return BoxView(
        count=found.count,
        low=_ms(found.low),
        q1=_ms(found.q1),
        median=_ms(found.median),
        q3=_ms(found.q3),
        high=_ms(found.high),
        mean=_ms(found.mean),
        p99=_ms(found.p99),
        outliers=found.outliers,
        outlier_values=tuple(map(_ms, beyond)),
    )


def _series(series: Series) -> SeriesView:
    return SeriesView(
        seconds=tuple(round(float(at), 2) for at in series.seconds),
        median=tuple(_ms(float(value)) for value in series.median),
        highest=tuple(_ms(float(value)) for value in series.highest),
    )


def _ms(value: float) -> float:
    """To the microsecond, below which clocks say nothing."""
    return round(value, 3)
