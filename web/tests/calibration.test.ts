import { describe, expect, it } from "vitest";
import type { CalibrationRun, CalibrationView, CameraComparison } from "../src/api/types";
import {
  byShift,
  describeTags,
  formatMm,
  formatPx,
  formatTurn,
  leftOver,
  progressOf,
  stageOf,
  verdictOf,
} from "../src/calibration/stage";

const S = 1e9;
const NOW = 1_700_000_000 * S;

function run(state: CalibrationRun["state"], changes: Partial<CalibrationRun> = {}): CalibrationRun {
  const cameras = ["cam0", "cam1"];
  return {
    id: 7,
    state,
    stamp_ns: NOW - S,
    started_ns: NOW - S,
    by: "olga",
    cameras,
    answered: [],
    text: "",
    ...changes,
  };
}

function view(changes: Partial<CalibrationView> = {}): CalibrationView {
  return { stamp_ns: NOW, run: null, current: null, previous: null, proposal: null, ...changes };
}

const proposal = {} as CalibrationView["proposal"];

describe("the stage of a calibration", () => {
  it("goes from looking over collecting to comparing and back", () => {
    expect(stageOf(view())).toBe("look");
    expect(stageOf(view({ run: run("collecting") }))).toBe("collect");
    expect(stageOf(view({ run: run("refining") }))).toBe("collect");
    expect(stageOf(view({ run: run("proposed"), proposal }))).toBe("compare");
    expect(stageOf(view({ run: run("accepted") }))).toBe("look");
  });

  it("does not wait for ever for a run whose calibrator died", () => {
    const dead = view({ run: run("collecting", { stamp_ns: NOW - 61 * S }) });
    expect(stageOf(dead)).toBe("look");
    expect(leftOver(dead)?.text).toContain("calibrator");
  });

  it("says why the last one failed or is gone, and nothing after a decision of a person", () => {
    expect(leftOver(view({ run: run("failed", { text: "cam0 did not answer" }) }))?.text).toBe("cam0 did not answer");
    expect(leftOver(view({ run: run("discarded", { text: "cam1 moved" }) }))?.title).toContain("out of date");
    expect(leftOver(view({ run: run("discarded") }))).toBeNull();
    expect(leftOver(view({ run: run("accepted", { text: "cam1 did not answer" }) }))).toBeNull();
    expect(leftOver(view({ run: run("collecting") }))).toBeNull();
    expect(leftOver(view())).toBeNull();
  });

  it("counts the cameras that have answered", () => {
    expect(progressOf(view())).toBe(0);
    expect(progressOf(view({ run: run("collecting", { answered: ["cam1"] }) }))).toBe(50);
    expect(progressOf(view({ run: run("refining", { answered: ["cam1"] }) }))).toBe(100);
  });
});

describe("the figures of a comparison", () => {
  const comparison = (before: number | null, after: number) =>
    ({ reprojection_before_px: before, reprojection_after_px: after }) as CameraComparison;

  it("are millimetres, pixels and degrees", () => {
    expect([0.00123, 0.0123, 0, null].map(formatMm)).toEqual(["1.2 mm", "12 mm", "0.0 mm", "–"]);
    expect([0.123, null].map(formatPx)).toEqual(["0.12 px", "–"]);
    expect([Math.PI / 180, null].map(formatTurn)).toEqual(["1.00°", "–"]);
  });

  it("are judged by what is in force; noise is no change", () => {
    expect(verdictOf(comparison(null, 0.2))).toBe("first");
    expect(verdictOf(comparison(2.0, 0.2))).toBe("better");
    expect(verdictOf(comparison(0.2, 0.19))).toBe("same");
    expect(verdictOf(comparison(0.02, 0.01))).toBe("same");
    expect(verdictOf(comparison(0.2, 0.4))).toBe("worse");
  });

  it("begin with the floor tag that is moved the farthest", () => {
    const tag = (shift_m: number) => ({ shift_m, cameras: [] });
    expect(byShift({ 10: tag(0), 2: tag(0), 3: tag(0.01) }).map(([id]) => id)).toEqual(["3", "2", "10"]);
  });

  it("say whether a camera sees enough", () => {
    expect(describeTags([])).toEqual({ text: "Sees no floor tag", isEnough: false });
    expect(describeTags([3])).toEqual({ text: "Sees floor tag 3; needs at least two", isEnough: false });
    expect(describeTags([3, 4])).toEqual({ text: "Sees floor tags 3, 4", isEnough: true });
  });
});
