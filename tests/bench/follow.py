"""Frame to message: how long each method needs for a frame while it follows vehicles, one frame after the other.

The methods take turns in blocks (A B C D A B C D ...), and figures are medians over the blocks: when the machine is busy for a
while, it is for all.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from protocol.codec import decode
from protocol.frames import Frame
from protocol.lab import Lab
from protocol.messages import FrameDetections, TrackedPose
from tests.bench.methods import Fusion, Method
from tests.bench.scene import Recording, decoded

THREADS = 2
"""The published detector and remap may use both cores; ours uses one."""
WARM_UP_FRAMES = 60
"""Of each camera, for ours: it calibrates itself and finds the vehicles. The baselines are calibrated apart, and see a whole
search first."""
BASELINE_WARM_UP_FRAMES = 2
P99_FRAMES = 100
"""With fewer frames in a block the 99th percentile is but the slowest."""
START_NS = 1_700_000_000_000_000_000
POSES_EVERY = 2
"""A camera reads the tracks at 30 Hz (`localization.pose_feed`), so every second frame."""


@dataclass(slots=True)
class Block:
    """Times of the frames that show at least one whole vehicle tag (ms), and what became of the tags."""

    process_ms: list[float] = field(default_factory=list[float])
    decode_ms: list[float] = field(default_factory=list[float])
    visible: int = 0
    found: int = 0
    errors_m: list[float] = field(default_factory=list[float])


class Run:
    """One method on its way through the film."""

    def __init__(self, method: Method, lab: Lab, recordings: Sequence[Recording]) -> None:
        self.method = method
        self._recordings = recordings
        self._fusion = Fusion(lab) if method.fuses else None
        self._threads = 1 if method.fuses else THREADS
        self._cameras = [method.camera(lab, recording.camera, self._threads) for recording in recordings]
        self._told: list[Mapping[str, TrackedPose]] = [{} for _ in recordings]
        self._number = 0
        for camera, recording in zip(self._cameras, recordings, strict=True):
            camera.prepare(Frame(0, START_NS, decoded(recording.floor)))
        self.play(WARM_UP_FRAMES if method.fuses else BASELINE_WARM_UP_FRAMES)

    def play(self, frames: int) -> Block:
        """The next frames of every camera."""
        cv2.setNumThreads(self._threads)
        block = Block()
        for _ in range(frames):
            for index in range(len(self._recordings)):
                self._look(index, block)
            self._number += 1
        return block

    def _look(self, index: int, block: Block) -> None:
        recording, camera = self._recordings[index], self._cameras[index]
        if self._fusion is not None and self._number % POSES_EVERY == 0:
            self._told[index] = dict(self._fusion.poses)
        recorded = recording.frames[self._number % len(recording.frames)]
        started_s = time.perf_counter()
        pixels = decoded(recorded.jpeg)
        decoded_s = time.perf_counter()
        frame = Frame(self._number + 1, recording.stamp_ns(self._number, START_NS), pixels)
        message = camera.process(frame, self._told[index])
        if self._fusion is not None:
            self._fusion.fuse(message)
        ended_s = time.perf_counter()
        if not recorded.truth:
            return
        block.decode_ms.append((decoded_s - started_s) * 1e3)
        block.process_ms.append((ended_s - decoded_s) * 1e3)
        found = {tag.tag_id: tag for tag in decode(FrameDetections, message).detections}
        block.visible += len(recorded.truth)
        for tag_id, (x, y, _) in recorded.truth.items():
            if tag_id in found:
                block.found += 1
                block.errors_m.append(float(np.hypot(found[tag_id].x - x, found[tag_id].y - y)))


def follow(runs: Sequence[Run], frames: Mapping[str, int], blocks: int) -> dict[str, list[Block]]:
    """Every method's blocks by its name; `frames` are those of each camera in one block."""
    played: dict[str, list[Block]] = {run.method.name: [] for run in runs}
    for _ in range(blocks):
        for run in runs:
            played[run.method.name].append(run.play(frames[run.method.name]))
    return played


def figures(blocks: Sequence[Block]) -> dict[str, float]:
    """Medians over the blocks of each block's median and, with frames enough to have one, 99th percentile; ValueError when no
    frame showed a vehicle."""
    if not any(block.process_ms for block in blocks):
        raise ValueError("no frame shows a whole vehicle tag")
    process = [np.array(block.process_ms) for block in blocks]
    whole = [np.array(block.process_ms) + np.array(block.decode_ms) for block in blocks]
    errors_m = [error for block in blocks for error in block.errors_m]
    result = {
        "median_ms": float(np.median([np.median(each) for each in process])),
        "with_decode_median_ms": float(np.median([np.median(each) for each in whole])),
        "found_share": sum(block.found for block in blocks) / sum(block.visible for block in blocks),
    }
    if min(each.size for each in process) >= P99_FRAMES:
        result["p99_ms"] = float(np.median([np.percentile(each, 99) for each in process]))
        result["with_decode_p99_ms"] = float(np.median([np.percentile(each, 99) for each in whole]))
    if errors_m:
        result["position_error_median_mm"] = float(np.median(errors_m)) * 1e3
    return result
