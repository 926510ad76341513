/**
 * The robots as the map draws them: smooth motion, colour and label, boxes and carrots. Tells whether anything that can be
 * seen has changed, so that a still floor is not drawn again twenty times a second.
 */
import type { LiveState, RobotView } from "../api/types";
import { freshness, poseAgeMs, summarize } from "../fleet/robot-state";
import { Motion } from "../geometry/motion";
import { contains, polygonToMap, type Point, type Pose } from "../geometry/points";
import { formatDuration } from "../ui/format";
import { visibleFootprint, type RobotMark } from "./paint/robots";
import type { BoxView } from "./paint/orders";
import type { Palette } from "./palette";

/** Smaller movements than these are the noise of a standing robot's pose. */
const STILL_M = 0.002;
const STILL_RAD = 0.004;
/** A robot is called stale on the map once its pose is older than the robots' own limit, with some patience for jitter. */
const STALE_MS = 750;

interface Entry {
  readonly motion: Motion;
  pose: Pose;
  robot: RobotView;
  drawn: string;
}

export class RobotMarks {
  private readonly entries = new Map<string, Entry>();

  /** Takes the newest state; true when what is drawn changes. */
  update(robots: LiveState["robots"], serverMs: number, nowMs: number): boolean {
    let changed = false;
    for (const [id, robot] of Object.entries(robots)) {
      if (robot.pose && this.place(id, robot, robot.pose, nowMs)) changed = true;
      const entry = this.entries.get(id);
      if (!entry) continue;
      entry.robot = robot;
      const looks = appearance(robot, serverMs);
      if (looks !== entry.drawn) changed = true;
      entry.drawn = looks;
    }
    for (const id of this.entries.keys()) {
      if (robots[id]?.pose) continue;
      this.entries.delete(id);
      changed = true;
    }
    return changed;
  }

  isMoving(nowMs: number): boolean {
    return [...this.entries.values()].some(({ motion }) => motion.isMoving(nowMs));
  }

  poseOf(id: string, nowMs: number): Pose | null {
    return this.entries.get(id)?.motion.at(nowMs) ?? null;
  }

  marks(palette: Palette, selected: string | null, serverMs: number, nowMs: number): { mark: RobotMark; pose: Pose }[] {
    return [...this.entries.values()].map(({ robot, motion }) => {
      const age = poseAgeMs(robot, serverMs) ?? 0;
      const isStale = age > STALE_MS;
      const mark = {
        id: robot.id,
        footprint: robot.footprint,
        color: palette.tones[summarize(robot).tone],
        label: isStale ? `${robot.id} · seen ${formatDuration(wholeSeconds(age))} ago` : robot.id,
        isStale,
        isSelected: robot.id === selected,
      };
      return { mark, pose: motion.at(nowMs) };
    });
  }

  boxes(): BoxView[] {
    return [...this.entries.values()].flatMap(({ robot: { guidance, reason } }) => {
      if (!guidance) return [];
      const { box, blocked, blockage } = guidance;
      return {
        outline: box,
        isBlocked: blocked,
        why: reason?.text ?? "blocked",
        blockage: blockage ? [blockage.x, blockage.y] : null,
      };
    });
  }

  /** Carrot, path ahead and detour of every robot that has one. */
  orders(): { robot: string; carrot: Point | null; path: readonly Point[]; detour: readonly Point[] }[] {
    return [...this.entries.values()].flatMap(({ robot: { id, guidance } }) =>
      guidance ? { robot: id, carrot: guidance.carrot, path: guidance.path, detour: guidance.detour } : [],
    );
  }

  /** The robot under a point of the floor. */
  at(point: Point, pixelsPerMetre: number, nowMs: number): string | null {
    for (const [id, { robot, motion }] of this.entries) {
      const outline = polygonToMap(motion.at(nowMs), visibleFootprint(robot.footprint, pixelsPerMetre));
      if (contains(outline, point)) return id;
    }
    return null;
  }

  private place(id: string, robot: RobotView, pose: Pose, nowMs: number): boolean {
    const entry = this.entries.get(id);
    if (!entry) {
      this.entries.set(id, { motion: new Motion(pose, nowMs), pose, robot, drawn: "" });
      return true;
    }
    const moved = Math.hypot(pose.x - entry.pose.x, pose.y - entry.pose.y) > STILL_M;
    if (!moved && Math.abs(pose.yaw - entry.pose.yaw) < STILL_RAD) return false;
    entry.motion.push(pose, nowMs);
    entry.pose = pose;
    return true;
  }
}

/** What a robot looks like apart from where it is, as text to compare. */
function appearance(robot: RobotView, serverMs: number): string {
  const age = poseAgeMs(robot, serverMs) ?? 0;
  const { tone } = summarize(robot);
  const { guidance } = robot;
  const shape = guidance
    ? [guidance.box, guidance.carrot, guidance.path, guidance.detour].flat(2).map((value) => value?.toFixed(2))
    : [];
  const stale = age > STALE_MS ? wholeSeconds(age) : freshness(0);
  return [tone, robot.reason?.text, guidance?.blocked, stale, ...shape].join(" ");
}

function wholeSeconds(ms: number): number {
  return Math.floor(ms / 1000) * 1000;
}
