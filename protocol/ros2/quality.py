"""ROS 2's qualities of service (rmw_qos_profile_default and rmw_qos_profile_sensor_data), with ROS 2's plain CDR."""

from cyclonedds.core import Policy, Qos
from cyclonedds.util import duration

_PLAIN_CDR = Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False)

DEFAULT = Qos(
    Policy.Reliability.Reliable(duration(seconds=0)),
    Policy.Durability.Volatile,
    Policy.History.KeepLast(10),
    _PLAIN_CDR,
)
"""Reliable, volatile, the last ten. A writer does not wait for slow readers: what it cannot send at once, it drops."""

SENSOR_DATA = Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, Policy.History.KeepLast(5), _PLAIN_CDR)
"""Best effort, the last five. A reader of this quality hears reliable writers too."""
