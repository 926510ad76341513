/** The routes that follow what a robot drives; each may be taken out again. */
import { ActionIcon, Group, Stack, Text } from "@mantine/core";
import { IconX } from "@tabler/icons-react";
import { act } from "../api/action";
import { call } from "../api/client";
import type { RobotView } from "../api/types";
import { Guarded } from "../ui/Guarded";

export function RouteQueue({ robot }: { readonly robot: RobotView }) {
  const queue = robot.assignment?.queue ?? [];
  if (queue.length === 0) return null;
  const takeOut = (entry_id: string, route: string) =>
    act(`Taking ${route} out of the queue`, () =>
      call("delete", "/api/robots/{robot_id}/queue/{entry_id}", { path: { robot_id: robot.id, entry_id } }),
    );
  return (
    <Stack gap={4} data-testid="route-queue">
      <Text size="xs" c="dimmed">
        Next
      </Text>
      {queue.map(({ id, route, queued_by }, index) => (
        <Group key={id} justify="space-between" wrap="nowrap">
          <Text size="sm">
            {index + 1}. {route}{" "}
            <Text span size="xs" c="dimmed">
              by {queued_by || "somebody"}
            </Text>
          </Text>
          <Guarded>
            <ActionIcon
              variant="subtle"
              size="sm"
              aria-label={`Take ${route} out of the queue`}
              onClick={() => void takeOut(id, route)}
            >
              <IconX size={14} />
            </ActionIcon>
          </Guarded>
        </Group>
      ))}
    </Stack>
  );
}
