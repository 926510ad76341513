/** How old what is known of a robot's place is, in the colours of its thresholds. */
import { Text } from "@mantine/core";
import type { RobotView } from "../api/types";
import { useLive } from "../live/store";
import { formatDuration } from "../ui/format";
import { freshness, poseAgeMs } from "./robot-state";

const COLORS = { ok: "teal", warn: "orange", stop: "red" } as const;

export function PoseAge({ robot }: { readonly robot: RobotView }) {
  const age = useLive((live) => poseAgeMs(robot, live.nowMs));
  if (age === null)
    return (
      <Text span size="xs" c="dimmed" data-testid="pose-age">
        never seen
      </Text>
    );
  const state = freshness(age);
  return (
    <Text span size="xs" fw={600} c={COLORS[state]} data-testid="pose-age" data-freshness={state}>
      {formatDuration(age)}
    </Text>
  );
}
