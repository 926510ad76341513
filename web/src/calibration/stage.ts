/** Where a calibration stands, and how its figures read. Pure. */
import type { CalibrationView, CameraComparison, FloorTagComparison } from "../api/types";
import { degrees } from "../ui/format";

export type Stage = "look" | "collect" | "compare";

/** A run without news for so long has lost the calibrator; the server lets another take its place then. */
const GIVEN_UP_MS = 60_000;

/** What the page is about now. */
export function stageOf(view: CalibrationView): Stage {
  const { run, proposal } = view;
  const isBusy = run?.state === "collecting" || run?.state === "refining";
  if (run && isBusy && view.stamp_ns - run.stamp_ns < GIVEN_UP_MS * 1e6) return "collect";
  return proposal ? "compare" : "look";
}

/** What the newest run has left to say: why it failed, or why its proposal is gone. Null when there is nothing. */
export function leftOver(view: CalibrationView): { readonly title: string; readonly text: string } | null {
  const { run } = view;
  if (!run || stageOf(view) !== "look") return null;
  if (run.state === "failed") return { title: "The last calibration gave nothing", text: run.text };
  if (run.state === "discarded" && run.text !== "") return { title: "The proposal is out of date", text: run.text };
  if (run.state === "collecting" || run.state === "refining")
    return { title: "The last calibration was never finished", text: "Is the process calibrator running?" };
  return null;
}

export function formatMm(metres: number | null): string {
  if (metres === null) return "–";
  const mm = metres * 1000;
  return `${mm.toFixed(mm < 10 ? 1 : 0)} mm`;
}

export function formatPx(px: number | null): string {
  return px === null ? "–" : `${px.toFixed(2)} px`;
}

export function formatTurn(radians: number | null): string {
  return radians === null ? "–" : `${degrees(radians).toFixed(2)}°`;
}

export type Verdict = "first" | "better" | "same" | "worse";

/** How well the proposal explains what the camera sees, against what is in force. */
export function verdictOf({ reprojection_before_px: before, reprojection_after_px: after }: CameraComparison): Verdict {
  if (before === null) return "first";
  if (after > before + 0.1) return "worse";
  return after < 0.8 * before - 0.02 ? "better" : "same";
}

/** The share (0..100) of the asked cameras that have answered; computing counts as all. */
export function progressOf({ run }: CalibrationView): number {
  if (!run) return 0;
  if (run.state === "refining") return 100;
  return (100 * run.answered.length) / Math.max(1, run.cameras.length);
}

/** Floor tags by how far they would be moved, the farthest first. */
export function byShift(tags: Readonly<Record<string, FloorTagComparison>>): [string, FloorTagComparison][] {
  return Object.entries(tags).sort(([a, x], [b, y]) => y.shift_m - x.shift_m || Number(a) - Number(b));
}

/** A sentence on what the floor tags that a camera sees are worth. */
export function describeTags(seen: readonly number[]): { readonly text: string; readonly isEnough: boolean } {
  if (seen.length === 0) return { text: "Sees no floor tag", isEnough: false };
  const list = `Sees floor tag${seen.length > 1 ? "s" : ""} ${seen.join(", ")}`;
  return seen.length < 2 ? { text: `${list}; needs at least two`, isEnough: false } : { text: list, isEnough: true };
}
