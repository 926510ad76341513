/** What is wrong now, since when, and how the processes do. */
import { Alert, Anchor, Drawer, Group, Stack, Text, Title } from "@mantine/core";
import { IconAlertTriangle, IconCircleCheck, IconExclamationCircle } from "@tabler/icons-react";
import { Link } from "react-router";
import type { HealthView } from "../api/types";
import { ProcessTable } from "../system/ProcessTable";
import { formatStamp } from "../ui/format";

interface HealthDrawerProps {
  readonly health: HealthView;
  readonly opened: boolean;
  readonly onClose: () => void;
}

export function HealthDrawer({ health, opened, onClose }: HealthDrawerProps) {
  return (
    <Drawer opened={opened} onClose={onClose} position="right" size="lg" title="Health" data-testid="health-drawer">
      <Stack>
        {health.problems.length === 0 && (
          <Alert color="teal" icon={<IconCircleCheck />}>
            Everything that should be there is there.
          </Alert>
        )}
        {health.problems.map((problem) => (
          <Alert
            key={`${problem.source} ${problem.text}`}
            color={problem.severity === "error" ? "red" : "orange"}
            icon={problem.severity === "error" ? <IconExclamationCircle /> : <IconAlertTriangle />}
            data-testid="problem"
          >
            <Text size="sm">{problem.text}</Text>
            <Text size="xs" c="dimmed">
              {problem.source}
              {problem.since_ns !== null && ` · since ${formatStamp(problem.since_ns)}`}
            </Text>
          </Alert>
        ))}
        <Group justify="space-between">
          <Title order={2} fz="h5">
            Processes
          </Title>
          <Anchor component={Link} to="/system" size="sm" onClick={onClose}>
            Channels and ages
          </Anchor>
        </Group>
        <ProcessTable processes={health.processes} />
      </Stack>
    </Drawer>
  );
}
