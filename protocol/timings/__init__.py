"""How long each stage of each frame took: the files in which processes keep it, and the statistics by which the reports compare
runs (GulliView 2024 and 2025, sec. 3.1.4 and 4.1).

Processes write (`localization.timings`); `./lilliput logs` and the console read. A run is one start of the system: a folder
`timings/RUN` in the state folder, with the segments of every process in it.
"""

from protocol.timings.runs import (
    ProcessTimings,
    Run,
    RunSummary,
    list_runs,
    read_files,
    read_run,
    run_name,
    summarize,
    timings_folder,
)
from protocol.timings.segment import SUFFIX, Header, Segment, encode_header, read_segment, record_struct, segment_name
from protocol.timings.statistics import Box, Series, box, change_percent, downsample, outliers

__all__ = [
    "SUFFIX",
    "Box",
    "Header",
    "ProcessTimings",
    "Run",
    "RunSummary",
    "Segment",
    "Series",
    "box",
    "change_percent",
    "downsample",
    "encode_header",
    "list_runs",
    "outliers",
    "read_files",
    "read_run",
    "read_segment",
    "record_struct",
    "run_name",
    "segment_name",
    "summarize",
    "timings_folder",
]
