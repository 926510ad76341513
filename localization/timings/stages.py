"""The stages whose times are kept, and how those of a frame come together (GulliView 2025, sec. 3.1.4)."""

from collections.abc import Mapping

from protocol.messages import FrameDetections

CAMERA_STAGES = ("decode", "wait", "window", "full", "undistort", "pose", "send", "total")
"""decode: from what the camera sent to pixels. wait: from the capture to the start of the work. window, full: the two searches.
undistort, pose: from corners to poses. send: the message to Redis. total: from the capture to the message being ready, which
is the reports' delay."""
TRACKER_STAGES = ("wait", "track", "send", "publish", "total")
"""wait: from the capture until the tracker has the detections. track: the filters. send: all datagrams. publish: the poses to
Redis. total: from the capture until the datagrams have left."""


def camera_stages(detections: FrameDetections, decode_ms: float, send_ms: float) -> Mapping[str, float]:
    """Milliseconds by stage; what took exactly no time did not happen, and is left out."""
    stages = {"decode": decode_ms, **detections.timings_ms, "send": send_ms}
    stages["total"] = (detections.sent_ns - detections.stamp_ns) * 1e-6
    return {stage: ms for stage, ms in stages.items() if ms != 0.0}
