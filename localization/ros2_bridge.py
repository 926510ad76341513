"""The ROS 2 bridge process: `python -m localization.ros2_bridge`. Publishes every tracked pose as /robot_N/pose
(geometry_msgs/PoseWithCovarianceStamped, frame `map`; N is the number of the vehicle's tag), as the lab description's
`outputs.ros2` says, and reads and writes nothing else on ROS 2.

A process of its own, so that nothing of DDS holds the tracker up.
"""

import argparse
import asyncio
import logging
import os
from collections.abc import Callable, Iterable, Mapping, Sequence

from protocol.bus import Bus
from protocol.channels import POSES
from protocol.clock import Clock, SystemClock
from protocol.errors import LabFileError
from protocol.lab import Lab, load_lab
from protocol.lifetime import run_until_signal
from protocol.messages import TrackedPose
from protocol.ros2 import DdsMissingError, domain_id, pose_topic, require_dds
from protocol.settings import Settings

_REPORT_S = 60.0
_logger = logging.getLogger(__name__)


async def forward(bus: Bus, take: Callable[[Iterable[TrackedPose]], None], clock: Clock) -> None:
    """From the channel to `take`, until cancelled. What is too old to be used, as after a restart, is left out."""
    async for received in bus.subscribe(POSES):
        pose: TrackedPose = received.message
        if abs(clock.now_ns() - pose.stamp_ns) <= POSES.stale_after_s * 1e9:
            take((pose,))


async def serve(lab: Lab, settings: Settings, domain: int, clock: Clock) -> None:
    """Runs the bridge until SIGTERM or SIGINT."""
    from localization.outputs.ros2_poses import Ros2Poses  # needs cyclonedds, which not every machine has

    bus = Bus.connect(settings.redis_url, clock)
    poses = Ros2Poses(lab, domain, clock)

    async def report() -> None:
        while True:
            await clock.sleep(_REPORT_S)
            _logger.info("%d published, %d failed", poses.published, poses.failed)

    try:
        await run_until_signal(forward(bus, poses.publish, clock), report())
    finally:
        _logger.info("%d published, %d failed", poses.published, poses.failed)
        await bus.close()


def main(arguments: Sequence[str] | None = None, environment: Mapping[str, str] = os.environ) -> None:
    """Settings come from the environment (`protocol.settings`), rate and domain from the lab description."""
    parser = argparse.ArgumentParser(prog="python -m localization.ros2_bridge", description=__doc__)
    parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(message)s")
    settings = Settings.from_environment(environment)
    try:
        require_dds()
        lab = load_lab(settings.lab)
        domain = domain_id(lab.outputs.ros2.domain, environment)
    except (DdsMissingError, LabFileError, ValueError) as error:
        raise SystemExit(str(error)) from None
    topics = ", ".join(f"{vehicle.id} as /{pose_topic(vehicle).removeprefix('rt/')}" for vehicle in lab.vehicles)
    _logger.info("%s, DDS domain %d: %s", settings, domain, topics or "no vehicle")
    try:
        asyncio.run(serve(lab, settings, domain, SystemClock()))
    except OSError as error:
        raise SystemExit(str(error)) from None


if __name__ == "__main__":
    main()
