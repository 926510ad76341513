"""How tracked poses leave: our datagrams to registered robots, packets of the existing systems, the bus. Each is switched and
paced by the lab description's `outputs`, and none waits for another."""

from localization.outputs.gulliview import GulliViewReceiver
from localization.outputs.pace import Pace
from localization.outputs.redis_poses import RedisPoses
from localization.outputs.robot_poses import RobotPoses
from localization.outputs.selection import Outputs, outputs_of
from localization.outputs.udp_sender import UdpSender

__all__ = ["GulliViewReceiver", "Outputs", "Pace", "RedisPoses", "RobotPoses", "UdpSender", "outputs_of"]
