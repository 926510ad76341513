/** One robot of the list: what it does, why it waits, where it stands in its route, and how old all that is. */
import { Group, Progress, Text, UnstyledButton } from "@mantine/core";
import { memo } from "react";
import type { RobotView } from "../api/types";
import classes from "../floor/floor.module.css";
import { useLive } from "../live/store";
import { Battery } from "./Battery";
import { PoseAge } from "./PoseAge";
import { describeProgress } from "./progress";
import { isAssigned, summarize } from "./robot-state";
import { StateBadge } from "./StateBadge";

interface RobotRowProps {
  readonly robot: RobotView;
  readonly isSelected: boolean;
  readonly onSelect: (robot: string) => void;
}

export const RobotRow = memo(function RobotRow({ robot, isSelected, onSelect }: RobotRowProps) {
  const { assignment, status } = robot;
  const route = useLive((live) => (assignment ? live.state.routes[assignment.route] : undefined));
  const summary = summarize(robot);
  const progress = assignment && isAssigned(robot) ? describeProgress(assignment, route) : null;
  return (
    <UnstyledButton
      className={classes["robot"] ?? ""}
      data-selected={isSelected}
      data-testid={`robot-${robot.id}`}
      data-state={robot.state}
      aria-pressed={isSelected}
      onClick={() => onSelect(robot.id)}
    >
      <Group justify="space-between" wrap="nowrap" gap="xs">
        <Text fw={600} truncate>
          {robot.id}
        </Text>
        <StateBadge summary={summary} />
      </Group>
      {summary.why && (
        <Text size="sm" c={summary.tone === "fault" ? "red" : "dimmed"} data-testid="robot-reason">
          {summary.why}
        </Text>
      )}
      <Group gap="md" mt={4} wrap="nowrap">
        <Text span size="xs" c="dimmed" style={{ whiteSpace: "nowrap" }}>
          pose <PoseAge robot={robot} />
        </Text>
        {status && (
          <Text span size="xs" c="dimmed" style={{ whiteSpace: "nowrap" }}>
            {Math.abs(status.linear_mps).toFixed(2)} m/s
          </Text>
        )}
        {status?.mode === "MANUAL" && (
          <Text span size="xs" c="dimmed">
            manual
          </Text>
        )}
        {typeof status?.battery === "number" && <Battery share={status.battery} />}
      </Group>
      {progress && (
        <>
          <Text size="xs" c="dimmed" mt={4} truncate data-testid="robot-progress">
            {progress.text}
          </Text>
          <Progress size={3} mt={3} value={progress.percent} aria-label={progress.text} />
        </>
      )}
    </UnstyledButton>
  );
});
