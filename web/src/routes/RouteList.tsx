/** All routes, one of them open in the builder. */
import { Badge, Button, Group, Paper, Stack, Text, Title, UnstyledButton } from "@mantine/core";
import { IconPlus, IconRepeat } from "@tabler/icons-react";
import { useState } from "react";
import type { Route } from "../api/types";
import { freeId } from "../floor/edits";
import { useLive } from "../live/store";
import { Guarded } from "../ui/Guarded";
import { RouteBuilder } from "./RouteBuilder";
import classes from "./routes.module.css";

type Opened = { readonly route: Route; readonly isNew: boolean } | null;

export function RouteList() {
  const routes = useLive((live) => live.state.routes);
  const robots = useLive((live) => live.state.robots);
  const [opened, setOpened] = useState<Opened>(null);
  const sorted = Object.values(routes).sort((a, b) => a.id.localeCompare(b.id, "en", { numeric: true }));
  const driversOf = (route: string) =>
    Object.values(robots).filter(
      ({ assignment }) => assignment?.route === route && ["running", "paused"].includes(assignment.state),
    );
  return (
    <Paper withBorder p="md">
      <Group justify="space-between" mb="sm">
        <Title order={2} fz="h5">
          Routes
        </Title>
        <Guarded>
          <Button
            size="xs"
            variant="default"
            leftSection={<IconPlus size={16} />}
            data-testid="route-new"
            onClick={() => setOpened({ route: { id: freeId("route", routes), legs: [], loop: false }, isNew: true })}
          >
            New route
          </Button>
        </Guarded>
      </Group>
      {sorted.length === 0 && opened === null && (
        <Text size="sm" c="dimmed">
          There is no route yet. Place a few waypoints, then put them in order with “New route”.
        </Text>
      )}
      <Stack gap={4} mb={opened ? "md" : 0}>
        {sorted.map((route) => (
          <UnstyledButton
            key={route.id}
            className={classes["route"] ?? ""}
            data-selected={opened?.route.id === route.id}
            data-testid={`route-${route.id}`}
            onClick={() => setOpened(opened?.route.id === route.id ? null : { route, isNew: false })}
          >
            <Group justify="space-between" wrap="nowrap">
              <Text fw={600} size="sm">
                {route.id}
              </Text>
              <Group gap={6} wrap="nowrap">
                {driversOf(route.id).map(({ id }) => (
                  <Badge key={id} variant="light" color="teal" tt="none">
                    {id}
                  </Badge>
                ))}
                {route.loop && <IconRepeat size={16} aria-label="looped" />}
              </Group>
            </Group>
            <Text size="xs" c="dimmed" truncate>
              {route.legs.map(({ waypoint }) => waypoint).join(" → ")}
            </Text>
          </UnstyledButton>
        ))}
      </Stack>
      {opened && (
        <RouteBuilder
          key={`${opened.route.id} ${opened.isNew}`}
          route={opened.route}
          isNew={opened.isNew}
          onSaved={(route) => setOpened({ route, isNew: false })}
          onClose={() => setOpened(null)}
        />
      )}
    </Paper>
  );
}
