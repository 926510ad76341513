/** One camera: its picture, what is wrong with it since when, and the numbers by which it is judged. */
import { Alert, Badge, Card, Group, SimpleGrid, Text } from "@mantine/core";
import type { CameraView } from "../api/types";
import { useLive } from "../live/store";
import { formatStamp, withSince } from "../ui/format";
import { FaultMenu } from "./FaultMenu";
import { Preview } from "./Preview";
import { StageTimings } from "./StageTimings";

export function CameraCard({ camera }: { readonly camera: CameraView }) {
  const { state } = camera;
  const problem = useLive((live) => live.state.health?.problems.find(({ source }) => source === camera.id));
  const isWell = state?.fresh === true && state.connected && state.error === null;
  const wrong = problem ? withSince(problem) : describeTrouble(camera);
  return (
    <Card withBorder padding="sm" data-testid={`camera-${camera.id}`} data-ok={isWell}>
      <Card.Section>
        <Preview camera={camera.id} ratio={camera.width / camera.height} />
      </Card.Section>
      <Group justify="space-between" mt="sm">
        <Text fw={600}>{camera.id}</Text>
        <Group gap="xs">
          {camera.source === "sim" && <FaultMenu camera={camera.id} fault={camera.fault} />}
          <Badge variant="dot" tt="none" color={isWell ? "teal" : "red"}>
            {isWell ? "working" : "not working"}
          </Badge>
        </Group>
      </Group>
      {!isWell && (
        <Alert color="red" p="xs" mt="xs">
          {wrong}
        </Alert>
      )}
      {state && (
        <>
          <SimpleGrid cols={3} spacing="xs" mt="sm">
            <Figure name="Rate" value={`${state.rate_hz.toFixed(1)} Hz`} isBad={state.rate_hz < 0.7 * camera.rate_hz} />
            <Figure name="Latency" value={`${state.latency_ms.toFixed(0)} ms`} isBad={state.latency_ms > 100} />
            <Figure
              name="Reprojection"
              value={state.reprojection_px === null ? "not calibrated" : `${state.reprojection_px.toFixed(2)} px`}
              isBad={state.reprojection_px === null || state.reprojection_px > 1}
            />
            <Figure name="Frames" value={state.frames.toLocaleString("en-GB")} />
            <Figure name="Skipped" value={state.skipped.toLocaleString("en-GB")} />
            <Figure name="Broken" value={state.broken.toLocaleString("en-GB")} isBad={state.broken > 0} />
          </SimpleGrid>
          <Text size="xs" c="dimmed" mt="sm">
            Floor tags seen: {state.floor_tags_seen.length > 0 ? state.floor_tags_seen.join(", ") : "none"}
          </Text>
          <StageTimings timings={state.timings_ms} />
        </>
      )}
    </Card>
  );
}

function describeTrouble({ id, state }: CameraView): string {
  if (!state) return `${id} has never reported; is its process running?`;
  if (state.fresh && state.error !== null) return withSince({ text: state.error, since_ns: state.error_since_ns });
  return `Nothing heard from ${id} since ${formatStamp(state.stamp_ns)}`;
}

interface FigureProps {
  readonly name: string;
  readonly value: string;
  readonly isBad?: boolean;
}

function Figure({ name, value, isBad = false }: FigureProps) {
  return (
    <div>
      <Text size="xs" c="dimmed">
        {name}
      </Text>
      <Text size="sm" fw={600} {...(isBad && { c: "orange" })}>
        {value}
      </Text>
    </div>
  );
}
