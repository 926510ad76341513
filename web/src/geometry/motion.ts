/**
 * Smooth motion between the states of the live stream. Each new pose is approached over the time that passed between the
 * last two, so a robot seen 15 times a second glides at the screen's rate, one state behind. A jump (a robot carried
 * elsewhere, a long silence) is not smoothed.
 */
import { interpolatePose, type Pose } from "./points";

const SHORTEST_MS = 30;
const LONGEST_MS = 200;
const JUMP_M = 0.5;

export class Motion {
  private from: Pose;
  private durationMs = 0;
  private arrivedMs: number;

  constructor(
    private to: Pose,
    nowMs: number,
  ) {
    this.from = to;
    this.arrivedMs = nowMs;
  }

  /** Takes a new pose that arrived now. */
  push(pose: Pose, nowMs: number): void {
    if (pose.x === this.to.x && pose.y === this.to.y && pose.yaw === this.to.yaw) return;
    const passed = nowMs - this.arrivedMs;
    const jumped = Math.hypot(pose.x - this.to.x, pose.y - this.to.y) > JUMP_M;
    this.from = jumped ? pose : this.at(nowMs);
    this.durationMs = jumped ? 0 : Math.min(LONGEST_MS, Math.max(SHORTEST_MS, passed));
    this.to = pose;
    this.arrivedMs = nowMs;
  }

  /** Where to draw it now. */
  at(nowMs: number): Pose {
    if (!this.isMoving(nowMs)) return this.to;
    return interpolatePose(this.from, this.to, (nowMs - this.arrivedMs) / this.durationMs);
  }

  /** Whether what is drawn still changes without a new pose. */
  isMoving(nowMs: number): boolean {
    return nowMs - this.arrivedMs < this.durationMs;
  }
}
