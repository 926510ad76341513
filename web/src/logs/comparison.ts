/** The same stage of several runs side by side, as the reports' tables have it: change in percent against the first run. */
import type { BoxView, RunTimingsView, SeriesView, StageView } from "../api/types";

export const QUANTITIES = ["low", "q1", "median", "q3", "high"] as const;
export type Quantity = (typeof QUANTITIES)[number];

/** What the reports' tables call them; min and max are without outliers. */
export const TITLES: Readonly<Record<Quantity, string>> = {
  low: "min",
  q1: "Q1",
  median: "median",
  q3: "Q3",
  high: "max",
};

export interface StageOfRun {
  readonly run: string;
  /** Null where the run does not have the stage. */
  readonly box: BoxView | null;
  readonly series: SeriesView | null;
}

export interface Comparison {
  readonly kind: string;
  readonly stage: string;
  readonly runs: readonly StageOfRun[];
}

const nameOf = ({ kind, stage }: StageView) => `${kind} ${stage}`;

/** Every stage that any of the runs has, in the order in which they come. */
export function compare(runs: readonly RunTimingsView[]): Comparison[] {
  const first = new Map<string, StageView>();
  for (const run of runs)
    for (const stage of run.stages) if (!first.has(nameOf(stage))) first.set(nameOf(stage), stage);
  return [...first].map(([name, { kind, stage }]) => ({
    kind,
    stage,
    runs: runs.map((run) => {
      const found = run.stages.find((each) => nameOf(each) === name);
      return { run: run.name, box: found?.box ?? null, series: found?.series ?? null };
    }),
  }));
}

/** By how much a run's quantity differs from the first run's, in percent; null where there is nothing to compare with. */
export function changePercent({ runs }: Comparison, index: number, quantity: Quantity): number | null {
  const reference = runs[0]?.box?.[quantity];
  const value = runs[index]?.box?.[quantity];
  if (index === 0 || reference === undefined || reference === 0 || value === undefined) return null;
  return (100 * (value - reference)) / reference;
}

/** Milliseconds with three digits that count: "0.042", "1.20", "14.0", "102". */
export function formatMs(ms: number): string {
  return ms >= 100 ? ms.toFixed(0) : ms >= 10 ? ms.toFixed(1) : ms >= 1 ? ms.toFixed(2) : ms.toFixed(3);
}

/** "-12.3 %", "+4.0 %". */
export function formatChange(percent: number): string {
  return `${percent > 0 ? "+" : ""}${percent.toFixed(1)} %`;
}
