/** Where the time of the frames goes: runs side by side as box plots, table and time graph. */
import {
  Alert,
  Card,
  Group,
  Loader,
  MultiSelect,
  SegmentedControl,
  SimpleGrid,
  Switch,
  Text,
  Title,
} from "@mantine/core";
import { useMemo, useState } from "react";
import type { TimingRunView } from "../api/types";
import { formatDuration, formatStamp } from "../ui/format";
import { Page } from "../ui/Page";
import { Chart } from "./Chart";
import { boxOption, graphOption } from "./charts";
import { compare } from "./comparison";
import { ComparisonTable } from "./ComparisonTable";
import { useRuns, useTimings } from "./use-timings";

const SPANS = [
  { value: "60", label: "1 min" },
  { value: "600", label: "10 min" },
  { value: "all", label: "Whole run" },
];
const VIEWS = [
  { value: "boxes", label: "Box plots" },
  { value: "graph", label: "Over time" },
];
const MOST_RUNS = 6;

/** "14:02:11, 25 min": when the run began and how long it has lasted. */
export function describeRun(run: TimingRunView): string {
  return `${formatStamp(run.start_ns)}, ${formatDuration((run.newest_ns - run.start_ns) / 1e6)}`;
}

export default function LogsPage() {
  const runs = useRuns();
  const [asked, setAsked] = useState<readonly string[] | null>(null);
  const [span, setSpan] = useState("600");
  const [view, setView] = useState("boxes");
  const [outliers, setOutliers] = useState(true);

  const known = runs.value ?? [];
  // Unless somebody chose: the newest run, and the one before it to compare with, the older one first.
  const newest = known.slice(0, 2).map((run) => run.name);
  const chosen = asked ?? newest.reverse();
  const timings = useTimings(
    chosen.flatMap((name) => known.find((run) => run.name === name) ?? []),
    span === "all" ? null : Number(span),
  );
  const shown = timings.value;
  const comparisons = useMemo(() => compare(shown ?? []), [shown]);
  const labels = (shown ?? []).map(({ name, start_ns }) => {
    const run = known.find((each) => each.name === name);
    return run ? formatStamp(run.start_ns) : formatStamp(start_ns);
  });
  const error = runs.error ?? timings.error;

  return (
    <Page
      title="Logs"
      note="How long each stage of each frame took. The first run is what the others are compared with."
      actions={
        <Group gap="sm">
          {view === "boxes" && (
            <Switch
              size="xs"
              label="Outliers"
              checked={outliers}
              onChange={(event) => setOutliers(event.currentTarget.checked)}
            />
          )}
          <SegmentedControl size="xs" data={VIEWS} value={view} onChange={setView} aria-label="Picture" />
          <SegmentedControl size="xs" data={SPANS} value={span} onChange={setSpan} aria-label="How much of the runs" />
        </Group>
      }
    >
      {error !== null && (
        <Alert color="red" data-testid="logs-error">
          {error} What is shown may be old.
        </Alert>
      )}
      {runs.value === null ? (
        error === null && <Loader aria-label="Fetching the runs" />
      ) : known.length === 0 ? (
        <Text c="dimmed" data-testid="logs-empty">
          No run has left stage timings on the server's machine yet. Cameras and tracker write them while they run,
          unless LILLIPUT_TIMINGS_MB is 0; on several machines each keeps its own, and ./lilliput logs compares them
          there.
        </Text>
      ) : (
        <MultiSelect
          label="Runs"
          description={`Up to ${MOST_RUNS}, in the order chosen`}
          data={known.map((run) => ({ value: run.name, label: describeRun(run) }))}
          value={[...chosen]}
          onChange={setAsked}
          maxValues={MOST_RUNS}
          searchable
          clearable
          data-testid="logs-runs"
        />
      )}
      {known.length > 0 && chosen.length === 0 && <Text c="dimmed">Choose a run.</Text>}
      {chosen.length > 0 && shown !== null && comparisons.length === 0 && (
        <Text c="dimmed">
          No frame was timed in {span === "all" ? "these runs" : "this time"}: are the cameras running?
        </Text>
      )}
      <SimpleGrid cols={view === "boxes" ? { base: 1, sm: 2, lg: 4 } : { base: 1, lg: 2 }} spacing="sm">
        {comparisons.map((comparison) => {
          const name = `${comparison.kind} ${comparison.stage}`;
          return (
            <Card key={name} withBorder padding="xs" data-testid={`timings-${comparison.kind}-${comparison.stage}`}>
              <Title order={2} fz="sm">
                {name}
              </Title>
              <Chart
                option={view === "boxes" ? boxOption(comparison, labels, outliers) : graphOption(comparison, labels)}
                height={200}
                label={`${name}, ${view === "boxes" ? "box plots of" : "over the time of"} ${labels.join(", ")}`}
              />
            </Card>
          );
        })}
      </SimpleGrid>
      {comparisons.length > 0 && <ComparisonTable comparisons={comparisons} labels={labels} />}
    </Page>
  );
}
