/** Where the time of a frame goes, stage by stage. */
import { Group, Progress, Text, Tooltip } from "@mantine/core";

const COLORS = ["gray.5", "steel.6", "teal.6", "grape.6", "orange.6", "cyan.6", "pink.6"];

export function StageTimings({ timings }: { readonly timings: Readonly<Record<string, number>> }) {
  const stages = Object.entries(timings);
  const total = stages.reduce((sum, [, ms]) => sum + ms, 0);
  if (total <= 0) return null;
  return (
    <>
      <Progress.Root size="md" mt="xs" aria-label={`Stages of a frame, ${total.toFixed(1)} ms together`}>
        {stages.map(([stage, ms], index) => (
          <Tooltip key={stage} label={`${stage} ${ms.toFixed(1)} ms`}>
            <Progress.Section value={(100 * ms) / total} color={COLORS[index % COLORS.length] ?? "gray"} />
          </Tooltip>
        ))}
      </Progress.Root>
      <Group gap="xs" mt={4}>
        {stages.map(([stage, ms]) => (
          <Text key={stage} size="xs" c="dimmed">
            {stage} {ms.toFixed(1)}
          </Text>
        ))}
        <Text size="xs" c="dimmed">
          ms
        </Text>
      </Group>
    </>
  );
}
