import { describe, expect, it } from "vitest";
import type { BoxView, RunTimingsView } from "../src/api/types";
import { boxOption, graphOption } from "../src/logs/charts";
import { changePercent, compare, formatChange, formatMs } from "../src/logs/comparison";

function box(median: number): BoxView {
  return {
    count: 100,
    low: median / 2,
    q1: median * 0.8,
    median,
    q3: median * 1.2,
    high: median * 1.5,
    mean: median,
    p99: median * 3,
    outliers: 2,
    outlier_values: [median * 2, median * 4],
  };
}

function run(name: string, medians: Readonly<Record<string, number>>): RunTimingsView {
  return {
    name,
    start_ns: 1,
    processes: ["camera-cam0"],
    stages: Object.entries(medians).map(([stage, median]) => ({
      kind: "camera",
      stage,
      box: box(median),
      series: { seconds: [0, 1], median: [median, median], highest: [median, 2 * median] },
    })),
  };
}

const before = run("before", { wait: 4, total: 102 });
const after = run("after", { wait: 4, window: 1, total: 14 });

describe("the comparison of runs", () => {
  it("puts the same stage of all runs side by side", () => {
    const compared = compare([before, after]);
    expect(compared.map(({ stage }) => stage)).toEqual(["wait", "total", "window"]);
    expect(compared[1]?.runs.map((each) => each.box?.median)).toEqual([102, 14]);
    expect(compared[2]?.runs.map((each) => each.box?.median)).toEqual([undefined, 1]);
    expect(compare([])).toEqual([]);
  });

  it("gives the change against the first run", () => {
    const [wait, total, window] = compare([before, after]);
    if (!wait || !total || !window) throw new Error("three stages");
    expect(changePercent(total, 1, "median")).toBeCloseTo(-86.27, 2);
    expect(changePercent(total, 0, "median")).toBeNull();
    expect(changePercent(wait, 1, "q3")).toBe(0);
    expect(changePercent(window, 1, "median")).toBeNull();
  });

  it("says nothing of a change from zero", () => {
    const [total] = compare(
      [run("a", { total: 0 }), after].map((each) => ({ ...each, stages: each.stages.slice(-1) })),
    );
    if (!total) throw new Error("one stage");
    expect(changePercent(total, 1, "median")).toBeNull();
  });
});

describe("numbers", () => {
  it("have three digits that count", () => {
    expect([0.0421, 1.204, 14.04, 102.4].map(formatMs)).toEqual(["0.042", "1.20", "14.0", "102"]);
    expect([-86.27, 4, 0].map(formatChange)).toEqual(["-86.3 %", "+4.0 %", "0.0 %"]);
  });
});

describe("the pictures", () => {
  const [, total, window] = compare([before, after]);
  if (!total || !window) throw new Error("three stages");

  it("have a box of five numbers per run, and its outliers above it", () => {
    const [boxes, points] = boxOption(total, ["a", "b"])["series"] as { data: { value: number[] }[] }[];
    const [first, second] = boxes?.data ?? [];
    expect(first?.value).toEqual([51, 102 * 0.8, 102, 102 * 1.2, 153]);
    expect(second?.value[2]).toBe(14);
    expect(points?.data.map(({ value }) => value)).toEqual([
      [0, 204],
      [0, 408],
      [1, 28],
      [1, 56],
    ]);
  });

  it("leave outliers out when asked", () => {
    const [, points] = boxOption(total, ["a", "b"], false)["series"] as { data: unknown[] }[];
    expect(points?.data).toEqual([]);
  });

  it("leave the place of a run without the stage empty", () => {
    const [boxes] = boxOption(window, ["a", "b"])["series"] as { data: { value: number[] }[] }[];
    expect(boxes?.data.map(({ value }) => value.length)).toEqual([0, 5]);
    expect((graphOption(window, ["a", "b"])["series"] as unknown[]).length).toBe(2);
  });

  it("draw the median and the highest value over the time", () => {
    const lines = graphOption(total, ["a", "b"])["series"] as { name: string; data: number[][] }[];
    expect(lines.map(({ name }) => name)).toEqual(["a highest", "a median", "b highest", "b median"]);
    expect(lines[2]?.data).toEqual([
      [0, 14],
      [1, 28],
    ]);
  });
});
