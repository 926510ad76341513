"""The console's page of stage timings on the running system: the present run fills it, another is compared with it."""

import re
from pathlib import Path

import msgspec
from playwright.sync_api import expect

from protocol.timings import encode_header, list_runs, read_run, read_segment, record_struct, timings_folder
from tests.e2e.browser import SLOW_MS, console
from tests.e2e.system import RunningSystem, wait_for

EARLIER = "20000101T000000Z"
HOUR_NS = 3600 * 10**9


def copy_as_earlier_run(folder: Path, run: str) -> None:
    """What the system has measured so far, as if an hour before."""
    (folder / EARLIER).mkdir()
    for path in (folder / run).iterdir():
        segment = read_segment(path)
        header = segment.header
        header = msgspec.structs.replace(
            header,
            run=EARLIER,
            run_start_ns=header.run_start_ns - HOUR_NS,
            start_ns=header.start_ns - HOUR_NS,
        )
        pack = record_struct(len(header.stages)).pack
        records = (pack(stamp - HOUR_NS, *row) for stamp, row in zip(segment.stamps_ns, segment.ms, strict=True))
        (folder / EARLIER / path.name).write_bytes(encode_header(header) + b"".join(records))


def all_have_written(folder: Path) -> bool:
    """Four cameras and the tracker, for some seconds."""
    runs = list_runs(folder)
    if not runs or len(runs[0].processes) < 5:
        return False
    return read_run(folder / runs[0].name).values("tracker", "total")[1].size >= 400


def test_runs_are_compared_in_the_browser(system: RunningSystem) -> None:
    folder = timings_folder(system.state)
    wait_for("cameras and tracker have written", lambda: all_have_written(folder))
    (run,) = list_runs(folder)
    copy_as_earlier_run(folder, run.name)
    try:
        with console(system) as operator:
            operator.page.set_viewport_size({"width": 1440, "height": 1250})
            operator.open("logs")
            for stage in ("camera-total", "camera-window", "tracker-track", "tracker-total"):
                expect(operator.part(f"timings-{stage}").locator("canvas").first).to_be_visible(timeout=SLOW_MS)
            table = operator.part("timings-table")
            total = table.get_by_role("row").filter(has_text="camera total")
            expect(total).to_have_count(1)
            frames = total.locator("td").last
            first = frames.inner_text()
            assert int(first.replace(",", "")) > 0
            expect(table).to_contain_text(re.compile(r"[+-]?\d+\.\d %"))
            operator.page.get_by_label("Outliers").click()
            operator.screenshot("logs")

            # The present run grows while one looks at it; the earlier one has ended.
            present = table.get_by_role("row").filter(has_text=re.compile(r"\d %")).first.locator("td").last
            before = present.inner_text()
            expect(present).not_to_have_text(before, timeout=SLOW_MS)
            expect(frames).to_have_text(first)

            operator.page.get_by_text("Over time", exact=True).click()
            expect(operator.part("timings-camera-total").get_by_role("img")).to_have_accessible_name(
                re.compile("camera total, over the time of")
            )
            operator.page.get_by_text("1 min", exact=True).click()
            expect(table.get_by_role("row").filter(has_text="camera total")).to_have_count(1)  # of the present run
    finally:
        for path in (folder / EARLIER).iterdir():
            path.unlink()
        (folder / EARLIER).rmdir()
