"""ROS 2 over DDS without a ROS installation: its names, types and qualities of service, on the `cyclonedds` package.

`names` needs nothing; everything else imports `cyclonedds`, which exists for 64-bit Intel Linux and for macOS only, so who uses
it does so late: `require_dds` says in a sentence when it is missing.
"""

from importlib.util import find_spec

from protocol.ros2.names import domain_id, namespace_of, pose_topic, topic

__all__ = ["DdsMissingError", "domain_id", "namespace_of", "pose_topic", "require_dds", "topic"]


class DdsMissingError(Exception):
    """This machine has no `cyclonedds`."""


def require_dds() -> None:
    """DdsMissingError, with what to do, where ROS 2 cannot be spoken."""
    if find_spec("cyclonedds") is None:
        raise DdsMissingError(
            "ROS 2 needs the package cyclonedds, of which there is none for this machine or Python (64-bit Intel Linux or macOS, "
            "Python 3.11 to 3.13); run this process on one that has it"
        )
