"""What the reports print of frame-to-message delays (GulliView 2025, sec. 4.1: Full HD, median 102 ms before, and after it the
box plot's numbers)."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PublishedBox:
    """A box plot's numbers in ms as printed, None where only the median is; of a stage of a kind of process."""

    label: str
    kind: str
    stage: str
    median: float
    low: float | None = None
    q1: float | None = None
    q3: float | None = None
    high: float | None = None


PUBLISHED = (
    PublishedBox("GulliView before 2025", "camera", "total", 102.0),
    PublishedBox("GulliView 2025", "camera", "total", 14.0, 7.9, 12.1, 17.0, 24.4),
)
