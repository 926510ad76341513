"""The programs of docs/examples leave no base rolling when the network, the server or the program itself fails."""

import importlib.util
import sys
import threading
from pathlib import Path
from types import ModuleType
from typing import Any

import httpx
import pytest
import redis

EXAMPLES = Path(__file__).parents[2] / "docs/examples"


def example(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(EXAMPLES)
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Base:
    """Holds a twist, and breaks when it is driven for the third time."""

    def __init__(self) -> None:
        self.driven: list[tuple[float, float]] = []

    @property
    def twist(self) -> tuple[float, float]:
        return self.driven[-1] if self.driven else (0.0, 0.0)

    def drive(self, linear: float, angular: float) -> None:
        self.driven.append((linear, angular))
        if len(self.driven) == 3:
            raise RuntimeError("broken")


def test_without_a_network_the_udp_robot_drives_on_by_what_comes_in_and_in_the_end_stands(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    module = example("udp_robot", monkeypatch)
    made: list[Any] = []
    unreachable = "127.0.0.1", 0

    class Robot(module.Robot):  # type: ignore[misc,name-defined]
        def __init__(self, *arguments: Any) -> None:
            super().__init__(*arguments)
            self.server = unreachable
            made.append(self)

        def register(self) -> None:
            threading.Event().wait()

        follow = register

        def decide(self, base: Base) -> tuple[float, float]:
            return 0.3, 0.0

    monkeypatch.setattr(module, "Robot", Robot)
    monkeypatch.setattr(sys, "argv", ["udp_robot.py", "my-robot"])
    for name, text in (("SERVER", "http://127.0.0.1:9"), ("TOKEN", "x"), ("UDP_KEY", "00" * 32)):
        monkeypatch.setenv(f"LILLIPUT_{name}", text)
    base = Base()
    with pytest.raises(RuntimeError, match="broken"):
        module.main(base)
    made[0].udp.close()
    assert base.driven == [(0.3, 0.0)] * 3 + [(0.0, 0.0)]


@pytest.mark.parametrize("status", [401, 403, 503])
def test_a_refused_stream_is_an_error_and_no_silence(monkeypatch: pytest.MonkeyPatch, status: int) -> None:
    module = example("udp_robot", monkeypatch)
    transport = httpx.MockTransport(lambda _: httpx.Response(status, json={"detail": "no"}))
    with httpx.Client(transport=transport, base_url="http://server/api") as api:
        robot = module.Robot("my-robot", api, b"k" * 32)
        try:
            for work in (robot.follow, robot.register):
                with pytest.raises(httpx.HTTPStatusError):
                    work()
        finally:
            robot.udp.close()


def test_a_stream_that_ended_is_opened_again_after_a_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    module = example("udp_robot", monkeypatch)
    paused: list[float] = []
    works = iter((None, httpx.ConnectError("away"), OSError("no network"), KeyboardInterrupt()))

    def work() -> None:
        error = next(works)
        if error is not None:
            raise error

    monkeypatch.setattr(module.time, "sleep", paused.append)
    with pytest.raises(KeyboardInterrupt):
        module.for_ever(work)
    assert paused == [0.5] * 3


def test_the_gpss_robot_stands_when_its_program_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    module = example("gpss_robot", monkeypatch)
    steps = iter((redis.ConnectionError("away"), ValueError("no JSON")))

    def step(robot: Any) -> None:
        robot.base.drive(0.3, 0.0)
        raise next(steps)

    monkeypatch.setattr(module.Robot, "step", step)
    monkeypatch.setattr(sys, "argv", ["gpss_robot.py", "my-agv"])
    monkeypatch.setenv("GPSS_REDIS", "redis://127.0.0.1:9")
    base = module.Base()
    driven: list[tuple[float, float]] = []

    def drive(linear: float, angular: float) -> None:
        driven.append((linear, angular))

    monkeypatch.setattr(base, "drive", drive)
    with pytest.raises(ValueError, match="no JSON"):
        module.main(base)
    assert driven == [(0.3, 0.0), (0.0, 0.0), (0.3, 0.0), (0.0, 0.0)]
