/** From a comparison to what ECharts draws: box plots with outliers, and times over the run. */
import type { EChartsCoreOption } from "echarts/core";
import type { Comparison } from "./comparison";

/** A colour per run, the same in every picture. */
export const COLORS = ["#478ed2", "#e8863a", "#2fa36b", "#b26fd0", "#d9534f", "#8d95a3"] as const;
const TEXT = "#8d95a3";
const LINE = "rgba(128, 138, 155, 0.25)";

export const colorOf = (index: number) => COLORS[index % COLORS.length] ?? TEXT;

const axis = {
  axisLabel: { color: TEXT },
  splitLine: { lineStyle: { color: LINE } },
  nameTextStyle: { color: TEXT },
};

/** One panel: a box per run, with `labels` under them. Without outliers the axis fits the whiskers. */
export function boxOption({ runs }: Comparison, labels: readonly string[], outliers = true): EChartsCoreOption {
  return {
    animation: false,
    grid: { left: 8, right: 12, top: 22, bottom: 6, containLabel: true },
    tooltip: { trigger: "item", confine: true, valueFormatter: (value: unknown) => `${String(value)} ms` },
    xAxis: { ...axis, type: "category", data: labels, splitLine: { show: false } },
    yAxis: { ...axis, type: "value", name: "ms", min: 0 },
    series: [
      {
        name: "quartiles",
        type: "boxplot",
        data: runs.map(({ box }, index) => ({
          value: box ? [box.low, box.q1, box.median, box.q3, box.high] : [],
          itemStyle: { color: `${colorOf(index)}66`, borderColor: colorOf(index), borderWidth: 1.5 },
        })),
      },
      {
        name: "outlier",
        type: "scatter",
        symbolSize: 3,
        data: runs.flatMap(({ box }, index) =>
          (outliers ? (box?.outlier_values ?? []) : []).map((value) => ({
            value: [index, value],
            itemStyle: { color: colorOf(index), opacity: 0.5 },
          })),
        ),
      },
    ],
  };
}

/** One panel: each run's median over its time, its highest values as a thin line. */
export function graphOption({ runs }: Comparison, labels: readonly string[]): EChartsCoreOption {
  const line = (name: string, seconds: readonly number[], values: readonly number[], color: string, thin: boolean) => ({
    name,
    type: "line",
    showSymbol: false,
    data: seconds.map((at, index) => [at, values[index] ?? null]),
    lineStyle: { color, width: thin ? 0.7 : 1.8, opacity: thin ? 0.6 : 1 },
    itemStyle: { color },
  });
  return {
    animation: false,
    grid: { left: 8, right: 16, top: 28, bottom: 20, containLabel: true },
    tooltip: { trigger: "axis", confine: true, valueFormatter: (value: unknown) => `${String(value)} ms` },
    xAxis: { ...axis, type: "value", name: "s", nameLocation: "end", min: "dataMin", max: "dataMax" },
    yAxis: { ...axis, type: "value", name: "ms", min: 0 },
    series: runs.flatMap(({ series }, index) =>
      series
        ? [
            line(`${labels[index] ?? ""} highest`, series.seconds, series.highest, colorOf(index), true),
            line(`${labels[index] ?? ""} median`, series.seconds, series.median, colorOf(index), false),
          ]
        : [],
    ),
  };
}
