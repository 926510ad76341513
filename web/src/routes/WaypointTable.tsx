/** All waypoints in a table that is edited in place. */
import { Anchor, Button, Group, Paper, Table, Text, Title } from "@mantine/core";
import { IconPlus } from "@tabler/icons-react";
import { useState } from "react";
import { Link } from "react-router";
import { useLab } from "../app/lab";
import { freeId } from "../floor/edits";
import { useLive } from "../live/store";
import { Guarded } from "../ui/Guarded";
import { WaypointRow } from "./WaypointRow";

export function WaypointTable() {
  const waypoints = useLive((live) => live.state.waypoints);
  const lab = useLab();
  const [adding, setAdding] = useState(false);
  const sorted = Object.values(waypoints).sort((a, b) => a.id.localeCompare(b.id, "en", { numeric: true }));
  const area = lab?.areas[0]?.id ?? "";
  return (
    <Paper withBorder p="md">
      <Group justify="space-between" mb="sm">
        <Title order={2} fz="h5">
          Waypoints
        </Title>
        <Guarded>
          <Button
            size="xs"
            variant="default"
            leftSection={<IconPlus size={16} />}
            disabled={adding}
            data-testid="waypoint-new"
            onClick={() => setAdding(true)}
          >
            New waypoint
          </Button>
        </Guarded>
      </Group>
      {sorted.length === 0 && !adding && (
        <Text size="sm" c="dimmed">
          There is no waypoint yet. Place them on the{" "}
          <Anchor component={Link} to="/floor" inherit>
            floor
          </Anchor>{" "}
          or type their coordinates here.
        </Text>
      )}
      {(sorted.length > 0 || adding) && (
        <Table.ScrollContainer minWidth={600}>
          <Table verticalSpacing={4} horizontalSpacing={6} data-testid="waypoints">
            <Table.Thead>
              <Table.Tr>
                <Table.Th>Id</Table.Th>
                <Table.Th>Area</Table.Th>
                <Table.Th w={92}>x, m</Table.Th>
                <Table.Th w={92}>y, m</Table.Th>
                <Table.Th w={92}>Radius, m</Table.Th>
                <Table.Th w={104}>Heading, °</Table.Th>
                <Table.Th w={76} />
              </Table.Tr>
            </Table.Thead>
            <Table.Tbody>
              {sorted.map((waypoint) => (
                <WaypointRow key={waypoint.id} waypoint={waypoint} />
              ))}
              {adding && (
                <WaypointRow
                  waypoint={{ id: freeId("wp", waypoints), area, x: 0, y: 0, radius_m: 0.15, yaw: null }}
                  isNew
                  onClose={() => setAdding(false)}
                />
              )}
            </Table.Tbody>
          </Table>
        </Table.ScrollContainer>
      )}
    </Paper>
  );
}
