"""The same stage of several runs side by side."""

from collections.abc import Sequence
from dataclasses import dataclass

from protocol.timings import Box, Run, box, change_percent


@dataclass(frozen=True, slots=True, eq=False)
class LabelledRun:
    """A run under the name that a reader knows it by."""

    label: str
    run: Run


@dataclass(frozen=True, slots=True)
class Comparison:
    """A stage of a kind of process: a box (ms) per run, in the runs' order; None for a run that does not have the stage."""

    kind: str
    stage: str
    boxes: tuple[Box | None, ...]

    def change_percent(self, index: int, quantity: str) -> float | None:
        """By how much a run's `low`, `q1`, `median`, `q3` or `high` differs from the first run's; None where there is nothing
        to compare with."""
        first, other = self.boxes[0], self.boxes[index]
        if index == 0 or first is None or other is None:
            return None
        return change_percent(getattr(other, quantity), getattr(first, quantity))


def compare(runs: Sequence[LabelledRun]) -> list[Comparison]:
    """Every stage that any of the runs has, over all processes of a kind together."""
    kinds = dict.fromkeys(kind for each in runs for kind in each.run.kinds)
    return [
        Comparison(kind, stage, boxes)
        for kind in kinds
        for stage in dict.fromkeys(stage for each in runs for stage in each.run.stages(kind))
        if any(boxes := tuple(box(each.run.values(kind, stage)[1]) for each in runs))
    ]
