"""Stage timings over REST: the runs of the server's state folder, their box plots and time graphs."""

from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

import httpx
import numpy as np
import pytest

from protocol.clock import SimulatedClock
from protocol.timings import Header, encode_header, record_struct, segment_name
from tests.redis_fixture import RedisServer
from tests.server.service import in_process

START_NS = SimulatedClock().now_ns() - 100 * 10**9


def write_run(state: Path, name: str, start_ns: int = START_NS, rows: int = 100) -> None:
    """A camera and a tracker with a record each second; `total` grows from 1 ms, the last is 500 ms."""
    folder = state / "timings" / name
    folder.mkdir(parents=True)
    for process, kind in (("camera-cam0", "camera"), ("tracker", "tracker")):
        header = Header(name, start_ns, start_ns, process, kind, "gulliver", "nuc", "0.1.0", ("full", "total"))
        pack = record_struct(2).pack
        totals = [*np.linspace(1.0, 2.0, rows - 1), 500.0]
        records = (pack(start_ns + n * 10**9, 8.0 if n == 0 else float("nan"), total) for n, total in enumerate(totals))
        (folder / segment_name(process, 1)).write_bytes(encode_header(header) + b"".join(records))


@pytest.fixture
async def viewer(redis_server: RedisServer, tmp_path: Path) -> AsyncIterator[httpx.AsyncClient]:
    async with in_process(redis_server.url, clock=SimulatedClock()) as service:
        service.context.configuration = replace(service.context.configuration, state=tmp_path)
        yield service.http("viewer")


async def test_runs_are_listed_newest_first(viewer: httpx.AsyncClient, tmp_path: Path) -> None:
    assert (await viewer.get("/api/timings")).json() == []
    write_run(tmp_path, "older", START_NS - 10**12)
    write_run(tmp_path, "newer")
    newer, older = (await viewer.get("/api/timings")).json()
    assert (newer["name"], older["name"]) == ("newer", "older")
    assert newer["start_ns"] == START_NS
    assert newer["processes"] == ["camera-cam0", "tracker"]
    assert (newer["lab"], newer["machine"], newer["version"]) == ("gulliver", "nuc", "0.1.0")


async def test_a_run_has_boxes_and_graphs(viewer: httpx.AsyncClient, tmp_path: Path) -> None:
    write_run(tmp_path, "r1")
    run = (await viewer.get("/api/timings/r1")).json()
    stages = {(stage["kind"], stage["stage"]): stage for stage in run["stages"]}
    assert list(stages) == [("camera", "full"), ("camera", "total"), ("tracker", "full"), ("tracker", "total")]
    total = stages["camera", "total"]["box"]
    assert total["count"] == 100
    assert total["median"] == pytest.approx(1.505, abs=0.01)
    assert total["high"] == 2.0
    assert (total["outliers"], total["outlier_values"]) == (1, [500.0])
    series = stages["camera", "total"]["series"]
    assert series["seconds"][0] == pytest.approx(0.0, abs=0.5)
    assert series["seconds"][-1] == pytest.approx(99.0, abs=0.5)
    assert max(series["highest"]) == 500.0
    assert stages["camera", "full"]["box"]["count"] == 1


async def test_the_last_seconds_alone(viewer: httpx.AsyncClient, tmp_path: Path) -> None:
    write_run(tmp_path, "r1")
    run = (await viewer.get("/api/timings/r1", params={"last_s": 10.5})).json()
    counts = {(stage["kind"], stage["stage"]): stage["box"]["count"] for stage in run["stages"]}
    assert counts == {("camera", "total"): 11, ("tracker", "total"): 11}
    newest = (await viewer.get("/api/timings/r1", params={"last_s": 0.1})).json()
    assert [stage["box"]["median"] for stage in newest["stages"]] == [500.0, 500.0]


async def test_what_is_not_there_is_said(viewer: httpx.AsyncClient, tmp_path: Path) -> None:
    answer = await viewer.get("/api/timings/yesterday")
    assert answer.status_code == 404
    assert answer.json() == {"detail": "there are no stage timings of a run 'yesterday' on this server's machine"}
    (tmp_path / "timings" / "broken").mkdir(parents=True)
    (tmp_path / "timings" / "broken" / "a.000001.timings").write_bytes(b"nothing")
    assert (await viewer.get("/api/timings/broken")).status_code == 404
    assert (await viewer.get("/api/timings")).json() == []
    for path in (
        "/api/timings/..%2Fsecret",
        "/api/timings/-x",
        "/api/timings/r1?last_s=0",
        "/api/timings/r1?last_s=nan",
    ):
        assert (await viewer.get(path)).status_code in (404, 422), path


async def test_timings_need_a_login(redis_server: RedisServer) -> None:
    async with in_process(redis_server.url) as service:
        assert (await service.http().get("/api/timings")).status_code == 401
        assert (await service.http("robot").get("/api/timings")).status_code == 403
