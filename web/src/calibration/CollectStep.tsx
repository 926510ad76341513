/** Second step: the cameras look, then everything is computed. */
import { Badge, Group, Loader, Paper, Progress, Text } from "@mantine/core";
import { IconCheck } from "@tabler/icons-react";
import type { CalibrationView } from "../api/types";
import { formatDuration } from "../ui/format";
import { progressOf } from "./stage";

export function CollectStep({ view }: { readonly view: CalibrationView }) {
  const { run } = view;
  if (!run) return null;
  const isRefining = run.state === "refining";
  return (
    <Paper withBorder p="md" data-testid="calibration-progress" aria-live="polite">
      <Group gap="sm" mb="sm">
        <Loader size="sm" />
        <Text fw={600}>
          {isRefining ? "Computing cameras and floor tags together…" : "Cameras look at their floor tags…"}
        </Text>
        <Text size="sm" c="dimmed">
          asked by {run.by}, {formatDuration((view.stamp_ns - run.started_ns) / 1e6)} ago
        </Text>
      </Group>
      <Progress value={progressOf(view)} animated aria-label="Cameras that have looked" />
      <Group gap="xs" mt="sm">
        {run.cameras.map((camera) => {
          const hasAnswered = run.answered.includes(camera);
          return (
            <Badge
              key={camera}
              tt="none"
              variant="light"
              color={hasAnswered ? "teal" : "gray"}
              leftSection={hasAnswered && <IconCheck size={12} />}
            >
              {camera}
            </Badge>
          );
        })}
      </Group>
      <Text size="xs" c="dimmed" mt="sm">
        Poses go on with the calibration in force. Of cameras that have not answered after 15 seconds, what they saw the
        last time is used.
      </Text>
    </Paper>
  );
}
