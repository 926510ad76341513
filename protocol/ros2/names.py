"""What things are called: ROS 2's topics on DDS, namespaces and pose topics of our vehicles, the DDS domain."""

from collections.abc import Mapping

from protocol.lab import VehicleSpec

_HIGHEST_DOMAIN = 232


def topic(*parts: str) -> str:
    """The DDS topic of a ROS 2 topic: `rt/` before the name without its first slash."""
    return "/".join(("rt", *parts))


def namespace_of(vehicle: VehicleSpec) -> str:
    """The namespace of a vehicle's own topics, which the lab description makes sure that no other ROS 2 base has."""
    return vehicle.ros2_namespace


def pose_topic(vehicle: VehicleSpec) -> str:
    """The DDS topic of a vehicle's tracked pose, /robot_N/pose: N is the number on its roof, its tag's id, which the lab
    description makes sure that no other vehicle has."""
    return topic(f"robot_{vehicle.tag.id}", "pose")


def domain_id(given: int | None, environment: Mapping[str, str]) -> int:
    """The DDS domain: as given, else ROS_DOMAIN_ID, else 0. ValueError when that variable is no domain."""
    if given is not None:
        return given
    text = environment.get("ROS_DOMAIN_ID") or "0"
    if not (text.isascii() and text.isdigit() and int(text) <= _HIGHEST_DOMAIN):
        raise ValueError(f"ROS_DOMAIN_ID must be a number from 0 to {_HIGHEST_DOMAIN}, not {text!r}")
    return int(text)
