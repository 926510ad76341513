import { describe, expect, it } from "vitest";
import type { Assignment, RobotView, Route } from "../src/api/types";
import { describeProgress } from "../src/fleet/progress";
import { freshness, isAssigned, poseAgeMs, summarize } from "../src/fleet/robot-state";
import { deflectionAt } from "../src/fleet/Stick";
import { plainLeg } from "../src/routes/leg";

const robot = (parts: Partial<RobotView>) => ({ id: "r", reason: null, pose: null, ...parts }) as RobotView;

describe("a robot's state", () => {
  it("says what it waits for in guidance's words", () => {
    const reason = { code: "obstacle", text: "0.42 m ahead" } as const;
    expect(summarize(robot({ state: "waiting", reason }))).toEqual({
      tone: "waiting",
      word: "Waiting",
      why: "0.42 m ahead",
    });
  });

  it("has words of its own for a bare reason", () => {
    expect(summarize(robot({ state: "lost", reason: { code: "pose_stale", text: "" } })).why).toBe("no camera sees it");
  });

  it("needs no reason to drive", () => {
    expect(summarize(robot({ state: "driving" })).why).toBe("");
  });

  it("ages on the server's clock, never below zero", () => {
    const seen = robot({ pose: { stamp_ns: 1000e6 } as RobotView["pose"] });
    expect(poseAgeMs(seen, 1080)).toBe(80);
    expect(poseAgeMs(seen, 900)).toBe(0);
    expect(poseAgeMs(robot({}), 900)).toBeNull();
  });

  it("warns of ages from 100 ms and stops from 500 ms", () => {
    expect([99, 100, 499, 500].map(freshness)).toEqual(["ok", "warn", "warn", "stop"]);
  });
});

describe("progress on a route", () => {
  const route: Route = {
    id: "round",
    loop: true,
    legs: ["a", "b", "c", "d"].map((waypoint) => plainLeg(waypoint, 0.3)),
  };
  const assignment = (parts: Partial<Assignment>) =>
    ({ route: "round", state: "running", leg: 1, laps: 2, reason: "", ...parts }) as Assignment;

  it("counts legs and laps from one", () => {
    expect(describeProgress(assignment({}), route)).toEqual({ text: "round: leg 2 of 4 to b, lap 3", percent: 25 });
  });

  it("survives a deleted route", () => {
    expect(describeProgress(assignment({}), undefined)).toEqual({ text: "round", percent: 0 });
  });

  it("tells how it ended and why", () => {
    const failed = assignment({ state: "failed", reason: "waypoint b is gone" });
    expect(describeProgress(failed, route).text).toBe("round failed: waypoint b is gone");
    expect(isAssigned(robot({ assignment: failed }))).toBe(false);
    expect(isAssigned(robot({ assignment: assignment({ state: "paused" }) }))).toBe(true);
  });
});

describe("the stick", () => {
  it("points forward when it is pushed up, left when it is pushed left", () => {
    expect(deflectionAt(0, -0.5)).toEqual({ forward: 0.5, left: -0 });
    expect(deflectionAt(-0.5, 0)).toEqual({ forward: -0, left: 0.5 });
  });

  it("goes no farther than its rim and rests near its middle", () => {
    const { forward, left } = deflectionAt(3, -4);
    expect(Math.hypot(forward, left)).toBeCloseTo(1);
    expect(deflectionAt(0.05, 0.05)).toEqual({ forward: 0, left: 0 });
  });
});
