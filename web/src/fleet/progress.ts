/** How far a robot has come on its route. */
import type { Assignment, Route } from "../api/types";

export interface Progress {
  readonly text: string;
  readonly percent: number;
}

const ENDED: Readonly<Record<Assignment["state"], string>> = {
  running: "",
  paused: "",
  done: "done",
  stopped: "stopped",
  failed: "failed",
};

export function describeProgress(assignment: Assignment, route: Route | undefined): Progress {
  const ended = ENDED[assignment.state];
  if (ended) {
    const why = assignment.reason ? `: ${assignment.reason}` : "";
    return { text: `${assignment.route} ${ended}${why}`, percent: assignment.state === "done" ? 100 : 0 };
  }
  const count = route?.legs.length ?? 0;
  if (count === 0) return { text: assignment.route, percent: 0 };
  const to = route?.legs[assignment.leg]?.waypoint;
  const laps = route?.loop === true ? `, lap ${assignment.laps + 1}` : "";
  return {
    text: `${assignment.route}: leg ${assignment.leg + 1} of ${count}${to ? ` to ${to}` : ""}${laps}`,
    percent: (100 * assignment.leg) / count,
  };
}
