"""Comparisons as text and as figures."""

from collections.abc import Iterator, Sequence

from launcher.timing_report.comparison import Comparison
from launcher.timing_report.published import PUBLISHED, PublishedBox
from protocol.timings import Box

QUANTITIES = {"low": "min", "q1": "Q1", "median": "median", "q3": "Q3", "high": "max"}
"""Fields of a box and what the reports' tables call them; min and max are without outliers."""
_NAME, _CELL = 26, 10


def as_table(comparisons: Sequence[Comparison], labels: Sequence[str], published: Sequence[PublishedBox] = ()) -> str:
    """A block of lines per stage: a line per run and, from the second on, one with the change in percent against the first."""
    lines: list[str] = []
    for comparison in comparisons:
        heads = "".join(f"{head:>{_CELL}}" for head in (*QUANTITIES.values(), "p99", "outliers", "frames"))
        lines.append(f"{f'{comparison.kind} {comparison.stage}, ms':<{_NAME}}{heads}")
        for index, (label, found) in enumerate(zip(labels, comparison.boxes, strict=True)):
            lines.extend(_rows(comparison, index, label, found))
        lines.extend(
            f"  {f'{box.label} (published)':<{_NAME - 2}}{_published_cells(box)}"
            for box in published
            if (box.kind, box.stage) == (comparison.kind, comparison.stage)
        )
        lines.append("")
    return "\n".join(lines).rstrip()


def as_figures(comparisons: Sequence[Comparison]) -> dict[str, float]:
    """`run1_camera_total_median_ms` and so on; with `_change_percent` for `_ms` from the second run on."""
    figures: dict[str, float] = {}
    for comparison in comparisons:
        for index, found in enumerate(comparison.boxes):
            if found is None:
                continue
            start = f"run{index + 1}_{comparison.kind}_{comparison.stage}"
            for quantity, name in QUANTITIES.items():
                figures[f"{start}_{name.lower()}_ms"] = getattr(found, quantity)
                change = comparison.change_percent(index, quantity)
                if change is not None:
                    figures[f"{start}_{name.lower()}_change_percent"] = change
            figures[f"{start}_p99_ms"] = found.p99
            figures[f"{start}_outliers"] = found.outliers
            figures[f"{start}_frames"] = found.count
    return figures


def published_figures(figures: dict[str, float]) -> dict[str, float]:
    """What the newest report prints for the same keys."""
    printed = PUBLISHED[-1]
    names = {f"{printed.kind}_{printed.stage}_{name.lower()}_ms": getattr(printed, q) for q, name in QUANTITIES.items()}
    return {key: names[rest] for key in figures if (rest := key.partition("_")[2]) in names}


def _rows(comparison: Comparison, index: int, label: str, found: Box | None) -> Iterator[str]:
    if found is None:
        yield f"  {label:<{_NAME - 2}}{'(does not have this stage)':>{3 * _CELL}}"
        return
    cells = [f"{getattr(found, quantity):.3f}" for quantity in (*QUANTITIES, "p99")]
    yield f"  {label:<{_NAME - 2}}" + "".join(f"{c:>{_CELL}}" for c in (*cells, found.outliers, found.count))
    changes = [comparison.change_percent(index, quantity) for quantity in QUANTITIES]
    if any(change is not None for change in changes):
        yield (
            " " * _NAME
            + "".join(f"{'' if change is None else f'{change:+.1f} %':>{_CELL}}" for change in changes).rstrip()
        )


def _published_cells(box: PublishedBox) -> str:
    values = (getattr(box, quantity) for quantity in QUANTITIES)
    return "".join(f"{'' if value is None else f'{value:.1f}':>{_CELL}}" for value in values).rstrip()
