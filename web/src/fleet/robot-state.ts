/** What a robot is doing, in one word and one colour, and how old what is known of it is. */
import type { ReasonCode, RobotState, RobotView } from "../api/types";

export type Tone = "driving" | "waiting" | "manual" | "idle" | "fault" | "offline";

const WORDS: Readonly<Record<RobotState, readonly [Tone, string]>> = {
  driving: ["driving", "Driving"],
  waiting: ["waiting", "Waiting"],
  paused: ["waiting", "Paused"],
  manual: ["manual", "By hand"],
  idle: ["idle", "Idle"],
  lost: ["fault", "Not seen"],
  emergency_stop: ["fault", "Stopped"],
  fault: ["fault", "Fault"],
  offline: ["offline", "Offline"],
};

/** What a reason means when it comes without a sentence of its own. */
const SENTENCES: Readonly<Record<ReasonCode, string>> = {
  route: "on its route",
  detour: "drives around something",
  yielding: "lets another robot pass",
  at_stop: "stays at a stop of its route",
  route_done: "its route is done",
  manual: "driven by hand",
  idle: "no route assigned",
  paused: "paused by a person",
  obstacle: "something is in its obstacle box",
  robot_ahead: "another robot is in its obstacle box",
  emergency_stop: "the emergency stop is engaged",
  pose_stale: "no camera sees it",
  command_stale: "it hears no fresh commands",
  obstacles_unknown: "the obstacle map is missing",
  outside_area: "it is outside every area",
  waypoint_missing: "its route cannot be driven",
  not_connected: "its agent is not connected",
  driver_fault: "its driver reports a fault",
  protective_field: "its scanner sees something in its protective field",
  battery_empty: "its battery is empty",
};

export interface RobotSummary {
  readonly tone: Tone;
  readonly word: string;
  /** What it waits for or why it stands; empty while it drives. */
  readonly why: string;
}

export function summarize(robot: RobotView): RobotSummary {
  const [tone, word] = WORDS[robot.state];
  const { reason } = robot;
  if (!reason) return { tone, word, why: "" };
  return { tone, word, why: reason.text || SENTENCES[reason.code] };
}

/** Thresholds of a pose's age: ok below 100 ms, warn below 500 ms, beyond it the robot must stop. */
export type Freshness = "ok" | "warn" | "stop";

export function freshness(ageMs: number): Freshness {
  if (ageMs < 100) return "ok";
  return ageMs < 500 ? "warn" : "stop";
}

/** Age of the last pose in ms on the server's clock; null when no camera has ever seen it. */
export function poseAgeMs(robot: RobotView, nowMs: number): number | null {
  return robot.pose ? Math.max(0, nowMs - robot.pose.stamp_ns / 1e6) : null;
}

/** Whether a route has been assigned and is not over. */
export function isAssigned(robot: RobotView): boolean {
  return robot.assignment?.state === "running" || robot.assignment?.state === "paused";
}

/** Whether a route may be started on the robot: it has none, or one of the tours of the lab's first start, which give way. */
export function isFree(robot: RobotView): boolean {
  return !isAssigned(robot) || robot.assignment?.started_by === "first start";
}
