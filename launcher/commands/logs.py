"""`./lilliput logs [RUN...]`: where the time of the frames went, runs compared as the reports do."""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from launcher.errors import LauncherError, UsageError
from launcher.lab_file import add_lab_arguments, read_lab, state_folder
from launcher.output import Result, print_result, progress
from launcher.timing_report import (
    PUBLISHED,
    LabelledRun,
    as_figures,
    as_table,
    compare,
    draw_boxes,
    draw_graph,
    published_figures,
)
from protocol.errors import DecodeError
from protocol.timings import SUFFIX, Run, RunSummary, list_runs, read_files, read_run, timings_folder

NEWEST = 2
"""So many runs are compared when none is named."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "runs",
        nargs="*",
        metavar="RUN",
        help=f"name of a run, its folder, or a {SUFFIX} file; the first is compared with (default: the {NEWEST} newest)",
    )
    add_lab_arguments(parser)
    parser.add_argument("--list", action="store_true", help="only list the runs that there are")
    parser.add_argument("--process", metavar="NAME", help="only this process or kind, e.g. camera-cam0 or tracker")
    parser.add_argument("--last", type=_seconds, metavar="S", help="only the last S seconds of each run")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw box plots to this PNG")
    parser.add_argument("--graph", type=Path, metavar="FILE", help="draw the times over the run to this PNG")
    parser.add_argument("--published", action="store_true", help="the reports' figures beside them")
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(arguments: argparse.Namespace) -> int:
    named: list[str] = arguments.runs
    folder = None if named and all(Path(name).exists() for name in named) else _folder(arguments)
    if arguments.list:
        return _list(_folder(arguments), as_json=arguments.json)
    runs = [_only(each, arguments.process) for each in _chosen(named, folder, arguments.last)]
    comparisons = compare(runs)
    if not comparisons:
        raise LauncherError("no frame has been timed in these runs yet")
    published = PUBLISHED if arguments.published else ()
    if arguments.plot is not None:
        _written(arguments.plot, lambda path: draw_boxes(path, comparisons, runs, published))
    if arguments.graph is not None:
        _written(arguments.graph, lambda path: draw_graph(path, comparisons, runs))
    labels = [each.label for each in runs]
    if not arguments.json:
        print(as_table(comparisons, labels, published))
        return 0
    figures = as_figures(comparisons)
    settings = {f"run{number}": _described(each) for number, each in enumerate(runs, 1)}
    print_result(Result("logs", figures, published_figures(figures), settings), as_json=True)
    return 0


def _folder(arguments: argparse.Namespace) -> Path:
    if arguments.state is not None:
        return timings_folder(arguments.state.resolve())
    return timings_folder(state_folder(None, read_lab(arguments.lab)[1]))


def _chosen(named: Sequence[str], folder: Path | None, last_s: float | None) -> list[LabelledRun]:
    if not named:
        assert folder is not None
        newest = list_runs(folder)[-NEWEST:]
        if not newest:
            raise LauncherError(
                f"no stage timings in {folder}; start the system (./lilliput up), or name a run or a file"
            )
        return [LabelledRun(summary.name, _read(folder / summary.name, last_s)) for summary in newest]
    chosen: list[LabelledRun] = []
    for name in named:
        path = Path(name)
        if folder is not None and not path.exists():
            path = folder / name
            if not path.is_dir():
                known = ", ".join(each.name for each in list_runs(folder)) or "none"
                raise UsageError(f"there is no run {name!r} in {folder}; there are {known}")
        chosen.append(LabelledRun(path.name.removesuffix(SUFFIX), _read(path, last_s)))
    return chosen


def _read(path: Path, last_s: float | None) -> Run:
    try:
        found = read_run(path) if path.is_dir() else read_files([path])
    except DecodeError as error:
        raise UsageError(str(error)) from error
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror or error}") from error
    return found if last_s is None else found.last(last_s)


def _only(labelled: LabelledRun, process: str | None) -> LabelledRun:
    if process is None:
        return labelled
    run = labelled.run
    kept = tuple(each for each in run.processes if process in (each.process, each.kind))
    if not kept:
        known = ", ".join(each.process for each in run.processes)
        raise UsageError(f"run {labelled.label} has no process {process!r}; it has {known}")
    return LabelledRun(labelled.label, replace(run, processes=kept))


def _written(path: Path, draw: Callable[[Path], None]) -> None:
    if path.suffix.lower() != ".png":
        raise UsageError(f"pictures are PNG: {path} should end with .png")
    try:
        draw(path)
    except OSError as error:
        raise LauncherError(f"cannot write {path}: {error.strerror or error}") from error
    progress(f"wrote {path}")


def _described(labelled: LabelledRun) -> dict[str, object]:
    header = labelled.run.header
    return {
        "label": labelled.label,
        "start_ns": header.run_start_ns,
        "lab": header.lab,
        "machine": header.machine,
        "version": header.version,
        "processes": [process.process for process in labelled.run.processes],
    }


def _list(folder: Path, *, as_json: bool) -> int:
    runs = list_runs(folder)
    if as_json:
        listed = [{"name": r.name, "processes": list(r.processes), "size_bytes": r.size_bytes} for r in runs]
        print_result(Result("logs", {"runs": listed}, settings={"folder": str(folder)}), as_json=True)
    else:
        print("\n".join(_line(each) for each in runs) or f"no stage timings in {folder}")
    return 0


def _line(summary: RunSummary) -> str:
    header = summary.header
    seconds = max(0.0, (summary.newest_ns - header.run_start_ns) * 1e-9)
    return (
        f"{summary.name:<24}{seconds:>9.0f} s {summary.size_bytes / 1e6:>8.1f} MB  {header.lab}, {header.version},"
        f" {header.machine}: {', '.join(summary.processes)}"
    )


def _seconds(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not 0 < number < 1e9:
        raise argparse.ArgumentTypeError("--last needs a number of seconds above 0")
    return number
