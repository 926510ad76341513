"""`python -m agents` as a process: what it needs, and how it ends."""

import asyncio
import os
import signal
import sys
from pathlib import Path

from agents.motion import STOP
from geometry import SE2
from protocol.messages import Outcome
from tests.agents.fake_base import FakeBase
from tests.agents.fake_server import FakeServer
from tests.agents.orders import Orders
from tests.agents.plant import tracked
from tests.agents.waiting import until

ROBOT = "wifibot-14"
ROOT = Path(__file__).parents[2]


async def test_drives_without_redis_and_stops_the_base_when_it_is_told_to_end(tmp_path: Path) -> None:
    server, base, orders = (
        FakeServer(ROBOT, token="secret-of-the-robot"),
        FakeBase(ROBOT, SE2(1.0, 1.0, 0.0)),
        Orders(ROBOT),
    )
    await base.start()
    await server.start()
    lab = tmp_path / "lab.yaml"
    lab.write_text((ROOT / "labs/gulliver.yaml").read_text().replace("lab_udp: 2030", f"lab_udp: {base.port}"))
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "agents", ROBOT, "--server", server.url,
        cwd=ROOT,
        env={"PATH": os.environ["PATH"], "PYTHONPATH": str(ROOT), "LILLIPUT_LAB": str(lab),
             "LILLIPUT_TOKEN": "secret-of-the-robot"},
        stderr=asyncio.subprocess.PIPE,
    )  # fmt: skip
    try:
        await until(lambda: server.registrations and server.streams, "registration and stream", 20.0)

        def drives() -> bool:
            now_ns = server.clock.now_ns()
            server.send_pose(tracked(ROBOT, base.plant.pose, now_ns))
            server.send(orders.move_to(now_ns, 6.0, 1.0, speed=0.5))
            return base.plant.twist.linear_mps > 0.3

        await until(drives, "the robot drives")
        process.send_signal(signal.SIGTERM)
        _, log = await asyncio.wait_for(process.communicate(), 5.0)
        assert process.returncode == 0
        assert base.setpoints[-1][1] == STOP
        assert Outcome.ACCEPTED in [response.outcome for response in server.responses]
        assert b"secret-of-the-robot" not in log, "secrets stay out of the log"
        assert b"Traceback" not in log
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
        await server.stop()
        await base.stop()
